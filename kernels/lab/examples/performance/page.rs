//! `docs/performance.md` and the pages beside it: keeps their prose, and regenerates everything between `<!-- NAME -->`
//! and `<!-- /NAME -->`.

mod meshes;
mod paper;
mod passes;
mod scaling;

use std::path::{Path, PathBuf};

use raystep_lab::human::{digits, time};
use raystep_lab::plots::{self, Dash, Draw as _, Format, Plot, Series, Stroke};
use raystep_lab::tidy::{Row, Table};
use serde_json::Value;

use crate::bytes;
use crate::measure::{COLUMNS, SECTIONS, write as write_file};

/// A machine's measurements.
pub(crate) struct Measured {
    /// The folder's name.
    name: String,
    about: Value,
    rows: Vec<Row>,
}

impl Measured {
    fn read(folder: &Path) -> Result<Self, String> {
        let at = |path: &Path, e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
        let name = folder.file_name().and_then(|n| n.to_str()).ok_or("a folder without a name")?.to_owned();
        let path = folder.join("machine.json");
        let json = std::fs::read(&path).map_err(|e| at(&path, &e))?;
        let about = serde_json::from_slice(&json).map_err(|e| at(&path, &e))?;
        let mut rows = Vec::new();
        for section in SECTIONS {
            let path = folder.join(format!("{section}.csv"));
            let columns = if matches!(section, "bytes" | "tdelta") { bytes::COLUMNS } else { COLUMNS };
            // A section may not have been measured.
            let Ok(file) = std::fs::read(&path) else { continue };
            rows.extend(Table::read(columns, &file).ok_or_else(|| at(&path, &"other columns"))?.rows);
        }
        Ok(Self { name, about, rows })
    }

    /// The rows of a section that have a time.
    fn of<'a>(&'a self, section: &'a str) -> impl Iterator<Item = &'a Row> {
        self.rows.iter().filter(move |row| row.is(&[("section", section)]) && row.number("median_ns").is_some())
    }

    /// The different fields of a column in a section, in order of first appearance.
    fn fields(&self, section: &str, column: &str) -> Vec<&str> {
        distinct(self.rows.iter().filter(|row| row.get("section") == section).map(|row| row.get(column)))
    }

    fn is_cpu(&self) -> bool {
        self.about["adapter"].is_null()
    }

    /// For headings: the adapter without what its driver adds in brackets.
    fn title(&self) -> String {
        let name = self.about["name"].as_str().and_then(|name| name.split(" (").next()).unwrap_or_default();
        match self.about["adapter"]["kind"].as_str() {
            Some("software") => format!("{name}, software Vulkan on {} cores", self.about["cores"]),
            Some(_) => name.to_owned(),
            None => format!("CPU with {} cores", self.about["cores"]),
        }
    }

    /// Writes a plot, and returns what shows it on a page.
    fn plot(&self, folder: &Path, name: &str, alternative: &str, plot: Plot) -> Result<String, String> {
        let points = plot.panels.iter().flat_map(|panel| &panel.series).flat_map(|s| &s.points).count();
        let Some(picture) = plot.picture(Format::TwoColumns).filter(|_| points > 1) else { return Ok(String::new()) };
        write_file(&folder.join(format!("{name}.svg")), picture.svg().as_bytes())?;
        Ok(format!("![{alternative}](performance/{}/{name}.svg)\n", self.name))
    }
}

/// The pages with blocks.
const PAGES: [&str; 3] = ["performance.md", "performance-notes.md", "paper-tables.md"];

/// Makes a block of a machine; plots go to the folder.
type Block = fn(&Measured, &Path) -> Result<String, String>;

const BLOCKS: [(&str, Block); 10] = [
    ("answer", |machine, _| Ok(meshes::answer(machine))),
    ("machines", |machine, _| Ok(meshes::machine(machine))),
    ("paper", paper::tables),
    ("why", |machine, _| Ok(paper::why(machine))),
    ("triangles", scaling::triangles),
    ("resolution", scaling::resolution),
    ("steps", scaling::steps),
    ("bytes", |machine, _| Ok(passes::bytes(machine))),
    ("tdelta", |machine, _| Ok(passes::tdelta(machine))),
    ("meshes", |machine, _| Ok(meshes::tables(machine))),
];

/// Reads folders, writes plots and pages.
pub(crate) fn write(folders: &[PathBuf]) -> Result<(), String> {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
    let machines = folders.iter().map(|f| Measured::read(f)).collect::<Result<Vec<_>, _>>()?;
    let mut pages = Vec::new();
    for path in PAGES.map(|name| docs.join(name)) {
        let page = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        pages.push((path, page));
    }
    for (name, block) in BLOCKS {
        let mut made = String::new();
        for machine in &machines {
            let folder = docs.join("performance").join(&machine.name);
            std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
            let text = block(machine, &folder)?;
            if !text.is_empty() {
                let heading = if name == "machines" { String::new() } else { format!("**{}**\n\n", machine.title()) };
                made += &format!("{heading}{}\n\n", text.trim_end());
            }
        }
        replace(&mut pages, name, made.trim_end())?;
    }
    replace(&mut pages, "work", meshes::work(&machines).trim_end())?;
    pages.into_iter().try_for_each(|(path, page)| write_file(&path, page.as_bytes()))
}

/// Replaces the text between two markers, in the page that has them.
fn replace(pages: &mut [(PathBuf, String)], name: &str, text: &str) -> Result<(), String> {
    let begin = format!("<!-- {name} -->");
    let page = pages.iter_mut().map(|(_, page)| page).find(|page| page.contains(&begin));
    let page = page.ok_or_else(|| format!("no page has {begin}"))?;
    *page = replaced(page, name, text)?;
    Ok(())
}

/// The page with another text between two markers.
fn replaced(page: &str, name: &str, text: &str) -> Result<String, String> {
    let (begin, end) = (format!("<!-- {name} -->"), format!("<!-- /{name} -->"));
    let missing = || format!("no page has {begin} with a {end} after it");
    let (before, rest) = page.split_once(&begin).ok_or_else(missing)?;
    let (_, after) = rest.split_once(&end).ok_or_else(missing)?;
    Ok(format!("{before}{begin}\n{text}\n{end}{after}"))
}

/// A configuration for display: `grid with skipping, compact K=8`.
fn name(row: &Row) -> String {
    let steps = match row.get("steps_per_pass") {
        "" => String::new(),
        steps => format!(" K={steps}"),
    };
    let skip = if row.get("skip") == "on" { " with skipping" } else { "" };
    format!("{}{skip}, {}{steps}", row.get("accelerator"), row.get("schedule"))
}

fn mray_per_s(row: &Row) -> Option<f64> {
    Some(row.number("rays")? / row.number("median_ns").filter(|&ns| ns > 0.0)? * 1e3)
}

/// One column divided by another; unknown if that is zero.
fn ratio(row: &Row, of: &str, to: &str) -> Option<f64> {
    Some(row.number(of)? / row.number(to)?).filter(|ratio| ratio.is_finite())
}

fn percent(share: f64) -> String {
    format!("{} %", digits(share * 100.0))
}

/// A value or a dash.
fn or_dash(value: Option<f64>, text: fn(f64) -> String) -> String {
    value.map_or("–".into(), text)
}

/// A Markdown table; the first column is text, the others are numbers. Nothing without rows.
fn table<T: AsRef<str>>(columns: &[T], rows: &[Vec<String>]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let names: Vec<&str> = columns.iter().map(AsRef::as_ref).collect();
    let rule = " --- |".to_owned() + &" ---: |".repeat(names.len() - 1);
    let rows: String = rows.iter().map(|row| format!("| {} |\n", row.join(" | "))).collect();
    format!("| {} |\n|{rule}\n{rows}\n", names.join(" | "))
}

/// Distinct values in order of first appearance.
fn distinct<T: PartialEq>(values: impl IntoIterator<Item = T>) -> Vec<T> {
    values.into_iter().fold(Vec::new(), |mut all, value| {
        if !all.contains(&value) {
            all.push(value);
        }
        all
    })
}

/// Times over counts, both logarithmic.
fn over(title: String, x: &str, series: Vec<Series>) -> Plot {
    let y = plots::Axis { text: time, ..plots::Axis::new("time", plots::Scale::Log) };
    Plot::new(title, plots::Axis::new(x, plots::Scale::Log), y, series)
}

fn line(name: String, color: usize, is_dashed: bool, points: Vec<(f64, f64)>) -> Series {
    let stroke = Stroke::Line(if is_dashed { Dash::Dashed } else { Dash::Solid });
    Series { stroke, ..Series::line(name, color, points) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_few_digits_and_unknown_ones_are_dashes() {
        let row = Row::new(COLUMNS).set("accelerator", "grid").set("skip", "on").set("schedule", "compact");
        let row = row.set("steps_per_pass", 8).set("rays", 2_000_000).set("median_ns", 4e6).set("tests_per_ray", 0.0);
        let row = row.set("repeated_per_ray", 0.0).set("cells_per_ray", 5.0);
        assert_eq!((name(&row).as_str(), mray_per_s(&row)), ("grid with skipping, compact K=8", Some(500.0)));
        let shares = ["tests_per_ray", "cells_per_ray"].map(|to| ratio(&row, "repeated_per_ray", to));
        assert_eq!(shares.map(|share| or_dash(share, percent)), ["–", "0 %"], "nothing is a share of nothing");
        assert_eq!(or_dash(ratio(&row, "rays", "hits"), digits), "–");
        assert_eq!([0.0732, 1.0].map(percent), ["7.32 %", "100 %"]);
        let one = [vec!["a".to_owned(), digits(66_450.0)]];
        assert_eq!(table(&["", "n"], &one), "|  | n |\n| --- | ---: |\n| a | 66,450 |\n\n");
        assert_eq!(table(&["", "n"], &[]), "");
    }

    #[test]
    fn prose_stays_and_blocks_are_made_anew() {
        let page = "prose\n<!-- a -->\nold\n<!-- /a -->\nmore <!-- b --><!-- /b -->\n";
        let once = replaced(page, "a", "new").expect("markers");
        assert_eq!(once, "prose\n<!-- a -->\nnew\n<!-- /a -->\nmore <!-- b --><!-- /b -->\n");
        assert_eq!(replaced(&once, "a", "new").as_deref(), Ok(once.as_str()), "again changes nothing");
        assert!(replaced(page, "c", "").is_err());
    }
}
