//! What is wrong with a user's WGSL, and where.

use std::error::Error;
use std::fmt;

use crate::options::replacement::Replacement;

/// A place in a user's file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file.
    pub file: String,
    /// Line, from 1; 0 if the place is in none of its lines.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// The text of the line.
    pub text: String,
}

/// What is wrong with a user's WGSL, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mistake {
    /// Where.
    pub place: Place,
    /// What.
    pub message: String,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            0 => f.write_str(&self.file),
            line => write!(f, "{}:{line}:{}", self.file, self.column),
        }
    }
}

impl fmt::Display for Mistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.message)
    }
}

impl Mistake {
    /// The line and, below it, a caret at the place; `None` if it has no place.
    #[must_use]
    pub fn excerpt(&self) -> Option<String> {
        if self.place.line == 0 {
            return None;
        }
        // Tabs keep their width, so that the caret stays below its character.
        let text = self.place.text.trim_end();
        let indent: String =
            text.chars().take(self.place.column - 1).map(|c| if c == '\t' { '\t' } else { ' ' }).collect();
        Some(format!("    {text}\n    {indent}^"))
    }
}

impl Error for Mistake {}

/// The place of a byte in a file's text.
pub(super) fn place_of(by: &Replacement, at: usize) -> Place {
    place_in(&by.file, &by.source, at)
}

/// The place of a byte in a text.
pub(crate) fn place_in(file: &str, source: &str, at: usize) -> Place {
    let mut at = at.min(source.len());
    while !source.is_char_boundary(at) {
        at -= 1;
    }
    let first = source[..at].rfind('\n').map_or(0, |end| end + 1);
    let text = source[first..].lines().next().unwrap_or_default().to_owned();
    let (line, column) = (source[..first].matches('\n').count() + 1, source[first..at].chars().count() + 1);
    Place { file: file.to_owned(), line, column, text }
}
