//! WGSL as words: as much of its grammar as it takes to find attributes, braces and names.

use std::ops::Range;

/// A name or number, an attribute (`@` with its name), or one character of anything else; comments are none.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Word<'a> {
    pub(super) text: &'a str,
    /// Byte at which it begins.
    pub(super) start: usize,
}

impl Word<'_> {
    pub(super) fn end(&self) -> usize {
        self.start + self.text.len()
    }

    pub(super) fn is_name(&self) -> bool {
        self.text.starts_with(|c: char| c == '_' || c.is_alphabetic())
    }
}

fn is_part_of_name(c: char) -> bool {
    c == '_' || c.is_alphanumeric()
}

/// Cuts a text into words.
pub(super) fn words(text: &str) -> Vec<Word<'_>> {
    let mut words = Vec::new();
    let mut at = 0;
    while let Some(first) = text[at..].chars().next() {
        let rest = &text[at..];
        let length = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            block_comment(rest)
        } else if first.is_whitespace() {
            first.len_utf8()
        } else {
            let sign = if first == '@' { 1 } else { 0 };
            let name = rest[sign..].find(|c| !is_part_of_name(c)).map_or(rest.len(), |end| end + sign);
            let length = name.max(first.len_utf8());
            words.push(Word { text: &rest[..length], start: at });
            length
        };
        at += length;
    }
    words
}

/// Bytes of a comment of several lines; they nest.
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

/// The number, from 1, of the line that a byte is on.
pub(super) fn line_of(text: &str, at: usize) -> usize {
    text[..at].matches('\n').count() + 1
}

/// The beginning of the comment lines right above a byte, or of its own line where there is nothing before it but
/// spaces; else the byte itself.
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

/// A text without some of its bytes; a line of which only spaces are left goes too.
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
