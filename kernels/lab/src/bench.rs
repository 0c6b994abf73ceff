//! How fast rays are traced: every scene at every size with every kind of rays is a group, in which every accelerator
//! with every schedule is measured in turn.
//!
//! Blocks while it waits for the device, and reads the host's clock: for a command line.

mod baseline;
mod measure;
mod rays;
pub mod summary;
mod table;

use std::collections::BTreeMap;

use measure::{Bench, Group};
use rays::Viewed;
use raystep_kernels::export::csv::RunContext;
use raystep_kernels::{Accelerator, GridSize, Options, Pass, ScheduleKind};

use crate::Error;
use crate::meter::Meter;
use crate::rays::RayKind;
use crate::reporter::Reporter;
use crate::subject::{Size, Subject};
pub use baseline::Baseline;
pub use rays::SEED;
pub use summary::{ReadError, SCHEMA_VERSION, SummaryRow, read_summary, useful_steps_per_thread, write_summary};
pub use table::text;

/// What is to be measured of each scene.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// What keeps rays from testing every triangle.
    pub accelerators: Vec<Accelerator>,
    /// How a walk is cut into passes.
    pub schedules: Vec<ScheduleKind>,
    /// Of the image that rays are of.
    pub sizes: Vec<Size>,
    /// Which rays.
    pub rays: Vec<RayKind>,
    /// Runs that count.
    pub repeats: u32,
    /// Runs before them that do not.
    pub warmups: u32,
    /// All other options. Its rays, accelerator and schedule do not matter.
    pub tuning: Options,
}

/// What was measured, with what is worth saying of it.
#[derive(Debug)]
pub struct Measured {
    /// Tells this benchmark from others.
    pub run_id: String,
    /// One per configuration, those of a group together.
    pub rows: Vec<SummaryRow>,
    /// The passes and the kernels of each row's configuration.
    pub details: Vec<Details>,
    /// Everything that was said.
    pub notes: Vec<String>,
}

/// What a row does not hold.
#[derive(Debug)]
pub struct Details {
    /// The run whose passes these are.
    pub context: RunContext,
    /// Its passes.
    pub passes: Vec<Pass>,
    /// Hashes of the kernels' sources, by name.
    pub shaders: BTreeMap<&'static str, String>,
}

/// Measures all configurations of all scenes. One that cannot be built or run is a note, unless none can.
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
    if let Some(note) = meter.machine.note_on_times() {
        bench.note(note);
    }
    let ways = ways(wanted, &mut bench);
    for subject in subjects {
        for &size in &wanted.sizes {
            let mut viewed = Viewed::new(subject, size, wanted.tuning.grid);
            for &kind in &wanted.rays {
                let name = format!("{} {size} {kind}", subject.scene.name);
                reporter.stage(&format!("{name}: generating rays"));
                match viewed.rays(kind, &meter.machine) {
                    Ok(Some(rays)) => bench.group(Group { name, subject, size, kind }, rays, &ways)?,
                    Ok(None) => bench.skip(format!("{name}: no pixel has such a ray")),
                    Err(error) => bench.failed(&name, error)?,
                }
            }
        }
    }
    bench.finish()
}

/// Accelerators with schedules; a note for each that would measure nothing new.
fn ways(wanted: &Wanted, bench: &mut Bench<'_>) -> Vec<(Accelerator, ScheduleKind)> {
    let mut ways = Vec::new();
    for &accelerator in &wanted.accelerators {
        for &schedule in &wanted.schedules {
            // Without cells to walk through there are no turns to take.
            let is_first_again = accelerator == Accelerator::None && schedule == ScheduleKind::Second;
            if is_first_again && wanted.schedules.contains(&ScheduleKind::First) {
                bench.skip(format!(
                    "accelerator {accelerator} with schedule {schedule}: same passes as with schedule first"
                ));
            } else {
                ways.push((accelerator, schedule));
            }
        }
    }
    ways
}

/// What sets two runs with the same accelerator, schedule and numerics apart.
#[must_use]
pub fn tuning_text(tuning: &Options, has_steps: bool) -> String {
    let mut text = format!("grid={} skip={}", grid_text(tuning.grid), tuning.skip);
    if has_steps {
        text += &format!(" steps_per_pass={}", tuning.steps_per_pass);
    }
    text + if tuning.keep_all { " keep_all" } else { "" }
}

/// As the command line reads it.
#[must_use]
pub fn grid_text(size: GridSize) -> String {
    match size {
        GridSize::Auto => "auto".into(),
        GridSize::Cells([x, y, z]) => format!("{x},{y},{z}"),
    }
}
