//! Whether kernels bind no more than a device allows.

use super::{DrawnPlan, Limits, PlanError};
use crate::fragment::Shader;
use crate::options::scene_data::SceneDataKind;
use crate::shader::{Binding, Resource, Variant};

/// Checks the shaders of a run: the kernels; or their draws, that of depths, and what counts rays.
pub(crate) fn check_bindings(
    variants: &[Variant],
    drawn: Option<&DrawnPlan>,
    scene_data: SceneDataKind,
    limits: &Limits,
) -> Result<(), PlanError> {
    let Some(drawn) = drawn else {
        let check = |variant: &Variant| check(variant.kernel.name(), &variant.bindings, scene_data, limits);
        return variants.iter().try_for_each(check);
    };
    for kernel in &drawn.kernels {
        let check = |shader: &Shader| check(kernel.kernel.name(), &shader.bindings, scene_data, limits);
        kernel.draws.iter().map(|draw| &draw.shader).try_for_each(check)?;
    }
    let counter = drawn.counter.iter().map(|shader| ("what counts rays", shader));
    let depths = drawn.depths.iter().map(|shader| ("the draw of depths", shader));
    counter.chain(depths).try_for_each(|(name, shader)| check(name, &shader.bindings, scene_data, limits))
}

/// What a device limits the number of, in a shader.
const KINDS: [&str; 3] = ["storage buffers", "storage textures", "textures"];

/// The index in [`KINDS`] of what is bound.
fn kind(resource: Resource, scene_data: SceneDataKind) -> Option<usize> {
    match (resource, scene_data) {
        (Resource::Storage, SceneDataKind::Buffers) | (Resource::Live { .. }, _) => Some(0),
        (Resource::WriteStream { .. }, _) => Some(1),
        (Resource::Storage, SceneDataKind::Textures) | (Resource::ReadStream(_) | Resource::List, _) => Some(2),
        (Resource::Uniform | Resource::Launch, _) => None,
    }
}

fn check(
    kernel: &'static str,
    bindings: &[Binding],
    scene_data: SceneDataKind,
    limits: &Limits,
) -> Result<(), PlanError> {
    let most = [limits.storage_buffers, limits.storage_textures, limits.sampled_textures];
    for (index, most) in most.into_iter().enumerate() {
        let is_one = |binding: &&Binding| kind(binding.resource, scene_data) == Some(index);
        let all: Vec<&Binding> = bindings.iter().filter(is_one).collect();
        if let Some(excess) = all.get(most as usize) {
            let (kind, count, name) = (KINDS[index], all.len(), excess.name.clone());
            return Err(PlanError::Bindings { kernel, kind, count, most, name });
        }
    }
    Ok(())
}
