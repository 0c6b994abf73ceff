//! What a user asks for, and which options of the kernels that needs.

pub mod features;
pub mod reasons;
pub mod samples;

use raystep_scenes::Camera;

pub use crate::numbers::named::ParseOptionError;
use crate::numbers::named::named;
use samples::Samples;

/// What runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ProgramName {
    /// Rays are traced to their closest hits, and shaded.
    #[default]
    ClosestHit,
    /// A uniform grid is built over the scene's triangles.
    GridBuild,
}

/// What keeps a ray from testing every triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Accelerator {
    /// The one of the others that traces this scene fastest, see [`Accelerator::candidates`].
    Auto,
    /// A uniform grid.
    #[default]
    Grid,
    /// A bounding volume hierarchy.
    Bvh,
    /// Nothing: every ray tests every triangle (the paper's Table 3).
    None,
}

/// In which order kernels run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ScheduleKind {
    /// The paper's first strategy: intersect until no ray is active there, then traverse once.
    First,
    /// The paper's second: intersect and traverse in turn.
    Second,
    /// As the second, but only rays that wait for a kernel are launched, for up to
    /// [`Options::steps_per_pass`] steps.
    #[default]
    Compact,
    /// One kernel takes each ray from its start to its hit.
    Fused,
}

impl ScheduleKind {
    /// Whether a ray's walk can be watched pass by pass.
    #[must_use]
    pub fn is_stepped(self) -> bool {
        self != Self::Fused
    }
}

/// How fine the grid is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum GridSize {
    /// From the number of triangles and the scene's extent, see [`automatic_cells`](crate::structures::grid::automatic_cells).
    #[default]
    Auto,
    /// Cells along x, y and z.
    Cells([u32; 3]),
}

/// Whether rays leap over empty cells of the grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Skip {
    /// Where most cells are empty.
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
    /// No missed, false or wrong hits but ties.
    #[default]
    Robust,
    /// As the paper has them, a measured baseline.
    Paper,
}

/// A rule of robust numerics that one may do without, to see what it is worth. See `docs/numerics.md`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Rule {
    /// tMax follows from the cell's integer coordinates. Without it, it grows by tDelta from cell to cell, and so
    /// does its error; walks do not leap over empty cells then.
    TMax,
    /// The nearest hit is kept and accepted at t ≤ exit. Without it, a hit counts only in the cell that is tested.
    Acceptance,
    /// The watertight test. Without it, Möller and Trumbore's.
    TriangleTest,
    /// Cells are grown by the bound on rounding before triangles are listed. Without it, they are not.
    CellGrowth,
    /// Boxes of the tree are grown likewise. Without it, they are not.
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
    /// What [`Auto`](Self::Auto) may mean for that many triangles; of two, the grid where most of its cells have
    /// triangles, else the tree. Measured in `docs/performance.md`: what fills its box evenly is traced faster
    /// through a grid, surfaces through a tree.
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

/// Most triangles that are tested faster without grid and tree.
pub const MOST_WITHOUT: usize = 6;

/// Fewest triangles whose grid has cells enough to tell whether they fill their box evenly.
pub const LEAST_FOR_GRID: usize = 512;

/// A ray in scene units: `origin + t * direction`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: [f32; 3],
    /// Where it goes; any length but 0.
    pub direction: [f32; 3],
}

/// Where rays come from.
#[derive(Clone, Debug, PartialEq)]
pub enum RaySource {
    /// One through the centre of each pixel.
    Camera {
        /// The camera.
        camera: Camera,
        /// Pixels a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// These. They fill texels row by row; the last row may be partly unused.
    Given(Vec<Ray>),
}

/// Steps a pass of the compact schedule, unless asked otherwise.
pub const STEPS_PER_PASS: u32 = 8;

/// A run's options.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// `--program`: what runs; rays that are not traced do not matter to a build.
    pub program: ProgramName,
    /// `--accelerator`
    pub accelerator: Accelerator,
    /// `--schedule`
    pub schedule: ScheduleKind,
    /// `--numerics`
    pub numerics: Numerics,
    /// A rule of robust numerics to do without.
    pub without: Option<Rule>,
    /// The watertight test as a compiler that contracts would have it: with an explicit fma wherever it may.
    pub contracted: bool,
    /// `--grid`
    pub grid: GridSize,
    /// `--skip`
    pub skip: Skip,
    /// `--steps-per-pass`: most steps of a ray in one pass of the compact schedule; 1 is the paper's.
    pub steps_per_pass: u32,
    /// A ray ends at the first hit that is found with t below 1, whichever it is: shadow rays, from a
    /// point to a light. Not with `--numerics paper`.
    pub any_hit: bool,
    /// Where rays come from.
    pub rays: RaySource,
    /// Shade the hits; without it, a run ends with the `hit` stream.
    pub shade: bool,
    /// Count cells, tests and repeated tests per ray.
    pub counters: bool,
    /// Time every pass, where the adapter can.
    pub timings: bool,
    /// Keep a record of every pass, for [`Renderer::passes`](crate::Renderer::passes). Without it, only what passes sum
    /// up to is known, and a run of many samples takes no more memory than one of few.
    pub keep_passes: bool,
    /// `--keep-all`: leave nothing out, to see what leaving out saves.
    pub keep_all: bool,
    /// `--spp`, `--sampler`, `--seed`: samples a pixel. More than one need a camera's rays, and shading.
    pub samples: Samples,
}

impl Options {
    /// The defaults: grid, compact with [`STEPS_PER_PASS`] steps a pass, robust, shaded, nothing measured, passes kept.
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
            keep_all: false,
            samples: Samples::default(),
        }
    }
}
