//! The common parts of generated HTML pages. They need no other file, script or network, and follow the browser's light
//! or dark theme.

use std::fmt::Write as _;

use crate::human::field;
use crate::text::visible;
use crate::tidy::{KEYS, Row};

/// Named colours, and the elements that every page has.
const STYLE: &str = "\
:root{color-scheme:light dark;--ink:#222;--paper:#fff;--dim:#555;--rule:#e4e4e0;--head:#999;--bad:#b01525;--odd:#fde9e9}\
@media(prefers-color-scheme:dark){:root{--ink:#ddd;--paper:#15181b;--dim:#a2a7ab;--rule:#33383c;--head:#778;--bad:#ff7d86;\
--odd:#4a2226}}body{font:15px/1.5 system-ui,sans-serif;color:var(--ink);background:var(--paper);max-width:76rem;margin:2rem \
auto;padding:0 1rem}h1{font-size:1.6rem}h2{font-size:1.2rem;margin:2.5rem 0 .3rem}p{margin:.3rem 0;max-width:50rem}\
a{color:inherit}table{border-collapse:collapse;margin:.8rem 0;font-size:.82rem}th,td{padding:.15rem .55rem;border-bottom:1px \
solid var(--rule);text-align:right;white-space:nowrap}th{font-weight:600;text-align:right;border-bottom:1px solid \
var(--head)}.l{text-align:left}.fail{color:var(--bad)}.odd{background:var(--odd)}.note{color:var(--dim)}figcaption{font-size:\
.78rem;color:var(--dim)}.wide{overflow-x:auto}";

/// A page. `style` is added to the common style sheet; title and body are HTML.
#[must_use]
pub fn page(title: &str, style: &str, body: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width\"><title>{title}</title><style>{STYLE}{style}</style></head><body>\n{body}</body></html>\n"
    )
}

/// Escapes text for HTML elements and attributes. HTML cannot express control characters, and bidirectional controls
/// would reorder the text that follows: both are shown as escapes, as in a terminal.
#[must_use]
pub fn escaped(text: &str) -> String {
    let text = visible(text);
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;").replace('\'', "&#39;")
}

/// A field of a CSV file as HTML: shown for people, with the field itself for programs.
pub(crate) fn cell(column: &str, text: &str) -> String {
    if text.is_empty() {
        return String::new();
    }
    data(text, &field(column, text))
}

/// A field of a CSV file, shown as something else.
pub(crate) fn data(text: &str, shown: &str) -> String {
    format!("<data value=\"{}\">{}</data>", escaped(text), escaped(shown))
}

/// Columns that tables of a page do not show: the same in all rows, or of interest to programs only.
const HIDDEN: &[&str] = columns![version seed is_quick interval_method interval_level clock is_last];

/// A row's class in a table: marked as unexpected, or empty.
pub(crate) type Class = &'static str;

/// A row that is as expected, or one that is not.
pub(crate) fn mark(is_as_expected: bool) -> Class {
    if is_as_expected { "" } else { "odd" }
}

/// A table of HTML cells. Numbers are right-aligned, words left-aligned.
pub(crate) fn table<N: AsRef<str>>(names: &[N], rows: &[(Class, Vec<String>)], class: Class) -> String {
    let is_number = |cell: &String| {
        let text = cell.strip_prefix("<data value=\"").unwrap_or(cell);
        cell.is_empty()
            || text.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '-' | '−' | '–' | '+' | '≤' | '≥'))
    };
    let is_left = |c: usize| !rows.iter().filter_map(|(_, cells)| cells.get(c)).all(is_number);
    let left: Vec<&str> = (0..names.len()).map(|c| if is_left(c) { " class=\"l\"" } else { "" }).collect();
    let mut html = format!("<div class=\"wide\"><table class=\"{class}\"><tr>");
    // Writing to a string cannot fail.
    for (left, name) in left.iter().zip(names) {
        let _ = write!(html, "<th{left}>{}</th>", escaped(name.as_ref()));
    }
    for (class, cells) in rows {
        let _ = write!(html, "</tr>\n<tr class=\"{class}\">");
        for (left, cell) in left.iter().zip(cells) {
            let _ = write!(html, "<td{left}>{cell}</td>");
        }
    }
    html + "</tr>\n</table></div>\n"
}

/// Rows of a CSV file as a table, without [hidden](HIDDEN) and empty columns; nothing without rows.
pub(crate) fn of_rows<'a>(rows: impl IntoIterator<Item = (Class, &'a Row)>) -> String {
    let rows: Vec<(Class, &Row)> = rows.into_iter().collect();
    let Some((_, first)) = rows.first() else { return String::new() };
    let is_shown =
        |c: &&str| !KEYS.contains(c) && !HIDDEN.contains(c) && rows.iter().any(|(_, row)| !row.get(c).is_empty());
    let columns: Vec<&str> = first.columns().iter().copied().filter(is_shown).collect();
    let names: Vec<String> = columns.iter().map(|c| name_of(c)).collect();
    let cells = |(class, row): &(Class, &Row)| (*class, columns.iter().map(|c| cell(c, row.get(c))).collect());
    table(&names, &rows.iter().map(cells).collect::<Vec<_>>(), "")
}

/// A part of a page that is shown when it is opened. Both are HTML.
pub(crate) fn folded(summary: &str, is_open: bool, body: &str) -> String {
    let open = if is_open { " open" } else { "" };
    format!("<details{open}><summary>{summary}</summary>{body}</details>\n")
}

/// A list of texts; nothing without any.
pub(crate) fn list(texts: &[impl AsRef<str>], class: Class) -> String {
    if texts.is_empty() {
        return String::new();
    }
    let items: String = texts.iter().map(|text| format!("<li>{}</li>", escaped(text.as_ref()))).collect();
    format!("<ul class=\"{class}\">{items}</ul>\n")
}

/// A drawing, as an element, with its caption, as HTML.
pub(crate) fn figure(drawing: &str, caption: &str) -> String {
    format!("<figure>{drawing}<figcaption>{caption}</figcaption></figure>\n")
}

/// A column's name for people: units are with the numbers.
fn name_of(column: &str) -> String {
    if let Some(column) = column.strip_suffix("_with") {
        return name_of(column) + " with";
    }
    let bare = column.strip_suffix("_ns").or_else(|| column.strip_suffix("_s")).unwrap_or(column);
    let bare = bare.strip_suffix("_bytes").filter(|b| *b != "structure").unwrap_or(bare);
    bare.replace('_', " ")
}

/// Text of a fragment of a page, and whether it is emphasised: for a window.
pub type Span = (String, bool);

/// The text of a fragment of HTML, without its elements. Text in `strong` and `b` is emphasised.
#[must_use]
pub(crate) fn spans(html: &str) -> Vec<Span> {
    let mut spans: Vec<Span> = Vec::new();
    let mut depth = 0_usize;
    for (i, piece) in html.split('<').enumerate() {
        let (tag, text) = if i == 0 { ("", piece) } else { piece.split_once('>').unwrap_or((piece, "")) };
        match tag {
            "strong" | "b" => depth += 1,
            "/strong" | "/b" => depth = depth.saturating_sub(1),
            _ => {}
        }
        let text = text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&#39;", "'");
        let text = text.replace("&amp;", "&");
        match spans.last_mut() {
            Some((last, is_strong)) if *is_strong == (depth > 0) => *last += &text,
            _ if text.is_empty() => {}
            _ => spans.push((text, depth > 0)),
        }
    }
    spans
}

/// The text of a fragment of HTML, without its elements.
#[must_use]
pub(crate) fn plain(html: &str) -> String {
    spans(html).into_iter().map(|(text, _)| text).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_keeps_the_field_of_the_file() {
        assert_eq!(cell("median_ns", "120"), "<data value=\"120\">120 ns</data>");
        assert_eq!(cell("median_ns", ""), "");
    }

    #[test]
    fn text_is_not_markup() {
        assert_eq!(escaped("<a href=\"x\">&'"), "&lt;a href=&quot;x&quot;&gt;&amp;&#39;");
        assert_eq!(escaped("a\u{1b}b\u{202e}c"), "a\\u{1b}b\\u{202e}c");
    }

    #[test]
    fn a_fragment_has_text_and_emphasis() {
        let text = "a < b & \"c\" 'd'";
        let html = format!("<strong>{} <b>1</b></strong><data value=\"7\">7</data> <em>x</em>", escaped(text));
        assert_eq!(spans(&html), [(format!("{text} 1"), true), ("7 x".to_owned(), false)]);
        assert_eq!(spans(""), []);
        assert_eq!(plain(&html), format!("{text} 17 x"));
    }
}
