//! Rewrites a shader so that the lists of scene data which it binds as storage buffers are textures: the paper's Figure 5.
//!
//! A list is one `r32uint` texture of k by k texels, a texel for each of its 32-bit words. Every device can load that
//! format, those of WebGL 2 too; it moves bits; and a kernel that needs a word of an element loads no other. What a kernel's
//! WGSL calls `grid_cells[i]` becomes a call of a function that loads the words of the element, or of a member of it, from
//! where [`get_address`](crate::shared::address) says.

mod accessors;

use std::collections::{BTreeMap, BTreeSet};

use naga::compact::{KeepUnused, compact};
use naga::valid::{Capabilities, FunctionInfo, ModuleInfo, ValidationFlags, Validator};
use naga::{
    AddressSpace, Block, Expression, Function, GlobalVariable, Handle, Literal, Module, Range, ResourceBinding, Span,
    Statement, TypeInner,
};

use super::blocks::rewritten;
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
        Shader::parse(&(functions + source), &lists)?.rewritten()
    };
    let source = rewritten().map_err(|message| ShaderError::Invalid { kernel: kernel.name(), message })?;
    Ok((source, bindings))
}

/// A shader, and the lists that it binds as buffers.
struct Shader {
    module: Module,
    info: ModuleInfo,
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

fn valid(module: &Module) -> Result<ModuleInfo, String> {
    Validator::new(ValidationFlags::all(), Capabilities::all()).validate(module).map_err(|e| format!("{e:?}"))
}

impl Shader {
    fn parse(source: &str, lists: &[ResourceBinding]) -> Result<Self, String> {
        let module = naga::front::wgsl::parse_str(source).map_err(|e| e.emit_to_string(source))?;
        let info = valid(&module)?;
        let is_list = |global: &GlobalVariable| {
            matches!(global.space, AddressSpace::Storage { .. }) && global.binding.is_some_and(|at| lists.contains(&at))
        };
        let globals = module.global_variables.iter();
        let lists = globals.filter(|(_, global)| is_list(global)).map(|(handle, _)| handle).collect();
        Ok(Self { module, info, lists })
    }

    /// Every function and what naga knows of it, entry points last.
    fn functions(&self) -> impl Iterator<Item = (&Function, &FunctionInfo)> {
        let plain = self.module.functions.iter().map(|(handle, function)| (function, &self.info[handle]));
        let entries = self.module.entry_points.iter().enumerate();
        plain.chain(entries.map(|(index, entry)| (&entry.function, self.info.get_entry_point(index))))
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
            let element = &self.module.types[element];
            return Ok(Some(Place { list, index, offset: 0, ty: element.inner.clone(), name: element.name.clone() }));
        }
        let Some(Place { list, index: of, offset, ty, .. }) = self.place(function, base)? else { return Ok(None) };
        let Index::Constant(member) = index else { return Err("an index within an element of a list".into()) };
        let (within, ty, name) = match &ty {
            TypeInner::Struct { members, .. } => {
                let member = &members[member as usize];
                let ty = &self.module.types[member.ty];
                (member.offset, ty.inner.clone(), ty.name.clone())
            }
            TypeInner::Vector { scalar, .. } => (u32::from(scalar.width) * member, TypeInner::Scalar(*scalar), None),
            other => return Err(format!("a member of {other:?} in a list")),
        };
        Ok(Some(Place { list, index: of, offset: offset + within, ty, name }))
    }

    /// The module with calls in place of loads from lists, as WGSL.
    fn rewritten(mut self) -> Result<String, String> {
        let changed: Vec<Function> =
            self.functions().map(|(function, info)| self.changed(function, info)).collect::<Result<_, _>>()?;
        let plain = self.module.functions.iter_mut().map(|(_, function)| function);
        let all = plain.chain(self.module.entry_points.iter_mut().map(|entry| &mut entry.function));
        all.zip(changed).for_each(|(function, changed)| *function = changed);
        // Nothing mentions the buffers any more.
        compact(&mut self.module, KeepUnused::No);
        let info = valid(&self.module)?;
        let flags = naga::back::wgsl::WriterFlags::empty();
        naga::back::wgsl::write_string(&self.module, &info, flags).map_err(|e| e.to_string())
    }

    fn changed(&self, original: &Function, info: &FunctionInfo) -> Result<Function, String> {
        let mut function = original.clone();
        // The pointers into lists, and for each load of one the call with its argument.
        let (mut pointers, mut calls) = (BTreeSet::new(), BTreeMap::new());
        for (handle, expression) in original.expressions.iter() {
            if let Expression::Load { pointer } = *expression
                && let Some(place) = self.place(original, pointer)?
            {
                let name = self.accessor(&place, info);
                let of = self.module.functions.iter().find(|(_, of)| of.name.as_ref() == Some(&name));
                let (callee, _) = of.ok_or_else(|| format!("no function {name}"))?;
                let argument = match place.index {
                    Index::Computed(index) => index,
                    Index::Constant(index) => {
                        let literal = Expression::Literal(Literal::U32(index));
                        function.expressions.append(literal, Span::UNDEFINED)
                    }
                };
                *function.expressions.get_mut(handle) = Expression::CallResult(callee);
                calls.insert(handle, (callee, argument));
            } else if self.place(original, handle)?.is_some() {
                // A pointer stays where other expressions follow it, as something that nobody asks for.
                *function.expressions.get_mut(handle) = Expression::Literal(Literal::U32(0));
                pointers.insert(handle);
            }
        }
        function.body = rewritten(&original.body, &mut |block, statement, span| {
            let Statement::Emit(range) = statement else {
                block.push(statement.clone(), span);
                return Ok::<(), String>(());
            };
            let mut computed = None;
            for handle in range.clone() {
                if let Some(&(function, argument)) = calls.get(&handle) {
                    emit(block, &mut computed, span);
                    let call = Statement::Call { function, arguments: vec![argument], result: Some(handle) };
                    block.push(call, span);
                } else if pointers.contains(&handle) {
                    emit(block, &mut computed, span);
                } else {
                    let (first, _) = computed.unwrap_or((handle, handle));
                    computed = Some((first, handle));
                }
            }
            emit(block, &mut computed, span);
            Ok(())
        })?;
        Ok(function)
    }
}

/// Appends the computation of these expressions, the first and the last, if there are any.
fn emit(block: &mut Block, computed: &mut Option<(Handle<Expression>, Handle<Expression>)>, span: Span) {
    if let Some((first, last)) = computed.take() {
        block.push(Statement::Emit(Range::new_from_bounds(first, last)), span);
    }
}

#[cfg(test)]
mod tests;
