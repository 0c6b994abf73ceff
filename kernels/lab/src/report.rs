//! Error against run time: what each choice costs in time and in wrong rays, as CSV files, plots and a page.
//!
//! Intended for a command line, which waits for it: most sections block while they wait for the device. An [`answer`]
//! consists of those that do not, for a window.

mod answer;
mod captions;
mod choices;
mod grid;
mod images;
mod judge;
pub mod left_out;
pub mod methods;
mod moved;
mod page;
mod photon_maps;
mod record;
mod resolved;
mod rules;
mod samples;
mod section;
mod stiff;
mod strategies;
mod times;
mod words;
mod work;

use std::io;
use std::sync::Arc;
use std::time::Duration;

use methods::Method;
use page::{Part, Scene};
use raystep_kernels::GridSize;
use record::Record;
use section::Run;
use web_time::Instant;
use work::Work;

use crate::meter::Meter;
use crate::rays::file::RaysFile;
use crate::reporter::Reporter;
use crate::stiff::Start;
use crate::subject::{Size, Subject};
use crate::tidy::Table;
use crate::tidy::package::{self, Resource};
use crate::{Error, html};
pub use answer::{Answer, Extent, Ready, answer};
pub use page::About;
pub use section::{SECTIONS, Section};
pub use work::Only;

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
    /// About how long a section may take for a scene. What does not fit is measured with fewer runs or left out, which
    /// a note says.
    pub time: Duration,
    /// The structures and schedules to measure.
    pub only: Only,
    /// Seed of all random numbers.
    pub seed: u32,
    /// How many seeds to measure where a section varies them: at least 6 for an interval.
    pub seeds: u32,
    /// Whether to write every judged ray.
    pub has_rays: bool,
    /// Results of other programs, for the section `choices`.
    pub methods: Vec<Method>,
    /// Rays for the section `choices`, instead of the camera's.
    pub rays: Option<RaysFile>,
    /// The families of stiff scenes, measured if the section is wanted.
    pub stiff: Arc<Start>,
}

/// The seed unless another one is requested.
pub const SEED: u32 = 2007;

/// The number of seeds unless another one is requested.
pub const SEEDS: u32 = 10;

/// Seconds of a section for a scene unless others are requested: of a quick report, and of a full one.
pub const SECONDS: [u32; 2] = [20, 60];

/// The results.
pub struct Report {
    tables: Vec<(&'static Section, Table)>,
    scenes: Vec<Scene>,
    record: Record,
}

/// Measures all sections for all scenes. A section that fails becomes a note on the page, unless all of them fail. Some
/// sections block this thread. `ready` gets the report after each section but the last one.
///
/// # Errors
/// If the device fails, no section could be measured, or `ready` fails.
pub async fn measure<E: From<Error>>(
    wanted: &Wanted,
    subjects: &[Subject],
    run_id: String,
    meter: &Meter,
    reporter: &dyn Reporter,
    mut ready: impl FnMut(&Report) -> Result<(), E>,
) -> Result<Report, E> {
    let Wanted { sections, size, grid, is_quick, time, only, seed, seeds, has_rays, methods, rays, stiff } = wanted;
    let tables = sections.iter().map(|&s| (s, Table::new(s.columns))).collect();
    let mut report = Report { tables, scenes: Vec::new(), record: Record::new(run_id, *seed, *has_rays) };
    let (mut failed, mut has_worked) = (None, false);
    let mut left = Left::new(sections, subjects.len(), *time);
    for subject in subjects {
        report.scenes.push(Scene {
            name: subject.scene.name.clone(),
            file: subject.file.clone(),
            triangles: subject.scene.triangles.len(),
            size: *size,
            rays: rays.as_ref().map(|file| file.rays.len()),
            slug: slug(&subject.scene.name, &report.scenes),
            parts: Vec::new(),
        });
        for index in 0..sections.len() {
            let Report { tables, scenes, record } = &mut report;
            let Some(((section, table), scene)) = tables.get_mut(index).zip(scenes.last_mut()) else { continue };
            let ahead = &Ahead { reporter, left: &left, section };
            let work = Work {
                subject,
                meter,
                size: *size,
                grid: *grid,
                is_quick: *is_quick,
                time: section.is_bounded.then_some(*time),
                begin: Instant::now(),
                only,
                seeds: *seeds,
                reporter: ahead,
                section: section.name,
                record,
                methods,
                rays: rays.as_ref(),
                stiff: Some(stiff),
            };
            let before = table.rows.len();
            let ran = match section.run {
                Run::Future(run) => run(&work, table).await,
                Run::Blocking(run) => run(&work, table),
            };
            let part = match ran {
                Ok(part) => {
                    has_worked = true;
                    part
                }
                Err(error) => {
                    // Continue with the other sections unless the device itself has failed.
                    work.can_go_on().map_err(E::from)?;
                    table.rows.truncate(before);
                    let mut part = Part::default();
                    part.notes.push(reporter.explain(&error));
                    failed = Some(error);
                    part
                }
            };
            left.finish(section);
            for note in &part.notes {
                reporter.note(&format!("{}, {}: {note}", subject.scene.name, section.name));
            }
            scene.parts.push((section.name, part));
            if left.done < left.count && has_worked {
                ready(&report)?;
            }
        }
    }
    match failed {
        Some(error) if !has_worked => Err(error.into()),
        _ => Ok(report),
    }
}

/// How much is left to measure.
struct Left {
    /// When everything began, and the section that runs.
    begin: [Instant; 2],
    done: usize,
    count: usize,
    /// Typical seconds of what is done, and of everything.
    seconds: [f64; 2],
    /// The time limit of a section.
    time: Duration,
}

impl Left {
    fn new(sections: &[&Section], scenes: usize, time: Duration) -> Self {
        let all = sections.iter().map(|s| s.seconds_within(time)).sum::<f64>() * scenes as f64;
        let begin = [Instant::now(); 2];
        Self { begin, done: 0, count: sections.len() * scenes, seconds: [0.0, all], time }
    }

    fn finish(&mut self, section: &Section) {
        self.begin[1] = Instant::now();
        self.done += 1;
        self.seconds[0] += section.seconds_within(self.time);
    }

    /// Position and time to go, in a section.
    fn text(&self, section: &Section) -> String {
        let place = format!("{} of {}", self.done + 1, self.count);
        let spent = [(self.begin[1] - self.begin[0]).as_secs_f64(), self.begin[1].elapsed().as_secs_f64()];
        match to_go(self.seconds, section.seconds_within(self.time), spent) {
            Some(seconds) => format!("{place}, about {seconds:.0} s to go"),
            None => place,
        }
    }
}

/// Seconds to go, rounded up to five: of typical seconds of what is `done` and of everything, those of the section that
/// runs, and the seconds that were spent before it and in it. `None` if it is the last one and should be over.
fn to_go([done, all]: [f64; 2], section: f64, [before, here]: [f64; 2]) -> Option<f64> {
    let pace = if done > 0.0 { before / done } else { 1.0 };
    let left = (pace * section - here).max(0.0) + pace * (all - done - section).max(0.0);
    (left > 0.0).then(|| (left / 5.0).ceil() * 5.0)
}

/// Tells stages with how much is left.
struct Ahead<'a> {
    reporter: &'a dyn Reporter,
    left: &'a Left,
    section: &'a Section,
}

impl Reporter for Ahead<'_> {
    fn stage(&self, name: &str) {
        self.reporter.stage(&format!("[{}] {name}", self.left.text(self.section)));
    }

    fn part(&self, what: &str, done: u64, of: u64) {
        self.reporter.part(&format!("[{}] {what}", self.left.text(self.section)), done, of);
    }

    fn next(&self) -> Option<&dyn Reporter> {
        Some(self.reporter)
    }
}

/// The start of the names of a scene's figures: its name in lowercase letters, digits and hyphens, with a number if it
/// is taken.
fn slug(name: &str, before: &[Scene]) -> String {
    let letters = name.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' });
    let name: String = letters.take(60).collect();
    let name = match name.trim_matches('-') {
        "" => "scene",
        name => name,
    };
    let is_taken = |slug: &str| before.iter().any(|scene| scene.slug == slug);
    let numbered = (2..).map(|i| format!("{name}-{i}"));
    std::iter::once(name.to_owned()).chain(numbered).find(|slug| !is_taken(slug)).unwrap_or_default()
}

impl Report {
    /// The sentences at the top of each scene, as plain text.
    #[must_use]
    pub fn lead(&self) -> Vec<String> {
        let parts = self.scenes.iter().flat_map(|scene| &scene.parts);
        parts.flat_map(|(_, part)| &part.lead).map(|sentence| html::plain(sentence)).collect()
    }

    /// The report's files, by name.
    ///
    /// # Errors
    /// If there is not enough memory for one.
    pub fn files(&self, about: &About) -> io::Result<Vec<(String, Vec<u8>)>> {
        let mut files = vec![(ABOUT.to_owned(), self.about(about)?)];
        let page = page::html(about, &self.scenes, self.record.seed);
        for scene in &self.scenes {
            files.extend(scene.figures());
        }
        files.extend(captions::tex(about, &self.scenes, self.record.seed));
        let recorded = self.record.tables();
        let of_sections = self.tables.iter().map(|(section, table)| (section.file, section.row, table));
        let of_record = recorded.iter().map(|(file, what, table)| (*file, *what, table));
        let tables: Vec<(&'static str, &'static str, &Table)> = of_sections.chain(of_record).collect();
        for (file, _, table) in &tables {
            files.push(((*file).to_owned(), table.csv()?));
        }
        let mut resources = vec![Resource { file: ABOUT, what: "a fact about the report", columns: ABOUT_COLUMNS }];
        resources.extend(tables.iter().map(|(file, what, table)| Resource { file, what, columns: table.columns }));
        let schema = package::describe("raystep-report", KNOWN_BY, &resources);
        files.push((package::FILE.to_owned(), serde_json::to_vec_pretty(&schema)?));
        files.push((PAGE.to_owned(), page.into_bytes()));
        Ok(files)
    }

    fn about(&self, about: &About) -> io::Result<Vec<u8>> {
        let mut table = Table::new(ABOUT_COLUMNS);
        let mut add = |scene: &str, name: &str, value: &str| {
            let row = crate::tidy::Row::new(ABOUT_COLUMNS).set("run_id", &*self.record.run_id);
            table.rows.push(row.set("scene", scene).set("name", name).set("value", value));
        };
        about.iter().for_each(|(name, value)| add("", name, value));
        add("", "seed", &self.record.seed.to_string());
        for scene in &self.scenes {
            add(&scene.name, "triangles", &scene.triangles.to_string());
            add(&scene.name, "width_px", &scene.size.width.to_string());
            add(&scene.name, "height_px", &scene.size.height.to_string());
            if let Some(rays) = scene.rays {
                add(&scene.name, "file_rays", &rays.to_string());
            }
        }
        table.csv()
    }
}

/// Columns of [`ABOUT`].
const ABOUT_COLUMNS: &[&str] = columns![schema_version run_id scene name value];

/// Whether a report may contain a file with this name.
#[must_use]
pub fn is_ours(name: &str) -> bool {
    let is_figure = [".pdf", ".svg"]
        .into_iter()
        .filter_map(|kind| name.strip_suffix(kind))
        .any(|stem| SECTIONS.iter().any(|section| stem.contains(&format!("-{}-", section.name))));
    let others = [PAGE, ABOUT, captions::FILE, package::FILE, record::RUNS, record::RAYS];
    others.contains(&name) || SECTIONS.iter().any(|s| s.file == name) || is_figure
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
    fn the_time_to_go_falls_while_a_section_runs() {
        // The first of three sections of 30 s, 20 s and 10 s.
        let first = |here: u32| to_go([0.0, 60.0], 30.0, [0.0, f64::from(here)]);
        let told: Vec<f64> = (0..=30).filter_map(first).collect();
        assert_eq!((told.len(), told[0], told[30]), (31, 60.0, 30.0));
        assert!(told.windows(6).all(|of| of[0] - of[5] == 5.0), "{told:?}");
        assert_eq!(first(90), Some(30.0), "what is late leaves the others");
        // The second one, after a first one that took half of its time.
        assert_eq!([0.0, 4.0, 99.0].map(|here| to_go([30.0, 60.0], 20.0, [15.0, here])), [15.0, 15.0, 5.0].map(Some));
        assert_eq!([4.0, 5.5].map(|here| to_go([50.0, 60.0], 10.0, [25.0, here])), [Some(5.0), None]);
    }

    #[test]
    fn our_names_are_known_and_others_are_not() {
        for name in [
            "index.html",
            "about.csv",
            "runs.csv",
            "left_out.csv",
            "a-b-grid-time-one-column.svg",
            "a-grid-time-two-columns.pdf",
            "captions.tex",
        ] {
            assert!(is_ours(name), "{name}");
        }
        for name in ["plot-1.svg", "grid.svg", "notes.csv", "index.htm"] {
            assert!(!is_ours(name), "{name}");
        }
    }
}
