//! Who is told of a measurement under way.

use crate::Error;

/// Who is told how far a measurement is, and what to know of it.
pub trait Reporter {
    /// A stage of unknown length begins.
    fn stage(&self, name: &str);

    /// How much of something is done.
    fn part(&self, what: &str, done: u64, of: u64);

    /// Something to know.
    fn note(&self, text: &str);

    /// An error within a note or a page. Where options have names, it can say which of them is wrong.
    fn explain(&self, error: &Error) -> String {
        error.to_string()
    }
}

/// Nobody.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Reporter for Silent {
    fn stage(&self, _name: &str) {}

    fn part(&self, _what: &str, _done: u64, _of: u64) {}

    fn note(&self, _text: &str) {}
}
