//! Text output: tables in columns, with control characters escaped.

use std::borrow::Cow;
use std::fmt::Display;

/// Whether a terminal, a browser or an editor would act on a character instead of showing it: control characters (C0,
/// DEL, C1), line and paragraph separators, and bidirectional controls.
#[must_use]
pub fn is_obeyed(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// One line with every character visible: those that would be acted on are escaped as in Rust.
#[must_use]
pub fn visible(line: &str) -> Cow<'_, str> {
    escaped(line, |_, _| false)
}

/// The same for text with tabs and line ends, which stay.
#[must_use]
pub fn visible_lines(text: &str) -> Cow<'_, str> {
    escaped(text, |c, next| matches!(c, '\n' | '\t') || c == '\r' && next == Some('\n'))
}

/// Escapes the characters that would be acted on, unless `may_stay` accepts the character and the one after it.
fn escaped(text: &str, may_stay: fn(char, Option<char>) -> bool) -> Cow<'_, str> {
    if !text.contains(is_obeyed) {
        return Cow::Borrowed(text);
    }
    let mut escaped = String::with_capacity(text.len() + 16);
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        if is_obeyed(c) && !may_stay(c, rest.peek().copied()) {
            escaped.extend(c.escape_default());
        } else {
            escaped.push(c);
        }
    }
    Cow::Owned(escaped)
}

/// A number and its noun: "1 pass", "2 passes", "3 leaves".
#[must_use]
pub fn counted<N: Display + PartialEq + From<bool>>(count: N, noun: &str) -> String {
    if count == N::from(true) {
        return format!("{count} {noun}");
    }
    match noun.strip_suffix('f') {
        Some(stem) => format!("{count} {stem}ves"),
        None if noun.ends_with("ss") => format!("{count} {noun}es"),
        None => format!("{count} {noun}s"),
    }
}

/// Lines of a table, each with a line feed, and two spaces between columns. The first `left` columns are left-aligned
/// words, the others right-aligned numbers. Lines may have fewer cells than others.
#[must_use]
pub fn aligned(lines: &[impl AsRef<[String]>], left: usize) -> Vec<String> {
    let columns = lines.iter().map(|line| line.as_ref().len()).max().unwrap_or(0);
    let width = |c: usize| lines.iter().filter_map(|l| l.as_ref().get(c)).map(|t| t.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let cell = |(c, text): (usize, &String)| {
        let width = widths[c];
        if c < left { format!("{text:<width$}") } else { format!("{text:>width$}") }
    };
    let line = |cells: &[String]| cells.iter().enumerate().map(cell).collect::<Vec<_>>().join("  ");
    lines.iter().map(|cells| line(cells.as_ref()).trim_end().to_owned() + "\n").collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_terminal_would_obey_is_shown_instead() {
        assert_eq!(visible("\u{1b}[31mred\u{7}"), "\\u{1b}[31mred\\u{7}");
        assert_eq!(visible("a\nb\tc\r"), "a\\nb\\tc\\r");
        // DEL, CSI as one character, bidirectional overrides and isolates, separators.
        for c in ['\0', '\u{7f}', '\u{9b}', '\u{202e}', '\u{2066}', '\u{2069}', '\u{200f}', '\u{61c}', '\u{2028}'] {
            let shown = visible(&format!("a{c}b")).into_owned();
            assert_eq!(shown, format!("a\\u{{{:x}}}b", u32::from(c)));
        }
        assert!(matches!(visible("schach brett ü – данные 日本 👩‍🚀.png"), Cow::Borrowed(_)), "nothing to escape");
    }

    #[test]
    fn lines_keep_their_ends_and_nothing_else() {
        assert_eq!(visible_lines("a\tb\r\nc\n"), "a\tb\r\nc\n");
        assert_eq!(visible_lines("over\rwritten\u{1b}[2J\n"), "over\\rwritten\\u{1b}[2J\n");
    }

    #[test]
    fn nouns_agree_with_their_numbers() {
        let counts = [counted(1_u32, "pass"), counted(0_usize, "pass"), counted(2_u64, "leaf"), counted(1_u8, "leaf")];
        assert_eq!(counts, ["1 pass", "0 passes", "2 leaves", "1 leaf"]);
        assert_eq!(counted(12_usize, "triangle"), "12 triangles");
    }

    #[test]
    fn words_stand_at_the_left_and_numbers_at_the_right() {
        let lines = [vec!["a".to_owned(), "12".into()], vec!["bcd".to_owned(), "3".into()], vec!["e".to_owned()]];
        assert_eq!(aligned(&lines, 1), ["a    12\n", "bcd   3\n", "e\n"]);
        assert_eq!(aligned(&[Vec::<String>::new()], 0), ["\n"]);
    }
}
