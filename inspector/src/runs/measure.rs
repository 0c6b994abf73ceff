//! Repeats runs to measure how long each of their kernels takes.
//!
//! Runs that are measured together take turns, so that what slows the machine down slows all of them down: their ratios
//! are of pairs, one beside the other.

use raystep_kernels::{Device, Progress};

use super::outcome::begin;
use super::recipe::{Recipe, RunId};
use crate::session::request::{Job, JobContext, answered, flow, job};
use crate::session::{Session, Target};

/// The engine's job, named while it runs.
pub const MEASURING: &str = "measuring kept runs";

/// Most repeats of a run.
pub const MOST_REPEATS: usize = 1000;

/// A repeat of a run.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Repeat {
    /// Device time of all passes of each kernel, by the kernel's name; `None` unless each of them was timed.
    pub kernels: Vec<(&'static str, Option<u64>)>,
    /// Device time of all passes; `None` unless each was timed.
    pub device_ns: Option<u64>,
    /// Time of the whole run by the host's clock; `None` without one.
    pub host_ns: Option<u64>,
}

/// How long a run takes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Measured {
    /// The same number in runs that took turns.
    pub together: u64,
    /// Every repeat, in order; the first run, which is slower than the others, is not one of them.
    pub repeats: Vec<Repeat>,
    /// Why there is no device time; `None` if there is.
    pub why_no_times: Option<String>,
}

/// A run to measure, and where.
pub struct Subject {
    /// Which run.
    pub id: RunId,
    /// How to make it.
    pub recipe: Recipe,
    /// Its device.
    pub device: Device,
}

/// Why a run cannot be measured; `None` if it can.
#[must_use]
pub fn why_not(recipe: &Recipe) -> Option<&'static str> {
    recipe.twins.map(|_| "its first passes run on the CPU reference, so its times are of two devices")
}

/// Measures these runs, so many times each. The answer is a list of runs and their times.
#[must_use]
pub fn measure(subjects: Vec<Subject>, repeats: usize, together: u64, clock: Option<fn() -> u64>) -> Job {
    let repeats = repeats.clamp(1, MOST_REPEATS);
    job!(context, {
        let JobContext { session, scene, settings, progress, .. } = context;
        let mut runs: Vec<(RunId, Session, Measured)> = Vec::new();
        for Subject { id, recipe, device } in subjects {
            if let Some(why) = why_not(&recipe) {
                return Err(format!("{}: {why}", recipe.name()));
            }
            let own = begin(session, (scene, settings), &recipe, (&device, clock)).await;
            let why_no_times = match &device {
                Device::Gpu(gpu) => gpu.why_no_times(),
                Device::Cpu(_) | Device::CpuF64(_) => clock.is_none().then(|| "the host provided no clock".into()),
            };
            let measured = Measured { together, repeats: Vec::new(), why_no_times };
            runs.push((id, own.map_err(|e| e.to_string())?, measured));
        }
        let all = runs.len().saturating_mul(repeats + 1) as u64;
        let mut done = 0;
        for repeat in 0..=repeats {
            for (_, own, measured) in &mut runs {
                let one = run(own, (done, all), progress).await?;
                // The first run warms up caches and clocks.
                if repeat > 0 {
                    measured.repeats.push(one);
                }
                done += 1;
            }
        }
        let answer: Vec<_> = runs.into_iter().map(|(id, _, measured)| (id, measured)).collect();
        answered(answer)
    })
}

/// Runs a session from its start to its end.
async fn run(
    own: &mut Session,
    (done, all): (u64, u64),
    progress: &mut (dyn FnMut(u64, u64) -> bool + Send),
) -> Result<Repeat, String> {
    /// Parts of a run in reports of progress.
    const PARTS: u64 = 1000;
    let mut tell = |at: &Progress| {
        let part = (PARTS * at.rays_decided).checked_div(at.rays).unwrap_or(0);
        flow(progress(done * PARTS + part, all * PARTS))
    };
    own.step(Target::Start, &mut tell).await.map_err(|e| e.to_string())?;
    own.step(Target::End, &mut tell).await.map_err(|e| e.to_string())?;
    let totals = own.renderer().totals();
    Ok(Repeat {
        kernels: totals.kernels.iter().map(|(name, kernel)| (*name, kernel.duration_ns)).collect(),
        device_ns: totals.duration_ns,
        host_ns: own.renderer().host_ns(),
    })
}
