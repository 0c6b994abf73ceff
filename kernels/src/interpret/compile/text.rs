//! Places in the source.

use std::ops::Range;

/// What is between the first parentheses after a name that begins here.
pub(in crate::interpret) fn arguments(source: &str, start: usize) -> Option<Range<usize>> {
    let rest = source.get(start..)?;
    let open =
        rest.find(|c: char| !c.is_alphanumeric() && c != '_' && c != ' ').filter(|&at| rest[at..].starts_with('('))?;
    let mut depth = 0usize;
    for (at, c) in rest.char_indices().skip_while(|&(at, _)| at < open) {
        match c {
            '(' => depth += 1,
            ')' => depth = depth.checked_sub(1)?,
            _ => {}
        }
        if depth == 0 {
            return Some(start + open + 1..start + at);
        }
    }
    None
}

/// The last of several arguments.
pub(in crate::interpret) fn last_of(source: &str, inside: Range<usize>) -> Option<Range<usize>> {
    let text = source.get(inside.clone())?;
    let (mut depth, mut first) = (0usize, 0);
    for (at, c) in text.char_indices() {
        match c {
            '(' | '[' => depth += 1,
            ')' | ']' => depth = depth.checked_sub(1)?,
            // A comma at the end is followed by nothing.
            ',' if depth == 0 && !text[at + 1..].trim().is_empty() => first = at + 1,
            _ => {}
        }
    }
    let last = text[first..].trim();
    let start = inside.start + first + (text[first..].len() - text[first..].trim_start().len());
    Some(start..start + last.trim_end_matches(',').len())
}

/// The line of a byte, from 0.
pub(in crate::interpret) fn line_of(source: &str, byte: usize) -> usize {
    source.bytes().take(byte).filter(|&b| b == b'\n').count()
}
