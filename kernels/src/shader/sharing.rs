//! Rewrites a shader so that streams share a texture, each in layers of its own: a device may allow fewer storage textures
//! than a kernel writes streams.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use naga::valid::FunctionInfo;
use naga::{Expression, Function, GlobalVariable, Handle, ImageQuery, ScalarKind, Statement};

use super::blocks::visit;
use super::parsed::{Parsed, Replaced};
use super::{Binding, Resource, ShaderError, Variant};
use crate::tables::stream::{Stream, Texel};

/// The streams that share a texture, in the order of their layers.
pub type Group = Vec<Stream>;

/// The first layer of a stream in the texture of its group.
#[must_use]
pub fn first_layer(group: &[Stream], stream: Stream) -> u32 {
    group.iter().take_while(|&&other| other != stream).map(|other| other.layers() as u32).sum()
}

impl Variant {
    /// The same kernel, as a device gets it that has textures for these groups of streams and binds at most so many storage
    /// textures; `None` if it binds no more than that.
    ///
    /// # Errors
    /// If it gives a texture to a function.
    pub(crate) fn sharing(&self, groups: &[Group], most: u32) -> Result<Option<Self>, ShaderError> {
        let is_written = |binding: &&Binding| matches!(binding.resource, Resource::WriteStream { .. });
        let written: BTreeSet<Stream> = self.bindings.iter().filter(is_written).filter_map(Binding::stream).collect();
        let is_shared = |group: &&Group| group.iter().filter(|stream| written.contains(stream)).count() > 1;
        let shared: Vec<&Group> = groups.iter().filter(is_shared).collect();
        if written.len() <= most as usize || shared.is_empty() {
            return Ok(None);
        }
        let (source, bindings) = shared
            .iter()
            .try_fold((self.source.clone(), self.bindings.clone()), |(source, bindings), group| {
                one(&source, bindings, group)
            })
            .map_err(|message| ShaderError::Invalid { kernel: self.kernel.name(), message })?;
        Ok(Some(Self { source, bindings, ..self.clone() }))
    }
}

/// The source and the bindings with one texture for a group.
fn one(source: &str, mut bindings: Vec<Binding>, group: &Group) -> Result<(String, Vec<Binding>), String> {
    let is_in = |binding: &Binding| binding.stream().is_some_and(|stream| group.contains(&stream));
    let in_group: Vec<Binding> = bindings.extract_if(.., |binding| is_in(binding)).collect();
    let (Some(at), Some(&first)) = (in_group.first(), group.first()) else { return Ok((source.to_owned(), bindings)) };
    let binding = Binding {
        name: format!("streams_with_{}", first.name()),
        resource: Resource::WriteStreams { first },
        reads: true,
        writes: true,
        ..at.clone()
    };
    // By their places: naga may write names in another way.
    let members = |parsed: &Parsed| -> BTreeMap<Handle<GlobalVariable>, Stream> {
        let stream = |global: &GlobalVariable| {
            let at = global.binding.as_ref()?;
            let is_it = |binding: &&Binding| (binding.group, binding.index) == (at.group, at.binding);
            let is_texture = global.name.as_deref() != Some(binding.name.as_str());
            in_group.iter().find(is_it).filter(|_| is_texture).and_then(Binding::stream)
        };
        let globals = parsed.module.global_variables.iter();
        globals.filter_map(|(handle, global)| Some((handle, stream(global)?))).collect()
    };
    let parsed = Parsed::new(source)?;
    let accessors = Accessors::new(&parsed, &members(&parsed))?.wgsl(&binding, group);
    // First, as a function comes before those that call it.
    let parsed = Parsed::new(&(accessors + source))?;
    let sharing = Sharing { members: members(&parsed), texture: texture(&parsed, &binding.name)? };
    let source = parsed.rewritten(|function, info| sharing.changed(&parsed, function, info))?;
    bindings.push(binding);
    bindings.sort_by_key(|binding| (binding.group, binding.index));
    Ok((source, bindings))
}

fn texture(parsed: &Parsed, name: &str) -> Result<Handle<GlobalVariable>, String> {
    let found = parsed.module.global_variables.iter().find(|(_, global)| global.name.as_deref() == Some(name));
    found.map(|(handle, _)| handle).ok_or_else(|| format!("no texture {name}"))
}

/// The function that loads a texel of a stream, or stores it: named after the types that coordinates and layers have.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Accessor {
    stream: Stream,
    stores: bool,
    is_signed: bool,
    has_signed_layer: bool,
}

impl Accessor {
    fn new(
        parsed: &Parsed,
        info: &FunctionInfo,
        stream: Stream,
        stores: bool,
        [coordinate, layer]: [Handle<Expression>; 2],
    ) -> Self {
        let is_signed = |expression: Handle<Expression>| {
            let kind = info[expression].ty.inner_with(&parsed.module.types).scalar_kind();
            kind == Some(ScalarKind::Sint)
        };
        Self { stream, stores, is_signed: is_signed(coordinate), has_signed_layer: is_signed(layer) }
    }

    fn name(&self) -> String {
        let what = if self.stores { "store" } else { "load" };
        let sign = |is_signed: bool| if is_signed { "i" } else { "u" };
        format!("{what}_{}_{}{}", self.stream.name(), sign(self.is_signed), sign(self.has_signed_layer))
    }
}

/// The functions that a shader needs.
struct Accessors(BTreeSet<Accessor>);

impl Accessors {
    fn new(parsed: &Parsed, members: &BTreeMap<Handle<GlobalVariable>, Stream>) -> Result<Self, String> {
        let mut all = BTreeSet::new();
        for (function, info) in parsed.functions() {
            let stream = |image: Handle<Expression>| stream_of(function, members, image);
            let mut add = |image, stores, at| {
                all.extend(stream(image).map(|stream| Accessor::new(parsed, info, stream, stores, at)));
            };
            for (_, expression) in function.expressions.iter() {
                if let Expression::ImageLoad { image, coordinate, array_index: Some(layer), .. } = *expression {
                    add(image, false, [coordinate, layer]);
                }
            }
            visit(&function.body, &mut |statement| {
                if let Statement::ImageStore { image, coordinate, array_index: Some(layer), .. } = *statement {
                    add(image, true, [coordinate, layer]);
                }
                let is_given = |argument: &Handle<Expression>| stream(*argument).is_some();
                match statement {
                    Statement::Call { arguments, .. } if arguments.iter().any(is_given) => {
                        Err("it gives a stream's texture to a function".to_owned())
                    }
                    _ => Ok(()),
                }
            })?;
        }
        Ok(Self(all))
    }

    fn wgsl(&self, binding: &Binding, group: &Group) -> String {
        let Binding { group: at, index, name, .. } = binding;
        let is_float = group.iter().any(|stream| stream.info().texel == Texel::F32);
        let (format, texel) = if is_float { ("r32float", "vec4f") } else { ("r32uint", "vec4u") };
        let mut text =
            format!("@group({at}) @binding({index}) var {name}: texture_storage_2d_array<{format}, read_write>;\n");
        let ty = |is_signed: bool| if is_signed { "i32" } else { "u32" };
        for accessor in &self.0 {
            let parameters =
                format!("texel: vec2<{}>, layer: {}", ty(accessor.is_signed), ty(accessor.has_signed_layer));
            let Accessor { stream, stores, .. } = *accessor;
            let (function, first, layers) = (accessor.name(), first_layer(group, stream), stream.layers());
            // A layer that the stream does not have is another stream's.
            _ = if stores {
                writeln!(
                    text,
                    "fn {function}({parameters}, value: {texel}) {{\n    if (u32(layer) < {layers}u) {{\n        \
                     textureStore({name}, texel, u32(layer) + {first}u, value);\n    }}\n}}"
                )
            } else {
                writeln!(
                    text,
                    "fn {function}({parameters}) -> {texel} {{\n    if (u32(layer) >= {layers}u) {{\n        return \
                     {texel}();\n    }}\n    return textureLoad({name}, texel, u32(layer) + {first}u);\n}}"
                )
            };
        }
        text
    }
}

fn stream_of(
    function: &Function,
    members: &BTreeMap<Handle<GlobalVariable>, Stream>,
    image: Handle<Expression>,
) -> Option<Stream> {
    let Expression::GlobalVariable(global) = function.expressions[image] else { return None };
    members.get(&global).copied()
}

/// The textures of streams, and that which takes their place.
struct Sharing {
    members: BTreeMap<Handle<GlobalVariable>, Stream>,
    texture: Handle<GlobalVariable>,
}

impl Sharing {
    fn changed(&self, parsed: &Parsed, original: &Function, info: &FunctionInfo) -> Result<Function, String> {
        let mut function = original.clone();
        let mut replaced = Replaced::default();
        let stream = |image: Handle<Expression>| stream_of(original, &self.members, image);
        for (handle, expression) in original.expressions.iter() {
            match *expression {
                Expression::ImageLoad { image, coordinate, array_index: Some(layer), .. } => {
                    let Some(stream) = stream(image) else { continue };
                    let accessor = Accessor::new(parsed, info, stream, false, [coordinate, layer]);
                    let callee = parsed.function(&accessor.name())?;
                    replaced.by_call(&mut function, handle, callee, vec![coordinate, layer]);
                }
                Expression::ImageQuery { image, query } => {
                    let Some(stream) = stream(image) else { continue };
                    match query {
                        ImageQuery::NumLayers => replaced.by_number(&mut function, handle, stream.layers() as u32),
                        _ => {
                            let query = ImageQuery::Size { level: None };
                            *function.expressions.get_mut(handle) = Expression::ImageQuery { image, query };
                        }
                    }
                }
                _ => {}
            }
        }
        // Each mention of a global is an expression of its own.
        for (handle, _) in original.expressions.iter().filter(|(handle, _)| stream(*handle).is_some()) {
            *function.expressions.get_mut(handle) = Expression::GlobalVariable(self.texture);
        }
        function.body = replaced.body(&original.body, &mut |block, statement, span| {
            if let Statement::ImageStore { image, coordinate, array_index: Some(layer), value } = *statement
                && let Some(stream) = stream(image)
            {
                let accessor = Accessor::new(parsed, info, stream, true, [coordinate, layer]);
                let function = parsed.function(&accessor.name())?;
                let arguments = vec![coordinate, layer, value];
                block.push(Statement::Call { function, arguments, result: None }, span);
            } else {
                block.push(statement.clone(), span);
            }
            Ok(())
        })?;
        Ok(function)
    }
}

#[cfg(test)]
mod tests;
