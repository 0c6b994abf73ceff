//! Error against run time: what each choice costs in time and in wrong rays, as CSV files, plots and a page.
//!
//! Blocks while it waits for the device, and reads the host's clock: intended for a command line.

mod factors;
mod grid;
mod judge;
mod left_out;
mod moved;
mod page;
mod resolved;
mod samples;
mod section;
mod work;

use std::io;

use page::{Part, Scene};
use raystep_kernels::GridSize;

use work::Work;

use crate::Error;
use crate::meter::Meter;
use crate::reporter::Reporter;
use crate::subject::{Size, Subject};
use crate::tidy::{SCHEMA_VERSION, Table};
pub use page::About;
pub use section::{SECTIONS, Section};

/// File name of the page.
pub const PAGE: &str = "index.html";

/// File with machine, command and scenes: `scene,name,value`.
const ABOUT: &str = "about.csv";

/// The page's title, which identifies a report.
const KNOWN_BY: &str = "raystep: error against run time";

/// What to measure for each scene.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// Sections, in the order of the page.
    pub sections: Vec<&'static Section>,
    /// Image size.
    pub size: Size,
    /// The grid's resolution in sections that do not vary it.
    pub grid: GridSize,
    /// Reduces every measurement.
    pub is_quick: bool,
}

/// The results.
pub struct Report {
    tables: Vec<(&'static Section, Table)>,
    scenes: Vec<Scene>,
}

/// Measures all sections for all scenes. A section that fails becomes a note on the page, unless all of them fail.
///
/// # Errors
/// If the device fails, or no section could be measured.
pub fn measure(wanted: &Wanted, subjects: &[Subject], meter: &Meter, reporter: &dyn Reporter) -> Result<Report, Error> {
    let Wanted { sections, size, grid, is_quick } = wanted;
    let mut tables: Vec<_> = sections.iter().map(|&s| (s, Table::new(s.columns))).collect();
    let mut scenes = Vec::new();
    let (mut failed, mut has_worked) = (None, false);
    for subject in subjects {
        let work = Work { subject, meter, size: *size, grid: *grid, is_quick: *is_quick, reporter };
        let mut parts = Vec::new();
        for (section, table) in &mut tables {
            let before = table.rows.len();
            let part = match (section.run)(&work, table) {
                Ok(part) => {
                    has_worked = true;
                    part
                }
                Err(error) => {
                    // Continue with the other sections unless the device itself has failed.
                    work.can_go_on()?;
                    table.rows.truncate(before);
                    let mut part = Part::default();
                    part.notes.push(work.explain(&error));
                    failed = Some(error);
                    part
                }
            };
            for note in &part.notes {
                reporter.note(&format!("{}, {}: {note}", subject.scene.name, section.name));
            }
            parts.push((section.name, part));
        }
        scenes.push(Scene {
            name: subject.scene.name.clone(),
            file: subject.file.clone(),
            triangles: subject.scene.triangles.len(),
            size: *size,
            parts,
        });
    }
    match failed {
        Some(error) if !has_worked => Err(error),
        _ => Ok(Report { tables, scenes }),
    }
}

impl Report {
    /// The report's files, by name.
    ///
    /// # Errors
    /// If there is not enough memory for one.
    pub fn files(&self, about: &About) -> io::Result<Vec<(String, Vec<u8>)>> {
        let mut files = Vec::new();
        for (section, table) in &self.tables {
            let mut csv = Vec::new();
            table.write(&mut csv)?;
            files.push((section.file.to_owned(), csv));
        }
        files.push((ABOUT.to_owned(), self.about(about)?));
        let plots = self.scenes.iter().flat_map(|scene| &scene.parts).flat_map(|(_, part)| part.svgs());
        files.extend((1..).zip(plots).map(|(i, svg)| (plot_name(i), svg.as_bytes().to_vec())));
        files.push((PAGE.to_owned(), page::html(about, &self.scenes).into_bytes()));
        Ok(files)
    }

    fn about(&self, about: &About) -> io::Result<Vec<u8>> {
        let mut file = Vec::new();
        let mut writer = raystep_kernels::export::csv::writer(&mut file);
        writer.write_record(["schema_version", "scene", "name", "value"])?;
        let version = SCHEMA_VERSION.to_string();
        about.iter().try_for_each(|(name, value)| writer.write_record([&version, "", *name, value]))?;
        for scene in &self.scenes {
            let of = [
                ("triangles", scene.triangles.to_string()),
                ("width_px", scene.size.width.to_string()),
                ("height_px", scene.size.height.to_string()),
            ];
            of.iter().try_for_each(|(name, value)| writer.write_record([&version, &*scene.name, *name, value]))?;
        }
        writer.flush()?;
        drop(writer);
        Ok(file)
    }
}

/// The file name of a plot, counted from 1.
fn plot_name(index: usize) -> String {
    format!("plot-{index:03}.svg")
}

/// Whether a report may contain a file with this name.
#[must_use]
pub fn is_ours(name: &str) -> bool {
    let is_plot = name.strip_prefix("plot-").and_then(|rest| rest.strip_suffix(".svg"));
    name == PAGE
        || name == ABOUT
        || SECTIONS.iter().any(|s| s.file == name)
        || is_plot.is_some_and(|digits| digits.len() == 3 && digits.bytes().all(|b| b.is_ascii_digit()))
}

/// Whether a [page](PAGE) belongs to a report.
#[must_use]
pub fn is_report(page: &[u8]) -> bool {
    let head = &page[..page.len().min(1024)];
    head.windows(KNOWN_BY.len()).any(|w| w == KNOWN_BY.as_bytes())
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
