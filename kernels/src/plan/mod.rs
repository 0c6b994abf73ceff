//! What a run needs, determined before any GPU call, and what it leaves out, with the reason.
//!
//! The plan follows from reflection: a stream or buffer is allocated if, and only if, a kernel of the
//! schedule, compiled with the run's options, binds it.

mod again;
mod allocated;
mod budget;
mod check;
mod decide;
pub(crate) mod display;
pub mod drawn;
pub(crate) mod grid_build;
pub(crate) mod limits;
mod omitted;
mod over;
mod resolve;
mod sort;
pub mod structure;
mod turns;
mod view;

use std::collections::BTreeSet;

use raystep_scenes::Scene;

use crate::numbers::units::Units;
use crate::options::features::Features;
use crate::options::keep::Item;
use crate::options::mapping::Until;
use crate::options::{Accelerator, Numerics, Options, ProgramName, RaySource, ScheduleKind, Traversal};
use crate::program::live;
use crate::program::schedule::{Schedule, Step};
use crate::program::{Kernel, Program};
use crate::programs::closest_hit;
use crate::scene_data::SceneData;
use crate::shader::{ShaderError, Variant};
use crate::shared::scene::SceneInfo;
use crate::tables::elements::{Elements, Size};
use crate::tables::kernel::Role;
use crate::tables::stream::Stream;

pub use crate::numbers::bytes::Bytes;
pub use crate::options::reasons::Because;
pub use crate::tables::elements::{folded_width as given_width, tiled};
use allocated::Allocated;
use budget::check_bindings;
pub(crate) use check::{FARTHEST, why_untraceable};
pub use check::{MAX_TEXELS, PlanError};
use check::{check_mapping, check_rays, check_samples, check_scene, check_scene_data, check_texels, image_size};
use decide::left_out;
pub use display::PlanText;
pub use drawn::DrawnPlan;
pub use limits::{Limits, Loops};
pub(crate) use resolve::Built;
use resolve::{Resolved, resolve};
pub use structure::{BvhSummary, GridSummary, IrregularSummary, Structure, structure_bytes};
use turns::{Resumes, Walk};

/// Something together with its size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Planned<T> {
    /// What it is.
    pub what: T,
    /// Its size in bytes on the executor.
    pub bytes: u64,
}

/// A set of elements in a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlannedSet {
    /// Which set.
    pub what: &'static Elements,
    /// Its size; `None` if the run has to find it.
    pub size: Option<Size>,
}

/// Something that a run leaves out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// `kernel shade`, `stream counters`, `buffer normals`, `code for spot lights`, …
    pub what: String,
    /// What made it unnecessary.
    pub because: Because,
    /// The reason.
    pub reason: &'static str,
    /// The item that puts it back, if [`Options::keep`] has it. One item may put back several things.
    pub item: Option<Item>,
}

/// Everything about a run that is decided before it starts.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The program that it runs.
    pub program: &'static Program,
    /// The program's sets of elements.
    pub sets: Vec<PlannedSet>,
    /// Longest side of a stream's texture.
    pub image_side: u32,
    /// Most elements per set.
    pub most_elements: u64,
    /// Texels per row of every stream.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Number of rays; fewer than texels if input rays do not fill the last row.
    pub rays: u64,
    /// Number of triangles.
    pub triangles: u64,
    /// The acceleration structure; never [`Accelerator::Auto`].
    pub accelerator: Accelerator,
    /// Whether it is for a GPU in hardware.
    pub is_gpu: bool,
    /// Options of the kernels.
    pub features: Features,
    /// Order of kernels.
    pub schedule: Schedule,
    /// The kernels as they will be compiled, in order of first use.
    pub variants: Vec<Variant>,
    /// The kernels as fragment programs, if they are mapped to those.
    pub drawn: Option<DrawnPlan>,
    /// Streams to allocate.
    pub streams: Vec<Planned<Stream>>,
    /// Uniforms and buffers to allocate, by name.
    pub buffers: Vec<Planned<&'static str>>,
    /// What is left out.
    pub left_out: Vec<LeftOut>,
    /// Most passes that a sample of all pixels can take: every ray visits at most nx + ny + nz + 2 cells and tests no
    /// list more than once. The paper's numerics can exceed it, see `docs`.
    pub pass_bound: u64,
}

/// The kernels of a schedule as they will be compiled, and the kernel that counts rays for those that do not.
fn variants(program: &'static Program, schedule: &Schedule, features: &Features) -> Result<Vec<Variant>, ShaderError> {
    let mut kernels = schedule.kernels();
    if kernels.iter().any(|kernel| kernel.is_counted_anew(features)) {
        kernels.extend(program.kernels().filter(|kernel| kernel.role() == Role::Count));
    }
    let lists = live::lists(&kernels, features);
    kernels.into_iter().map(|kernel| Variant::new(kernel, features, &lists)).collect()
}

/// The names that the kernels of a run bind.
fn bound_by(variants: &[Variant]) -> BTreeSet<&str> {
    variants.iter().flat_map(|v| &v.bindings).map(|b| b.name.as_str()).collect()
}

impl Plan {
    /// Whether a ray alone goes through the same passes, with the same indices, as it does among all others. Up to the
    /// end of its walk that holds if every iteration of the walk runs the same kernels, whatever the rays do; not if a
    /// kernel runs until it is idle before the next one, and not with several samples, as the next sample begins when
    /// the last ray's walk is over.
    #[must_use]
    pub fn can_go_alone(&self) -> bool {
        let runs_once =
            |step: &Step| matches!(step, Step::Run(kernel) | Step::RunBy(kernel, _) if kernel.role() != Role::Whole);
        let is_the_same_for_all = |step: &Step| match step {
            Step::Run(_) | Step::RunBy(..) => runs_once(step),
            // Shading that runs as long as the ray with the most work is not part of the walk.
            Step::RunUntilIdle(kernel) => kernel.is_walk(),
            Step::LoopWhileActive(_, body) | Step::RepeatWhileAny(_, body) | Step::Repeat(_, body) => {
                body.iter().all(runs_once)
            }
        };
        self.program.course().is_some() && !self.features.samples && self.schedule.steps.iter().all(is_the_same_for_all)
    }

    /// A label for an object of this run, shown by debuggers and in wgpu's errors.
    #[must_use]
    pub fn label(&self, name: &str) -> String {
        format!("{}.{name}", self.program.name)
    }

    /// Plans a run and prepares the data that it binds. Uses no GPU.
    ///
    /// # Errors
    /// If the scene or the options do not fit `limits`, with the numbers.
    pub fn new(scene: &Scene, options: &Options, limits: &Limits) -> Result<(Self, SceneData), PlanError> {
        Self::with(scene, options, limits, None)
    }

    /// As [`new`](Self::new), with the grid that the options ask for, if it is built already.
    pub(crate) fn with(
        scene: &Scene,
        options: &Options,
        limits: &Limits,
        built: Option<Built>,
    ) -> Result<(Self, SceneData), PlanError> {
        check_scene_data(options, limits)?;
        if options.program != ProgramName::ClosestHit && options.mapping.fragment().is_some() {
            return Err(PlanError::Mapping("--mapping fragment traces rays: no other program can be drawn"));
        }
        match options.program {
            ProgramName::ClosestHit => {}
            ProgramName::GridBuild => return grid_build::plan(scene, options, limits),
            ProgramName::Sort => return sort::plan(options, limits),
        }
        let units = Units::of(scene);
        let (width, height, rays) = image_size(options, limits)?;
        check_scene(scene, units)?;
        check_mapping(options, limits)?;
        check_rays(options, units)?;
        check_samples(options)?;
        if options.accelerator == Accelerator::Irregular && options.numerics == Numerics::Paper {
            return Err(PlanError::NoPaperRules);
        }
        let is_walked = options.accelerator == Accelerator::Grid && options.numerics == Numerics::Paper;
        if options.traversal == Traversal::Dda3d && !is_walked {
            return Err(PlanError::NoTraversal);
        }
        let given = matches!(options.rays, RaySource::Given(_));
        let Resolved { accelerator, mut features, structure, vertices, extent } =
            resolve(scene, options, units, limits, (width, height), built)?;

        // The last options of the kernels to be decided are those that depend on iterations of loops.
        let is_fused = options.schedule == ScheduleKind::Fused;
        let triangles = scene.triangles.len() as u64;
        let lights = if options.shade { scene.lights.len() as u64 } else { 0 };
        let walk = Walk { features: &features, structure: &structure, triangles };
        let resumes = Resumes::of(&walk, is_fused, options.steps_per_pass, lights, limits);
        (features.resumes, features.resumes_scan, features.resumes_light) = (resumes.walk, resumes.scan, resumes.light);
        features.turns = if resumes == Resumes::default() { 0 } else { limits.turns };
        let features = features;
        let pass_bound = Walk { features: &features, structure: &structure, triangles }.most_passes(is_fused);
        // A query finds out with a pass that a kernel has no rays.
        let is_queried = options.mapping.fragment().is_some_and(|how| how.until == Until::Query);
        let pass_bound = if is_queried { pass_bound.saturating_mul(2).saturating_add(4) } else { pass_bound };

        let program = &closest_hit::PROGRAM;
        let schedule = closest_hit::schedule::of(options, &features);
        let variants = variants(program, &schedule, &features)?;
        let drawn =
            options.mapping.fragment().map(|how| DrawnPlan::new(how, &variants, &features, limits)).transpose()?;
        check_bindings(&variants, drawn.as_ref(), features.scene_data, limits)?;
        let bound = bound_by(&variants);
        if bound.contains("texels") {
            check_texels(scene, options.scene_data, limits)?;
        }
        let info = SceneInfo {
            triangles: triangles as u32,
            steps: options.steps_per_pass,
            rays: rays as u32,
            first_row: 0,
            size: [width, height],
        };
        let is_bound = |name: &str| bound.contains(name);
        let mut data = SceneData::new(scene, options, features, units, (vertices, structure), info, is_bound)?;
        (data.bounds, data.reach) = (extent.bounds, extent.reach);

        let size = Size { width, height, count: rays as u32 };
        let Allocated { sets, streams, buffers } =
            Allocated::new(program, &bound, &data, size, given, limits, drawn.as_ref())?;
        let mut plan = Self {
            program,
            sets,
            image_side: limits.image_side,
            most_elements: limits.rays,
            width,
            height,
            rays,
            triangles,
            accelerator,
            is_gpu: limits.is_gpu,
            features,
            schedule,
            variants,
            drawn,
            streams,
            buffers,
            left_out: Vec::new(),
            pass_bound,
        };
        plan.left_out = left_out(&plan, scene, options);
        Ok((plan, data))
    }

    /// The same run by another program, whose kernels read the same scene in another order or more often.
    ///
    /// # Errors
    /// If a kernel is invalid, or its streams and buffers do not fit `limits`.
    pub fn hosted(
        &self,
        program: &'static Program,
        schedule: Schedule,
        data: &SceneData,
        limits: &Limits,
    ) -> Result<Self, PlanError> {
        let variants = variants(program, &schedule, &self.features)?;
        let how = self.drawn.as_ref().map(|drawn| drawn.how);
        let drawn = how.map(|how| DrawnPlan::new(how, &variants, &self.features, limits)).transpose()?;
        check_bindings(&variants, drawn.as_ref(), self.features.scene_data, limits)?;
        let bound = bound_by(&variants);
        let Allocated { sets, streams, buffers } =
            Allocated::new(program, &bound, data, self.size(), false, limits, drawn.as_ref())?;
        Ok(Self { program, sets, schedule, variants, drawn, streams, buffers, ..self.clone() })
    }

    /// The size of the program's main set of elements.
    #[must_use]
    pub fn size(&self) -> Size {
        Size { width: self.width, height: self.height, count: self.rays as u32 }
    }

    /// Bytes of all streams and buffers with a known size.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.streams.iter().map(|s| s.bytes).sum::<u64>() + self.buffers.iter().map(|b| b.bytes).sum::<u64>()
    }

    /// The stream of counters, if rays are counted.
    #[must_use]
    pub fn counters(&self) -> Option<Stream> {
        self.program.results.map(|results| results.counters).filter(|&stream| self.has_stream(stream))
    }

    /// Whether the run has this stream.
    #[must_use]
    pub fn has_stream(&self, stream: Stream) -> bool {
        self.streams.iter().any(|s| s.what == stream)
    }

    /// The variant of a kernel, if the run has it.
    #[must_use]
    pub fn variant(&self, kernel: Kernel) -> Option<&Variant> {
        self.variants.iter().find(|v| v.kernel == kernel)
    }
}
