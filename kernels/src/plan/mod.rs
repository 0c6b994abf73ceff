//! What a run needs, determined before any GPU call, and what it leaves out, with the reason.
//!
//! The plan follows from reflection: a stream or buffer is allocated if, and only if, a kernel of the
//! schedule, compiled with the run's options, binds it.

mod absent;
mod again;
pub(crate) mod allocated;
mod budget;
mod check;
pub(crate) mod display;
pub mod drawn;
pub(crate) mod limits;
mod omitted;
pub(crate) mod over;
mod sourced;
pub mod structure;

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::options::Accelerator;
use crate::options::features::Features;
use crate::options::keep::Item;
use crate::options::replacement::Replacement;
use crate::program::live;
use crate::program::schedule::{Schedule, Step};
use crate::program::{Kernel, Program};
use crate::scene_data::SceneData;
use crate::shader::{ShaderError, Variant};
use crate::tables::elements::{Elements, Size};
use crate::tables::kernel::Role;
use crate::tables::state::{StateInfo, StateRole};
use crate::tables::stream::Stream;

pub use crate::numbers::bytes::Bytes;
pub use crate::options::reasons::Because;
pub use crate::tables::elements::{folded_width as given_width, tiled};
pub(crate) use absent::absent;
use allocated::{Allocated, live_texels, sets_of};
pub use budget::Sharing;
pub(crate) use budget::fit_bindings;
pub(crate) use check::{
    FARTHEST, check_buffer, check_choices, check_list, check_rays, check_samples, check_scene, check_texels,
    image_size, why_untraceable,
};
pub use check::{MAX_TEXELS, PlanError};
pub use display::PlanText;
pub use drawn::DrawnPlan;
pub use limits::{Limits, Loops};
pub use structure::{BvhSummary, GridSummary, IrregularSummary, Structure, structure_bytes};

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
    /// The item that puts it back, if [`Options::keep`](crate::Options::keep) has it. One item may put back several things.
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
    /// The kernels in order of first use, as they are before their streams share textures.
    pub variants: Vec<Variant>,
    /// The streams that share textures, as a kernel writes more than the device binds.
    pub sharing: Sharing,
    /// The kernels as fragment programs, if they are mapped to those.
    pub drawn: Option<DrawnPlan>,
    /// Streams to allocate.
    pub streams: Vec<Planned<Stream>>,
    /// Uniforms and buffers to allocate, by name.
    pub buffers: Vec<Planned<&'static str>>,
    /// What is left out.
    pub left_out: Vec<LeftOut>,
    /// Most turns of the loops of a user's kernel, all loops of a thread together.
    pub turns: u32,
    /// Most passes that a sample of all pixels can take: every ray visits at most nx + ny + nz + 2 cells and tests no
    /// list more than once. The paper's numerics can exceed it, see `docs`.
    pub pass_bound: u64,
}

/// The kernels of a schedule as they will be compiled, and the kernel that counts rays for those that do not.
pub(crate) fn variants(
    program: &'static Program,
    schedule: &Schedule,
    features: &Features,
    replaced: &[Arc<Replacement>],
) -> Result<Vec<Variant>, ShaderError> {
    let mut kernels = schedule.kernels();
    if kernels.iter().any(|kernel| kernel.is_counted_anew(features)) {
        kernels.extend(program.kernels().filter(|kernel| kernel.role() == Role::Count));
    }
    let lists = live::lists(&kernels, features);
    let variant = |kernel: Kernel| {
        let lists = live::lists_of(kernel, &lists);
        match replaced.iter().rfind(|by| by.kernel == kernel.name()) {
            Some(by) => Variant::replaced(kernel, features, &lists, by),
            None if program.files.is_empty() => Variant::new(kernel, features, &lists),
            None => Variant::of_folder(kernel, features, &lists),
        }
    };
    kernels.into_iter().map(variant).collect()
}

/// The names that the kernels of a run bind.
pub(crate) fn bound_by(variants: &[Variant]) -> BTreeSet<&str> {
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
            looped => looped.body().unwrap_or_default().iter().all(runs_once),
        };
        self.program.course().is_some() && !self.features.samples && self.schedule.steps.iter().all(is_the_same_for_all)
    }

    /// Whether a ray may walk again after its walk: for another sample, or to a light.
    #[must_use]
    pub fn has_more_walks(&self) -> bool {
        self.features.samples || self.features.shadows
    }

    /// A label for an object of this run, shown by debuggers and in wgpu's errors.
    #[must_use]
    pub fn label(&self, name: &str) -> String {
        format!("{}.{name}", self.program.name)
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
        let variants = variants(program, &schedule, &self.features, &self.replaced())?;
        let how = self.drawn.as_ref().map(|drawn| drawn.how);
        let drawn = how.map(|how| DrawnPlan::new(how, &variants, &self.features, limits)).transpose()?;
        let sharing = fit_bindings(program, &variants, drawn.as_ref(), self.features.scene_data, limits)?;
        let bound = bound_by(&variants);
        let sets = sets_of(program, self.size(), &[], limits.image_side)?;
        let Allocated { sets, streams, buffers } =
            Allocated::new(program, sets, &bound, data, false, limits, drawn.as_ref())?;
        Ok(Self { program, sets, schedule, variants, sharing, drawn, streams, buffers, ..self.clone() })
    }

    /// The size of the program's main set of elements.
    #[must_use]
    pub fn size(&self) -> Size {
        Size { width: self.width, height: self.height, count: self.rays as u32 }
    }

    /// Texels of the largest set whose elements may be listed.
    pub(crate) fn live_texels(&self) -> u64 {
        live_texels(self.program, &self.sets)
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

    /// Whether elements of this run are ever in a state: in an active one only if a kernel takes them from there.
    #[must_use]
    pub fn has_state(&self, state: &StateInfo) -> bool {
        state.role != StateRole::Active
            || self.variants.iter().any(|variant| variant.kernel.takes().contains(&state.tag))
    }

    /// The users' files that some kernels are from, in place of ours.
    #[must_use]
    pub fn replaced(&self) -> Vec<Arc<Replacement>> {
        if !self.program.files.is_empty() {
            return Vec::new();
        }
        self.variants.iter().filter_map(|variant| Some(variant.replaced.as_ref()?.by.clone())).collect()
    }

    /// Whether a kernel is from a user's file.
    pub(crate) fn has_replaced(&self, name: &str) -> bool {
        self.variants.iter().any(|variant| variant.replaced.is_some() && variant.kernel.name() == name)
    }

    /// The same run by our own kernels, with the same streams: what those of users are compared with. Without any of these,
    /// it is this plan.
    ///
    /// # Errors
    /// If a kernel is invalid, which is a bug.
    pub fn with_own_kernels(self: &Arc<Self>) -> Result<Arc<Self>, PlanError> {
        if self.replaced().is_empty() {
            return Ok(self.clone());
        }
        let variants = variants(self.program, &self.schedule, &self.features, &[])?;
        Ok(Arc::new(Self { variants, ..Self::clone(self) }))
    }

    /// The variant of a kernel, if the run has it.
    #[must_use]
    pub fn variant(&self, kernel: Kernel) -> Option<&Variant> {
        self.variants.iter().find(|v| v.kernel == kernel)
    }
}
