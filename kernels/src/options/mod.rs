//! A user's options, and the options of the kernels that follow from them.

pub mod features;
pub mod keep;
pub mod reasons;
pub mod samples;

use raystep_scenes::Camera;

pub use crate::numbers::named::ParseOptionError;
use crate::numbers::named::named;
use keep::Keep;
use samples::Samples;

/// The program to run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ProgramName {
    /// Rays are traced to their closest hits and shaded.
    #[default]
    ClosestHit,
    /// A uniform grid is built over the scene's triangles.
    GridBuild,
}

/// The acceleration structure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Accelerator {
    /// Whichever of the others is expected to trace this scene fastest, see [`Accelerator::candidates`].
    Auto,
    /// A uniform grid.
    #[default]
    Grid,
    /// A bounding volume hierarchy.
    Bvh,
    /// None: every ray tests every triangle (the paper's Table 3).
    None,
}

/// The order in which kernels run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ScheduleKind {
    /// The paper's first strategy: intersect until no ray is active there, then traverse once.
    First,
    /// The paper's second: intersect and traverse in turn.
    Second,
    /// Like the second, but only rays that wait for a kernel are launched, for up to [`Options::steps_per_pass`] steps.
    #[default]
    Compact,
    /// One kernel traces each ray from its start to its hit.
    Fused,
}

impl ScheduleKind {
    /// Whether a ray's walk can be observed pass by pass.
    #[must_use]
    pub fn is_stepped(self) -> bool {
        self != Self::Fused
    }
}

/// The grid's resolution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum GridSize {
    /// From the number of triangles and the scene's extent, see [`automatic_cells`](crate::structures::grid::automatic_cells).
    #[default]
    Auto,
    /// Cells along x, y and z.
    Cells([u32; 3]),
}

/// Empty-space skipping: whether rays step across several empty cells at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Skip {
    /// Only if most cells are empty.
    #[default]
    Auto,
    /// Always.
    On,
    /// Never.
    Off,
}

/// The rules for planes, steps and hits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Numerics {
    /// No missed, false or wrong hits except ties.
    #[default]
    Robust,
    /// The paper's rules, kept as a baseline.
    Paper,
}

/// A rule of robust numerics that can be switched off to measure its effect. See `docs/numerics.md`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Rule {
    /// tMax is computed from the cell's integer coordinates. Without this rule it is accumulated from tDelta, and so is
    /// its error; empty cells are then not skipped.
    TMax,
    /// The nearest hit is kept, and accepted at t ≤ exit. Without this rule, a hit counts only inside the cell being
    /// tested.
    Acceptance,
    /// The watertight test. Without it, Möller and Trumbore's test.
    TriangleTest,
    /// Cells are grown by the bound on rounding errors before triangles are assigned to them. Without this rule, they
    /// are not.
    CellGrowth,
    /// Boxes of the BVH are grown likewise. Without this rule, they are not.
    BoxPadding,
}

named!(Accelerator, "auto, grid, bvh, none", Auto "auto", Grid "grid", Bvh "bvh", None "none");
named!(ProgramName, "closest-hit, grid-build", ClosestHit "closest-hit", GridBuild "grid-build");
named!(ScheduleKind, "first, second, compact, fused", First "first", Second "second", Compact "compact", Fused "fused");
named!(Skip, "auto, on, off", Auto "auto", On "on", Off "off");
named!(
    Rule,
    "tmax, acceptance, triangle-test, cell-growth, box-padding",
    TMax "tmax",
    Acceptance "acceptance",
    TriangleTest "triangle-test",
    CellGrowth "cell-growth",
    BoxPadding "box-padding"
);
named!(Numerics, "robust, paper", Robust "robust", Paper "paper");

impl Accelerator {
    /// The accelerators that [`Auto`](Self::Auto) chooses from for a number of triangles. Of two, it takes the grid if
    /// most of its cells have triangles, else the BVH: `docs/performance.md` measures that evenly filled scenes are
    /// traced faster through a grid, surfaces through a BVH.
    #[must_use]
    pub fn candidates(&self, triangles: usize) -> &[Self] {
        match self {
            Self::Auto if triangles <= MOST_WITHOUT => &[Self::None],
            Self::Auto if triangles < LEAST_FOR_GRID => &[Self::Bvh],
            Self::Auto => &[Self::Grid, Self::Bvh],
            chosen => std::slice::from_ref(chosen),
        }
    }
}

/// Most triangles that are tested faster without a grid or BVH.
pub const MOST_WITHOUT: usize = 6;

/// Fewest triangles whose grid has enough cells to tell whether the scene is filled evenly.
pub const LEAST_FOR_GRID: usize = 512;

/// A ray in scene units: `origin + t * direction`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: [f32; 3],
    /// Direction; any length but 0.
    pub direction: [f32; 3],
}

/// The source of rays.
#[derive(Clone, Debug, PartialEq)]
pub enum RaySource {
    /// One ray through the centre of each pixel.
    Camera {
        /// The camera.
        camera: Camera,
        /// Pixels per row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// Input rays. They fill texels row by row; the last row may be partly unused.
    Given(Vec<Ray>),
}

/// Default steps per pass of the compact schedule.
pub const STEPS_PER_PASS: u32 = 8;

/// A run's options.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// `--program`: what runs. A build traces no rays.
    pub program: ProgramName,
    /// `--accelerator`
    pub accelerator: Accelerator,
    /// `--schedule`
    pub schedule: ScheduleKind,
    /// `--numerics`
    pub numerics: Numerics,
    /// A rule of robust numerics to switch off.
    pub without: Option<Rule>,
    /// The watertight test as compiled with contraction: with an explicit fma wherever a compiler may contract.
    pub contracted: bool,
    /// `--grid`
    pub grid: GridSize,
    /// `--skip`
    pub skip: Skip,
    /// `--steps-per-pass`: most steps of a ray per pass of the compact schedule; the paper takes 1.
    pub steps_per_pass: u32,
    /// A ray ends at the first hit found with t below 1, nearest or not: for shadow rays, from a point to a light. Not
    /// with `--numerics paper`.
    pub any_hit: bool,
    /// The source of rays.
    pub rays: RaySource,
    /// Shade the hits; without it, a run ends with the `hit` stream.
    pub shade: bool,
    /// Count cells, tests and repeated tests per ray.
    pub counters: bool,
    /// Time every pass, if the adapter can.
    pub timings: bool,
    /// Keep a record of every pass, for [`Renderer::passes`](crate::Renderer::passes). Without it, only sums are kept,
    /// and a run of many samples takes no more memory than one of few.
    pub keep_passes: bool,
    /// What the plan keeps even if the scene does not need it: with `--keep-all` everything.
    pub keep: Keep,
    /// `--spp`, `--sampler`, `--seed`: samples per pixel. More than one require a camera and shading.
    pub samples: Samples,
}

impl Options {
    /// The defaults: grid, compact with [`STEPS_PER_PASS`] steps per pass, robust, shaded, nothing measured, passes
    /// kept.
    #[must_use]
    pub fn new(rays: RaySource) -> Self {
        Self {
            program: ProgramName::default(),
            accelerator: Accelerator::default(),
            schedule: ScheduleKind::default(),
            numerics: Numerics::default(),
            without: None,
            contracted: false,
            grid: GridSize::default(),
            skip: Skip::default(),
            steps_per_pass: STEPS_PER_PASS,
            any_hit: false,
            rays,
            shade: true,
            counters: false,
            timings: false,
            keep_passes: true,
            keep: Keep::NONE,
            samples: Samples::default(),
        }
    }
}
