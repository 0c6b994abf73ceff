//! Splits WGSL into words, for highlighting and for finding its blocks. Any text can be split: anything that is not
//! WGSL is plain.

use std::ops::Range;

/// The class of a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// `fn`, `let`, `if`, …
    Keyword,
    /// `u32`, `vec3f`, `Candidate`, …
    Type,
    /// A number.
    Number,
    /// `// …`
    Comment,
    /// `@if(grid)`, `@group(0)`, …
    Attribute,
    /// A name that is called or declared with parentheses.
    Function,
    /// Everything else.
    Plain,
}

/// A word or punctuation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Word {
    /// Byte range in the text.
    pub(super) range: Range<usize>,
    pub(super) class: Class,
}

const KEYWORDS: &[&str] = &[
    "alias",
    "break",
    "case",
    "const",
    "const_assert",
    "continue",
    "continuing",
    "default",
    "diagnostic",
    "discard",
    "else",
    "enable",
    "false",
    "fn",
    "for",
    "if",
    "import",
    "let",
    "loop",
    "override",
    "requires",
    "return",
    "struct",
    "switch",
    "true",
    "var",
    "while",
];

const TYPES: &[&str] = &["array", "atomic", "bool", "f16", "f32", "i32", "ptr", "sampler", "u32"];

/// Splits a text; omits whitespace.
pub(super) fn words(text: &str) -> Vec<Word> {
    let bytes = text.as_bytes();
    let mut words = Vec::new();
    let mut at = 0;
    let run =
        |from: usize, of: fn(u8) -> bool| bytes[from..].iter().position(|&b| !of(b)).map_or(bytes.len(), |n| from + n);
    while at < bytes.len() {
        let rest = &bytes[at..];
        let (end, class) = match rest[0] {
            b if b.is_ascii_whitespace() => {
                at += 1;
                continue;
            }
            b'/' if rest.starts_with(b"//") => (run(at, |b| b != b'\n'), Class::Comment),
            b'/' if rest.starts_with(b"/*") => (block_comment(bytes, at), Class::Comment),
            b'@' => {
                let name = run(at + 1, is_name);
                (if bytes.get(name) == Some(&b'(') { closed(bytes, name) } else { name }, Class::Attribute)
            }
            b'0'..=b'9' => (number(bytes, at), Class::Number),
            b if is_name(b) => {
                let end = run(at, is_name);
                (end, class_of(&text[at..end], bytes[run(end, |b| b == b' ')..].first() == Some(&b'(')))
            }
            _ => (at + 1, Class::Plain),
        };
        words.push(Word { range: at..end, class });
        at = end;
    }
    words
}

/// Part of a name, including every byte of a non-ASCII letter.
fn is_name(b: u8) -> bool {
    b == b'_' || b.is_ascii_alphanumeric() || b >= 0x80
}

fn class_of(name: &str, is_called: bool) -> Class {
    let is_vector = |prefix| name.strip_prefix(prefix).is_some_and(|rest| rest.starts_with(['2', '3', '4']));
    let has_lower = name.bytes().any(|b| b.is_ascii_lowercase());
    if KEYWORDS.contains(&name) {
        Class::Keyword
    } else if TYPES.contains(&name)
        || name.starts_with("texture_")
        || is_vector("vec")
        || is_vector("mat")
        || (name.starts_with(|c: char| c.is_ascii_uppercase()) && has_lower)
    {
        Class::Type
    } else if is_called {
        Class::Function
    } else {
        Class::Plain
    }
}

/// The end of a number: `1`, `1u`, `0x3fu`, `1.5`, `1e-37`.
fn number(bytes: &[u8], start: usize) -> usize {
    let is_hex = bytes[start..].starts_with(b"0x");
    let is_part = |at: usize| {
        let is_exponent = |b: u8| matches!((b, is_hex), (b'e' | b'E', false) | (b'p' | b'P', true));
        match bytes[at] {
            b'.' => true,
            b'+' | b'-' => is_exponent(bytes[at - 1]),
            b => b.is_ascii_alphanumeric(),
        }
    };
    (start + 1..bytes.len()).find(|&at| !is_part(at)).unwrap_or(bytes.len())
}

/// The position after the parenthesis that closes the one at `open`, or the end of the line.
fn closed(bytes: &[u8], open: usize) -> usize {
    let mut depth = 0usize;
    for (at, b) in bytes.iter().enumerate().skip(open) {
        match b {
            b'(' => depth += 1,
            b')' if depth == 1 => return at + 1,
            b')' => depth -= 1,
            b'\n' => return at,
            _ => {}
        }
    }
    bytes.len()
}

/// The position after a comment; comments nest.
fn block_comment(bytes: &[u8], start: usize) -> usize {
    let (mut at, mut depth) = (start, 0usize);
    while at < bytes.len() {
        if bytes[at..].starts_with(b"/*") {
            (at, depth) = (at + 2, depth + 1);
        } else if bytes[at..].starts_with(b"*/") {
            (at, depth) = (at + 2, depth - 1);
            if depth == 0 {
                return at;
            }
        } else {
            at += 1;
        }
    }
    bytes.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_have_their_classes() {
        let cases = [
            ("let", Class::Keyword),
            ("vec3f", Class::Type),
            ("texture_2d_array", Class::Type),
            ("Candidate", Class::Type),
            ("NO_NODE", Class::Plain),
            ("0x3fffffffu", Class::Number),
            ("1e-37", Class::Number),
            ("@if(grid && (robust || !bvh))", Class::Attribute),
            ("// a + b", Class::Comment),
            ("/* a /* b */ c */", Class::Comment),
            ("origin", Class::Plain),
        ];
        for (text, class) in cases {
            assert_eq!(words(text), [Word { range: 0..text.len(), class }], "{text}");
        }
        let all = words("walk = advance(walk);");
        assert_eq!(all.iter().map(|w| w.class).filter(|&c| c == Class::Function).count(), 1);
    }

    #[test]
    fn any_text_is_cut() {
        for text in ["", "@", "@if(", "/*", "/* /*", "1.", "0x", "1e-", "深(", "a\u{0}b", "}}{{((", "*/", "\"'\\"] {
            let end = words(text).last().map_or(0, |w| w.range.end);
            assert_eq!(end, text.len(), "{text}");
        }
    }
}
