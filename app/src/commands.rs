//! The subcommands, one file each, and what several of them need.

pub(crate) mod bench;
pub(crate) mod completions;
pub(crate) mod dump;
pub(crate) mod info;
pub(crate) mod plan;
pub(crate) mod render;
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
