//! Kernels as fragment programs, made from the compute kernels by a transformation of their naga modules.
//!
//! A fragment is a workgroup of one thread, whose ids are those of its texel. A stream is one `rgba32uint` texture, its
//! layers the components of a texel, as bits. A stream that a kernel reads becomes a texture, one that it writes a colour
//! output; the layers in between are private variables. A thread that writes nothing becomes a fragment that discards
//! itself, or writes again what was there, as [`Cull`](crate::options::mapping::Cull) says.
//!
//! A stream has at most four layers here, and a kernel reads and writes no ray but its own.

mod entry;
mod rewrite;
mod uses;

use std::collections::BTreeSet;

use naga::Module;
use naga::compact::{KeepUnused, compact};
use naga::valid::{Capabilities, ValidationFlags, Validator};

use crate::options::mapping::{Fragment, Targets};
use crate::program::Kernel;
use crate::shader::{Binding, Resource, ShaderError, Variant, by_component, in_textures};
use crate::tables::stream::{STATE_TAG, Stream};
use uses::Uses;

/// Layers of a stream that fit a texel.
pub const MOST_LAYERS: usize = 4;

/// Bytes of a stream's texel.
pub const TEXEL_BYTES: u64 = 16;

/// The bind group of the streams that a program reads.
pub const STREAMS_GROUP: u32 = 0;

/// The names under which a rewritten module has a stream's texture, a layer, and whether the stream was written.
fn input(stream: Stream) -> String {
    format!("in_{}", stream.name())
}

fn value(stream: Stream, layer: usize) -> String {
    format!("{}_{}_now", stream.name(), stream.info().layers[layer])
}

fn is_written(stream: Stream) -> String {
    format!("is_{}_written", stream.name())
}

/// The function that was the compute shader's entry point.
const BODY: &str = "run_kernel";

/// Name of the entry point of every program made here.
pub const ENTRY: &str = "program";

/// A shader over streams of this mapping.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shader {
    /// Its WGSL, with one entry point, [`ENTRY`].
    pub source: String,
    /// Streams, uniforms and buffers.
    pub bindings: Vec<Binding>,
}

/// A draw of a kernel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Draw {
    /// The streams it writes, in the order of its colour outputs.
    pub targets: Vec<Stream>,
    /// What runs for every fragment.
    pub shader: Shader,
}

impl Draw {
    /// The streams it reads.
    pub fn reads(&self) -> impl Iterator<Item = Stream> + '_ {
        self.shader.bindings.iter().filter_map(Binding::stream)
    }
}

/// A pass of a kernel as draws, all of which read the same streams.
#[derive(Clone, Debug)]
pub struct DrawnKernel {
    /// The kernel.
    pub kernel: Kernel,
    /// The streams that it both reads and writes.
    pub updates: Vec<Stream>,
    /// Its draws; the last one writes the states.
    pub draws: Vec<Draw>,
}

impl DrawnKernel {
    /// Transforms a variant, for targets of which a draw has at most `most_targets`.
    ///
    /// # Errors
    /// If the kernel has something that fragment programs cannot do; see the kernels of the paper's schedules.
    pub fn new(variant: &Variant, how: Fragment, most_targets: usize) -> Result<Self, ShaderError> {
        let kernel = variant.kernel;
        let fail = |message: &str| ShaderError::Invalid { kernel: kernel.name(), message: message.to_owned() };
        let state = kernel.program().state_stream().ok_or_else(|| fail("its program has no states"))?;
        let parsed = parse(kernel, &variant.source)?;
        let uses = Uses::of(kernel, &parsed)?;
        // The states are the last: whoever reads them finds the other streams written.
        let mut written = uses.written();
        written.sort_by_key(|&stream| stream == state);
        if let Some(stream) = variant.streams().map(|(stream, _)| stream).find(|stream| stream.layers() > MOST_LAYERS) {
            return Err(fail(&format!("a texel of {} has more than {MOST_LAYERS} components", stream.name())));
        }
        let at_once = match how.targets {
            Targets::One => 1,
            Targets::Many => most_targets.max(1),
        };
        // The states share their draw with as many others as fit.
        let first = written.len() % at_once;
        let (short, full) = written.split_at(first);
        let groups = std::iter::once(short).filter(|group| !group.is_empty()).chain(full.chunks(at_once));
        let draws: Result<Vec<Draw>, ShaderError> = groups
            .map(|targets| {
                let text = entry::fragment(kernel, state, &parsed, &uses, targets, how.cull)?;
                let shader = transformed(kernel, &uses, &variant.source, &text)?;
                Ok(Draw { targets: targets.to_vec(), shader })
            })
            .collect();
        let draws = draws?;
        let read: BTreeSet<Stream> = draws.iter().flat_map(Draw::reads).collect();
        let updates = written.into_iter().filter(|stream| read.contains(stream)).collect();
        Ok(Self { kernel, updates, draws })
    }

    /// The same with the lists of scene data in textures: no draw binds a storage buffer. It is also valid as GLSL ES 3.0,
    /// for the devices that have none.
    ///
    /// # Errors
    /// As for [`Variant::in_textures`].
    pub fn in_textures(mut self) -> Result<Self, ShaderError> {
        for Draw { shader, .. } in &mut self.draws {
            (shader.source, shader.bindings) = in_textures(self.kernel, &shader.source, &shader.bindings)?;
            shader.source = by_component(self.kernel, &shader.source)?;
        }
        Ok(self)
    }
}

/// A compute kernel that only reads streams, for streams of this mapping: it counts rays.
///
/// # Errors
/// If it writes streams.
pub fn reader(variant: &Variant) -> Result<Shader, ShaderError> {
    let kernel = variant.kernel;
    let parsed = parse(kernel, &variant.source)?;
    let uses = Uses::of(kernel, &parsed)?;
    let text = entry::compute(kernel, &parsed, &uses)?;
    transformed(kernel, &uses, &variant.source, &text)
}

/// The draw that turns the states into depths: [`depth_of`] the kernel that takes a ray.
#[must_use]
pub fn depths(state: Stream, kernels: &[Kernel]) -> Shader {
    let source = entry::depths(state, kernels);
    let binding = Binding {
        group: STREAMS_GROUP,
        index: 0,
        name: state.name().to_owned(),
        resource: Resource::ReadStream(state),
        reads: true,
        writes: false,
    };
    Shader { source, bindings: vec![binding] }
}

/// The depth that names a kernel: a multiple of 2⁻⁸, which every format of depths holds exactly.
#[must_use]
pub fn depth_of(kernel: Kernel) -> f32 {
    (kernel.index() + 1) as f32 / 256.0
}

fn parse(kernel: Kernel, source: &str) -> Result<Module, ShaderError> {
    naga::front::wgsl::parse_str(source)
        .map_err(|e| ShaderError::Invalid { kernel: kernel.name(), message: e.emit_to_string(source) })
}

/// The kernel with another entry point, over streams of this mapping.
fn transformed(kernel: Kernel, uses: &Uses, source: &str, entry: &str) -> Result<Shader, ShaderError> {
    let source = format!("{source}\n{entry}");
    let invalid = |message: String| ShaderError::Invalid { kernel: kernel.name(), message };
    let mut module = parse(kernel, &source)?;
    rewrite::rewrite(kernel, uses, &mut module).map_err(invalid)?;
    compact(&mut module, KeepUnused::No);
    let info = Validator::new(ValidationFlags::all(), Capabilities::default())
        .validate(&module)
        .map_err(|e| invalid(format!("{e:?}")))?;
    let mut bindings = Vec::new();
    for (_, global) in module.global_variables.iter() {
        let (Some(at), Some(name)) = (&global.binding, &global.name) else { continue };
        let stream = kernel.program().streams().find(|&stream| input(stream) == *name);
        let name = stream.map_or_else(|| kernel.bound(name).to_owned(), |stream| stream.name().to_owned());
        let resource = match (stream, global.space) {
            (Some(stream), _) => Resource::ReadStream(stream),
            (None, naga::AddressSpace::Uniform) => Resource::Uniform,
            (None, naga::AddressSpace::Storage { access }) if access.contains(naga::StorageAccess::STORE) => {
                Resource::Live { writable: true }
            }
            (None, _) => Resource::Storage,
        };
        let writes = matches!(resource, Resource::Live { .. });
        bindings.push(Binding { group: at.group, index: at.binding, name, resource, reads: !writes, writes });
    }
    bindings.sort_by_key(|b| (b.group, b.index));
    let flags = naga::back::wgsl::WriterFlags::empty();
    let source = naga::back::wgsl::write_string(&module, &info, flags).map_err(|e| invalid(e.to_string()))?;
    Ok(Shader { source, bindings })
}

/// The condition that a ray is in one of a kernel's states, in WGSL, for the tag of a texel named `state`.
fn takes(kernel: Kernel) -> String {
    let is = |tag: &u32| format!("state[{STATE_TAG}u] == {tag}u");
    kernel.takes().iter().map(is).collect::<Vec<_>>().join(" || ")
}

#[cfg(test)]
mod tests;
