//! WGSL's words, for highlighting and for finding its blocks. Any text is cut: what is no WGSL is plain.

use std::ops::Range;

use raystep_kernels::compose::{self, WordKind};

/// What a word is.
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

/// A word, or a sign.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Word {
    /// Bytes of the text.
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

/// Cuts a text as it is composed, but an attribute and the parentheses after it are one word; spaces are left out.
pub(super) fn words(text: &str) -> Vec<Word> {
    let bytes = text.as_bytes();
    let mut words: Vec<Word> = Vec::new();
    for word in compose::words(text) {
        if words.last().is_some_and(|last| word.start < last.range.end) {
            continue;
        }
        let mut end = word.end();
        let class = match word.kind {
            WordKind::Comment => Class::Comment,
            WordKind::Number => Class::Number,
            WordKind::Sign => Class::Plain,
            WordKind::Name => class_of(word.text, text[end..].trim_start_matches(' ').starts_with('(')),
            WordKind::Attribute => {
                if bytes.get(end) == Some(&b'(') {
                    end = closed(bytes, end);
                }
                Class::Attribute
            }
        };
        words.push(Word { range: word.start..end, class });
    }
    words
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

/// Behind the parenthesis that closes the one at `open`, or at the line's end.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_wgsl_have_their_classes() {
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
    fn any_text_is_split_into_words_without_a_rest() {
        for text in ["", "@", "@if(", "/*", "/* /*", "1.", "0x", "1e-", "深(", "a\u{0}b", "}}{{((", "*/", "\"'\\"] {
            let end = words(text).last().map_or(0, |w| w.range.end);
            assert_eq!(end, text.len(), "{text}");
        }
    }
}
