//! Words and numbers of text, whose encoding is never trusted.

/// The byte order mark of UTF-8.
const MARK: &[u8] = b"\xef\xbb\xbf";

/// A file without a byte order mark.
pub(super) fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(MARK).unwrap_or(bytes)
}

/// A file from its first character on that is neither a byte order mark nor blank.
pub(super) fn trimmed(bytes: &[u8]) -> &[u8] {
    without_mark(bytes).trim_ascii_start()
}

/// Whether text starts with these bytes, after a byte order mark.
pub(super) fn starts_with(bytes: &[u8], start: &[u8]) -> bool {
    without_mark(bytes).starts_with(start)
}

/// Whether a file starts like UTF-16: by its byte order mark, or by two ASCII characters.
pub(super) fn is_utf16(bytes: &[u8]) -> bool {
    let is_ascii = |byte: u8| byte.is_ascii_graphic() || byte.is_ascii_whitespace();
    match bytes {
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => true,
        &[a, 0, b, 0, ..] | &[0, a, 0, b, ..] => is_ascii(a) && is_ascii(b),
        _ => false,
    }
}

/// The value of a number; NaN for other words, such as `-nan(ind)`.
pub(super) fn number(word: &[u8]) -> f64 {
    std::str::from_utf8(word).ok().and_then(|word| word.parse().ok()).unwrap_or(f64::NAN)
}

/// Splits off the first line: the line, and what follows its end, which is `\n`, `\r\n` or `\r`.
pub(super) fn split_line(text: &[u8]) -> (&[u8], &[u8]) {
    let end = text.iter().position(|byte| matches!(byte, b'\n' | b'\r')).unwrap_or(text.len());
    let (line, rest) = text.split_at(end);
    let rest = rest.strip_prefix(b"\r\n").or_else(|| rest.get(1..)).unwrap_or_default();
    (line, rest)
}

/// Splits off the first word between blanks: the word, and what follows it. Empty at the end of the text.
pub(super) fn split_word(text: &[u8]) -> (&[u8], &[u8]) {
    let text = text.trim_ascii_start();
    text.split_at(text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len()))
}

/// A word for a message: shortened, since it may be megabytes long.
pub(super) fn shown(word: &[u8]) -> String {
    const MOST: usize = 40;
    String::from_utf8_lossy(word.get(..MOST).unwrap_or(word))
        .chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_in_three_ways() {
        let mut rest: &[u8] = b"a\r\nb\rc\n\nd";
        let mut lines = Vec::new();
        while !rest.is_empty() {
            let (line, after) = split_line(rest);
            lines.push(line);
            rest = after;
        }
        assert_eq!(lines, [&b"a"[..], b"b", b"c", b"", b"d"]);
    }

    #[test]
    fn words_that_are_no_numbers_are_nan() {
        for word in ["", "x", "1,5", "-nan(ind)", "1.#QNAN", "1.#INF", "0x10", "1e", "\u{661}"] {
            assert!(number(word.as_bytes()).is_nan(), "{word}");
        }
        assert!(number(b"\xff1").is_nan());
        assert_eq!(
            [number(b"-0"), number(b"+1.5e2"), number(b".5"), number(b"1e400")],
            [0.0, 150.0, 0.5, f64::INFINITY]
        );
    }
}
