//! Why a text is no link: what, where, and what would be right, in one line.

use super::{KEYS, VERSION};

/// A text is no link.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LinkError {
    /// It begins otherwise.
    #[error("{0:?} is no link: one begins with \"raystep:{VERSION}?\"")]
    NotALink(String),
    /// It is of another version.
    #[error("the link is of version {0:?}, and this raystep reads version {VERSION}")]
    Version(String),
    /// Something between two `&` is no pair.
    #[error("{0:?}: a key, = and a value are wanted")]
    NoValue(String),
    /// A key that has no meaning.
    #[error("{0:?} is no key of a link; the keys are {keys}", keys = KEYS.join(", "))]
    UnknownKey(String),
    /// A key that is there twice.
    #[error("{0} is there twice: leave one out")]
    Twice(&'static str),
    /// Two keys of which one makes the other meaningless.
    #[error("{0} and {1} are both there: leave one out")]
    Both(&'static str, &'static str),
    /// A key without the one that gives it its meaning.
    #[error("{0} is there without {1}: add {1}, or leave {0} out")]
    Without(&'static str, &'static str),
    /// A value that its key cannot have.
    #[error("{key}={value:?}: {wanted}")]
    Value {
        /// The key.
        key: &'static str,
        /// The value; the start of a long one.
        value: String,
        /// What would be right.
        wanted: String,
    },
}

/// As much of a text as an error needs to say where it is.
pub(super) fn start(text: &str) -> String {
    const MOST: usize = 40;
    match text.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.into(),
    }
}
