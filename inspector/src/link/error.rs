//! Errors in links: one line with the problem, its place, and what is valid.

use super::{VERSION, keys};

/// A text is not a link.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LinkError {
    /// It has another beginning.
    #[error("{0:?} is not a link: links start with \"raystep:{VERSION}?\"")]
    NotALink(String),
    /// It is of another version.
    #[error("the link has version {0:?}, but this raystep reads version {VERSION}")]
    Version(String),
    /// Text between two `&` is not a pair.
    #[error("{0:?}: expected KEY=VALUE")]
    NoValue(String),
    /// An unknown key.
    #[error("{0:?} is not a key of a link; the keys are {keys}", keys = keys().collect::<Vec<_>>().join(", "))]
    UnknownKey(String),
    /// A duplicate key.
    #[error("{0} is there twice: omit one")]
    Twice(&'static str),
    /// Two keys that exclude each other.
    #[error("{0} and {1} exclude each other: omit one")]
    Both(&'static str, &'static str),
    /// A key that requires another one.
    #[error("{0} requires {1}: add {1}, or omit {0}")]
    Without(&'static str, &'static str),
    /// An invalid value.
    #[error("{key}={value:?}: {wanted}")]
    Value {
        /// The key.
        key: &'static str,
        /// The value; the start of a long one.
        value: String,
        /// The valid values.
        wanted: String,
    },
}

/// The start of a text, enough to locate the error.
pub(super) fn start(text: &str) -> String {
    const MOST: usize = 40;
    match text.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.into(),
    }
}
