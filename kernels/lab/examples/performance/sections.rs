//! The sections to measure, one file each.
//!
//! | section | asks |
//! |---|---|
//! | `paper` | the paper's Tables 2 and 3, and the same with each of our schedules |
//! | `resolution` | time against rays: is it a straight line? |
//! | `steps` | time against steps per pass |
//! | `bytes` | bytes that passes move, compared with the device's copy speed; cost of an empty pass |
//! | `tdelta` | §4.2.3: recompute tDelta in every pass, or load it? |
//! | `meshes` | rays per second by kind of ray, and their counters |
//! | `triangles` | time against triangles, and where one configuration overtakes another |
//!
//! Times are the device's: from the start of the first kernel, which generates the rays, until t, u, v and triangle of
//! every ray are in memory. Configurations of a group are interleaved.

mod bytes;
mod meshes;
mod paper;
mod resolution;
mod steps;
mod tdelta;
mod triangles;

use std::time::{Duration, Instant};

use crate::args::MeasureArgs;
use crate::csvs;
use crate::machine::Machine;
use crate::meter::Meter;
use crate::scenes::Viewed;

/// In the order in which they run: the largest scenes last.
pub(crate) const NAMES: [&str; 7] = ["paper", "resolution", "steps", "bytes", "tdelta", "meshes", "triangles"];

/// Triangles of the terrain that represents an ordinary scene.
pub(crate) const TERRAIN: u64 = 20_000;

/// A section's deadline.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Deadline(Instant);

impl Deadline {
    /// The reason given in a row that was not measured in time.
    pub(crate) const OVER: &str = "the section's time was over";

    pub(crate) fn after(time: Duration) -> Self {
        Self(Instant::now() + time)
    }

    /// The time left.
    pub(crate) fn left(self) -> Duration {
        self.0.saturating_duration_since(Instant::now())
    }

    pub(crate) fn is_over(self) -> bool {
        Instant::now() >= self.0
    }
}

/// Measures the requested sections.
pub(crate) fn measure(args: &MeasureArgs) -> Result<(), String> {
    let machine = Machine::open(args)?;
    std::fs::create_dir_all(&args.output).map_err(|e| format!("{}: {e}", args.output.display()))?;
    let mut about = machine.about(args);
    let begin = Instant::now();
    eprintln!("{} ({}, {}), {} cores", about.name, about.backend, about.driver, about.cores);
    for name in NAMES.iter().filter(|name| args.only.is_empty() || args.only.iter().any(|o| o == *name)) {
        let start = Instant::now();
        let path = args.output.join(format!("{name}.csv"));
        let deadline = Deadline::after(budget(&machine, name, begin.elapsed()));
        let mut meter = Meter { machine: &machine, section: name, deadline, rows: Vec::new() };
        match *name {
            "bytes" => csvs::write(&path, &bytes::measure(&machine, deadline)?)?,
            "tdelta" => csvs::write(&path, &tdelta::measure(&machine)?)?,
            _ => {
                match *name {
                    "paper" => paper::measure(&mut meter)?,
                    "resolution" => resolution::measure(&mut meter)?,
                    "steps" => steps::measure(&mut meter)?,
                    "meshes" => meshes::measure(&mut meter, &args.meshes)?,
                    _ => triangles::measure(&mut meter)?,
                }
                csvs::write(&path, &meter.rows)?;
            }
        }
        let seconds = start.elapsed().as_secs_f64();
        eprintln!("{name}: {seconds:.1} s");
        about.seconds.push(((*name).into(), seconds));
        // Written after every section, so that an interruption loses nothing.
        let json = serde_json::to_string_pretty(&about).map_err(|e| e.to_string())?;
        let path = args.output.join("machine.json");
        std::fs::write(&path, json + "\n").map_err(|e| format!("{}: {e}", path.display()))?;
    }
    Ok(())
}

/// Time for a section. On a GPU all of them take less than six minutes: small sections use less than their share, and
/// the two with large scenes get the rest.
fn budget(machine: &Machine, section: &str, elapsed: Duration) -> Duration {
    const ALL: Duration = Duration::from_secs(330);
    const TRIANGLES: Duration = Duration::from_secs(120);
    let small = match section {
        "paper" => 30,
        "resolution" => 20,
        "steps" | "bytes" => 15,
        _ => 10,
    };
    match (machine.is_fast(), machine.quick, section) {
        (true, false, "meshes") => ALL.saturating_sub(TRIANGLES + elapsed),
        (true, false, "triangles") => ALL.saturating_sub(elapsed),
        (true, false, _) => Duration::from_secs(small),
        (_, true, _) => Duration::from_secs(30),
        (false, false, "meshes" | "triangles") => Duration::from_secs(1200),
        (false, false, _) => Duration::from_secs(20 * small),
    }
}

/// The image size for sections that measure only one.
fn one_size(machine: &Machine) -> (u32, u32) {
    match (machine.is_fast(), machine.quick) {
        (true, _) => (1920, 1080),
        (false, false) => (512, 512),
        (false, true) => (128, 128),
    }
}

/// The paper's scene, and a larger one.
fn two_scenes() -> Result<[Viewed; 2], String> {
    Ok([Viewed::generated("cornell-box", None)?, Viewed::generated("terrain", Some(TERRAIN))?])
}
