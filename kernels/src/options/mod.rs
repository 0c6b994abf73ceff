//! A user's options, and the options of the kernels that follow from them.

pub mod features;
pub mod folder;
mod grid_size;
pub mod keep;
mod light;
pub mod mapping;
mod photons;
mod rays;
pub mod reasons;
pub mod replacement;
pub mod row;
pub mod rows;
mod rules;
pub mod samples;
pub mod scene_data;
mod settled;

use std::sync::Arc;

pub use crate::numbers::named::ParseOptionError;
use crate::numbers::named::named;
use folder::Folder;
pub use grid_size::{GridSize, MOST_CELLS};
use keep::Keep;
pub use light::{Environment, Integrator, MAX_DEPTH, MOST_BOUNCES, MOST_DEPTH, Strategy};
use mapping::Mapping;
pub use photons::{Gather, Neighbours, PhotonSort, Photons};
pub use rays::{FileRay, Ray, RayColumns, RayLayout, RaySource};
use replacement::Replacement;
pub use rules::{Numerics, Order, Rule, Traversal};
use samples::Samples;
use scene_data::SceneDataKind;

/// The program to run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ProgramName {
    /// Rays are traced to their closest hits and shaded.
    #[default]
    ClosestHit,
    /// A grid is built over the scene's triangles.
    GridBuild,
    /// Keys are sorted, without a scene.
    Sort,
}

/// The acceleration structure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Accelerator {
    /// Whichever of the others is expected to trace this scene fastest, see [`Accelerator::candidates`].
    Auto,
    /// A uniform grid.
    #[default]
    Grid,
    /// An irregular grid: cells of many sizes (Pérard-Gayot, Kalojanov and Slusallek, 2017). Only for robust numerics.
    Irregular,
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

/// Who builds a grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum BuiltBy {
    /// The device, if that is a GPU and the grid an irregular one over [`LEAST_FOR_DEVICE`] triangles or more; else the
    /// host.
    #[default]
    Auto,
    /// The host.
    Host,
    /// The device that traces the rays, by the program `grid-build`: the same grid, bit for bit.
    Device,
}

named!(
    Accelerator,
    "auto, grid, irregular, bvh, none",
    Auto "auto",
    Grid "grid",
    Irregular "irregular",
    Bvh "bvh",
    None "none"
);
named!(ProgramName, "closest-hit, grid-build, sort", ClosestHit "closest-hit", GridBuild "grid-build", Sort "sort");
named!(ScheduleKind, "first, second, compact, fused", First "first", Second "second", Compact "compact", Fused "fused");
named!(BuiltBy, "auto, host, device", Auto "auto", Host "host", Device "device");
named!(Skip, "auto, on, off", Auto "auto", On "on", Off "off");

impl Accelerator {
    /// The accelerators that [`Auto`](Self::Auto) chooses from for a number of triangles. Of two, it takes the grid if
    /// most of its cells have triangles and none has very many ([`MOST_LISTED`]), else the BVH: `docs/performance.md`
    /// measures that a GPU traces evenly filled scenes faster through a grid, surfaces through a BVH. CPUs, and adapters
    /// in software, trace all scenes faster through a BVH.
    #[must_use]
    pub fn candidates(&self, triangles: usize, is_gpu: bool) -> &[Self] {
        match self {
            Self::Auto if triangles <= MOST_WITHOUT => &[Self::None],
            Self::Auto if triangles < LEAST_FOR_GRID || !is_gpu => &[Self::Bvh],
            Self::Auto => &[Self::Grid, Self::Bvh],
            chosen => std::slice::from_ref(chosen),
        }
    }
}

/// Most triangles that are tested faster without a grid or BVH.
pub const MOST_WITHOUT: usize = 6;

/// Fewest triangles whose grid has enough cells to tell whether the scene is filled evenly.
pub const LEAST_FOR_GRID: usize = 512;

/// Fewest triangles over which the device builds an irregular grid by default. The host takes a second or more for them,
/// and a driver that has not compiled the kernels of the build before takes some seconds for that.
pub const LEAST_FOR_DEVICE: usize = 200_000;

/// Longest mean list of a grid that `auto` takes, each list weighted by its length: about the number of triangles that a
/// ray tests in the cell where it ends. Even scenes have 3 to 6, whatever their size.
pub const MOST_LISTED: f64 = 16.0;

/// Longest such mean of a grid that is left as it is; else its crowded cells are divided further.
pub const MOST_LISTED_IN_ONE_LEVEL: f64 = 32.0;

/// Default number of elements of a program that needs no scene.
pub const ELEMENTS: u32 = 1 << 12;

/// Most of them: a sort then takes 253 passes.
pub const MOST_ELEMENTS: u32 = 1 << 22;

/// Default steps per pass of the compact schedule.
pub const STEPS_PER_PASS: u32 = 8;

/// A run's options.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// `--program`: what runs. A build traces no rays.
    pub program: ProgramName,
    /// `--elements`: how many elements a program works on that needs no scene.
    pub elements: u32,
    /// `--integrator`
    pub integrator: Integrator,
    /// `--max-depth`: how many times a ray is reflected or refracted, or a path bounces.
    pub max_depth: u32,
    /// `--strategy`: how a path finds light.
    pub strategy: Strategy,
    /// `--environment`: what a path sees that leaves the scene.
    pub environment: Environment,
    /// `--photons` and the like: with `--integrator photons`
    pub photons: Photons,
    /// `--accelerator`
    pub accelerator: Accelerator,
    /// `--schedule`
    pub schedule: ScheduleKind,
    /// `--mapping`, and the choices of the fragment mapping
    pub mapping: Mapping,
    /// `--scene-data`
    pub scene_data: SceneDataKind,
    /// `--numerics`
    pub numerics: Numerics,
    /// `--order`
    pub order: Order,
    /// `--traversal`
    pub traversal: Traversal,
    /// A rule of robust numerics to switch off.
    pub without: Option<Rule>,
    /// The watertight test as compiled with contraction: with an explicit fma wherever a compiler may contract.
    pub contracted: bool,
    /// `--grid`
    pub grid: GridSize,
    /// `--skip`
    pub skip: Skip,
    /// `--build`: who builds a grid that [`accelerator`](Self::accelerator) names.
    pub build: BuiltBy,
    /// `--steps-per-pass`: most steps of a ray per pass of the compact schedule; the paper takes 1.
    pub steps_per_pass: u32,
    /// A ray ends at the first hit found, nearest or not: for shadow rays, from a point to a light. Not with
    /// `--numerics paper`.
    pub any_hit: bool,
    /// All hits of each ray are wanted, in exact order, see [`Caster::cast_all`](crate::Caster::cast_all): with [`Order::Exact`]
    /// and rays that are given only. A run finds the first of them.
    pub all_hits: bool,
    /// The source of rays.
    pub rays: RaySource,
    /// Shade the hits; without it, a run ends with the `hit` stream.
    pub shade: bool,
    /// Count cells, tests and repeated tests per ray.
    pub counters: bool,
    /// Time every pass, if the adapter can.
    pub timings: bool,
    /// Count the fragments that draws run, where the adapter has pipeline statistics. Only with [`mapping::Until::Count`]:
    /// a query of that kind and an occlusion query exclude each other.
    pub count_fragments: bool,
    /// Keep a record of every pass, for [`Renderer::passes`](crate::Renderer::passes). Without it, only sums are kept,
    /// and a run of many samples takes no more memory than one of few.
    pub keep_passes: bool,
    /// What the plan keeps even if the scene does not need it: with `--keep-all` everything.
    pub keep: Keep,
    /// `--spp`, `--sampler`, `--seed`: samples per pixel. More than one require a camera and shading.
    pub samples: Samples,
    /// `--kernel`: kernels whose WGSL is a user's.
    pub replaced: Vec<Arc<Replacement>>,
    /// A user's program, which runs in place of [`program`](Self::program).
    pub folder: Option<Arc<Folder>>,
}

impl Options {
    /// The defaults: grid, compact with [`STEPS_PER_PASS`] steps per pass, robust, shaded, nothing measured, passes
    /// kept.
    #[must_use]
    pub fn new(rays: RaySource) -> Self {
        Self {
            program: ProgramName::default(),
            elements: ELEMENTS,
            integrator: Integrator::default(),
            max_depth: MAX_DEPTH,
            strategy: Strategy::default(),
            environment: Environment::default(),
            photons: Photons::default(),
            accelerator: Accelerator::default(),
            schedule: ScheduleKind::default(),
            mapping: Mapping::default(),
            scene_data: SceneDataKind::default(),
            numerics: Numerics::default(),
            order: Order::default(),
            traversal: Traversal::default(),
            without: None,
            contracted: false,
            grid: GridSize::default(),
            skip: Skip::default(),
            build: BuiltBy::default(),
            steps_per_pass: STEPS_PER_PASS,
            all_hits: false,
            any_hit: false,
            rays,
            shade: true,
            counters: false,
            timings: false,
            count_fragments: false,
            keep_passes: true,
            keep: Keep::NONE,
            samples: Samples::default(),
            replaced: Vec::new(),
            folder: None,
        }
    }

    /// Whether it traces the rays of a scene.
    #[must_use]
    pub fn traces_rays(&self) -> bool {
        self.program == ProgramName::ClosestHit && self.folder.is_none()
    }
}

macro_rules! choices {
    ($($(#[$attribute:meta])* $field:ident: $type:ty,)*) => {
        /// What people choose of a run's [`Options`]: command line, links, sessions, tables and panels read and write it by
        /// [`ROWS`](rows::ROWS).
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
        pub struct Choices {
            $($(#[$attribute])* #[doc = concat!("[`Options::", stringify!($field), "`]")] pub $field: $type,)*
        }

        impl Options {
            /// Its choices.
            #[must_use]
            pub fn choices(&self) -> Choices {
                Choices { $($field: self.$field,)* }
            }

            /// The same with these choices.
            #[must_use]
            pub fn chosen(self, choices: &Choices) -> Self {
                Self { $($field: choices.$field,)* ..self }
            }
        }
    };
}

choices! {
    program: ProgramName,
    elements: u32,
    integrator: Integrator,
    accelerator: Accelerator,
    mapping: Mapping,
    scene_data: SceneDataKind,
    schedule: ScheduleKind,
    numerics: Numerics,
    order: Order,
    traversal: Traversal,
    grid: GridSize,
    skip: Skip,
    steps_per_pass: u32,
    build: BuiltBy,
    photons: Photons,
    max_depth: u32,
    strategy: Strategy,
    environment: Environment,
    #[cfg_attr(feature = "serde", serde(rename = "keep_all"))]
    keep: Keep,
    samples: Samples,
}

impl Default for Choices {
    fn default() -> Self {
        Options::new(RaySource::Given(Vec::new())).choices()
    }
}

impl Choices {
    /// Whether only a GPU can run it, if only one in software.
    #[must_use]
    pub fn needs_gpu(&self) -> bool {
        self.mapping != Mapping::Compute || self.scene_data == SceneDataKind::Textures
    }

    /// The default, where every step of a ray is a pass: what links and windows start from.
    #[must_use]
    pub fn stepped() -> Self {
        Self { steps_per_pass: 1, ..Self::default() }
    }
}
