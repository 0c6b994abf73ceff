//! The files of a report.

use std::io::Write as _;
use std::path::Path;

use super::page::{self, About, Scene};
use super::section::{SECTIONS, Section};
use super::table::Table;
use crate::error::Error;
use crate::output::{self, TargetFolder};

/// All of it.
pub(super) const PAGE: &str = "index.html";
/// On what, by which command, and of which scenes: `scene,name,value`.
const ABOUT: &str = "about.csv";

/// What a report's page begins with, by which the folder is known.
const KNOWN_BY: &str = "raystep: error against run time";

/// The name of a plot's file, counted from 1.
fn plot_name(index: usize) -> String {
    format!("plot-{index:03}.svg")
}

/// Whether a report may have a file of this name.
pub(super) fn is_ours(name: &str) -> bool {
    let is_plot = name.strip_prefix("plot-").and_then(|rest| rest.strip_suffix(".svg"));
    name == PAGE
        || name == ABOUT
        || SECTIONS.iter().any(|s| s.file == name)
        || is_plot.is_some_and(|digits| digits.len() == 3 && digits.bytes().all(|b| b.is_ascii_digit()))
}

/// The files of an earlier report that go with it: another one may have fewer sections, and fewer plots.
pub(super) fn plots_in(folder: &Path) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    names.filter(|name| is_ours(name)).collect()
}

/// Refuses a folder whose files of our names are not a report's.
pub(super) fn refuse_others(folder: &Path) -> Result<(), Error> {
    let names = plots_in(folder);
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let is_report = |bytes: &[u8]| {
        let head = &bytes[..bytes.len().min(1024)];
        head.windows(KNOWN_BY.len()).any(|w| w == KNOWN_BY.as_bytes())
    };
    output::refuse_others(folder, &names, "such report's", PAGE, is_report)
}

/// Writes every file.
pub(super) fn write(
    folder: &TargetFolder,
    about: &About,
    tables: &[(&Section, Table)],
    scenes: &[Scene],
) -> Result<(), Error> {
    for (section, table) in tables {
        folder.write(section.file, |out| table.write(out))?;
    }
    folder.write(ABOUT, |out| {
        let mut writer = raystep_kernels::export::csv::writer(out);
        writer.write_record(["schema_version", "scene", "name", "value"])?;
        let version = super::table::SCHEMA_VERSION.to_string();
        about.iter().try_for_each(|(name, value)| writer.write_record([&version, "", *name, value]))?;
        for scene in scenes {
            let of = [
                ("triangles", scene.triangles.to_string()),
                ("width_px", scene.size.width.to_string()),
                ("height_px", scene.size.height.to_string()),
            ];
            of.iter().try_for_each(|(name, value)| writer.write_record([&version, &*scene.name, *name, value]))?;
        }
        writer.flush()
    })?;
    let plots = scenes.iter().flat_map(|scene| &scene.parts).flat_map(|(_, part)| part.svgs());
    for (i, svg) in plots.enumerate() {
        folder.write(&plot_name(i + 1), |out| out.write_all(svg.as_bytes()))?;
    }
    let page = page::html(about, scenes);
    folder.write(PAGE, |out| out.write_all(page.as_bytes()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn our_names_are_known_and_others_are_not() {
        for name in ["index.html", "about.csv", "resolved.csv", "left_out.csv", &plot_name(7)] {
            assert!(is_ours(name), "{name}");
        }
        for name in ["plot-1.svg", "plot-abc.svg", "notes.csv", "index.htm"] {
            assert!(!is_ours(name), "{name}");
        }
    }
}
