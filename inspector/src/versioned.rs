//! JSON files with a version. They are untrusted: a file is read as a whole or not at all.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// A file cannot be read, or be written: one line that says why.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct FileError(String);

/// What files of one kind have in common.
pub(crate) struct FileKind {
    /// What errors call such a file.
    pub(crate) name: &'static str,
    /// Incremented when the meaning of something in it changes.
    pub(crate) version: u32,
    /// Largest file that is read or written, bytes.
    pub(crate) most_bytes: usize,
}

impl FileKind {
    /// Reads a file.
    pub(crate) fn read<T: DeserializeOwned>(&self, bytes: &[u8]) -> Result<T, FileError> {
        /// What every version has.
        #[derive(Deserialize)]
        struct Head {
            version: u32,
        }
        self.check_size(bytes.len())?;
        let text = std::str::from_utf8(bytes).map_err(|_| self.wrong("is not UTF-8"))?;
        // Other versions may have other fields: check the version first.
        let Head { version } = self.parse(text)?;
        if version != self.version {
            return Err(self.wrong(format!("has version {version}, but this raystep reads version {}", self.version)));
        }
        self.parse(text)
    }

    /// The file, unless it would be too large to be read again.
    pub(crate) fn write(&self, contents: &impl Serialize) -> Result<String, FileError> {
        let text = serde_json::to_string_pretty(contents);
        let text = text.map_err(|error| self.wrong(format!("cannot be saved: {error}")))? + "\n";
        self.check_size(text.len())?;
        Ok(text)
    }

    /// What is wrong with a file.
    pub(crate) fn wrong(&self, why: impl AsRef<str>) -> FileError {
        FileError(format!("{} {}", self.name, why.as_ref()))
    }

    fn check_size(&self, bytes: usize) -> Result<(), FileError> {
        let why = || self.wrong(format!("has {bytes} bytes: the limit is {}", self.most_bytes));
        if bytes > self.most_bytes { Err(why()) } else { Ok(()) }
    }

    fn parse<T: DeserializeOwned>(&self, text: &str) -> Result<T, FileError> {
        serde_json::from_str(text).map_err(|error| {
            let (line, column) = (error.line(), error.column());
            // serde_json's message ends with the position, which ours already contains.
            let place = format!(" at line {line} column {column}");
            let message = error.to_string();
            let message = message.strip_suffix(&place).unwrap_or(&message);
            // What a file contains may be long, and may hold line feeds.
            let message: String = message.split_whitespace().collect::<Vec<_>>().join(" ").chars().take(200).collect();
            self.wrong(format!("cannot be read: line {line}, column {column}: {message}"))
        })
    }
}
