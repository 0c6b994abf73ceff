//! Types and their slots.

use naga::proc::TypeResolution;
use naga::{Arena, Expression, Handle, Literal, Module, ScalarKind, TypeInner};

use crate::interpret::code::{Holds, Slot, slots};

pub(super) fn inner<'a>(ty: &'a TypeResolution, types: &'a naga::UniqueArena<naga::Type>) -> &'a TypeInner {
    ty.inner_with(types)
}

/// What a pointer points to.
pub(in crate::interpret) fn pointee(types: &naga::UniqueArena<naga::Type>, pointer: &TypeInner) -> Option<TypeInner> {
    match *pointer {
        TypeInner::Pointer { base, .. } => Some(types[base].inner.clone()),
        TypeInner::ValuePointer { size: Some(size), scalar, .. } => Some(TypeInner::Vector { size, scalar }),
        TypeInner::ValuePointer { size: None, scalar, .. } => Some(TypeInner::Scalar(scalar)),
        _ => None,
    }
}

/// The slot at which a part of a composite begins.
pub(in crate::interpret) fn part(types: &naga::UniqueArena<naga::Type>, whole: &TypeInner, index: u32) -> u32 {
    match *whole {
        TypeInner::Struct { ref members, .. } => {
            members.iter().take(index as usize).filter_map(|member| slots(types, &types[member.ty].inner)).sum()
        }
        TypeInner::Array { base, .. } => index * slots(types, &types[base].inner).unwrap_or(0),
        TypeInner::Matrix { rows, .. } => index * rows as u32,
        _ => index,
    }
}

fn slot(literal: Literal) -> Slot {
    let (bits, wide) = match literal {
        Literal::F32(value) => (value.to_bits(), f64::from(value)),
        Literal::U32(value) => (value, 0.0),
        Literal::I32(value) => (value.cast_unsigned(), 0.0),
        Literal::Bool(value) => (value.into(), f64::from(u8::from(value))),
        _ => (0, 0.0),
    };
    Slot { bits, from: 0, wide }
}

/// Whether values of a type can be computed: scalars of four bytes, booleans, and what is made of them. What has no values
/// is used by what it is a part of.
pub(super) fn is_known(inner: &TypeInner) -> bool {
    match *inner {
        TypeInner::Scalar(scalar)
        | TypeInner::Vector { scalar, .. }
        | TypeInner::Matrix { scalar, .. }
        | TypeInner::Atomic(scalar)
        | TypeInner::ValuePointer { scalar, .. } => match scalar.kind {
            ScalarKind::Sint | ScalarKind::Uint | ScalarKind::Float => scalar.width == 4,
            ScalarKind::Bool | ScalarKind::AbstractInt | ScalarKind::AbstractFloat => true,
        },
        TypeInner::Array { .. } | TypeInner::Struct { .. } | TypeInner::Pointer { .. } => true,
        TypeInner::Image { .. } | TypeInner::Sampler { .. } => true,
        _ => false,
    }
}

pub(super) fn holds(inner: &TypeInner) -> Holds {
    match inner {
        TypeInner::Pointer { .. } | TypeInner::ValuePointer { .. } => Holds::Pointer,
        TypeInner::Image { .. } => Holds::Texture,
        _ => Holds::Value,
    }
}

/// The value of an expression without variables; `None` for one that is not supported.
pub(super) fn evaluated(module: &Module, arena: &Arena<Expression>, at: Handle<Expression>) -> Option<Vec<Slot>> {
    let (types, globals) = (&module.types, &module.global_expressions);
    Some(match arena[at] {
        Expression::Literal(literal) => vec![slot(literal)],
        Expression::ZeroValue(ty) => vec![Slot::default(); slots(types, &types[ty].inner)? as usize],
        Expression::Constant(constant) => evaluated(module, globals, module.constants[constant].init)?,
        Expression::Override(over) => evaluated(module, globals, module.overrides[over].init?)?,
        Expression::Compose { ref components, .. } => {
            components.iter().map(|&part| evaluated(module, arena, part)).collect::<Option<Vec<_>>>()?.concat()
        }
        Expression::Splat { size, value } => evaluated(module, arena, value)?.repeat(size as usize),
        _ => return None,
    })
}
