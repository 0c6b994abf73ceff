//! The subcommands, one file each, and what several of them need.

pub(crate) mod bench;
pub(crate) mod completions;
pub(crate) mod dump;
mod html;
pub(crate) mod info;
mod input;
pub(crate) mod inspect;
pub(crate) mod plan;
mod plot;
pub(crate) mod render;
pub(crate) mod report;
pub(crate) mod scene;
pub(crate) mod stability;
mod summary;
pub(crate) mod trace;

use serde::Serialize;

use crate::error::Error;

/// A value as indented JSON with a line feed at its end.
pub(crate) fn json_text(value: &impl Serialize) -> Result<String, Error> {
    let text = serde_json::to_string_pretty(value);
    text.map(|text| text + "\n").map_err(|e| Error::failed(format!("cannot write as JSON: {e}")))
}

/// A file name's extension in lower case, or nothing.
pub(crate) fn extension(path: &std::path::Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// Lines of a table, each with a line feed; two blanks between columns, the first `left` of which hold words and stand
/// at the left, the others numbers.
fn aligned(lines: &[impl AsRef<[String]>], left: usize) -> Vec<String> {
    let columns = lines.iter().map(|line| line.as_ref().len()).max().unwrap_or(0);
    let width = |c: usize| lines.iter().map(|line| line.as_ref()[c].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let cell = |(c, text): (usize, &String)| {
        let width = widths[c];
        if c < left { format!("{text:<width$}") } else { format!("{text:>width$}") }
    };
    let line = |cells: &[String]| cells.iter().enumerate().map(cell).collect::<Vec<_>>().join("  ");
    lines.iter().map(|cells| line(cells.as_ref()).trim_end().to_owned() + "\n").collect()
}

/// Each value once, in the order of their first mention.
fn distinct<T: Clone + PartialEq>(values: &[T]) -> Vec<T> {
    let mut distinct: Vec<T> = Vec::new();
    for value in values {
        if !distinct.contains(value) {
            distinct.push(value.clone());
        }
    }
    distinct
}
