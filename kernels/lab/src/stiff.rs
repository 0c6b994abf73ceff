//! Stiff scenes as curves: what a structure and its rules cost while a scene gets harder in one way.
//!
//! [`FAMILIES`] is the table of families; each has 8 to 12 scenes that differ in one parameter. At each, every structure
//! traces the same random rays by all robust rules and without one of them: time, cells and tests per ray, building,
//! memory, and hits compared with f64 brute force. Counts of a few rays determine how many are traced, so that a run takes
//! about as long for every structure, and a second measurement finds the same errors.
//!
//! Each family has a time limit; after it, its other scenes are measured by one run of a few rays. Rows are handed out as
//! soon as they are finished, and [`Kept`] continues from them.
//!
//! | module | contents |
//! |---|---|
//! | `family`, `scenes`, `lit` | the families, their scenes and rays; those of light |
//! | `measure` | a scene with all structures and rules |
//! | `light` | of families of light, every ray to a light judged in f64, and the light compared with f64's |
//! | `row`, `kept`, `start` | `stiff.csv` and `runs.csv`; results of an interrupted start; a measurement made when needed |
//! | [`number`] | the stiffness number, and its correlation with cost |
//! | `figures`, `words`, `page` | curves, what is more than 20 times as slow as the best, and both as HTML |

mod family;
mod figures;
mod kept;
mod light;
mod lit;
mod measure;
pub mod number;
mod page;
mod row;
mod scenes;
mod start;
#[cfg(test)]
mod tests;
mod words;

use std::io;
use std::time::{Duration, Instant};

use raystep_kernels::options::{Integrator, MAX_DEPTH};
use raystep_kernels::{Accelerator, Ray, RaySource, Rule, ScheduleKind};
use raystep_scenes::Scene;

use crate::configuration::{Configuration, has_rule};
use crate::meter::Meter;
use crate::reporter::Reporter;
use crate::stability::Workload;
use crate::tidy::package::Resource;
use crate::tidy::{Field as _, Row, Table};
use crate::{Error, Machine};
pub use family::{FAMILIES, Family};
pub(crate) use figures::over_stiffness;
pub use kept::{Kept, KeptError};
use measure::{MOST_RAYS, Point, Work, id};
pub(crate) use page::{CAPTION, correlation_text, own_numbers, parts};
pub use page::{STYLE, html};
pub use row::{COLUMNS, RUN_COLUMNS};
pub use start::Start;
pub use words::{TIMES_THE_BEST, sentences};

/// File with a row per family, point, structure and rule.
pub const CSV: &str = "stiff.csv";
/// File with a row per timed run.
pub const RUNS: &str = "runs.csv";

/// Default seed of rays.
pub const SEED: u32 = 2007;
/// Default time limit of a family: eighteen of them take at most 30 minutes.
pub const BUDGET: Duration = Duration::from_secs(100);
/// Default time limit of a run.
pub const LONGEST_RUN: Duration = Duration::from_secs(5);
/// Most triangles that are traced without a structure.
const MOST_WITHOUT: usize = 1 << 16;
/// The family of a scene that is of none.
pub(crate) const OWN: &str = "scene";

/// What to measure.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// The families.
    pub families: Vec<&'static Family>,
    /// The structures: grid, irregular, bvh and none, or some of them.
    pub accelerators: Vec<Accelerator>,
    /// The schedule.
    pub schedule: ScheduleKind,
    /// Whether to trace an eighth of the rays.
    pub is_quick: bool,
    /// Seed of rays.
    pub seed: u32,
    /// Time limit of a family.
    pub budget: Duration,
    /// Time limit of a run.
    pub longest_run: Duration,
    /// Identifies this start.
    pub run_id: String,
}

impl Wanted {
    /// All families and structures, with the default limits.
    #[must_use]
    pub fn new(run_id: String, is_quick: bool) -> Self {
        Self {
            families: FAMILIES.iter().collect(),
            accelerators: vec![Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh, Accelerator::None],
            schedule: ScheduleKind::Fused,
            is_quick,
            seed: SEED,
            budget: BUDGET,
            longest_run: LONGEST_RUN,
            run_id,
        }
    }

    /// Columns that all rows share, and that a continued measurement must have in common.
    fn settings(&self, machine: &Machine) -> Settings {
        Settings(vec![
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
            ("adapter", machine.name()),
            ("seed", self.seed.text()),
            ("schedule", self.schedule.to_string()),
            ("is_quick", self.is_quick.text()),
        ])
    }

    fn most_rays(&self) -> usize {
        MOST_RAYS[usize::from(self.is_quick)]
    }

    /// Structures and rules for a scene.
    fn configurations(&self, triangles: usize) -> Vec<Configuration> {
        let is_affordable = |a: &&Accelerator| **a != Accelerator::None || triangles <= MOST_WITHOUT;
        let rules = || std::iter::once(None).chain(Rule::ALL.iter().copied().map(Some));
        let of = |&accelerator: &Accelerator| {
            rules()
                .filter(move |rule| rule.is_none_or(|rule| has_rule(accelerator, rule)))
                .map(move |without| Configuration { without, ..Configuration::usual(accelerator, self.schedule) })
        };
        self.accelerators.iter().filter(is_affordable).flat_map(of).collect()
    }
}

/// Names with values.
struct Settings(Vec<(&'static str, String)>);

impl Settings {
    fn fill(&self, row: Row) -> Row {
        self.0.iter().fold(row, |row, (column, value)| row.set(column, &**value))
    }
}

/// What was measured.
#[derive(Clone, Debug)]
pub struct Cost {
    pub(crate) rows: Table,
    pub(crate) runs: Table,
    /// What could not be measured, or not as thoroughly.
    pub notes: Vec<String>,
    run_id: String,
}

impl Cost {
    fn new(run_id: &str) -> Self {
        Self { rows: Table::new(COLUMNS), runs: Table::new(RUN_COLUMNS), notes: Vec::new(), run_id: run_id.to_owned() }
    }

    /// Both files with their names.
    ///
    /// # Errors
    /// If there is not enough memory.
    pub fn files(&self) -> io::Result<[(&'static str, Vec<u8>); 2]> {
        Ok([(CSV, self.rows.csv()?), (RUNS, self.runs.csv()?)])
    }
}

/// The files, for a schema.
#[must_use]
pub fn resources() -> [Resource<'static>; 2] {
    [
        Resource { file: CSV, what: "a structure with or without a rule, at a point of a family", columns: COLUMNS },
        Resource { file: RUNS, what: "a timed run", columns: RUN_COLUMNS },
    ]
}

/// Receives finished rows, as lines of [`CSV`] or [`RUNS`], whose name it gets.
pub type Append<'a> = &'a mut dyn FnMut(&'static str, &[u8]) -> io::Result<()>;

/// Measures the families. Rows of `kept` are not measured again; others are passed to `append` as they are finished.
///
/// # Errors
/// If the device fails, or `append` does.
pub fn measure(
    wanted: &Wanted,
    kept: Kept,
    meter: &Meter,
    reporter: &dyn Reporter,
    append: Append<'_>,
) -> Result<Cost, Error> {
    let points: usize = wanted.families.iter().map(|family| family.points.len()).sum();
    let mut cost = Cost::new(&wanted.run_id);
    let work = Work { wanted, meter, reporter };
    let (begin, mut measured, mut done) = (Instant::now(), 0, 0);
    let mut order = Vec::new();
    for family in &wanted.families {
        let (family_begin, mut late) = (Instant::now(), 0);
        for &parameter in family.points {
            let name = format!("{}/{}", family.name, parameter.text());
            let Workload { scene, rays, grid } = (family.make)(parameter, wanted.most_rays(), wanted.seed)?;
            let RaySource::Given(rays) = rays else { continue };
            let all = wanted.configurations(scene.triangles.len());
            order.extend(all.iter().map(|configuration| id(configuration, &name)));
            let missing: Vec<Configuration> = all.into_iter().filter(|one| !kept.has(&id(one, &name))).collect();
            done += 1;
            if missing.is_empty() {
                continue;
            }
            let to_go = to_go(begin.elapsed(), measured, points + 1 - done);
            reporter.stage(&format!("stiff: {} {}, {done} of {points}{to_go}", family.name, parameter.text()));
            let is_late = family_begin.elapsed() > wanted.budget;
            late += usize::from(is_late);
            let stratum = family.stratum;
            let (scene, rays) = (&scene, &rays[..]);
            let (integrator, max_depth) = (family.integrator, (family.max_depth)(parameter));
            let family = family.name;
            let point = Point {
                family,
                parameter: Some(parameter),
                name,
                stratum,
                scene,
                rays,
                grid,
                integrator,
                max_depth,
                is_late,
            };
            one(&work, &point, &missing, &mut cost, append)?;
            measured += 1;
        }
        if late > 0 {
            cost.notes.push(format!(
                "{}: {late} of {} points were measured by one run of few rays, since the family's {} s were spent",
                family.name,
                family.points.len(),
                wanted.budget.as_secs()
            ));
        }
    }
    cost.rows.rows.extend(kept.rows.rows);
    cost.runs.rows.extend(kept.runs.rows);
    let place = |row: &Row| order.iter().position(|id| id == row.get("configuration"));
    for table in [&mut cost.rows, &mut cost.runs] {
        table.rows.retain(|row| place(row).is_some());
        table.rows.sort_by_cached_key(place);
    }
    Ok(cost)
}

/// Measures a scene of the user's, with rays from its box to its edges.
///
/// # Errors
/// If the device fails.
pub fn measure_scene(
    wanted: &Wanted,
    name: &str,
    scene: &Scene,
    meter: &Meter,
    reporter: &dyn Reporter,
    cost: &mut Cost,
) -> Result<(), Error> {
    let rays: Vec<Ray> = scenes::own(scene, wanted.most_rays(), wanted.seed);
    let grid = raystep_kernels::GridSize::Auto;
    let name = format!("{OWN}/{name}");
    let point = Point {
        family: OWN,
        parameter: None,
        name,
        stratum: "edges",
        scene,
        rays: &rays,
        grid,
        integrator: Integrator::default(),
        max_depth: MAX_DEPTH,
        is_late: false,
    };
    Work { wanted, meter, reporter }.measure(&point, &wanted.configurations(scene.triangles.len()), cost)
}

fn one(
    work: &Work<'_>,
    point: &Point<'_>,
    configurations: &[Configuration],
    cost: &mut Cost,
    append: Append<'_>,
) -> Result<(), Error> {
    let before = [cost.runs.rows.len(), cost.rows.rows.len()];
    work.measure(point, configurations, cost)?;
    // Runs first: a row whose runs are there is finished.
    append(RUNS, &cost.runs.lines(before[0])?)?;
    append(CSV, &cost.rows.lines(before[1])?)?;
    Ok(())
}

/// What is left to do, by what was done; nothing before the first point.
fn to_go(spent: Duration, measured: u32, left: usize) -> String {
    if measured == 0 {
        return String::new();
    }
    let seconds = (spent.as_secs_f64() / f64::from(measured) * left as f64).ceil() as u64;
    match seconds {
        0..=90 => format!(", about {seconds} s to go"),
        _ => format!(", about {} min to go", seconds.div_ceil(60)),
    }
}
