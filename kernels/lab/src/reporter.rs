//! Receivers of progress reports.

use crate::Error;

/// Receives progress and notes of a measurement, which may move from thread to thread.
pub trait Reporter: Sync {
    /// Begins a stage of unknown length.
    fn stage(&self, name: &str);

    /// Reports progress of a stage.
    fn part(&self, what: &str, done: u64, of: u64);

    /// Adds a note.
    fn note(&self, text: &str);

    /// Shows the rows of a table that grows while a measurement goes on, all of them each time, under these names.
    fn rows(&self, _names: &[&'static str], _rows: &[Vec<String>]) {}

    /// Whether to stop: the measurement then ends with [`Error::Cancelled`].
    fn is_cancelled(&self) -> bool {
        false
    }

    /// The text of an error in a note or a page. If options have names, it can name the wrong one.
    fn explain(&self, error: &Error) -> String {
        error.to_string()
    }
}

/// Ignores everything.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Reporter for Silent {
    fn stage(&self, _name: &str) {}

    fn part(&self, _what: &str, _done: u64, _of: u64) {}

    fn note(&self, _text: &str) {}
}
