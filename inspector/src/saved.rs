//! Saved state of the inspector, as a JSON file.
//!
//! Layout, settings and watches are texts of the user interface, stored verbatim. The caller reads and writes the file.

use serde::{Deserialize, Deserializer, Serialize};

use crate::link::Link;
use crate::versioned::{FileError, FileKind};
use raystep_kernels::history::units::Units;
use smart_default::SmartDefault;

/// Version of the file; incremented when the meaning of something in it changes.
pub const VERSION: u32 = 1;
/// Most recent files stored.
pub const MOST_RECENT: usize = 10;
/// The smallest and the largest factor for the size of text.
pub const TEXT_SIZES: [f32; 2] = [0.5, 3.0];
/// Largest file that is read or written, bytes.
pub const MOST_BYTES: usize = 1 << 20;
const KIND: FileKind = FileKind { name: "the settings file", version: VERSION, most_bytes: MOST_BYTES };

/// What the user has done, and whether the line that explains it was dismissed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct FirstSteps {
    /// A pixel was clicked.
    pub has_clicked: bool,
    /// The next or the previous event of the ray was gone to.
    pub has_followed: bool,
    /// A pass was run.
    pub has_stepped: bool,
    /// The line was dismissed.
    pub is_dismissed: bool,
}

impl FirstSteps {
    /// Whether the line is still of use.
    #[must_use]
    pub fn is_needed(self) -> bool {
        !(self.is_dismissed || self.has_clicked && self.has_stepped)
    }
}

/// An arrangement of panels that the user saved.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct OwnLayout {
    /// Its name.
    pub name: String,
    /// The arrangement.
    pub tree: String,
}

/// The saved state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, SmartDefault)]
#[serde(default, deny_unknown_fields)]
pub struct Saved {
    #[default(VERSION)]
    version: u32,
    /// The arrangement of panels.
    pub layout: Option<String>,
    /// The name of the layout that it came from.
    pub layout_name: String,
    /// The user's own layouts.
    pub layouts: Vec<OwnLayout>,
    /// The settings.
    pub settings: Option<String>,
    /// The last view.
    pub link: Option<Link>,
    /// The watches.
    pub watches: Option<String>,
    /// The bookmarks, and their scene.
    pub bookmarks: Option<String>,
    /// The size of all text, as a factor.
    #[default(1.0)]
    #[serde(deserialize_with = "read_text_size")]
    pub text_size: f32,
    /// Whether the toolbar has words.
    #[default(true)]
    pub toolbar_words: bool,
    /// What a new user has done.
    pub first_steps: FirstSteps,
    /// The units of lengths and of t.
    pub units: Units,
    /// Recent files, the latest first.
    recent: Vec<String>,
}

impl Saved {
    /// Reads a file.
    ///
    /// # Errors
    /// Where it is not one of this version; with the line and the column of what is wrong.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FileError> {
        let mut saved: Self = KIND.read(bytes)?;
        saved.recent.truncate(MOST_RECENT);
        Ok(saved)
    }

    /// Reads a file; where that fails, the defaults and the reason.
    #[must_use]
    pub fn from_bytes_or_default(bytes: &[u8]) -> (Self, Option<FileError>) {
        match Self::from_bytes(bytes) {
            Ok(saved) => (saved, None),
            Err(error) => (Self::default(), Some(error)),
        }
    }

    /// The file.
    ///
    /// # Errors
    /// Where it would be too large to be read again.
    pub fn to_text(&self) -> Result<String, FileError> {
        KIND.write(self)
    }

    /// Recent files, the latest first; at most [`MOST_RECENT`], each once.
    #[must_use]
    pub fn recent(&self) -> &[String] {
        &self.recent
    }

    /// A file was opened.
    pub fn opened(&mut self, path: &str) {
        self.forget(path);
        self.recent.insert(0, path.into());
        self.recent.truncate(MOST_RECENT);
    }

    /// Removes a file that no longer exists.
    pub fn forget(&mut self, path: &str) {
        self.recent.retain(|other| other != path);
    }
}

/// The nearest factor that is allowed; 1 for what is not a number.
fn read_text_size<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f32, D::Error> {
    let value = serde_json::Value::deserialize(deserializer)?;
    let [least, most] = TEXT_SIZES.map(f64::from);
    Ok(value.as_f64().map_or(1.0, |factor| factor.clamp(least, most) as f32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::LinkRay;

    fn some() -> Saved {
        let mut saved = Saved {
            layout: Some("(tabs: [\"passes\", \"ray\"])".into()),
            settings: Some("say \"hi\"\n\\ \u{7f} ø".into()),
            link: Some(Link { scene: Some("a b.glb".into()), ray: Some(LinkRay::Pixel([1, 2])), ..Link::default() }),
            watches: Some(String::new()),
            bookmarks: Some("[\"start\"]".into()),
            text_size: 1.25,
            toolbar_words: false,
            first_steps: FirstSteps { has_clicked: true, ..FirstSteps::default() },
            units: Units::Scene,
            ..Saved::default()
        };
        saved.opened("a b.glb");
        saved
    }

    #[test]
    fn what_is_saved_comes_back() {
        for saved in [Saved::default(), some()] {
            let text = saved.to_text().expect("small");
            assert_eq!(Saved::from_bytes(text.as_bytes()), Ok(saved), "{text}");
        }
        assert!(some().to_text().expect("small").contains("raystep:1?scene=a%20b.glb&pixel=1,2"));
        assert_eq!(Saved::from_bytes(b"{\"version\": 1}"), Ok(Saved::default()), "what is not there is as by default");
    }

    #[test]
    fn recent_files_are_few_and_each_is_there_once() {
        let mut saved = Saved::default();
        (0..30).for_each(|i| saved.opened(&format!("{}.glb", i % 12)));
        saved.opened("3.glb");
        assert_eq!(
            (saved.recent().len(), saved.recent()[0].as_str(), saved.recent()[1].as_str()),
            (10, "3.glb", "5.glb")
        );
        assert_eq!(saved.recent().iter().filter(|p| *p == "3.glb").count(), 1);
        saved.forget("3.glb");
        assert_eq!(saved.recent()[0], "5.glb");
        let many: Vec<_> = (0..50).map(|i| format!("\"{i}\"")).collect();
        let text = format!("{{\"version\": 1, \"recent\": [{}]}}", many.join(", "));
        assert_eq!(Saved::from_bytes(text.as_bytes()).expect("JSON").recent().len(), MOST_RECENT);
    }

    #[test]
    fn a_broken_file_says_where_and_gives_defaults() {
        let deep = format!("{{\"version\": 1, \"layout\": {}", "[".repeat(100_000));
        let large = format!("{{\"version\": 1, \"layout\": \"{}\"}}", "x".repeat(MOST_BYTES));
        let cases: &[(&[u8], &str)] = &[
            (b"", "line 1, column 0: EOF"),
            (b"{\"version\": 1,\n \"layout\": 7}", "line 2, column 12: invalid type: integer `7`, expected a string"),
            (b"{\"version\": 1, \"colour\": 7}", "colour"),
            (b"{\"version\": 1, \"link\": \"raystep:9?\"}", "version \"9\""),
            (b"{\"layout\": null}", "version"),
            (b"{\"version\": 2, \"whatever\": [1, 2]}", "version 2, but this raystep reads version 1"),
            (b"\xff\xfe", "not UTF-8"),
            (b"(version: 1)", "line 1, column 1"),
            (deep.as_bytes(), "line 1"),
            (large.as_bytes(), "limit is 1048576"),
        ];
        for (bytes, wanted) in cases {
            let (saved, error) = Saved::from_bytes_or_default(bytes);
            let error = error.expect("an error").to_string();
            assert!(error.contains(wanted) && !error.contains('\n') && error.len() < 300, "{wanted}: {error}");
            assert_eq!(saved, Saved::default());
        }
        let too_large = Saved { layout: Some("x".repeat(MOST_BYTES)), ..Saved::default() };
        let error = too_large.to_text().expect_err("too large").to_string();
        assert!(error.contains("the limit is 1048576"), "{error}");
    }

    #[test]
    fn text_sizes_outside_the_range_are_clamped() {
        let read = |text: &str| {
            let file = format!("{{\"version\": 1, \"text_size\": {text}}}");
            Saved::from_bytes(file.as_bytes()).expect("JSON").text_size
        };
        let texts = ["1.5", "0", "-1e300", "1e300", "7", "null", "\"large\"", "[2]"];
        assert_eq!(texts.map(read), [1.5, 0.5, 0.5, 3.0, 3.0, 1.0, 1.0, 1.0]);
    }

    #[test]
    fn the_line_stays_until_both_are_known_or_it_is_dismissed() {
        let with = |has_clicked, has_stepped, is_dismissed| FirstSteps {
            has_clicked,
            has_stepped,
            is_dismissed,
            ..FirstSteps::default()
        };
        let needed = [with(false, false, false), with(true, false, false), with(false, true, false)];
        assert!(needed.iter().all(|steps| steps.is_needed()));
        let known = [with(true, true, false), with(false, false, true)];
        assert!(!known.iter().any(|steps| steps.is_needed()));
    }
}
