//! Extreme cases: scenes and rays on which tracers break, and what each way to trace them makes of them.
//!
//! [`CASES`] is the table of them; adding a case is one entry there. Every case is traced in every [`Variant`] that
//! is asked for, and each result is compared with f64 brute force and exact predicates at edges
//! ([`crate::reference`]). Truth is worked out once a case: the rays are the same f32 numbers in all variants.
//!
//! | module | holds |
//! |---|---|
//! | `cases` | the table |
//! | `claims` | what the table claims of them, with reasons |
//! | `make`, `planes` | the scenes and rays that its entries are made of |
//! | `probe` | the same pairs of ray and triangle through every pipeline |
//! | `score` | what became of every ray, counted |
//! | `drift` | how far tMax is off along a walk |
//! | `row` | a row of `stability.csv`, and whether it is as it must be |
//! | `report` | all of it, and its files |
//! | `beside`, `table` | walks, pipelines and cases in words |
//! | `page`, `picture` | `stability.html`, and pictures of where errors are |
//!
//! Nothing here reads a clock or writes a file; [`measure`] blocks while it waits for a device.

mod beside;
mod cases;
mod claims;
pub mod drift;
mod make;
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
use raystep_kernels::plan::PlanError;
use raystep_kernels::renderer::{Device, RenderError, Renderer};
use raystep_scenes::Scene;
use raystep_scenes::generate::GenerateError;

use crate::judge::Judge;
pub use beside::text as text_beside;
pub use cases::CASES;
pub use report::{ACCELERATORS, FILES, Outcome, Report, Wanted, measure};
pub use row::{COLUMNS, Expected, Place, Row, SCHEMA_VERSION, write_rows};
pub use score::{Largest, Score};
pub use table::{list, text};

/// One extreme case.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Its name on the command line and in reports.
    pub name: &'static str,
    /// What is traced, one sentence.
    pub what: &'static str,
    /// Rays that are asked for; a case whose number is its point takes its own.
    pub rays: usize,
    /// Makes scene and rays.
    pub make: fn(usize) -> Result<Workload, StabilityError>,
    /// What a ray that hits nothing, or anything, means.
    pub truth: Truth,
    /// How many rays f32 may leave undecided.
    pub undecided: Ceiling,
    /// Where the paper's rules must fail in f32, and why.
    pub paper: Paper,
}

/// What is known of every ray of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Truth {
    /// Nothing: each ray is judged by what it may hit.
    Open,
    /// Every ray hits something, whichever of two triangles at an edge it is: a ray that hits nothing is missed.
    Closed,
    /// No ray hits anything: every triangle is seen edge-on.
    Nothing,
}

/// The largest share of rays for which the error bound is expected to leave a choice that is then taken otherwise. It
/// follows from the bound, not from a result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ceiling {
    /// Of all rays.
    pub share: f64,
    /// Where the share comes from.
    pub because: &'static str,
}

impl Ceiling {
    /// Of so many rays: what is expected, and four standard deviations of a count.
    #[must_use]
    pub fn count(&self, rays: u64) -> u64 {
        let expected = self.share * rays as f64;
        ((expected + 4.0 * expected.sqrt()) as u64).min(rays)
    }
}

/// What is expected of the paper's rules.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Paper {
    /// With these accelerators it must fail. With others it may.
    pub fails_on: &'static [Accelerator],
    /// Why.
    pub because: &'static str,
}

/// A scene and the rays to trace in it.
#[derive(Clone, Debug)]
pub struct Workload {
    /// The scene.
    pub scene: Scene,
    /// The rays.
    pub rays: RaySource,
    /// The grid's resolution.
    pub grid: GridSize,
}

/// A case that could not be made or run.
#[derive(Debug, thiserror::Error)]
pub enum StabilityError {
    /// A scene could not be generated.
    #[error(transparent)]
    Generate(#[from] GenerateError),
    /// A scene could not be planned.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A run failed.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A camera has no view.
    #[error("the case's camera has no direction")]
    NoView,
}

/// One way to trace a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Variant {
    /// By which rules.
    pub numerics: Numerics,
    /// What keeps rays from testing every triangle.
    pub accelerator: Accelerator,
    /// In which order kernels run.
    pub schedule: ScheduleKind,
    /// With explicit fma wherever a compiler may contract, see [`Options::contracted`].
    pub contracted: bool,
}

impl Variant {
    /// Those of one accelerator: both rules in steps; the robust ones in one kernel too, and as a compiler that
    /// contracts has them.
    #[must_use]
    pub fn of(accelerator: Accelerator) -> [Self; 4] {
        use Numerics::{Paper, Robust};
        use ScheduleKind::{Compact, Fused};
        let variant = |numerics, schedule| Self { numerics, accelerator, schedule, contracted: false };
        let robust = variant(Robust, Compact);
        [robust, variant(Robust, Fused), Self { contracted: true, ..robust }, variant(Paper, Compact)]
    }

    /// The name of its test of a triangle in `stability.csv`.
    #[must_use]
    pub fn triangle_test(&self) -> &'static str {
        match (self.numerics, self.contracted) {
            (Numerics::Robust, false) => "watertight",
            (Numerics::Robust, true) => "watertight_fma",
            (Numerics::Paper, _) => "moller_trumbore",
        }
    }
}

/// Tests a pass without an accelerator: the longest lists are 10,000 triangles long.
const TESTS_PER_PASS: u32 = 128;

/// Passes after which a walk is given up. The longest of a case takes some hundreds.
const MOST_PASSES: usize = 20_000;

/// A run of a variant.
#[derive(Debug)]
pub struct Run {
    /// Counted.
    pub score: Score,
    /// Passes that it took.
    pub passes: usize,
    /// Rays that still walked when their bound was reached.
    pub at_bound: u64,
}

/// Traces a case in one way and judges every ray.
///
/// # Errors
/// If the device fails or the scene does not fit it.
pub async fn run(
    case: &Case,
    workload: &Workload,
    variant: Variant,
    device: &Device,
    judge: &mut Judge,
) -> Result<Run, StabilityError> {
    // A fused kernel that need not shade makes its rays itself, and nobody could see them.
    let is_camera = matches!(workload.rays, RaySource::Camera { .. });
    let mut options = Options {
        numerics: variant.numerics,
        accelerator: variant.accelerator,
        schedule: variant.schedule,
        contracted: variant.contracted,
        grid: if variant.accelerator == Accelerator::Grid { workload.grid } else { GridSize::Auto },
        shade: variant.schedule == ScheduleKind::Fused && is_camera,
        keep_passes: false,
        ..Options::new(workload.rays.clone())
    };
    if variant.accelerator == Accelerator::None {
        options.steps_per_pass = TESTS_PER_PASS;
    }
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
