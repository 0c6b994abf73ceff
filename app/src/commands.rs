//! The subcommands, one file each, and their common functions.

pub(crate) mod bench;
pub(crate) mod build;
pub(crate) mod cast;
pub(crate) mod check;
pub(crate) mod check_kernel;
pub(crate) mod completions;
pub(crate) mod cost;
pub(crate) mod course;
pub(crate) mod debug_adapter;
pub(crate) mod dump;
pub(crate) mod export_program;
pub(crate) mod grade;
pub(crate) mod info;
mod input;
pub(crate) mod inspect;
pub(crate) mod merge;
pub(crate) mod new;
pub(crate) mod paper;
pub(crate) mod plan;
pub(crate) mod render;
pub(crate) mod report;
pub(crate) mod run;
pub(crate) mod scene;
pub(crate) mod source_line;
pub(crate) mod stability;
pub(crate) mod stop;
mod summary;
pub(crate) mod sweep;
pub(crate) mod trace;
mod unfinished;

use raystep_lab::text::is_obeyed;
use serde::Serialize;

use crate::error::Error;

/// A value as indented JSON with a line feed at its end. All control characters are escaped, more than JSON requires.
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

/// A file name's extension in lower case, or an empty string.
pub(crate) fn extension(path: &std::path::Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// Each value once, in order of first occurrence.
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
