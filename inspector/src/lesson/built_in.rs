//! The lessons and scenes that need no file.

use raystep_scenes::generate;

use crate::session::request::{Loader, at_once};

/// What the path of a built-in scene begins with; the name of a generator follows.
pub const PREFIX: &str = "built-in:";

/// The scene that opens by its name everywhere, even where no file is.
pub const CORNELL_BOX: &str = "cornell-box";

/// The lessons: the name of each file, and its text.
pub const LESSONS: [(&str, &str); 9] = [
    ("one-ray.md", include_str!("../../lessons/one-ray.md")),
    ("grid-2004.md", include_str!("../../lessons/grid-2004.md")),
    ("fragment-2004.md", include_str!("../../lessons/fragment-2004.md")),
    ("crack.md", include_str!("../../lessons/crack.md")),
    ("leaping.md", include_str!("../../lessons/leaping.md")),
    ("tie.md", include_str!("../../lessons/tie.md")),
    ("four-programs.md", include_str!("../../lessons/four-programs.md")),
    ("bright-pixel.md", include_str!("../../lessons/bright-pixel.md")),
    ("caustic.md", include_str!("../../lessons/caustic.md")),
];

/// The names of the lessons: those of their files without the ending.
pub fn lessons() -> impl Iterator<Item = &'static str> {
    LESSONS.iter().map(|(file, _)| file.trim_end_matches(".md"))
}

/// The place of a lesson in [`LESSONS`], by its name.
#[must_use]
pub fn lesson(name: &str) -> Option<usize> {
    lessons().position(|own| own == name)
}

/// A loader for the built-in scene of a path; its error says which names there are.
#[must_use]
pub fn loader(path: &str) -> Loader {
    let name = path.strip_prefix(PREFIX).unwrap_or(path).to_owned();
    at_once(move || generate::find(&name).and_then(|scene| scene.make(&[])).map_err(|error| error.to_string()))
}
