//! The text of a lesson: paragraphs with `**strong**`, `` `code` ``, `*emphasis*` and `{{values}}`.

use super::error::Wrong;
use super::expression::Expression;

/// How words are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Style {
    /// `**strong**`
    pub strong: bool,
    /// `` `code` ``: the screen has to show it outside of the lesson.
    pub code: bool,
    /// `*emphasis*`
    pub emphasis: bool,
}

/// Words, or a value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Content {
    /// Words.
    Text(String),
    /// A value of the run.
    Value(Expression),
}

/// A part of a paragraph in one style.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// The line in the file, from 1.
    pub line: usize,
    /// How it is shown.
    pub style: Style,
    /// What it is.
    pub content: Content,
}

/// A paragraph, or an item of a list.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Paragraph {
    /// Whether it is an item of a list.
    pub is_item: bool,
    /// Its parts.
    pub parts: Vec<Part>,
}

/// Reads a paragraph from its lines with their numbers.
pub(super) fn paragraph(lines: &[(usize, &str)], is_item: bool) -> Result<Paragraph, (usize, Wrong)> {
    let mut reader = Reader { parts: Vec::new(), text: String::new(), style: Style::default(), line: 0 };
    for (i, (line, text)) in lines.iter().enumerate() {
        if i > 0 {
            reader.text.push(' ');
        }
        if reader.text.is_empty() || i == 0 {
            reader.line = *line;
        }
        reader.read(*line, text.trim()).map_err(|wrong| (*line, wrong))?;
    }
    reader.flush();
    let first = lines.first().map_or(0, |(line, _)| *line);
    let Style { strong, code, emphasis } = reader.style;
    let open = [(strong, "**"), (code, "`"), (emphasis, "*")].into_iter().find(|(is_open, _)| *is_open);
    match open {
        Some((_, mark)) => Err((first, Wrong::Unclosed(mark))),
        None => Ok(Paragraph { is_item, parts: reader.parts }),
    }
}

/// The text between double quotes.
pub(super) fn quoted(word: &'static str, text: &str) -> Result<String, Wrong> {
    let inner = text.strip_prefix('"').and_then(|rest| rest.strip_suffix('"'));
    let inner = inner.filter(|inner| !inner.trim().is_empty());
    inner.map(str::to_owned).ok_or_else(|| Wrong::Argument(word, "expected a text in double quotes".into()))
}

struct Reader {
    parts: Vec<Part>,
    /// Words since the last part.
    text: String,
    style: Style,
    /// The line in which they begin.
    line: usize,
}

impl Reader {
    fn read(&mut self, line: usize, mut rest: &str) -> Result<(), Wrong> {
        while !rest.is_empty() {
            if let Some(after) = rest.strip_prefix("{{") {
                let (name, after) = after.split_once("}}").ok_or(Wrong::Unclosed("{{"))?;
                self.flush();
                let content = Content::Value(Expression::parse(name.trim())?);
                self.parts.push(Part { line, style: self.style, content });
                rest = after;
            } else if let Some(after) = rest.strip_prefix('`') {
                self.flush();
                self.style.code = !self.style.code;
                rest = after;
            } else if let Some(after) = rest.strip_prefix("**").filter(|_| !self.style.code) {
                self.flush();
                self.style.strong = !self.style.strong;
                rest = after;
            } else if let Some(after) = rest.strip_prefix('*').filter(|_| !self.style.code) {
                self.flush();
                self.style.emphasis = !self.style.emphasis;
                rest = after;
            } else {
                let end = rest.char_indices().skip(1).find(|(_, c)| matches!(c, '{' | '`' | '*'));
                let (words, after) = rest.split_at(end.map_or(rest.len(), |(at, _)| at));
                if self.text.is_empty() {
                    self.line = line;
                }
                self.text.push_str(words);
                rest = after;
            }
        }
        Ok(())
    }

    /// Ends the words so far.
    fn flush(&mut self) {
        if !self.text.is_empty() {
            let content = Content::Text(std::mem::take(&mut self.text));
            self.parts.push(Part { line: self.line, style: self.style, content });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_paragraph_has_styles_and_values() {
        let lines =
            [(7, "A ray is a **texel**: `state` and *its* {{ray.cells}} cells,"), (8, "**{{passes}}** of 2 { 3")];
        let read = paragraph(&lines, false).expect("a paragraph");
        let shown: Vec<_> = read.parts.iter().map(|p| (p.line, p.style, format!("{:?}", p.content))).collect();
        let (plain, strong) = (Style::default(), Style { strong: true, ..Style::default() });
        let code = Style { code: true, ..plain };
        let emphasis = Style { emphasis: true, ..plain };
        let text = |text: &str| format!("{:?}", Content::Text(text.into()));
        let value = |name: &str| format!("{:?}", Content::Value(Expression::parse(name).expect("a value")));
        let expected = [
            (7, plain, text("A ray is a ")),
            (7, strong, text("texel")),
            (7, plain, text(": ")),
            (7, code, text("state")),
            (7, plain, text(" and ")),
            (7, emphasis, text("its")),
            (7, plain, text(" ")),
            (7, plain, value("ray.cells")),
            (7, plain, text(" cells, ")),
            (8, strong, value("passes")),
            (8, plain, text(" of 2 { 3")),
        ];
        assert_eq!(shown, expected);
    }

    #[test]
    fn marks_without_a_partner_are_errors() {
        for (line, mark) in [("a **b", "**"), ("a `b", "`"), ("a *b", "*"), ("a {{passes", "{{")] {
            assert_eq!(paragraph(&[(3, line)], false), Err((3, Wrong::Unclosed(mark))), "{line}");
        }
        let unknown = paragraph(&[(3, "a"), (4, "{{speed}}")], false);
        assert_eq!(unknown, Err((4, Wrong::Name("speed".into()))));
    }
}
