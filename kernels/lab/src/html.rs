//! The common parts of generated HTML pages. They need no other file, script or network, and follow the browser's light
//! or dark theme.

use crate::text::visible;

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
