//! Whether kernels bind no more than a device allows, and which streams share a texture so that they do.

use std::collections::BTreeMap;

use super::{DrawnPlan, Limits, PlanError};
use crate::fragment::Shader;
use crate::options::scene_data::SceneDataKind;
use crate::program::Program;
use crate::shader::{Binding, Group, Resource, Variant};
use crate::tables::stream::{Stream, Texel};

/// The streams that share textures.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Sharing {
    /// Those of each texture, in the order of their layers. A stream that is in none has a texture of its own.
    pub groups: Vec<Group>,
    /// Most storage textures that a kernel may bind.
    pub most: u32,
}

impl Sharing {
    /// The streams in the texture that a stream is in.
    #[must_use]
    pub fn of<'a>(&'a self, stream: &'a Stream) -> &'a [Stream] {
        self.groups.iter().find(|group| group.contains(stream)).map_or(std::slice::from_ref(stream), Vec::as_slice)
    }
}

/// Finds which streams share textures so that each kernel of a run fits, and checks its shaders: the kernels; or their
/// draws, that of depths, and what counts rays.
pub(crate) fn fit_bindings(
    program: &Program,
    variants: &[Variant],
    drawn: Option<&DrawnPlan>,
    scene_data: SceneDataKind,
    limits: &Limits,
) -> Result<Sharing, PlanError> {
    let Some(drawn) = drawn else {
        let sharing = shared(program, variants, limits.storage_textures);
        for variant in variants {
            let guarded = variant.guarded(limits.turns_of_users())?;
            let variant = guarded.as_ref().unwrap_or(variant);
            let shared = variant.sharing(&sharing.groups, sharing.most)?;
            let bindings = &shared.as_ref().unwrap_or(variant).bindings;
            check(variant.kernel.name(), bindings, scene_data, limits)?;
        }
        return Ok(sharing);
    };
    for kernel in &drawn.kernels {
        let check = |shader: &Shader| check(kernel.kernel.name(), &shader.bindings, scene_data, limits);
        kernel.draws.iter().map(|draw| &draw.shader).try_for_each(check)?;
    }
    let counter = drawn.counter.iter().map(|shader| ("what counts rays", shader));
    let depths = drawn.depths.iter().map(|shader| ("the draw of depths", shader));
    counter.chain(depths).try_for_each(|(name, shader)| check(name, &shader.bindings, scene_data, limits))?;
    Ok(Sharing::default())
}

/// Most layers of a texture in core WebGPU.
const MOST_LAYERS: usize = 256;

/// Of the streams that a kernel writes, those of the same set of elements and the same format share a texture, the largest
/// class first, and no more than necessary for it to bind at most so many.
fn shared(program: &Program, variants: &[Variant], most: u32) -> Sharing {
    // A stream that another one becomes is in a texture of its own.
    let pairs = || program.kernels.iter().flat_map(|instance| instance.adopts);
    let is_adopted = |stream: Stream| pairs().any(|&(to, from)| [to, from].contains(&stream));
    let mut groups: Vec<Group> = Vec::new();
    for variant in variants {
        let mut classes: BTreeMap<(&str, bool), Group> = BTreeMap::new();
        let mut textures = 0usize;
        for binding in &variant.bindings {
            let Resource::WriteStream { stream, .. } = binding.resource else { continue };
            textures += 1;
            let info = stream.info();
            if !is_adopted(stream) {
                classes.entry((info.elements.name, info.texel == Texel::F32)).or_default().push(stream);
            }
        }
        let mut classes: Vec<Group> = classes.into_values().collect();
        classes.sort_by_key(|class| std::cmp::Reverse(class.len()));
        for mut class in classes {
            let excess = textures.saturating_sub(most as usize);
            class.truncate(excess + 1);
            if class.len() < 2 {
                continue;
            }
            // With all that share a texture with one of them already.
            let is_joined = |group: &Group| group.iter().any(|stream| class.contains(stream));
            let mut group: Group = groups.iter().filter(|group| is_joined(group)).flatten().copied().collect();
            group.extend(class.iter().filter(|stream| !group.contains(stream)).copied().collect::<Vec<_>>());
            if group.iter().map(|stream| stream.layers()).sum::<usize>() <= MOST_LAYERS {
                textures -= class.len() - 1;
                groups.retain(|group| !is_joined(group));
                groups.push(group);
            }
        }
    }
    Sharing { groups, most }
}

/// What a device limits the number of, in a shader.
const KINDS: [&str; 3] = ["storage buffers", "storage textures", "textures"];

/// The index in [`KINDS`] of what is bound.
fn kind(resource: Resource, scene_data: SceneDataKind) -> Option<usize> {
    match (resource, scene_data) {
        (Resource::Storage, SceneDataKind::Buffers) | (Resource::Live { .. }, _) => Some(0),
        (Resource::WriteStream { .. } | Resource::WriteStreams { .. }, _) => Some(1),
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
            let is_helped = index == 0 && scene_data == SceneDataKind::Buffers;
            let hint = if is_helped { "; use --scene-data textures" } else { "" };
            return Err(PlanError::Bindings { kernel, kind, count, most, name, hint });
        }
    }
    Ok(())
}
