//! Turns a kernel's file into the WGSL that a device gets, and reflects its bindings.
//!
//! [`compose`](crate::compose) resolves `import` and `@if`; naga parses and validates the result and tells what every
//! entry point reads and writes, including through the functions it calls. The WGSL is the only list of bindings.

mod before;
mod blocks;
mod guarded;
mod layouts;
mod lists;
mod mistake;
mod notes;
mod parsed;
mod replaced;
mod selects;
mod sharing;
mod sourced;
mod statements;
mod stops;
mod uniform;

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::{Arc, LazyLock, Mutex, MutexGuard, PoisonError};

use naga::valid::{Capabilities, FunctionInfo, GlobalUse, ValidationFlags, Validator};
use naga::{AddressSpace, ImageClass, Module, ShaderStage, StorageAccess, TypeInner};

use crate::compose::{ComposeError, compose};
use crate::options::features::Features;
use crate::program::live::{self, LiveList};
use crate::program::{self, Kernel};
use crate::tables::stream::{Stream, Texel};
pub use before::name_of_copy;
pub(crate) use blocks::rewritten;
pub use layouts::{ArrayLayout, Field, StructLayout};
use layouts::{array_of, structs_of};
pub(crate) use lists::in_textures;
pub(crate) use mistake::place_in;
pub use mistake::{Mistake, Place};
pub(crate) use notes::statement_of;
pub use notes::{MOST_ASSERTIONS, MOST_NOTE_WORDS, Noted, Notes, Printed};
pub use replaced::Replaced;
pub(crate) use selects::by_component;
pub use sharing::{Group, first_layer};
pub use sourced::{FileLine, SourceFile, Sourced};
pub(crate) use statements::{By, Declared, Statements};
pub(crate) use stops::{Call, call_of, watched_by};
pub use stops::{MOST_WATCHED, Stop, StopError, Stopping};

/// What a global is bound to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Resource {
    /// A per-ray stream, read through a sampled texture.
    ReadStream(Stream),
    /// A per-ray stream, written or updated in place.
    WriteStream {
        /// The stream.
        stream: Stream,
        /// Declared `read_write`, else `write`.
        readable: bool,
    },
    /// Streams that share a texture, which the executor makes where textures are few.
    WriteStreams {
        /// The first of them.
        first: Stream,
    },
    /// A uniform.
    Uniform,
    /// A read-only storage buffer.
    Storage,
    /// The same contents in a texture, see [`Variant::in_textures`].
    List,
    /// Counters of the passes and lists of live rays.
    Live {
        /// Declared `read_write`, else `read`.
        writable: bool,
    },
    /// Launch parameters: a uniform that the executor writes for each pass.
    Launch,
}

/// A binding of a kernel's variant, as its WGSL declares and uses it.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Binding {
    /// `@group`
    pub group: u32,
    /// `@binding`
    pub index: u32,
    /// The global's name: that of the stream or buffer.
    pub name: String,
    /// What is bound.
    pub resource: Resource,
    /// Whether the entry point reads it.
    pub reads: bool,
    /// Whether the entry point writes it.
    pub writes: bool,
}

impl Binding {
    /// The stream that is bound, if any.
    #[must_use]
    pub fn stream(&self) -> Option<Stream> {
        match self.resource {
            Resource::ReadStream(stream) | Resource::WriteStream { stream, .. } => Some(stream),
            _ => None,
        }
    }

    /// The stream whose texture is bound, if any: it may hold others too.
    pub(crate) fn texture_of(&self) -> Option<Stream> {
        match self.resource {
            Resource::WriteStreams { first } => Some(first),
            _ => self.stream(),
        }
    }
}

/// A kernel with its options decided.
#[derive(Clone, Debug)]
pub struct Variant {
    /// The kernel.
    pub kernel: Kernel,
    /// Plain WGSL source.
    pub source: String,
    /// All of its bindings.
    pub bindings: Vec<Binding>,
    /// Structs of its uniforms and buffers.
    pub structs: Vec<StructLayout>,
    /// Elements of its read-only storage buffers.
    pub arrays: Vec<ArrayLayout>,
    /// The user's file that the source is from, if it is not ours.
    pub replaced: Option<Arc<Replaced>>,
}

/// The buffers of [`Resource::Live`] that every program has; the others are the program's lists. All but `live_rays`
/// have slots, one per pass.
pub const LIVE: [&str; 3] = ["sent", "own_list", "live_rays"];

/// The uniform of [`Resource::Launch`].
pub const LAUNCH: &str = "launch";

/// A kernel's source is not valid. Unless it is a user's, this is a bug in raystep, not in a scene.
#[derive(Debug, thiserror::Error)]
pub enum ShaderError {
    /// `import` or `@if` could not be resolved.
    #[error("kernel {kernel}: {source}")]
    Compose {
        /// The kernel.
        kernel: &'static str,
        /// The place and the reason.
        source: ComposeError,
    },
    /// naga rejects the result.
    #[error("kernel {kernel} is not valid WGSL: {message}")]
    Invalid {
        /// The kernel.
        kernel: &'static str,
        /// naga's message.
        message: String,
    },
    /// A global is unknown to the host.
    #[error("kernel {kernel} binds {name:?}, which is neither a stream nor a buffer")]
    UnknownBinding {
        /// The kernel.
        kernel: &'static str,
        /// The global.
        name: String,
    },
    /// A user's WGSL is not valid.
    #[error("{0}")]
    Mistake(Box<Mistake>),
}

/// Variants that were composed before. Parsing and validating one takes longer than rendering a small image.
static KEPT: LazyLock<Mutex<Kept>> = LazyLock::new(Mutex::default);

type Kept = HashMap<(Kernel, Features, Vec<LiveList>), Variant>;

/// Most variants to keep; each takes about 30 KB.
const MOST_KEPT: usize = 256;

fn kept() -> MutexGuard<'static, Kept> {
    KEPT.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Drops the variants composed so far, so that the next plan composes its own: to time a first start.
pub fn forget_variants() {
    kept().clear();
}

impl Variant {
    /// A label with the names of its program and kernel, for debuggers and wgpu's errors.
    #[must_use]
    pub fn label(&self) -> String {
        format!("{}.{}", self.kernel.program().name, self.kernel.name())
    }

    /// The streams that the kernel writes.
    pub fn written_streams(&self) -> impl Iterator<Item = Stream> + '_ {
        self.bindings.iter().filter_map(|binding| match binding.resource {
            Resource::WriteStream { stream, .. } if binding.writes => Some(stream),
            _ => None,
        })
    }

    /// Composes, validates and reflects a kernel, once for each combination of options. `lists` are those in which its
    /// elements wait for other kernels, see [`live::lists`]. Needs no device.
    ///
    /// # Errors
    /// If the WGSL in this crate is invalid.
    pub fn new(kernel: Kernel, features: &Features, lists: &[LiveList]) -> Result<Self, ShaderError> {
        let features = &kernel.features(features);
        let key = (kernel, *features, lists.to_vec());
        if let Some(variant) = kept().get(&key) {
            return Ok(variant.clone());
        }
        // Done without the lock: two threads may compose the same variant at once, with equal results.
        let variant = Self::own(kernel, features, lists)?;
        let mut kept = kept();
        if kept.len() >= MOST_KEPT {
            kept.clear();
        }
        kept.insert(key, variant.clone());
        Ok(variant)
    }

    fn own(kernel: Kernel, features: &Features, lists: &[LiveList]) -> Result<Self, ShaderError> {
        let name = kernel.name();
        let source =
            composed(kernel, features, lists).map_err(|source| ShaderError::Compose { kernel: name, source })?;
        let invalid = |message| ShaderError::Invalid { kernel: name, message };
        let module = naga::front::wgsl::parse_str(&source).map_err(|e| invalid(e.emit_to_string(&source)))?;
        let info = Validator::new(ValidationFlags::all(), Capabilities::all())
            .validate(&module)
            .map_err(|e| invalid(e.emit_to_string(&source)))?;
        let entry = module
            .entry_points
            .iter()
            .position(|e| e.stage == ShaderStage::Compute && e.name == kernel.info().name)
            .ok_or_else(|| invalid(format!("no compute entry point named {}", kernel.info().name)))?;
        let (bindings, structs, arrays) = reflected(kernel, &module, info.get_entry_point(entry))
            .map_err(|global| ShaderError::UnknownBinding { kernel: name, name: global })?;
        Ok(Self { kernel, structs, arrays, source, bindings, replaced: None })
    }

    /// Streams that the variant reads or writes.
    pub fn streams(&self) -> impl Iterator<Item = (Stream, &Binding)> {
        self.bindings.iter().filter_map(|b| match b.resource {
            Resource::ReadStream(stream) | Resource::WriteStream { stream, .. } => Some((stream, b)),
            _ => None,
        })
    }
}

/// What a module's entry point binds, and how structs and lists are laid out.
type Reflected = (Vec<Binding>, Vec<StructLayout>, Vec<ArrayLayout>);

/// Reflects a module. Fails with the name of a global that the host does not know.
fn reflected(kernel: Kernel, module: &Module, usage: &FunctionInfo) -> Result<Reflected, String> {
    let (mut bindings, mut arrays) = (Vec::new(), Vec::new());
    for (handle, global) in module.global_variables.iter() {
        let (Some(at), Some(global_name)) = (&global.binding, &global.name) else { continue };
        let used = usage[handle];
        if used.is_empty() {
            continue;
        }
        let global_name = kernel.bound(global_name);
        let resource = resource_of(kernel, module, global, global_name).ok_or_else(|| global_name.to_owned())?;
        if resource == Resource::Storage {
            arrays.extend(array_of(module, global, global_name));
        }
        bindings.push(Binding {
            group: at.group,
            index: at.binding,
            name: global_name.to_owned(),
            resource,
            reads: used.contains(GlobalUse::READ),
            writes: used.contains(GlobalUse::WRITE),
        });
    }
    bindings.sort_by_key(|b| (b.group, b.index));
    Ok((bindings, structs_of(module), arrays))
}

/// The modules that a kernel may import from: its program's, and those made of the program's rows.
#[must_use]
pub fn modules(kernel: Kernel, features: &Features, lists: &[LiveList]) -> Vec<program::Module> {
    let program = kernel.program();
    let files = program.files.iter().map(|file| (file.module, Cow::Borrowed(file.source)));
    files.chain((program.modules)(features)).chain(live::modules(kernel, features, lists)).collect()
}

/// The WGSL that belongs to a kernel alone, before its options are decided: its file, and below it the modules named
/// after the kernel (`KERNEL_…`) that it imports from, with those chosen for these options, each below a line with its
/// name.
#[must_use]
pub fn own_source(kernel: Kernel, features: &Features) -> String {
    let root = kernel.info().name;
    let mut text = kernel.info().wgsl.to_owned();
    let mut modules = (kernel.program().modules)(features);
    modules.retain(|(name, _)| name.strip_prefix(root).is_some_and(|rest| rest.starts_with('_')));
    while let Some(next) = modules.iter().position(|(name, _)| text.contains(&format!("import package::{name}::"))) {
        let (name, source) = modules.remove(next);
        text += &format!("\n// ---- {name}\n{source}");
    }
    text
}

/// Composes a kernel's file and the modules that it imports from, with its options decided.
fn composed(kernel: Kernel, features: &Features, lists: &[LiveList]) -> Result<String, ComposeError> {
    let modules = modules(kernel, features, lists);
    let root = kernel.info().name;
    let options = features.list();
    let source = |name: &str| {
        if name == root {
            return Some(kernel.info().wgsl);
        }
        modules.iter().find(|(module, _)| *module == name).map(|(_, source)| source.as_ref())
    };
    let option = |name: &str| match name {
        "live_lists" => Some(!lists.is_empty()),
        _ => options.iter().find(|(option, _)| *option == name).map(|&(_, is_on)| is_on),
    };
    compose(root, root, &source, &option)
}

fn resource_of(kernel: Kernel, module: &Module, global: &naga::GlobalVariable, name: &str) -> Option<Resource> {
    let program = kernel.program();
    match global.space {
        AddressSpace::Uniform if name == LAUNCH => Some(Resource::Launch),
        AddressSpace::Uniform => program.buffer(name).map(|_| Resource::Uniform),
        AddressSpace::Storage { access }
            if LIVE.contains(&name) || program.lists.iter().any(|list| list.name == name) =>
        {
            Some(Resource::Live { writable: access.contains(StorageAccess::STORE) })
        }
        AddressSpace::Storage { access } if access == StorageAccess::LOAD => {
            program.buffer(name).map(|_| Resource::Storage)
        }
        AddressSpace::Handle => {
            let stream = program.stream(name)?;
            let TypeInner::Image { arrayed: true, class, .. } = module.types[global.ty].inner else { return None };
            match class {
                ImageClass::Sampled { .. } => Some(Resource::ReadStream(stream)),
                ImageClass::Storage { format, access } => {
                    let wanted = match stream.info().texel {
                        Texel::F32 => naga::StorageFormat::R32Float,
                        Texel::U32 => naga::StorageFormat::R32Uint,
                    };
                    let readable = access.contains(StorageAccess::LOAD);
                    (format == wanted).then_some(Resource::WriteStream { stream, readable })
                }
                _ => None,
            }
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::programs::closest_hit::kernels;

    #[test]
    fn a_variant_is_kept_until_it_is_forgotten() {
        // Options that no other test uses.
        let features = Features { turns: 4321, ..Features::default() };
        let is_kept = || kept().contains_key(&(kernels::SETUP, features, Vec::new()));
        Variant::new(kernels::SETUP, &features, &[]).expect("a variant");
        assert!(is_kept());
        forget_variants();
        assert!(!is_kept());
    }
}
