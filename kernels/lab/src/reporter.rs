//! Receivers of progress reports.

use crate::Error;

/// Receives progress and notes of a measurement, which may move from thread to thread.
pub trait Reporter: Sync {
    /// The reporter that receives what this one does not; none by default.
    fn next(&self) -> Option<&dyn Reporter> {
        None
    }

    /// Begins a stage of unknown length.
    fn stage(&self, name: &str) {
        self.next().into_iter().for_each(|next| next.stage(name));
    }

    /// Reports progress of a stage.
    fn part(&self, what: &str, done: u64, of: u64) {
        self.next().into_iter().for_each(|next| next.part(what, done, of));
    }

    /// Adds a note.
    fn note(&self, text: &str) {
        self.next().into_iter().for_each(|next| next.note(text));
    }

    /// Shows the rows of a table that grows while a measurement goes on, all of them each time, under these names.
    fn rows(&self, names: &[&'static str], rows: &[Vec<String>]) {
        self.next().into_iter().for_each(|next| next.rows(names, rows));
    }

    /// Whether to stop: the measurement then ends with [`Error::Cancelled`].
    fn is_cancelled(&self) -> bool {
        self.next().is_some_and(|next| next.is_cancelled())
    }

    /// The text of an error in a note or a page. If options have names, it can name the wrong one.
    fn explain(&self, error: &Error) -> String {
        self.next().map_or_else(|| error.to_string(), |next| next.explain(error))
    }
}

/// Ignores everything.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Reporter for Silent {}
