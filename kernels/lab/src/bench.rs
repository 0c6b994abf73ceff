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
use std::fmt;
use std::sync::Arc;

use measure::Bench;
use prepare::Group;
use rays::Viewed;
use raystep_kernels::export::csv::{DrawnPart, RunContext};
use raystep_kernels::options::mapping::Mapping;
use raystep_kernels::{Accelerator, GridSize, Options, Pass, RaySource, ScheduleKind, Traversal};

use crate::Error;
use crate::meter::Meter;
use crate::rays::file::RaysFile;
use crate::rays::{RayKind, in_tiles};
use crate::reporter::Reporter;
use crate::subject::{Size, Subject};
pub use baseline::Baseline;
pub use rays::SEED;
pub use runs::{RunRow, read_runs, write_runs};
pub use serve::{Announced, Served};
pub use summary::{ReadError, SCHEMA_VERSION, SummaryRow, read_summary, useful_steps_per_thread, write_summary};
pub use table::text;

/// What to measure for each scene.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// Acceleration structures.
    pub accelerators: Vec<Accelerator>,
    /// Schedules.
    pub schedules: Vec<ScheduleKind>,
    /// How kernels are mapped to the GPU.
    pub mappings: Vec<Mapping>,
    /// How rays walk through a uniform grid.
    pub traversals: Vec<Traversal>,
    /// Image sizes; they determine the number of rays.
    pub sizes: Vec<Size>,
    /// Kinds of rays.
    pub rays: Vec<RayKind>,
    /// Rays of another program, instead of these sizes and kinds.
    pub file: Option<Arc<RaysFile>>,
    /// Counted runs of each configuration.
    pub repeats: u32,
    /// Warm-up runs before them.
    pub warmups: u32,
    /// Whether counted runs submit exactly the passes that they need.
    pub replay: bool,
    /// Seed of rays, and of the orders within rounds.
    pub seed: u32,
    /// All other options. The rays, accelerator, schedule, mapping and traversal in it are ignored.
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
    /// Its passes.
    pub passes: Vec<Pass>,
    /// The parts of each of them, if they are drawn.
    pub parts: Vec<Vec<DrawnPart>>,
    /// Hashes of the kernels' sources, by name.
    pub shaders: BTreeMap<&'static str, String>,
}

impl Details {
    fn without_passes(context: RunContext) -> Self {
        Self { context, passes: Vec::new(), parts: Vec::new(), shaders: BTreeMap::new() }
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
    let ways = ways(wanted, bench);
    for subject in subjects {
        if let Some(file) = &wanted.file {
            let name = format!("{} {OF_FILE}", subject.scene.name);
            let rays = RaySource::Given(in_tiles(&file.in_scene(&subject.scene)));
            let kind = format!("file {}", file.hash);
            bench.group(Group { name, subject, size: None, kind, ends_early: false }, rays, &ways)?;
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
                        bench.group(Group { name, subject, size: Some(size), kind, ends_early }, rays, &ways)?;
                    }
                    Ok(None) => bench.skip(format!("{name}: no pixel has such a ray")),
                    Err(error) => bench.failed(&name, error)?,
                }
            }
        }
    }
    Ok(())
}

/// What is measured: a structure, a schedule, how kernels are mapped to the GPU, and how rays walk through a grid.
#[derive(Clone, Copy, Debug)]
struct Way {
    accelerator: Accelerator,
    schedule: ScheduleKind,
    mapping: Mapping,
    traversal: Traversal,
}

impl fmt::Display for Way {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.accelerator, self.schedule)?;
        if self.mapping != Mapping::Compute {
            write!(f, " {}", self.mapping)?;
        }
        if self.traversal == Traversal::AmanatidesWoo { Ok(()) } else { write!(f, " {}", self.traversal) }
    }
}

/// Every combination that is possible; a note for each that would measure nothing new.
fn ways(wanted: &Wanted, bench: &mut Bench<'_>) -> Vec<Way> {
    let mut ways = Vec::new();
    for &accelerator in &wanted.accelerators {
        for &schedule in &wanted.schedules {
            // Without a grid or BVH, `second` is the same as `first`.
            let is_first_again = accelerator == Accelerator::None && schedule == ScheduleKind::Second;
            if is_first_again && wanted.schedules.contains(&ScheduleKind::First) {
                bench.note("none is measured once: first and second are the same without a grid");
                continue;
            }
            // Others cannot be drawn.
            let is_drawn = matches!(schedule, ScheduleKind::First | ScheduleKind::Second);
            let mappings = wanted.mappings.iter().filter(|&&mapping| is_drawn || mapping == Mapping::Compute);
            let traversals = match accelerator {
                Accelerator::Grid => wanted.traversals.as_slice(),
                // Without a uniform grid, there is nothing to choose.
                _ => &[Traversal::AmanatidesWoo],
            };
            for &mapping in mappings {
                ways.extend(traversals.iter().map(|&traversal| Way { accelerator, schedule, mapping, traversal }));
            }
        }
    }
    ways
}

/// In the command line's format.
#[must_use]
pub fn grid_text(size: GridSize) -> String {
    match size {
        GridSize::Auto => "auto".into(),
        GridSize::Cells([x, y, z]) => format!("{x},{y},{z}"),
    }
}
