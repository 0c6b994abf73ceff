//! What the fragment mapping adds to a plan: the draws of each kernel, and the textures that they take.

use super::{Limits, Planned};
use crate::fragment::{DrawnKernel, Shader, TEXEL_BYTES, depths, reader};
use crate::options::features::Features;
use crate::options::mapping::{Cull, Fragment, Update};
use crate::options::scene_data::SceneDataKind;
use crate::program::Kernel;
use crate::shader::{ShaderError, Variant};
use crate::tables::elements::Size;
use crate::tables::kernel::Role;
use crate::tables::sizes::{COUNT_SLOT_BYTES, COUNT_SLOTS};
use crate::tables::stream::Stream;

/// A run's kernels as draws.
#[derive(Clone, Debug)]
pub struct DrawnPlan {
    /// The choices.
    pub how: Fragment,
    /// The draws of each kernel, in order of first use.
    pub kernels: Vec<DrawnKernel>,
    /// The draw that turns states into depths, before the draws of each kernel.
    pub depths: Option<Shader>,
    /// The compute shader that counts the rays in each state; without compute shaders, the host does.
    pub counter: Option<Shader>,
}

/// Bytes of a texel's depth.
const DEPTH_BYTES: u64 = 4;

/// Bytes of the result of a query.
pub const QUERY_BYTES: u64 = 8;

impl DrawnPlan {
    /// Transforms the kernels of a run.
    pub(crate) fn new(
        how: Fragment,
        variants: &[Variant],
        features: &Features,
        limits: &Limits,
    ) -> Result<Self, ShaderError> {
        let most_targets = (u64::from(limits.color_bytes) / TEXEL_BYTES) as usize;
        let drawn = |variant: &Variant| {
            let drawn = DrawnKernel::new(variant, how, most_targets)?;
            match features.scene_data {
                SceneDataKind::Buffers => Ok(drawn),
                SceneDataKind::Textures => drawn.in_textures(),
            }
        };
        let kernels = variants.iter().filter(|variant| variant.kernel.role() != Role::Count).map(drawn);
        let kernels = kernels.collect::<Result<Vec<_>, _>>()?;
        let program = variants[0].kernel.program();
        let counter = program.kernels().find(|kernel| kernel.role() == Role::Count);
        let missing = || ShaderError::Invalid { kernel: program.name, message: "no kernel counts its rays".into() };
        let counter = counter.ok_or_else(missing)?;
        let counter = limits.computes().then(|| reader(&Variant::new(counter, features, &[])?)).transpose()?;
        let all: Vec<Kernel> = kernels.iter().map(|drawn| drawn.kernel).collect();
        let state = program.state_stream().ok_or_else(missing)?;
        let depths = (how.cull == Cull::EarlyZ).then(|| depths(state, &all));
        Ok(Self { how, kernels, depths, counter })
    }

    /// The draws of a kernel.
    #[must_use]
    pub fn of(&self, kernel: Kernel) -> Option<&DrawnKernel> {
        self.kernels.iter().find(|drawn| drawn.kernel == kernel)
    }

    /// Whether a stream takes two textures, because a kernel both reads and writes it.
    #[must_use]
    pub fn is_double(&self, stream: Stream) -> bool {
        self.kernels.iter().any(|drawn| drawn.updates.contains(&stream))
    }

    /// Bytes of a stream's textures.
    pub(super) fn stream_bytes(&self, stream: Stream, size: Size) -> u64 {
        let textures = if self.is_double(stream) { 2 } else { 1 };
        textures * TEXEL_BYTES * size.texels()
    }

    /// Bytes copied before a pass of a kernel, in an image of this size.
    #[must_use]
    pub fn copied_bytes(&self, kernel: Kernel, size: Size) -> u64 {
        let copies = match self.how.update {
            Update::Copy => self.of(kernel).map_or(0, |drawn| drawn.updates.len() as u64),
            Update::Swap => 0,
        };
        copies * TEXEL_BYTES * size.texels()
    }

    /// What the executor allocates beside the streams.
    pub(super) fn housekeeping(&self, size: Size) -> Vec<Planned<&'static str>> {
        let slots = COUNT_SLOTS * COUNT_SLOT_BYTES;
        let queries = COUNT_SLOTS * QUERY_BYTES;
        let depth = self.depths.as_ref().map(|_| ("depth", DEPTH_BYTES * size.texels()));
        let sent = self.counter.as_ref().map(|_| [("sent", slots), ("sent_copy", slots)]);
        let all = [("queries", queries), ("queries_copy", queries)];
        sent.into_iter().flatten().chain(all).chain(depth).map(|(what, bytes)| Planned { what, bytes }).collect()
    }
}
