//! Splits WGSL into words: only as much of its grammar as is needed to find attributes, braces and names.

use std::ops::Range;

/// What a [`Word`] is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WordKind {
    /// `ray_origin`, `let`
    Name,
    /// `1`, `1u`, `0x3fu`, `1.5`, `1e-37`
    Number,
    /// `@` and a name; parentheses after it are separate words.
    Attribute,
    /// `// …`, or `/* … */` including nested ones.
    Comment,
    /// Any other single character.
    Sign,
}

/// A word of a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Word<'a> {
    /// Its text.
    pub text: &'a str,
    /// Byte offset of its start.
    pub start: usize,
    /// What it is.
    pub kind: WordKind,
}

impl Word<'_> {
    /// Byte offset after its last byte.
    #[must_use]
    pub fn end(&self) -> usize {
        self.start + self.text.len()
    }

    pub(super) fn is_name(&self) -> bool {
        self.kind == WordKind::Name
    }
}

fn is_part_of_name(c: char) -> bool {
    c == '_' || c.is_alphanumeric()
}

/// Length in bytes of the name at the start of `text`.
fn name(text: &str) -> usize {
    text.find(|c| !is_part_of_name(c)).unwrap_or(text.len())
}

/// Length in bytes of the number at the start of `text`.
fn number(text: &str) -> usize {
    let is_hex = text.starts_with("0x");
    let mut before = '0';
    let is_part = |c: char| {
        let is_exponent = matches!((before, is_hex), ('e' | 'E', false) | ('p' | 'P', true));
        before = c;
        c == '.' || c.is_ascii_alphanumeric() || matches!(c, '+' | '-') && is_exponent
    };
    text.len() - text.trim_start_matches(is_part).len()
}

/// Splits a text into words, including comments; only white space is left out. Accepts any text, WGSL or not.
#[must_use]
pub fn words(text: &str) -> Vec<Word<'_>> {
    let mut words = Vec::new();
    let mut at = 0;
    while let Some(first) = text[at..].chars().next() {
        let rest = &text[at..];
        let (length, kind) = match first {
            _ if first.is_whitespace() => {
                at += first.len_utf8();
                continue;
            }
            _ if rest.starts_with("//") => (rest.find('\n').unwrap_or(rest.len()), WordKind::Comment),
            _ if rest.starts_with("/*") => (block_comment(rest), WordKind::Comment),
            '@' => (1 + name(&rest[1..]), WordKind::Attribute),
            '0'..='9' => (number(rest), WordKind::Number),
            _ if first == '_' || first.is_alphabetic() => (name(rest), WordKind::Name),
            _ => (first.len_utf8(), WordKind::Sign),
        };
        words.push(Word { text: &rest[..length], start: at, kind });
        at += length;
    }
    words
}

/// The words that are not comments.
pub(super) fn code(text: &str) -> Vec<Word<'_>> {
    let mut words = words(text);
    words.retain(|word| word.kind != WordKind::Comment);
    words
}

/// Length in bytes of a block comment; block comments nest.
fn block_comment(text: &str) -> usize {
    let (mut depth, mut at) = (0usize, 0);
    loop {
        let Some(next) = text[at..].find("/*").into_iter().chain(text[at..].find("*/")).min() else {
            return text.len();
        };
        if text[at + next..].starts_with("/*") {
            depth += 1
        } else {
            depth -= 1
        }
        at += next + 2;
        if depth == 0 {
            return at;
        }
    }
}

/// The line number, from 1, of a byte offset.
pub(super) fn line_of(text: &str, at: usize) -> usize {
    text[..at].matches('\n').count() + 1
}

/// If only spaces precede a byte offset on its line, the start of that line, or of the comment lines right above it;
/// else the offset itself.
pub(super) fn with_comment_above(text: &str, at: usize) -> usize {
    let line = text[..at].rfind('\n').map_or(0, |end| end + 1);
    if !text[line..at].trim().is_empty() {
        return at;
    }
    let mut first = line;
    while first > 0 {
        let above = text[..first - 1].rfind('\n').map_or(0, |end| end + 1);
        if !text[above..first].trim_start().starts_with("//") {
            break;
        }
        first = above;
    }
    first
}

/// Replaces byte ranges of a text by spaces, but keeps their line breaks.
pub(crate) fn blanked(text: &str, removed: &[Range<usize>]) -> String {
    let mut bytes = text.as_bytes().to_vec();
    for byte in removed.iter().flat_map(|range| range.clone()) {
        if !matches!(bytes[byte], b'\n' | b'\r') {
            bytes[byte] = b' ';
        }
    }
    // Ranges begin and end at words, so no character was cut in two.
    String::from_utf8(bytes).unwrap_or_else(|_| text.to_owned())
}

/// Removes byte ranges from a text; a line of which only spaces remain is removed too.
pub(super) fn without(text: &str, removed: &[Range<usize>]) -> String {
    let mut marked = vec![false; text.len()];
    for range in removed {
        marked[range.clone()].fill(true);
    }
    let mut kept = String::with_capacity(text.len());
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let marks = &marked[start..start + line.len()];
        start += line.len();
        if !marks.contains(&true) {
            kept.push_str(line);
            continue;
        }
        let left: String = line.char_indices().filter(|&(at, _)| !marks[at]).map(|(_, c)| c).collect();
        if !left.trim().is_empty() {
            let indent = &line[..line.len() - line.trim_start().len()];
            kept.push_str(indent);
            kept.push_str(left.trim_start());
            if !left.ends_with('\n') && line.ends_with('\n') {
                kept.push('\n');
            }
        }
    }
    kept
}
