//! Whether a user's WGSL fits the kernel that it replaces: how it is launched, and what it binds.

use naga::valid::{FunctionInfo, GlobalUse, ModuleInfo};
use naga::{
    AddressSpace, Block, Function, GlobalVariable, Handle, ImageClass, Module, ScalarKind, Statement, StorageAccess,
    Type, TypeInner,
};

use super::super::{LAUNCH, LIVE, Resource, resource_of};
use super::{Mistake, Replaced, declared};
use crate::program::Kernel;
use crate::tables::kernel::Launch;
use crate::tables::stream::Texel;

/// Whether no two globals have the same binding.
pub(super) fn distinct(replaced: &Replaced, module: &Module) -> Result<(), Mistake> {
    let mut seen: Vec<(u32, u32, &str)> = Vec::new();
    for (handle, global) in module.global_variables.iter() {
        let (Some(at), Some(name)) = (&global.binding, &global.name) else { continue };
        if let Some((.., other)) = seen.iter().find(|(group, index, _)| (*group, *index) == (at.group, at.binding)) {
            let message = format!("{name} and {other} have the same @group({}) @binding({})", at.group, at.binding);
            return Err(replaced.mistake([module.global_variables.get_span(handle)], message));
        }
        seen.push((at.group, at.binding, name));
    }
    Ok(())
}

/// Whether the module can run where the kernel does.
pub(super) fn fits(
    replaced: &Replaced,
    kernel: Kernel,
    module: &Module,
    info: &ModuleInfo,
    entry: usize,
) -> Result<(), Mistake> {
    let point = &module.entry_points[entry];
    let side = kernel.workgroup();
    let (wanted, size) = match kernel.info().launch {
        Launch::List { .. } => ([side, 1, 1], format!("{side}")),
        Launch::Whole | Launch::Bands => ([side, side, 1], format!("{side}, {side}")),
    };
    let at = declared(&replaced.by, kernel.info().name);
    if point.workgroup_size != wanted {
        let [x, y, z] = point.workgroup_size;
        let message = format!(
            "its workgroups have {x}×{y}×{z} threads, but {} is launched with @workgroup_size({size})",
            kernel.name()
        );
        return Err(Mistake { place: at, message });
    }
    if let Some((handle, _)) = module.overrides.iter().next() {
        let message = "an override gets no value here: use a const".to_owned();
        return Err(replaced.mistake([module.overrides.get_span(handle)], message));
    }
    let statements = inlined(module, &point.function);
    if statements > MOST_STATEMENTS {
        let message = format!(
            "with the functions that it calls in their places, it has more than {MOST_STATEMENTS} statements: a driver \
             would compile it for hours"
        );
        return Err(Mistake { place: at, message });
    }
    let usage = info.get_entry_point(entry);
    workgroup_fits(replaced, module, usage)?;
    own_fits(replaced, module, usage)?;
    for (handle, global) in module.global_variables.iter() {
        let (Some(at), Some(name)) = (&global.binding, &global.name) else { continue };
        if usage[handle].is_empty() {
            continue;
        }
        let mistake = |message: String| Err(replaced.mistake([module.global_variables.get_span(handle)], message));
        let bound = kernel.bound(name);
        if resource_of(kernel, module, global, bound).is_none_or(|resource| !is_readable(module, global, resource)) {
            return mistake(mismatch(kernel, module, global, name, bound));
        }
        let is_live =
            matches!(resource_of(kernel, module, global, bound), Some(Resource::Live { .. } | Resource::Launch));
        if is_live != (at.group == 2) || at.group > 2 || at.binding > MOST_BINDING {
            return mistake(format!(
                "{name} is in @group({}) @binding({}): streams and scene data belong to groups 0 and 1, what \
                 package::live declares to group 2, and no binding is above {MOST_BINDING}",
                at.group, at.binding
            ));
        }
        // Streams of other elements have another size.
        let streams = kernel.program().stream(bound).filter(|_| kernel.program().files.is_empty());
        if usage[handle].contains(GlobalUse::WRITE)
            && streams.is_some_and(|stream| stream.info().elements.name != kernel.instance().over.name)
        {
            return mistake(format!("{name} is a stream of other elements than those that {} works on", kernel.name()));
        }
    }
    Ok(())
}

/// Statements of a function with those that it calls in their places, as drivers compile it.
fn inlined(module: &Module, entry: &Function) -> u64 {
    fn count(block: &Block, sizes: &[u64]) -> u64 {
        let of = |statement: &Statement| match statement {
            Statement::Block(block) => count(block, sizes),
            Statement::If { accept, reject, .. } => count(accept, sizes).saturating_add(count(reject, sizes)),
            Statement::Switch { cases, .. } => {
                cases.iter().fold(0, |sum: u64, case| sum.saturating_add(count(&case.body, sizes)))
            }
            Statement::Loop { body, continuing, .. } => count(body, sizes).saturating_add(count(continuing, sizes)),
            Statement::Call { function, .. } => sizes.get(function.index()).copied().unwrap_or_default(),
            _ => 0,
        };
        block.iter().fold(0, |sum: u64, statement| sum.saturating_add(1).saturating_add(of(statement)))
    }
    // A function comes before those that call it.
    let mut sizes = Vec::new();
    for (_, function) in module.functions.iter() {
        sizes.push(count(&function.body, &sizes));
    }
    count(&entry.body, &sizes)
}

/// Far more than any kernel of ours has.
const MOST_STATEMENTS: u64 = 1 << 17;

/// Whether the variables of a workgroup fit on every device; where they do not, drivers fail or take other memory.
fn workgroup_fits(replaced: &Replaced, module: &Module, usage: &FunctionInfo) -> Result<(), Mistake> {
    let is_used = |handle: Handle<GlobalVariable>, global: &GlobalVariable| {
        global.space == AddressSpace::WorkGroup && !usage[handle].is_empty()
    };
    let size = |global: &GlobalVariable| u64::from(module.types[global.ty].inner.size(module.to_ctx()));
    let mut used: Vec<_> = module.global_variables.iter().filter(|(handle, global)| is_used(*handle, global)).collect();
    let bytes: u64 = used.iter().map(|(_, global)| size(global)).sum();
    if bytes <= MOST_WORKGROUP_BYTES {
        return Ok(());
    }
    let message =
        format!("the workgroup's variables take {bytes} bytes, of which a device may have only {MOST_WORKGROUP_BYTES}");
    used.sort_by_key(|(_, global)| std::cmp::Reverse(size(global)));
    Err(replaced.mistake(used.iter().map(|(handle, _)| module.global_variables.get_span(*handle)), message))
}

/// Whether the variables of a thread are as small as WGSL demands: a driver would compile larger ones for hours.
fn own_fits(replaced: &Replaced, module: &Module, usage: &FunctionInfo) -> Result<(), Mistake> {
    let size = |ty: Handle<Type>| u64::from(module.types[ty].inner.size(module.to_ctx()));
    let is_used = |handle: &Handle<GlobalVariable>| !usage[*handle].is_empty();
    let globals = module.global_variables.iter();
    let private = globals.filter(|(handle, global)| global.space == AddressSpace::Private && is_used(handle));
    let private: Vec<_> =
        private.map(|(handle, global)| (size(global.ty), module.global_variables.get_span(handle))).collect();
    let functions = module.functions.iter().map(|(_, function)| function);
    let functions = functions.chain(module.entry_points.iter().map(|point| &point.function));
    let locals = functions.map(|function| {
        let locals = function.local_variables.iter();
        locals.map(|(handle, local)| (size(local.ty), function.local_variables.get_span(handle))).collect::<Vec<_>>()
    });
    for (mut all, whose) in std::iter::once((private, "var<private>")).chain(locals.map(|all| (all, "a function"))) {
        let bytes = all.iter().fold(0u64, |sum, (bytes, _)| sum.saturating_add(*bytes));
        if bytes > MOST_OWN_BYTES {
            all.sort_by_key(|(bytes, _)| std::cmp::Reverse(*bytes));
            let message = format!("the variables of {whose} take {bytes} bytes; WGSL allows {MOST_OWN_BYTES}");
            return Err(replaced.mistake(all.into_iter().map(|(_, span)| span), message));
        }
    }
    Ok(())
}

/// WGSL's limit for the variables of a function, and for those that are private.
const MOST_OWN_BYTES: u64 = 8192;

/// Core WebGPU's `maxComputeWorkgroupStorageSize`.
const MOST_WORKGROUP_BYTES: u64 = 16_384;

/// Largest index of a binding: core WebGPU allows 999.
const MOST_BINDING: u32 = 639;

/// Whether a texture's format and access are those that its stream is bound with.
fn is_readable(module: &Module, global: &GlobalVariable, resource: Resource) -> bool {
    let TypeInner::Image { class, .. } = module.types[global.ty].inner else { return true };
    match (resource, class) {
        (Resource::ReadStream(stream), ImageClass::Sampled { kind, multi }) => {
            let wanted = match stream.info().texel {
                Texel::F32 => ScalarKind::Float,
                Texel::U32 => ScalarKind::Uint,
            };
            kind == wanted && !multi
        }
        (Resource::WriteStream { .. }, ImageClass::Storage { access, .. }) => {
            access == StorageAccess::STORE || access == StorageAccess::STORE | StorageAccess::LOAD
        }
        _ => true,
    }
}

/// Why a global cannot be bound, and what would be right.
fn mismatch(kernel: Kernel, module: &Module, global: &GlobalVariable, name: &str, bound: &str) -> String {
    let program = kernel.program();
    if let Some(stream) = program.stream(bound) {
        let (texel, format) = match stream.info().texel {
            Texel::F32 => ("f32", "r32float"),
            Texel::U32 => ("u32", "r32uint"),
        };
        return format!(
            "the stream {name} is texture_2d_array<{texel}>, or texture_storage_2d_array<{format}, read_write>, or the \
             same with write"
        );
    }
    if let Some(buffer) = program.buffer(bound) {
        let space = if buffer.is_uniform { "var<uniform>" } else { "var<storage, read>" };
        let is_written =
            matches!(global.space, AddressSpace::Storage { access } if access.contains(StorageAccess::STORE));
        let why = if is_written { ": a kernel only reads it" } else { "" };
        return format!("the buffer {name} is {space}{why}");
    }
    if name == LAUNCH || LIVE.contains(&name) || program.lists.iter().any(|list| list.name == name) {
        return format!("{name} is not declared as in package::live: import from there");
    }
    let is_texture = matches!(module.types[global.ty].inner, TypeInner::Image { .. });
    let (kind, mut names): (&str, Vec<&str>) = if is_texture {
        ("stream", program.streams().map(|stream| stream.name()).collect())
    } else {
        ("buffer", program.buffers.iter().map(|buffer| buffer.name).collect())
    };
    if names.is_empty() && !is_texture {
        return format!("no buffer is named {name}: a program without a scene has none; use a stream");
    }
    names.sort_unstable();
    format!("no {kind} is named {name}; there are {}", names.join(", "))
}
