//! What a student gets: the pages, their drawings, the scenes, and the kernels with their holes. Not the solutions.

use std::borrow::Cow;

/// A text of the course.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileOfCourse {
    /// Its name, and its folder in that of the course.
    pub name: &'static str,
    /// What is in it.
    pub text: &'static str,
}

/// A file of the course, by its name.
macro_rules! file {
    ($name:literal) => {
        $crate::course::FileOfCourse { name: $name, text: include_str!(concat!(env!("RAYSTEP_COURSE"), "/", $name)) }
    };
}
pub(super) use file;

/// The wall whose edges many rays meet.
pub(super) const CRACK: FileOfCourse = file!("crack.obj");

const FILES: &[FileOfCourse] = &[
    file!("README.md"),
    file!("1-tmax.md"),
    file!("1-tmax.wgsl"),
    file!("2-step.md"),
    file!("2-step.wgsl"),
    file!("3-triangle.md"),
    file!("3-triangle.wgsl"),
    file!("4-list-end.md"),
    file!("4-list-end.wgsl"),
    file!("5-schedule.md"),
    file!("5-schedule.toml"),
    file!("6-resolution.md"),
    file!("6-resolution.wgsl"),
    file!("7-crack.md"),
    file!("7-crack.wgsl"),
    file!("8-shadow.md"),
    file!("8-shadow.wgsl"),
    CRACK,
    file!("images/1-tmax.svg"),
    file!("images/2-step.svg"),
    file!("images/3-triangle.svg"),
    file!("images/4-list-end.svg"),
    file!("images/5-schedule.svg"),
    file!("images/6-resolution.svg"),
    file!("images/7-crack.svg"),
    file!("images/8-shadow.svg"),
];

/// The files, by name. Pages are without the renderings, which are no texts: the commands beside them render the same.
pub fn files() -> impl Iterator<Item = (&'static str, Cow<'static, str>)> {
    FILES.iter().map(|file| (file.name, without_renderings(file.text)))
}

/// A page without its paragraphs that are a PNG.
fn without_renderings(text: &'static str) -> Cow<'static, str> {
    let is_rendering = |paragraph: &&str| paragraph.starts_with("![") && paragraph.trim_end().ends_with(".png)");
    if !text.split("\n\n").any(|paragraph| is_rendering(&paragraph)) {
        return text.into();
    }
    text.split("\n\n").filter(|paragraph| !is_rendering(paragraph)).collect::<Vec<_>>().join("\n\n").into()
}
