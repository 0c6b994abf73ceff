//! How fast rays are traced. Every combination of scene, size and kind of ray is a group, in which all accelerators and
//! schedules are measured in interleaved runs.
//!
//! Blocks while it waits for the device, and reads the host's clock: intended for a command line.

mod baseline;
pub mod gate;
mod measure;
mod prepare;
mod rays;
pub mod runs;
mod serve;
pub mod summary;
mod table;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use measure::Bench;
use prepare::Group;
use rays::Viewed;
use raystep_kernels::export::csv::{DrawnPart, RunContext};
use raystep_kernels::options::Integrator;
use raystep_kernels::options::mapping::Mapping;
use raystep_kernels::{Accelerator, Options, Pass, RaySource, ScheduleKind, Traversal};

use crate::Error;
use crate::configuration::Configuration;
use crate::meter::{Meter, Turns};
use crate::rays::file::RaysFile;
use crate::rays::{RayKind, in_tiles};
use crate::reporter::Reporter;
use crate::subject::{Size, Subject};
use crate::work::Cast;
pub use baseline::Baseline;
pub use rays::SEED;
pub use runs::{RunRow, read_runs};
pub use serve::{Announced, Served};
pub use summary::{ReadError, SCHEMA_VERSION, SummaryRow, read_summary, useful_steps_per_thread, write_rows};
pub use table::text;

/// What to measure for each scene.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// What is compared; of none, `second` is left out beside `first`.
    pub configurations: Vec<Configuration>,
    /// Image sizes; they determine the number of rays.
    pub sizes: Vec<Size>,
    /// Kinds of rays.
    pub rays: Vec<RayKind>,
    /// Rays of another program, instead of these sizes and kinds.
    pub file: Option<Arc<RaysFile>>,
    /// How often each configuration runs, and for how long.
    pub turns: Turns,
    /// Time limit of a run; a configuration that takes longer is left out.
    pub longest_run: Duration,
    /// The deadline: after it, nothing more is built, and no round begins that is not needed. `None` for no limit.
    pub until: Option<Instant>,
    /// Which configurations' work is counted, by a run of its own with the same time limit.
    pub is_counted: fn(&Configuration) -> bool,
    /// Which configurations' timed runs submit exactly the passes that they need.
    pub is_replayed: fn(&Configuration) -> bool,
    /// Seed of rays.
    pub seed: u32,
    /// All other options. The rays in it are ignored.
    pub tuning: Options,
}

/// The results, with notes.
#[derive(Debug)]
pub struct Measured {
    /// Identifies this benchmark.
    pub run_id: String,
    /// One per configuration; those of a group are adjacent.
    pub rows: Vec<SummaryRow>,
    /// Every counted run; those of a configuration are adjacent and in order.
    pub runs: Vec<RunRow>,
    /// Passes and kernels of each row's configuration.
    pub details: Vec<Details>,
    /// Everything worth noting.
    pub notes: Vec<String>,
}

/// Details of a configuration that its row does not contain.
#[derive(Debug)]
pub struct Details {
    /// The run whose passes these are: one of its own, before the timed ones, since timing passes takes time.
    pub context: RunContext,
    /// Cells of a uniform grid along x, y and z; `None` without one.
    pub cells: Option<[i32; 3]>,
    /// Its passes.
    pub passes: Vec<Pass>,
    /// The parts of each of them, if they are drawn.
    pub parts: Vec<Vec<DrawnPart>>,
    /// The rays that kernels cast, beside those of the group, if rays are counted.
    pub cast: Option<Cast>,
    /// Hashes of the kernels' sources, by name.
    pub shaders: BTreeMap<&'static str, String>,
}

impl Details {
    fn without_passes(context: RunContext) -> Self {
        Self { context, cells: None, passes: Vec::new(), parts: Vec::new(), cast: None, shaders: BTreeMap::new() }
    }
}

/// Measures all configurations of all scenes. One that cannot be built or run becomes a note, unless all fail.
///
/// # Errors
/// If the device fails, or there is nothing to measure.
pub fn measure(
    wanted: &Wanted,
    subjects: &[Subject],
    run_id: String,
    meter: &Meter,
    reporter: &dyn Reporter,
) -> Result<Measured, Error> {
    let mut bench = Bench::new(wanted, run_id, meter, reporter);
    all_groups(wanted, subjects, &mut bench)?;
    bench.finish()
}

/// What rays of a file are called, of which the tables have the hash.
const OF_FILE: &str = "rays of a file";

/// Hands every group to `bench`.
fn all_groups(wanted: &Wanted, subjects: &[Subject], bench: &mut Bench<'_>) -> Result<(), Error> {
    let machine = bench.machine();
    if let Some(note) = machine.note_on_times() {
        bench.note(note);
    }
    let configurations = different(wanted, bench);
    for subject in subjects {
        if let Some(file) = &wanted.file {
            let name = format!("{} {OF_FILE}", subject.scene.name);
            let rays = RaySource::Given(in_tiles(&file.in_scene(&subject.scene)));
            let kind = format!("file {}", file.hash);
            bench.group(Group { name, subject, size: None, kind, ends_early: false }, rays, &configurations)?;
            continue;
        }
        for &size in &wanted.sizes {
            let mut viewed = Viewed::new(subject, size, wanted.tuning.grid, wanted.seed);
            for &kind in &wanted.rays {
                let name = format!("{} {size} {kind}", subject.scene.name);
                bench.stage(&format!("{name}: generating rays"));
                match viewed.rays(kind, machine) {
                    Ok(Some(rays)) => {
                        let (ends_early, kind) = (kind == RayKind::Shadow, kind.to_string());
                        let group = Group { name, subject, size: Some(size), kind, ends_early };
                        bench.group(group, rays, &configurations)?;
                    }
                    Ok(None) => bench.skip(format!("{name}: no pixel has such a ray")),
                    Err(error) => bench.failed(&name, error)?,
                }
            }
        }
    }
    Ok(())
}

/// Every combination that is possible, with other options.
#[must_use]
pub fn combinations(
    accelerators: &[Accelerator],
    schedules: &[ScheduleKind],
    mappings: &[Mapping],
    traversals: &[Traversal],
    integrators: &[Integrator],
    tuning: &Options,
) -> Vec<Configuration> {
    let mut all = Vec::new();
    for &accelerator in accelerators {
        for &schedule in schedules {
            // Others cannot be drawn.
            let is_drawn = matches!(schedule, ScheduleKind::First | ScheduleKind::Second);
            let mappings = mappings.iter().filter(|&&mapping| is_drawn || mapping == Mapping::Compute);
            let traversals = match accelerator {
                Accelerator::Grid => traversals,
                // Without a uniform grid, there is nothing to choose.
                _ => &[Traversal::AmanatidesWoo],
            };
            let of = Configuration { accelerator, schedule, ..Configuration::from(tuning) };
            for &mapping in mappings {
                for &traversal in traversals {
                    let of = Configuration { mapping, traversal, ..of };
                    all.extend(integrators.iter().map(|&of_light| Configuration { integrator: Some(of_light), ..of }));
                }
            }
        }
    }
    all
}

/// The configurations; a note if one of them would measure nothing new.
fn different(wanted: &Wanted, bench: &mut Bench<'_>) -> Vec<Configuration> {
    let all = &wanted.configurations;
    // Without a grid or BVH, `second` is the same as `first`.
    let is_first_again = |one: &Configuration| {
        (one.accelerator, one.schedule) == (Accelerator::None, ScheduleKind::Second)
            && all.contains(&Configuration { schedule: ScheduleKind::First, ..*one })
    };
    let different: Vec<Configuration> = all.iter().filter(|one| !is_first_again(one)).copied().collect();
    if different.len() < all.len() {
        bench.note("none is measured once: first and second are the same without a grid");
    }
    different
}

/// A configuration in the notes of a benchmark.
fn in_words(configuration: &Configuration) -> String {
    let mut words = configuration.to_string();
    if let Some(raystep_kernels::GridSize::Cells([x, y, z])) = configuration.grid {
        words += &format!(" grid={x},{y},{z}");
    }
    if configuration.mapping != Mapping::Compute {
        words += &format!(" {}", configuration.mapping);
    }
    if let Some(integrator) = configuration.integrator.filter(|&integrator| integrator != Integrator::default()) {
        words += &format!(" {integrator}");
    }
    words
}
