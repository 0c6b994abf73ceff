//! Rewrites a shader so that the lists of scene data which it binds as storage buffers are textures: the paper's Figure 5.
//!
//! A list is one `r32uint` texture of k by k texels, a texel for each of its 32-bit words. Every device can load that
//! format, those of WebGL 2 too; it moves bits; and a kernel that needs a word of an element loads no other. What a kernel's
//! WGSL calls `grid_cells[i]` becomes a call of a function that loads the words of the element, or of a member of it, from
//! where [`get_address`](crate::shared::address) says.

mod accessors;

use std::collections::BTreeSet;

use naga::valid::FunctionInfo;
use naga::{AddressSpace, Expression, Function, GlobalVariable, Handle, Literal, ResourceBinding, Span, TypeInner};

use super::parsed::{Parsed, Replaced};
use super::{Binding, Resource, ShaderError, Variant};
use crate::program::Kernel;

impl Variant {
    /// The same kernel, as a device gets it whose lists are in textures.
    ///
    /// # Errors
    /// If it does more with a list than to load elements, or members of them.
    pub fn in_textures(&self) -> Result<Self, ShaderError> {
        let (source, bindings) = in_textures(self.kernel, &self.source, &self.bindings)?;
        Ok(Self { source, bindings, ..self.clone() })
    }
}

/// A shader's WGSL and its bindings, with its lists in textures.
///
/// # Errors
/// If it does more with a list than to load elements, or members of them.
pub(crate) fn in_textures(
    kernel: Kernel,
    source: &str,
    bindings: &[Binding],
) -> Result<(String, Vec<Binding>), ShaderError> {
    let mut bindings = bindings.to_vec();
    let mut lists = Vec::new();
    for binding in bindings.iter_mut().filter(|binding| binding.resource == Resource::Storage) {
        binding.resource = Resource::List;
        lists.push(ResourceBinding { group: binding.group, binding: binding.index });
    }
    if lists.is_empty() {
        return Ok((source.to_owned(), bindings));
    }
    let rewritten = || {
        // First, as a function comes before those that call it.
        let functions = Shader::parse(source, &lists)?.accessors()?;
        let shader = Shader::parse(&(functions + source), &lists)?;
        shader.parsed.rewritten(|function, info| shader.changed(function, info))
    };
    let source = rewritten().map_err(|message| ShaderError::Invalid { kernel: kernel.name(), message })?;
    Ok((source, bindings))
}

/// A shader, and the lists that it binds as buffers.
struct Shader {
    parsed: Parsed,
    lists: BTreeSet<Handle<GlobalVariable>>,
}

/// Which element of a list.
#[derive(Clone, Copy)]
enum Index {
    Computed(Handle<Expression>),
    Constant(u32),
}

/// An element of a list, or a member of one.
struct Place {
    list: Handle<GlobalVariable>,
    index: Index,
    /// Bytes before it in its element.
    offset: u32,
    ty: TypeInner,
    /// The type's name, if it is a struct.
    name: Option<String>,
}

impl Shader {
    fn parse(source: &str, lists: &[ResourceBinding]) -> Result<Self, String> {
        let parsed = Parsed::new(source)?;
        let is_list = |global: &GlobalVariable| {
            matches!(global.space, AddressSpace::Storage { .. }) && global.binding.is_some_and(|at| lists.contains(&at))
        };
        let globals = parsed.module.global_variables.iter();
        let lists = globals.filter(|(_, global)| is_list(global)).map(|(handle, _)| handle).collect();
        Ok(Self { parsed, lists })
    }

    /// What a pointer points to, if that is in a list.
    fn place(&self, function: &Function, pointer: Handle<Expression>) -> Result<Option<Place>, String> {
        let (base, index) = match function.expressions[pointer] {
            Expression::Access { base, index } => (base, Index::Computed(index)),
            Expression::AccessIndex { base, index } => (base, Index::Constant(index)),
            _ => return Ok(None),
        };
        if let Expression::GlobalVariable(list) = function.expressions[base]
            && self.lists.contains(&list)
        {
            let (element, _) = self.element(list)?;
            let element = &self.parsed.module.types[element];
            return Ok(Some(Place { list, index, offset: 0, ty: element.inner.clone(), name: element.name.clone() }));
        }
        let Some(Place { list, index: of, offset, ty, .. }) = self.place(function, base)? else { return Ok(None) };
        let Index::Constant(member) = index else { return Err("an index within an element of a list".into()) };
        let (within, ty, name) = match &ty {
            TypeInner::Struct { members, .. } => {
                let member = &members[member as usize];
                let ty = &self.parsed.module.types[member.ty];
                (member.offset, ty.inner.clone(), ty.name.clone())
            }
            TypeInner::Vector { scalar, .. } => (u32::from(scalar.width) * member, TypeInner::Scalar(*scalar), None),
            other => return Err(format!("a member of {other:?} in a list")),
        };
        Ok(Some(Place { list, index: of, offset: offset + within, ty, name }))
    }

    /// A function with calls in place of loads from lists.
    fn changed(&self, original: &Function, info: &FunctionInfo) -> Result<Function, String> {
        let (mut function, mut replaced) = (original.clone(), Replaced::default());
        for (handle, expression) in original.expressions.iter() {
            if let Expression::Load { pointer } = *expression
                && let Some(place) = self.place(original, pointer)?
            {
                let callee = self.parsed.function(&self.accessor(&place, info))?;
                let argument = match place.index {
                    Index::Computed(index) => index,
                    Index::Constant(index) => {
                        let literal = Expression::Literal(Literal::U32(index));
                        function.expressions.append(literal, Span::UNDEFINED)
                    }
                };
                replaced.by_call(&mut function, handle, callee, vec![argument]);
            } else if self.place(original, handle)?.is_some() {
                // A pointer stays where other expressions follow it, as something that nobody asks for.
                replaced.by_number(&mut function, handle, 0);
            }
        }
        function.body = replaced.body(&original.body, &mut |block, statement, span| {
            block.push(statement.clone(), span);
            Ok(())
        })?;
        Ok(function)
    }
}

#[cfg(test)]
mod tests;
