//! `index.html`: one page that needs no other files. Its numbers are copied from the CSV files.

use std::fmt::Write as _;

use super::section::SECTIONS;
use crate::html::{self, escaped};
use crate::plots;
use crate::subject::Size;
use crate::tidy::Row;

/// A section's results for one scene.
#[derive(Clone, Debug, Default)]
pub(super) struct Part {
    /// Paragraphs, as HTML.
    pub(super) prose: Vec<String>,
    /// Missing results with reasons, and other notes, as plain text.
    pub(super) notes: Vec<String>,
    figures: Vec<Figure>,
    /// As HTML.
    tables: Vec<String>,
}

/// What the whiskers of times show.
pub(super) const WHISKERS: &str =
    "Whiskers show the 5th to the 95th percentile, or the full range for fewer than 20 repeats.";

/// A plot with its caption.
#[derive(Clone, Debug)]
struct Figure {
    svg: String,
    caption: String,
}

impl Part {
    /// Adds a plot, if there is one.
    pub(super) fn figure(&mut self, svg: Option<String>, caption: &str) {
        self.figures.extend(svg.map(|svg| Figure { svg, caption: caption.to_owned() }));
    }

    /// Adds a table with some of the columns.
    pub(super) fn table<'a>(&mut self, rows: impl IntoIterator<Item = &'a Row>, columns: &[&str]) {
        let rows: Vec<&Row> = rows.into_iter().collect();
        if rows.is_empty() {
            return;
        }
        // Numbers are right-aligned, words left-aligned.
        let is_words =
            |column: &str| rows.iter().any(|row| row.number(column).is_none() && !row.get(column).is_empty());
        let class: Vec<&str> = columns.iter().map(|c| if is_words(c) { " class=\"l\"" } else { "" }).collect();
        let mut html = String::from("<div class=\"wide\"><table><tr>");
        // Writing to a string cannot fail.
        for (column, class) in columns.iter().zip(&class) {
            let _ = write!(html, "<th{class}>{}</th>", escaped(&column.replace('_', " ")));
        }
        html += "</tr>\n";
        for row in rows {
            html += "<tr>";
            for (column, class) in columns.iter().zip(&class) {
                let _ = write!(html, "<td{class}>{}</td>", escaped(row.get(column)));
            }
            html += "</tr>\n";
        }
        html += "</table></div>\n";
        self.tables.push(html);
    }

    /// The plots, to be written to files.
    pub(super) fn svgs(&self) -> impl Iterator<Item = &str> {
        self.figures.iter().map(|f| f.svg.as_str())
    }
}

/// A field of a CSV in a paragraph, as HTML.
pub(super) fn number(field: &str) -> String {
    format!("<b class=\"n\">{}</b>", if field.is_empty() { "?" } else { field })
}

/// A scene of the report.
pub(super) struct Scene {
    pub(super) name: String,
    /// Its path.
    pub(super) file: String,
    pub(super) triangles: usize,
    /// Image size.
    pub(super) size: Size,
    /// By section, in their order; sections that were not requested are missing.
    pub(super) parts: Vec<(&'static str, Part)>,
}

/// Machine and command: names with values.
pub type About = Vec<(&'static str, String)>;

/// The page.
pub(super) fn html(about: &About, scenes: &[Scene]) -> String {
    let mut page = String::from(
        "<h1>Error against run time</h1>\n<p>The cost of each choice in a ray tracer, in time and in wrong rays. A \
         ray is wrong if its hit differs from that of f64 brute force with exact predicates at edges, and f32 could \
         have decided it; a ray that f32 cannot decide is called undecided and is not an error. Every number in \
         tables, text and legends is in a CSV file beside this page, in the same form; notes have numbers of their \
         own. Compare times only within this report.</p>\n<table>\n",
    );
    for (name, value) in about {
        let _ = writeln!(page, "<tr><th class=\"l\">{name}</th><td class=\"l a\">{}</td></tr>", escaped(value));
    }
    page += "</table>\n<p>";
    for (i, scene) in scenes.iter().enumerate() {
        let _ = write!(page, "<a href=\"#scene-{i}\">{}</a>: ", escaped(&scene.name));
        for (key, _) in &scene.parts {
            let title = SECTIONS.iter().find(|s| s.name == *key).map_or("", |s| s.title);
            let _ = write!(page, "<a href=\"#{key}-{i}\">{}</a> · ", title.to_lowercase());
        }
        page += "<br>";
    }
    page += "</p>\n";
    for (i, scene) in scenes.iter().enumerate() {
        let _ = write!(
            page,
            "<h2 class=\"s\" id=\"scene-{i}\">{}</h2>\n<p>{}: {} triangles; views of {} × {} pixels.</p>\n",
            escaped(&scene.name),
            escaped(&scene.file),
            number(&scene.triangles.to_string()),
            number(&scene.size.width.to_string()),
            number(&scene.size.height.to_string())
        );
        for (key, part) in &scene.parts {
            section(&mut page, i, key, part);
        }
    }
    html::page(super::KNOWN_BY, &style(), &page)
}

fn section(page: &mut String, scene: usize, key: &str, part: &Part) {
    let Some(section) = SECTIONS.iter().find(|s| s.name == key) else { return };
    let _ = write!(
        page,
        "<h3 id=\"{key}-{scene}\">{}</h3>\n<p>{} All of it is in <code>{}</code>.</p>\n",
        section.title, section.what, section.file
    );
    for paragraph in &part.prose {
        let _ = writeln!(page, "<p>{paragraph}</p>");
    }
    for Figure { svg, caption } in &part.figures {
        let _ = writeln!(page, "<figure>{}<figcaption>{}</figcaption></figure>", plots::inline(svg), escaped(caption));
    }
    part.tables.iter().for_each(|table| *page += table);
    if !part.notes.is_empty() {
        *page += "<p class=\"note\">Notes:</p><ul class=\"note\">";
        for note in &part.notes {
            let _ = write!(page, "<li>{}</li>", escaped(note));
        }
        *page += "</ul>\n";
    }
}

/// Styles that only this page needs.
fn style() -> String {
    "h2.s{border-top:2px solid var(--head);padding-top:1rem;font-size:1.4rem}h3{font-size:1.15rem;margin:2rem 0 .3rem}\
     figure{margin:.6rem 0}td.a{white-space:normal}ul{max-width:50rem;font-size:.85rem}"
        .to_owned()
        + &plots::style()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_text_and_numbers_are_fields() {
        const COLUMNS: &[&str] = &["schema_version", "scene", "rays_per_s"];
        let row = Row::new(COLUMNS).set("scene", "<b>").set("rays_per_s", 12.5);
        let mut part = Part::default();
        part.table([&row], COLUMNS);
        part.notes.push("a < b".into());
        let size = Size { width: 3, height: 2 };
        let parts = vec![(SECTIONS[0].name, part)];
        let scenes = [Scene { name: "<x>".into(), file: "1 & 2".into(), triangles: 7, size, parts }];
        let page = html(&vec![("command", "raystep \"x\"".into())], &scenes);
        assert!(page.contains("<th class=\"l\">scene</th>") && page.contains("<th>rays per s</th>"), "{page}");
        assert!(page.contains("<td class=\"l\">&lt;b&gt;</td><td>12.5</td>") && page.contains("a &lt; b"));
        assert!(page.contains("raystep &quot;x&quot;") && !page.contains("<x>") && page.contains("1 &amp; 2"));
    }
}
