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

/// Columns that tables of a page do not show: of interest to programs only, or shown by the cells of others.
const HIDDEN: &[&str] = columns![
    version seed is_quick interval_method interval_level min_ns max_ns clock ratio_to wrong_per_million is_last
    is_lower_bound
];

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

/// Rows of a CSV file as a table, without [hidden](HIDDEN) and empty columns; nothing without rows. Columns that are the
/// same in several rows are a sentence above the table.
pub(crate) fn of_rows<'a>(rows: impl IntoIterator<Item = (Class, &'a Row)>) -> String {
    let rows: Vec<(Class, &Row)> = rows.into_iter().collect();
    let Some((_, first)) = rows.first() else { return String::new() };
    let is_shown =
        |c: &&str| !KEYS.contains(c) && !HIDDEN.contains(c) && rows.iter().any(|(_, row)| !row.get(c).is_empty());
    let differs = |c: &&str| rows.len() == 1 || rows.iter().any(|(_, row)| row.get(c) != first.get(c));
    let (columns, same): (Vec<&str>, Vec<&str>) = first.columns().iter().copied().filter(is_shown).partition(differs);
    let names: Vec<String> = columns.iter().map(|c| name_of(c)).collect();
    let cells = |(class, row): &(Class, &Row)| (*class, columns.iter().map(|c| cell_of(c, row)).collect());
    let table = table(&names, &rows.iter().map(cells).collect::<Vec<_>>(), "");
    let same: Vec<String> = same.iter().map(|c| format!("{} = {}", name_of(c), cell_of(c, first))).collect();
    if same.is_empty() { table } else { format!("<p class=\"note\">In all rows: {}.</p>\n{table}", same.join("; ")) }
}

/// A field of a row: what failed is red, and the time of a stopped run is a lower bound.
fn cell_of(column: &str, row: &Row) -> String {
    let is_bound = || row.columns().contains(&"is_lower_bound") && row.get("is_lower_bound") == "true";
    match (column, cell(column, row.get(column))) {
        ("result", cell) if row.get(column) == "fail" => format!("<span class=\"fail\">{cell}</span>"),
        ("median_ns" | "ns_per_ray", cell) if is_bound() => format!("≥ {cell}"),
        (_, cell) => cell,
    }
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
    match column.split_once('_') {
        Some((of @ ("t" | "u" | "v"), "relative")) => return format!("{of}, relative"),
        Some(("t", "ulp")) => return "t, ulp".into(),
        Some((of @ ("u" | "v"), "ulp")) => return format!("{of}, ulp of 1"),
        _ => {}
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

    const COLUMNS: &[&str] = columns![schema_version accelerator schedule ns_per_ray is_lower_bound u_ulp result];

    fn row(accelerator: &str, is_lower_bound: bool, result: &str) -> Row {
        let row = Row::new(COLUMNS).set("accelerator", accelerator).set("schedule", "fused").set("ns_per_ray", 20.0);
        row.set("is_lower_bound", is_lower_bound).set("u_ulp", 0.5).set("result", result)
    }

    #[test]
    fn what_is_the_same_in_several_rows_is_said_once() {
        let [one, other] = [row("bvh", false, "pass"), row("grid", false, "pass")];
        let html = of_rows([("", &one), ("odd", &other)]);
        let same = "In all rows: schedule = fused; ns per ray = 20 ns; u, ulp of 1 = 0.5; result = pass.";
        assert!(plain(&html).starts_with(same), "{html}");
        assert!(html.contains("<tr><th class=\"l\">accelerator</th></tr>\n<tr class=\"\"><td"), "{html}");
        let single = of_rows([("", &one)]);
        assert!(single.contains("<th>ns per ray</th><th>u, ulp of 1</th>") && !single.contains("<p"), "{single}");
        assert_eq!(of_rows([]), "");
    }

    #[test]
    fn failures_are_red_and_stopped_runs_are_lower_bounds() {
        let html = of_rows([("", &row("bvh", true, "fail"))]);
        assert!(html.contains("<td>≥ <data value=\"20\">20 ns</data></td>"), "{html}");
        assert!(html.contains("<span class=\"fail\"><data value=\"fail\">fail</data></span>"), "{html}");
        let html = of_rows([("", &row("bvh", false, "pass"))]);
        assert!(!html.contains('≥') && !html.contains("\"fail\""), "{html}");
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
