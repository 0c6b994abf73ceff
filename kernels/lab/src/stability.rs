//! Extreme cases: scenes and rays that break ray tracers, traced in several configurations.
//!
//! [`CASES`] is the table of cases; a new case is one entry there. Every case is traced in every requested
//! configuration, and each result is compared with f64 brute force and exact predicates at edges
//! ([`crate::reference`]). The correct hits are computed once per case, since all configurations trace the same f32 rays.
//!
//! | module | contents |
//! |---|---|
//! | `cases` | the table of cases |
//! | `claims` | what the table expects, with reasons |
//! | `make`, `planes` | scenes and rays for its entries |
//! | `probe` | the same ray/triangle pairs through every pipeline |
//! | `score` | verdicts on all rays, counted |
//! | `drift` | the error of tMax along a walk |
//! | `row` | a row of `stability.csv`, and whether it is as expected |
//! | `report` | everything together, and its files |
//! | `beside`, `table` | walks, pipelines and cases as text |
//! | `page`, `picture` | `stability.html`, and images of the errors |
//!
//! Nothing here writes a file; [`measure`] blocks while it waits for a device, and only the cost of stiff scenes
//! ([`crate::stiff`]) is timed.

mod beside;
mod cases;
mod claims;
pub mod drift;
pub(crate) mod make;
mod page;
mod picture;
mod planes;
pub mod probe;
mod report;
mod row;
mod score;
mod table;

use std::ops::ControlFlow;

use raystep_kernels::GridSize;
use raystep_kernels::options::{Accelerator, Numerics, Options, RaySource, ScheduleKind};
use raystep_kernels::renderer::{Device, RenderError, Renderer};
use raystep_scenes::Scene;

use crate::Error;
use crate::configuration::{Configuration, numerics_of};
use crate::judge::Judge;
pub use beside::text as text_beside;
pub use cases::CASES;
pub use report::{ACCELERATORS, FILES, Outcome, Report, Wanted, measure};
pub use row::{COLUMNS, DeviceName, Expected, Row, Traced};
pub use score::{Largest, Score};
pub use table::{list, text};

/// One extreme case.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Its name on the command line and in reports.
    pub name: &'static str,
    /// What is traced, in one sentence.
    pub what: &'static str,
    /// Number of rays to request; a case with a fixed number ignores it.
    pub rays: usize,
    /// Generates scene and rays.
    pub make: fn(usize) -> Result<Workload, Error>,
    /// What is known about its hits.
    pub truth: Truth,
    /// How many rays may be undecided.
    pub undecided: Ceiling,
    /// Where the paper's numerics must fail in f32, and why.
    pub paper: Paper,
}

/// What is known about every ray of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Truth {
    /// Nothing: each ray is judged by what it may hit.
    Open,
    /// Every ray hits something, either of two triangles at an edge: a ray without a hit counts as missed.
    Closed,
    /// No ray hits anything: every triangle is seen edge-on.
    Nothing,
}

/// The largest expected share of undecided rays, for which the error bound allows another result and the kernel finds
/// it. It is derived from the bound, not measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ceiling {
    /// Share of all rays.
    pub share: f64,
    /// The derivation of the share.
    pub because: &'static str,
}

impl Ceiling {
    /// The expected number among this many rays, plus four standard deviations.
    #[must_use]
    pub fn count(&self, rays: u64) -> u64 {
        let expected = self.share * rays as f64;
        ((expected + 4.0 * expected.sqrt()) as u64).min(rays)
    }
}

/// What is expected of the paper's numerics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Paper {
    /// The accelerators with which they must fail. With others they may.
    pub fails_on: &'static [Accelerator],
    /// Why.
    pub because: &'static str,
}

/// A scene and its rays.
#[derive(Clone, Debug)]
pub struct Workload {
    /// The scene.
    pub scene: Scene,
    /// The rays.
    pub rays: RaySource,
    /// The grid's resolution.
    pub grid: GridSize,
}

/// The configurations of one accelerator: the numerics that it has with stepped schedules; robust numerics also fused, with
/// contraction, and with hits that are ordered by exact t.
#[must_use]
pub fn configurations(accelerator: Accelerator) -> Vec<Configuration> {
    let robust = Configuration::usual(accelerator, ScheduleKind::Compact);
    let fused = Configuration { schedule: ScheduleKind::Fused, ..robust };
    let mut all = vec![robust, fused, Configuration { contracted: true, ..robust }, robust.exact(), fused.exact()];
    all.extend(numerics_of(accelerator).contains(&Numerics::Paper).then(|| robust.paper()));
    all
}

/// The name of a configuration's triangle test in `stability.csv`.
#[must_use]
pub fn triangle_test(configuration: &Configuration) -> &'static str {
    match (configuration.numerics, configuration.contracted) {
        (Numerics::Robust, _) if configuration.is_exact() => "exact",
        (Numerics::Robust, false) => "watertight",
        (Numerics::Robust, true) => "watertight_fma",
        (Numerics::Paper, _) => "moller_trumbore",
    }
}

/// Maximum number of passes of a walk. The longest walk of a case takes some hundreds.
const MOST_PASSES: usize = 20_000;

/// The result of running a case.
#[derive(Debug)]
pub struct Run {
    /// The verdicts, counted.
    pub score: Score,
    /// Passes that it took.
    pub passes: usize,
    /// Rays still active when the pass limit was reached.
    pub at_bound: u64,
}

/// Traces a case in one configuration and judges every ray.
///
/// # Errors
/// If the device fails or the scene does not fit it.
pub async fn run(
    case: &Case,
    workload: &Workload,
    configuration: Configuration,
    device: &Device,
    judge: &mut Judge,
) -> Result<Run, Error> {
    // A fused kernel that does not shade generates its rays itself, so they could not be read.
    let is_camera = matches!(workload.rays, RaySource::Camera { .. });
    let options = configuration.of(&Options {
        grid: if configuration.accelerator == Accelerator::Grid { workload.grid } else { GridSize::Auto },
        shade: configuration.schedule == ScheduleKind::Fused && is_camera,
        keep_passes: false,
        ..Options::new(workload.rays.clone())
    });
    let mut renderer = Renderer::new(&workload.scene, &options, device).await?;
    let mut at_bound = 0;
    let stop = renderer.run(|progress| {
        if progress.passes < MOST_PASSES {
            return ControlFlow::Continue(());
        }
        at_bound = progress.rays - progress.rays_decided;
        ControlFlow::Break(())
    });
    match stop.await {
        Ok(()) | Err(RenderError::Cancelled { .. }) => {}
        Err(error) => return Err(error.into()),
    }
    let at_bound = at_bound.max(renderer.unfinished());
    let score = Score::of(judge, case.truth, &renderer).await?;
    Ok(Run { score, passes: renderer.pass_count(), at_bound })
}
