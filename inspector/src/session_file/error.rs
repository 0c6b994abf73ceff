//! Errors in session files: one line with the problem and its place.

use super::{MOST_BYTES, VERSION};

/// A session cannot be read, or be written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SessionFileError {
    /// It is too large.
    #[error("a session of {0} bytes: the limit is {MOST_BYTES}")]
    TooLarge(usize),
    /// It is not text.
    #[error("the session is not UTF-8")]
    NoText,
    /// It is of another version.
    #[error("the session has version {0}, but this raystep reads version {VERSION}")]
    Version(u32),
    /// Its link names no scene.
    #[error("the session names no scene: add scene=FILE to the link of \"here\"")]
    NoScene,
    /// It refers to a run that is not there.
    #[error("the session compares runs that it does not have: it has {0}, counted from 0")]
    NoRun(usize),
    /// It is not JSON, or not of this form.
    #[error("the session cannot be read: line {line}, column {column}: {message}")]
    Broken {
        /// From 1.
        line: usize,
        /// From 1.
        column: usize,
        /// The problem.
        message: String,
    },
    /// It cannot be written.
    #[error("the session cannot be saved: {0}")]
    Write(String),
}

impl From<serde_json::Error> for SessionFileError {
    fn from(error: serde_json::Error) -> Self {
        let (line, column) = (error.line(), error.column());
        // serde_json's message ends with the position, which ours already contains.
        let place = format!(" at line {line} column {column}");
        let message = error.to_string();
        let message = message.strip_suffix(&place).unwrap_or(&message);
        // What a file contains may be long, and may hold line feeds.
        let message: String = message.split_whitespace().collect::<Vec<_>>().join(" ").chars().take(200).collect();
        Self::Broken { line, column, message }
    }
}
