//! Places of global variables.

use naga::valid::FunctionInfo;
use naga::{AddressSpace, GlobalVariable, Module};

use super::parts::evaluated;
use super::text::line_of;
use crate::interpret::InterpretError;
use crate::interpret::code::{Code, Global, MOST_SLOTS, Slot, slots};
use crate::shader::{Resource, Variant};

/// Gives a place to each global variable that an entry point uses.
pub(super) fn globals(
    variant: &Variant,
    module: &Module,
    usage: &FunctionInfo,
    is_whole: bool,
    code: &mut Code,
) -> Result<(), InterpretError> {
    for (handle, global) in module.global_variables.iter() {
        let name = global.name.as_deref().map(|name| variant.kernel.bound(name));
        let binding = name.and_then(|name| variant.bindings.iter().find(|binding| binding.name == name));
        let unsupported = |what: &str| {
            let span = module.global_variables.get_span(handle).to_range();
            let line = span.map_or(0, |span| line_of(&variant.source, span.start) + 1);
            InterpretError::Unsupported { what: what.into(), line }
        };
        let found = match (binding.map(|binding| binding.resource), global.space) {
            (Some(Resource::ReadStream(stream) | Resource::WriteStream { stream, .. }), _) => Global::Stream(stream),
            (Some(Resource::Uniform | Resource::Storage), _) => Global::Bytes(name.unwrap_or_default().to_owned()),
            (Some(Resource::Launch), _) if is_whole => Global::Launch,
            (None, AddressSpace::Private | AddressSpace::WorkGroup) if usage[handle].is_empty() => Global::Other,
            (None, AddressSpace::Private) => {
                let place = code.private.len() as u32;
                let value = initial(module, global).ok_or_else(|| unsupported("a variable of this type"))?;
                code.private.extend(value);
                Global::Private(place)
            }
            (None, AddressSpace::WorkGroup) if is_whole => {
                let place = code.workgroup;
                let width = size(module, global).ok_or_else(|| unsupported("a variable of this type"))?;
                code.workgroup += width;
                code.shared.push((place, global.name.clone().unwrap_or_default()));
                Global::Workgroup(place)
            }
            _ => Global::Other,
        };
        if code.private.len() > MOST_SLOTS as usize || code.workgroup > MOST_SLOTS {
            return Err(unsupported("so much memory of variables"));
        }
        code.globals.push(found);
    }
    Ok(())
}

/// Slots of a variable; `None` if it has too many, or a type without values.
fn size(module: &Module, global: &GlobalVariable) -> Option<u32> {
    slots(&module.types, &module.types[global.ty].inner).filter(|&width| width <= MOST_SLOTS)
}

fn initial(module: &Module, global: &GlobalVariable) -> Option<Vec<Slot>> {
    let width = size(module, global)? as usize;
    match global.init {
        Some(init) => evaluated(module, &module.global_expressions, init).filter(|value| value.len() == width),
        None => Some(vec![Slot::default(); width]),
    }
}
