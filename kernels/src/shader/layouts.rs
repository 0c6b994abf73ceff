//! Where the members of structs and of lists' elements lie, as naga says.

use naga::{ArraySize, GlobalVariable, Module, ScalarKind, TypeInner};

/// Layout of a uniform or storage struct, from naga.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StructLayout {
    /// The WGSL struct's name.
    pub name: String,
    /// Bytes, padding included.
    pub size: u32,
    /// Name and byte offset of each member.
    pub members: Vec<(String, u32)>,
}

/// A scalar of a struct, or several side by side.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field {
    /// The member's name; empty where elements are no structs.
    pub name: String,
    /// Bytes before it.
    pub offset: u32,
    /// What it is.
    pub kind: ScalarKind,
    /// How many of them there are.
    pub count: u32,
}

/// What an array of scene data consists of, from naga.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ArrayLayout {
    /// The buffer's name.
    pub name: String,
    /// Bytes of an element, padding included.
    pub stride: u32,
    /// Its members; one if it is no struct.
    pub fields: Vec<Field>,
}

pub(super) fn structs_of(module: &Module) -> Vec<StructLayout> {
    module
        .types
        .iter()
        .filter_map(|(_, ty)| match (&ty.inner, &ty.name) {
            (TypeInner::Struct { members, span }, Some(name)) => Some(StructLayout {
                name: name.clone(),
                size: *span,
                members: members.iter().filter_map(|m| Some((m.name.clone()?, m.offset))).collect(),
            }),
            _ => None,
        })
        .collect()
}

/// The elements of an array of scalars, vectors, or structs of these; `None` for anything else.
pub(super) fn array_of(module: &Module, global: &GlobalVariable, name: &str) -> Option<ArrayLayout> {
    let TypeInner::Array { base, stride, .. } = module.types[global.ty].inner else { return None };
    let scalars = |name: &str, offset: u32, inner: &TypeInner| {
        let (kind, count) = match *inner {
            TypeInner::Scalar(scalar) => (scalar.kind, 1),
            TypeInner::Vector { size, scalar } => (scalar.kind, size as u32),
            TypeInner::Array { base, size: ArraySize::Constant(count), .. } => {
                let TypeInner::Scalar(scalar) = module.types[base].inner else { return None };
                (scalar.kind, count.get())
            }
            _ => return None,
        };
        Some(Field { name: name.to_owned(), offset, kind, count })
    };
    let fields = match &module.types[base].inner {
        TypeInner::Struct { members, .. } => members
            .iter()
            .map(|m| scalars(m.name.as_deref().unwrap_or_default(), m.offset, &module.types[m.ty].inner))
            .collect::<Option<Vec<_>>>()?,
        inner => vec![scalars("", 0, inner)?],
    };
    Some(ArrayLayout { name: name.to_owned(), stride, fields })
}
