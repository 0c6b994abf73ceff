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
use crate::terminal::is_obeyed;

/// A value as indented JSON with a line feed at its end. No string in it has a character that a terminal obeys:
/// JSON itself wants only some of them escaped.
pub(crate) fn json_text(value: &impl Serialize) -> Result<String, Error> {
    let text = serde_json::to_string_pretty(value).map_err(|e| Error::failed(format!("cannot write as JSON: {e}")))?;
    let mut json = String::with_capacity(text.len() + 1);
    for c in text.chars() {
        if is_obeyed(c) && c != '\n' {
            // All of them have four digits.
            json += &format!("\\u{:04x}", u32::from(c));
        } else {
            json.push(c);
        }
    }
    Ok(json + "\n")
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_is_the_same_data_with_nothing_to_obey_in_it() {
        let name = "a\u{1b}\u{7f}\u{9b}\u{202e}\nü";
        let text = json_text(&[name]).expect("JSON");
        assert_eq!(text, "[\n  \"a\\u001b\\u007f\\u009b\\u202e\\nü\"\n]\n");
        assert_eq!(serde_json::from_str::<Vec<String>>(&text).expect("JSON"), [name]);
    }
}
