//! `docs/performance.md` and `docs/performance-notes.md`: keeps their prose, and regenerates everything between
//! `<!-- NAME -->` and `<!-- /NAME -->`.

mod answer;
mod meshes;
mod paper;
mod passes;
mod plot;
mod scaling;
mod text;

use std::path::{Path, PathBuf};

use crate::csvs;
use crate::machine::About;
use crate::row::{Probe, Row};

/// A machine's measurements.
pub(crate) struct Measured {
    /// The folder's name.
    name: String,
    about: About,
    rows: Vec<Row>,
    probes: Vec<Probe>,
}

impl Measured {
    fn read(folder: &Path) -> Result<Self, String> {
        let name = folder.file_name().and_then(|n| n.to_str()).ok_or("a folder without a name")?.to_owned();
        let path = folder.join("machine.json");
        let json = std::fs::read(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        let about = serde_json::from_slice(&json).map_err(|e| format!("{}: {e}", path.display()))?;
        let (mut rows, mut probes) = (Vec::new(), Vec::new());
        for section in crate::sections::NAMES {
            let path = folder.join(format!("{section}.csv"));
            match section {
                "bytes" | "tdelta" => probes.extend(csvs::read::<Probe>(&path)?),
                _ => rows.extend(csvs::read::<Row>(&path)?),
            }
        }
        Ok(Self { name, about, rows, probes })
    }

    /// The rows of a section that have a time.
    fn timed<'a>(&'a self, section: &'a str) -> impl Iterator<Item = &'a Row> {
        self.rows.iter().filter(move |row| row.section == section && row.median_device_ns.is_some())
    }

    fn probed<'a>(&'a self, section: &'a str, what: &'a str) -> impl Iterator<Item = &'a Probe> {
        let is_wanted = move |p: &&Probe| p.section == section && p.what.starts_with(what);
        self.probes.iter().filter(is_wanted).filter(|p| p.median_device_ns.is_some())
    }

    /// For headings: the adapter without what its driver adds in brackets.
    fn title(&self) -> String {
        let name = self.about.name.split(" (").next().unwrap_or_default();
        match self.about.kind.as_str() {
            "software" => format!("{name}, software Vulkan on {} cores", self.about.cores),
            "processor" => format!("CPU with {} cores", self.about.cores),
            _ => name.to_owned(),
        }
    }
}

/// The pages with blocks.
const PAGES: [&str; 3] = ["performance.md", "performance-notes.md", "paper-tables.md"];

/// Reads folders, writes plots and pages.
pub(crate) fn write(folders: &[PathBuf]) -> Result<(), String> {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
    let machines = folders.iter().map(|f| Measured::read(f)).collect::<Result<Vec<_>, _>>()?;
    let mut pages = Vec::new();
    for path in PAGES.map(|name| docs.join(name)) {
        let page = std::fs::read_to_string(&path).map_err(|e| at(&path, &e))?;
        pages.push((path, page));
    }
    for machine in &machines {
        let folder = docs.join("performance").join(&machine.name);
        std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        scaling::plots(machine, &folder)?;
        paper::plot(machine, &folder)?;
    }
    type Block = fn(&Measured) -> String;
    let blocks: [(&str, Block); 10] = [
        ("answer", answer::answer),
        ("machines", answer::machine),
        ("paper", paper::tables),
        ("why", paper::why),
        ("triangles", scaling::triangles),
        ("resolution", scaling::resolution),
        ("steps", scaling::steps),
        ("bytes", passes::bytes),
        ("tdelta", passes::tdelta),
        ("meshes", meshes::tables),
    ];
    for (name, block) in blocks {
        let mut made = String::new();
        for machine in &machines {
            let text = block(machine);
            if !text.is_empty() {
                let heading = if name == "machines" { String::new() } else { format!("**{}**\n\n", machine.title()) };
                made += &format!("{heading}{}\n\n", text.trim_end());
            }
        }
        replace(&mut pages, name, made.trim_end())?;
    }
    replace(&mut pages, "work", meshes::work(&machines).trim_end())?;
    pages.into_iter().try_for_each(|(path, page)| std::fs::write(&path, page).map_err(|e| at(&path, &e)))
}

fn at(path: &Path, error: &std::io::Error) -> String {
    format!("{}: {error}", path.display())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prose_stays_and_blocks_are_made_anew() {
        let page = "prose\n<!-- a -->\nold\n<!-- /a -->\nmore <!-- b --><!-- /b -->\n";
        let once = replaced(page, "a", "new").expect("markers");
        assert_eq!(once, "prose\n<!-- a -->\nnew\n<!-- /a -->\nmore <!-- b --><!-- /b -->\n");
        assert_eq!(replaced(&once, "a", "new").as_deref(), Ok(once.as_str()), "again changes nothing");
        assert!(replaced(page, "c", "").is_err());
    }
}
