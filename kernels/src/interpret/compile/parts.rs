//! Types and their slots.

use naga::proc::TypeResolution;
use naga::{Literal, TypeInner};

use crate::interpret::code::{Slot, slots};

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
        _ => index,
    }
}

pub(super) fn slot(literal: Literal) -> Slot {
    let (bits, wide) = match literal {
        Literal::F32(value) => (value.to_bits(), f64::from(value)),
        Literal::U32(value) => (value, 0.0),
        Literal::I32(value) => (value.cast_unsigned(), 0.0),
        Literal::Bool(value) => (value.into(), f64::from(u8::from(value))),
        _ => (0, 0.0),
    };
    Slot { bits, from: 0, wide }
}
