//! A `.raystep-session` file: what was looked at in the inspector, to be opened again.
//!
//! JSON, with the scene by name and not by value. A run is stored as a link, so that its line can be copied from the file,
//! and as what a link cannot express. Results are not stored: they follow from the rest. The file is untrusted: it is
//! read as a whole or not at all. The caller reads and writes it.

mod error;
pub(crate) mod layout;
mod recipe;
#[cfg(test)]
mod tests;

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};

use crate::runs::kept::MOST_RUNS;
use crate::session::Watch;
pub use error::SessionFileError;
pub use recipe::SavedRun;

/// Version of the file; incremented when the meaning of something in it changes.
pub const VERSION: u32 = 1;
/// The ending of its name, without the dot.
pub const EXTENSION: &str = "raystep-session";
/// Largest file that is read or written, bytes.
pub const MOST_BYTES: usize = 4 << 20;
/// Most edits of a run, and most bookmarks.
pub const MOST_EDITS: usize = 10_000;
/// The beginning of names of scenes that are not files.
pub const BUILT_IN: &str = "built-in:";

/// A place to return to.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Bookmark {
    /// The number of passes before it.
    pub place: usize,
    /// The ray that was selected.
    pub pixel: Option<[u32; 2]>,
    /// The user's name for it.
    pub name: String,
}

/// Whether a file's name is that of a session.
pub(crate) fn is_session(path: &str) -> bool {
    path.rsplit_once('.').is_some_and(|(_, end)| end.eq_ignore_ascii_case(EXTENSION))
}

/// A saved session.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SessionFile {
    version: u32,
    /// The run that was open, with its place and view.
    pub here: SavedRun,
    /// Places to return to.
    #[serde(default, deserialize_with = "bookmarks")]
    pub bookmarks: Vec<Bookmark>,
    /// The watches, and whether they are active.
    #[serde(default, deserialize_with = "watches")]
    pub watches: Vec<(Watch, bool)>,
    /// The user's notes.
    #[serde(default)]
    pub notes: String,
    /// The kept runs, oldest first.
    #[serde(default, deserialize_with = "runs")]
    pub runs: Vec<SavedRun>,
    /// The index of the run that others are compared with.
    #[serde(default)]
    pub reference: Option<usize>,
    /// The index of the run that is compared with it.
    #[serde(default)]
    pub compared: Option<usize>,
    /// The arrangement of panels: a text of the user interface.
    #[serde(default, deserialize_with = "layout::check")]
    pub layout: Option<String>,
}

impl SessionFile {
    /// A session with one run.
    #[must_use]
    pub fn new(here: SavedRun) -> Self {
        Self {
            version: VERSION,
            here,
            bookmarks: Vec::new(),
            watches: Vec::new(),
            notes: String::new(),
            runs: Vec::new(),
            reference: None,
            compared: None,
            layout: None,
        }
    }

    /// Reads a file.
    ///
    /// # Errors
    /// Where it is not a session of this version; with the line and the column of what is wrong.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, SessionFileError> {
        /// What every version has.
        #[derive(Deserialize)]
        struct Head {
            version: u32,
        }
        if bytes.len() > MOST_BYTES {
            return Err(SessionFileError::TooLarge(bytes.len()));
        }
        let text = std::str::from_utf8(bytes).map_err(|_| SessionFileError::NoText)?;
        // Other versions may have other fields: check the version first.
        let head: Head = serde_json::from_str(text)?;
        if head.version != VERSION {
            return Err(SessionFileError::Version(head.version));
        }
        let file: Self = serde_json::from_str(text)?;
        if file.here.link.scene.is_none() {
            return Err(SessionFileError::NoScene);
        }
        let is_there = |index: Option<usize>| index.is_none_or(|index| index < file.runs.len());
        if !is_there(file.reference) || !is_there(file.compared) {
            return Err(SessionFileError::NoRun(file.runs.len()));
        }
        Ok(file)
    }

    /// The file.
    ///
    /// # Errors
    /// Where it would be too large to be read again.
    pub fn to_text(&self) -> Result<String, SessionFileError> {
        let text = serde_json::to_string_pretty(self).map_err(|e| SessionFileError::Write(e.to_string()))? + "\n";
        if text.len() > MOST_BYTES { Err(SessionFileError::TooLarge(text.len())) } else { Ok(text) }
    }

    /// Renames the files of all scenes, for example relative to another folder. Built-in scenes keep their names.
    pub fn rename_scenes(&mut self, rename: impl Fn(&str) -> String) {
        for run in std::iter::once(&mut self.here).chain(&mut self.runs) {
            if let Some(scene) = run.link.scene.as_mut().filter(|scene| !scene.starts_with(BUILT_IN)) {
                *scene = rename(scene);
            }
        }
    }
}

/// A list of at most so many.
fn at_most<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    from: D,
    what: &str,
    most: usize,
) -> Result<Vec<T>, D::Error> {
    let list = Vec::<T>::deserialize(from)?;
    if list.len() > most {
        return Err(D::Error::custom(format!("{} {what}, but at most {most} are read", list.len())));
    }
    Ok(list)
}

fn bookmarks<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<Bookmark>, D::Error> {
    at_most(from, "bookmarks", MOST_EDITS)
}

fn watches<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<(Watch, bool)>, D::Error> {
    at_most(from, "watches", 100)
}

fn runs<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<SavedRun>, D::Error> {
    at_most(from, "runs", MOST_RUNS)
}
