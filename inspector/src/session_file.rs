//! A `.raystep-session` file: what was looked at in the inspector, to be opened again.
//!
//! JSON, with the scene by name and not by value. A run is stored as a link, so that its line can be copied from the file,
//! and as what a link cannot express. Results are not stored: they follow from the rest. The file is untrusted: it is
//! read as a whole or not at all. The caller reads and writes it.

pub(crate) mod layout;
mod recipe;
#[cfg(test)]
mod tests;

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};

use crate::runs::kept::MOST_RUNS;
use crate::session::Watch;
use crate::versioned::{FileError, FileKind};
pub use recipe::SavedRun;

/// Version of the file; incremented when the meaning of something in it changes.
pub const VERSION: u32 = 1;
/// The ending of its name, without the dot.
pub const EXTENSION: &str = "raystep-session";
/// Largest file that is read or written, bytes.
pub const MOST_BYTES: usize = 4 << 20;
const KIND: FileKind = FileKind { name: "the session", version: VERSION, most_bytes: MOST_BYTES };
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
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FileError> {
        let file: Self = KIND.read(bytes)?;
        if file.here.link.scene.is_none() {
            return Err(KIND.wrong("names no scene: add scene=FILE to the link of \"here\""));
        }
        let runs = file.runs.len();
        if [file.reference, file.compared].into_iter().flatten().any(|index| index >= runs) {
            return Err(KIND.wrong(format!("compares runs that it does not have: it has {runs}, counted from 0")));
        }
        Ok(file)
    }

    /// The file.
    ///
    /// # Errors
    /// Where it would be too large to be read again.
    pub fn to_text(&self) -> Result<String, FileError> {
        KIND.write(self)
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
