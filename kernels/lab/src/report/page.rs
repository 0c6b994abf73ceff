//! `index.html`: one page that needs no other files. The answer for each scene is on its first screen; its numbers are
//! fields of the CSV files, in units for people.

use std::fmt::Write as _;
use std::sync::Arc;

use super::section::SECTIONS;
use crate::html::{self, cell, data, escaped};
use crate::plots::{self, Draw, Format};
use crate::subject::Size;
use crate::text::counted;
use crate::tidy::Row;

/// A section's results for one scene.
#[derive(Clone, Debug, Default)]
pub(super) struct Part {
    /// Sentences for the top of the scene, as HTML.
    pub(super) lead: Vec<String>,
    /// Figures for the top of the scene, side by side.
    pub(super) lead_figures: Vec<Figure>,
    /// A table for the top of the scene.
    pub(super) lead_table: Option<LeadTable>,
    /// Paragraphs, as HTML.
    pub(super) prose: Vec<String>,
    /// Whether figures and tables are folded: of little interest to most readers.
    pub(super) is_folded: bool,
    /// Missing results with reasons, and other notes, as plain text.
    pub(super) notes: Vec<String>,
    figures: Vec<Figure>,
    /// As HTML.
    tables: Vec<String>,
}

/// A table for the top of a scene.
#[derive(Clone, Debug)]
pub(super) struct LeadTable {
    /// Names of columns.
    pub(super) names: Vec<&'static str>,
    /// Cells, as HTML.
    pub(super) rows: Vec<Vec<String>>,
    /// What its readers need to know, as plain text.
    pub(super) note: String,
}

/// A plot with its caption.
#[derive(Clone, Debug)]
pub(super) struct Figure {
    /// Part of its file's name.
    name: &'static str,
    pub(super) plot: Arc<dyn Draw + Send + Sync>,
    /// As an element of the page.
    inline: String,
    pub(super) caption: String,
}

impl Figure {
    /// `None` if there is nothing to show.
    fn new(name: &'static str, plot: impl Draw + Send + Sync + 'static, caption: impl Into<String>) -> Option<Self> {
        Some(Self { name, inline: plot.inline()?, plot: Arc::new(plot), caption: caption.into() })
    }
}

impl Part {
    /// Adds a plot, if there is one. The caption says what is shown, of how many measurements, and by which method; the
    /// page adds scene, adapter and seed.
    pub(super) fn figure(
        &mut self,
        name: &'static str,
        plot: impl Draw + Send + Sync + 'static,
        caption: impl Into<String>,
    ) {
        self.figures.extend(Figure::new(name, plot, caption));
    }

    /// Adds a plot to the top of the scene.
    pub(super) fn lead_figure(
        &mut self,
        name: &'static str,
        plot: impl Draw + Send + Sync + 'static,
        caption: impl Into<String>,
    ) {
        self.lead_figures.extend(Figure::new(name, plot, caption));
    }

    /// Adds a folded table.
    pub(super) fn table<'a>(&mut self, rows: impl IntoIterator<Item = &'a Row>) {
        let rows: Vec<_> = rows.into_iter().map(|row| ("", row)).collect();
        if !rows.is_empty() {
            let summary = format!("Table, {}", counted(rows.len(), "row"));
            self.tables.push(html::folded(&summary, false, &html::of_rows(rows)));
        }
    }
}

/// A field of a CSV in a paragraph, as HTML.
pub(super) fn number(column: &str, row: &Row) -> String {
    let field = row.get(column);
    if field.is_empty() { "?".into() } else { format!("<b>{}</b>", cell(column, field)) }
}

/// A number that is in `about.csv`.
fn about_number(value: usize) -> String {
    let text = value.to_string();
    data(&text, &crate::human::field("", &text))
}

/// A scene of the report.
pub(super) struct Scene {
    pub(super) name: String,
    /// Its path.
    pub(super) file: String,
    pub(super) triangles: usize,
    /// Image size.
    pub(super) size: Size,
    /// How many rays of a file stand for those of the view.
    pub(super) rays: Option<usize>,
    /// Start of its files' names.
    pub(super) slug: String,
    /// By section, in their order; sections that were not requested are missing.
    pub(super) parts: Vec<(&'static str, Part)>,
}

impl Scene {
    /// The figures, each with the start of its files' names.
    pub(super) fn named_figures(&self) -> impl Iterator<Item = (String, &Figure)> {
        self.parts.iter().flat_map(move |(section, part)| {
            let figures = part.lead_figures.iter().chain(&part.figures);
            figures.map(move |figure| (stem(&self.slug, section, figure.name), figure))
        })
    }

    /// The figures' files, for papers.
    pub(super) fn figures(&self) -> impl Iterator<Item = (String, Vec<u8>)> {
        self.named_figures().flat_map(|(stem, figure)| figure.plot.files(&stem))
    }

    /// A figure's caption, as HTML.
    pub(super) fn caption(&self, figure: &Figure, common: &str) -> String {
        format!("{} {}, {common}", figure.caption, escaped(&self.name))
    }
}

/// The start of the names of a figure's files: the same in every report of the same scenes.
fn stem(slug: &str, section: &str, name: &str) -> String {
    format!("{slug}-{section}-{name}")
}

/// Machine and command: names with values.
pub type About = Vec<(&'static str, String)>;

/// What the captions of all figures end with, as HTML: adapter and seed.
pub(super) fn common(about: &About, seed: u32) -> String {
    let value = |wanted: &str| about.iter().find(|(name, _)| *name == wanted).map_or("", |(_, value)| value);
    format!("{}; seed {}.", escaped(value("adapter")), data(&seed.to_string(), &seed.to_string()))
}

/// The page.
pub(super) fn html(about: &About, scenes: &[Scene], seed: u32) -> String {
    let common = common(about, seed);
    let mut page = String::new();
    if scenes.len() > 1 {
        let link = |(i, scene): (usize, &Scene)| format!("<a href=\"#scene-{i}\">{}</a>", escaped(&scene.name));
        let links: Vec<String> = scenes.iter().enumerate().map(link).collect();
        let _ = writeln!(page, "<p class=\"nav\">{}</p>", links.join(" · "));
    }
    for (i, scene) in scenes.iter().enumerate() {
        of_scene(&mut page, i, scene, &common);
    }
    page += "<h2 class=\"s\" id=\"about\">About this report</h2>\n<p>Wrong: the ray hits something else than exact \
             arithmetic finds (f64, edges decided exactly), although f32's error bounds allow only that result. Undecided: it hits \
             something else, but the bounds allow more than one result; not counted as wrong. Every number is a field of \
             a CSV file beside this page; <a href=\"datapackage.json\">datapackage.json</a> describes their columns, and every timed run is in \
             <a href=\"runs.csv\">runs.csv</a>. Compare times only within this report.</p>\n<table>\n";
    for (name, value) in about {
        let _ = writeln!(page, "<tr><th class=\"l\">{name}</th><td class=\"l a\">{}</td></tr>", escaped(value));
    }
    page += "</table>\n";
    html::page(super::KNOWN_BY, &style(), &page)
}

fn of_scene(page: &mut String, i: usize, scene: &Scene, common: &str) {
    let rays = match scene.rays {
        Some(rays) => format!("{} rays of a file", about_number(rays)),
        None => {
            let [width, height] = [scene.size.width, scene.size.height].map(|side| about_number(side as usize));
            format!("{width} × {height} pixels")
        }
    };
    let _ = writeln!(
        page,
        "<h1 id=\"scene-{i}\">{} <small>error against run time · {} triangles · {rays} · {}</small></h1>",
        escaped(&scene.name),
        about_number(scene.triangles),
        escaped(&scene.file),
    );
    let parts = || scene.parts.iter().map(|(_, part)| part);
    for sentence in parts().flat_map(|part| &part.lead) {
        let _ = writeln!(page, "<p class=\"lead\">{sentence}</p>");
    }
    let caption = |figure: &Figure| scene.caption(figure, common);
    *page += "<div class=\"pair\">";
    for (key, part) in &scene.parts {
        part.lead_figures.iter().for_each(|figure| drawn(page, &scene.slug, key, figure, &caption(figure)));
    }
    *page += "</div>\n";
    for lead in parts().filter_map(|part| part.lead_table.as_ref()) {
        let rows: Vec<_> = lead.rows.iter().map(|cells| ("", cells.clone())).collect();
        *page += &html::table(&lead.names, &rows, "lead");
        let _ = writeln!(page, "<p class=\"note\">{}</p>", escaped(&lead.note));
    }
    let link = |(key, _): &(&'static str, Part)| {
        let title = SECTIONS.iter().find(|s| s.name == *key).map_or("", |s| s.title);
        format!("<a href=\"#{key}-{i}\">{title}</a>")
    };
    let links: Vec<String> = scene.parts.iter().map(link).collect();
    let _ = writeln!(page, "<p class=\"nav\">{} · <a href=\"#about\">About</a></p>", links.join(" · "));
    for (key, part) in &scene.parts {
        let Some(section) = SECTIONS.iter().find(|s| s.name == *key) else { continue };
        let _ = write!(
            page,
            "<section><h3 id=\"{key}-{i}\">{}</h3>\n<p>{} Data: <a href=\"{2}\">{2}</a>.</p>\n",
            section.title, section.what, section.file
        );
        for paragraph in &part.prose {
            let _ = writeln!(page, "<p>{paragraph}</p>");
        }
        let mut body = String::new();
        part.figures.iter().for_each(|figure| drawn(&mut body, &scene.slug, key, figure, &caption(figure)));
        body.extend(part.tables.iter().map(String::as_str));
        *page += &if part.is_folded { html::folded("Figures and table", false, &body) } else { body };
        *page += &html::list(&part.notes, "note");
        *page += "</section>\n";
    }
}

fn drawn(page: &mut String, slug: &str, section: &str, figure: &Figure, caption: &str) {
    let stem = stem(slug, section, figure.name);
    let links = Format::PAPER.map(|format| {
        let name = format.name();
        let link = |kind: &str| format!("<a href=\"{stem}-{name}.{kind}\">{}</a>", kind.to_uppercase());
        format!("{}: {} {}", name.replace('-', " "), link("pdf"), link("svg"))
    });
    *page += &html::figure(&figure.inline, &format!("{caption} For a paper, {}.", links.join(", ")));
}

/// Styles that only this page needs.
fn style() -> String {
    "body{margin:.4rem auto}h1{font-size:1.25rem;margin:0}h1~h1{border-top:2px solid var(--head);margin-top:3rem;\
     padding-top:.6rem;break-before:page}h1 small{font-size:.85rem;font-weight:400;color:var(--dim)}\
     h2.s{border-top:2px solid var(--head);padding-top:.6rem}\
     h3{font-size:1.15rem;margin:2rem 0 .3rem}figure{margin:.4rem 0}td.a{white-space:normal}\
     ul{max-width:50rem;font-size:.85rem}p.lead{font-size:.95rem;line-height:1.36;max-width:none;margin:.2rem 0}\
     .pair{display:flex;gap:1rem;align-items:flex-start}.pair figure{flex:1 1 0;min-width:0;margin:0}\
     .pair figcaption{line-height:1.25}.wide table.lead{font-size:.82rem;margin:.2rem 0}table.lead td,table.lead th{padding:.02rem .6rem;\
     line-height:1.35}p.note{font-size:.78rem;line-height:1.25;max-width:none;margin:.1rem 0}\
     .nav{font-size:.85rem;max-width:none}summary{cursor:pointer;font-size:.85rem}\
     @media(max-width:900px){.pair{display:block}}\
     @media print{body{max-width:none;margin:0}.nav{display:none}details::details-content{content-visibility:visible;\
     height:auto}figure,tr{break-inside:avoid}}"
        .to_owned()
        + &plots::style()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_text_and_numbers_are_fields() {
        const COLUMNS: &[&str] = columns![schema_version accelerator median_ns rule];
        let row = Row::new(COLUMNS).set("accelerator", "<b>").set("median_ns", 12_500.0);
        let mut part = Part::default();
        part.table([&row]);
        part.notes.push("a < b".into());
        let size = Size { width: 3, height: 2 };
        let parts = vec![(SECTIONS[0].name, part)];
        let (name, file, slug) = ("<x>".into(), "1 & 2".into(), "x".into());
        let scenes = [Scene { name, file, slug, triangles: 7, size, rays: None, parts }];
        let page = html(&vec![("command", "raystep \"x\"".into())], &scenes, 5);
        assert!(page.contains("<th class=\"l\">accelerator</th><th>median</th></tr>"), "{page}");
        assert!(page.contains("<data value=\"12500\">12.5 µs</data>") && page.contains("a &lt; b"));
        assert!(page.contains("raystep &quot;x&quot;") && !page.contains("<x>") && page.contains("1 &amp; 2"));
    }
}
