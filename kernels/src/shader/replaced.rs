//! Kernels whose WGSL is a user's: composed and checked like ours, but a mistake is named with its place in their file.

use std::error::Error;
use std::fmt;
use std::sync::Arc;

use naga::valid::{Capabilities, GlobalUse, ModuleInfo, ValidationError, ValidationFlags, Validator};
use naga::{
    AddressSpace, GlobalVariable, ImageClass, Module, ScalarKind, ShaderStage, Span, StorageAccess, TypeInner, WithSpan,
};

use super::uniform::astray;
use super::{LAUNCH, LIVE, Resource, ShaderError, Variant, modules, reflected, resource_of};
use crate::compose::{ComposeError, Composed, compose_in_place};
use crate::options::features::Features;
use crate::options::replacement::Replacement;
use crate::program::Kernel;
use crate::program::live::LiveList;
use crate::tables::kernel::Launch;
use crate::tables::stream::Texel;

/// What a kernel's WGSL was replaced by.
#[derive(Clone, Debug)]
pub struct Replaced {
    /// The user's file.
    pub by: Arc<Replacement>,
    composed: Composed,
    root: &'static str,
}

/// A place in a user's file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file.
    pub file: String,
    /// Line, from 1; 0 if the place is in none of its lines.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// The text of the line.
    pub text: String,
}

/// What is wrong with a user's WGSL, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mistake {
    /// Where.
    pub place: Place,
    /// What.
    pub message: String,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            0 => f.write_str(&self.file),
            line => write!(f, "{}:{line}:{}", self.file, self.column),
        }
    }
}

impl fmt::Display for Mistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.message)
    }
}

impl Mistake {
    /// The line and, below it, a caret at the place; `None` if it has no place.
    #[must_use]
    pub fn excerpt(&self) -> Option<String> {
        if self.place.line == 0 {
            return None;
        }
        // Tabs keep their width, so that the caret stays below its character.
        let text = self.place.text.trim_end();
        let indent: String =
            text.chars().take(self.place.column - 1).map(|c| if c == '\t' { '\t' } else { ' ' }).collect();
        Some(format!("    {text}\n    {indent}^"))
    }
}

impl Error for Mistake {}

/// The place of a byte in a file's text.
fn place_of(by: &Replacement, at: usize) -> Place {
    let source = &by.source;
    let mut at = at.min(source.len());
    while !source.is_char_boundary(at) {
        at -= 1;
    }
    let first = source[..at].rfind('\n').map_or(0, |end| end + 1);
    let text = source[first..].lines().next().unwrap_or_default().to_owned();
    let (line, column) = (source[..first].matches('\n').count() + 1, source[first..at].chars().count() + 1);
    Place { file: by.file.clone(), line, column, text }
}

/// A mistake that has no place.
fn everywhere(by: &Replacement, message: String) -> Mistake {
    Mistake { place: Place { file: by.file.clone(), line: 0, column: 0, text: String::new() }, message }
}

impl Replaced {
    /// The place in the user's file of a byte of the composed source; `None` if that is from another module.
    #[must_use]
    pub fn place(&self, at: usize) -> Option<Place> {
        let (_, byte) = self.composed.origin(at, self.root)?;
        byte.map(|byte| place_of(&self.by, byte))
    }

    /// The place in the user's file of a line of the composed source, from 1.
    #[must_use]
    pub fn place_of_line(&self, line: usize) -> Option<Place> {
        let text = &self.composed.text;
        let first: usize = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
        let indent = text[first..].len() - text[first..].trim_start_matches([' ', '\t']).len();
        self.place(first + indent)
    }

    /// A place of the composed source as a reader finds it: in their file, or in a module that they import from.
    #[must_use]
    pub fn named_line(&self, line: usize) -> String {
        let first: usize = self.composed.text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
        match (self.place_of_line(line), self.composed.origin(first, self.root)) {
            (Some(place), _) => format!("{}:{}", place.file, place.line),
            (None, Some((module, _))) => format!("package::{module}"),
            (None, None) => self.by.file.clone(),
        }
    }

    /// A mistake at the first of these places that is in the user's file.
    fn mistake(&self, spans: impl IntoIterator<Item = Span>, message: String) -> Mistake {
        let mut elsewhere = None;
        for range in spans.into_iter().filter_map(Span::to_range) {
            match self.composed.origin(range.start, self.root) {
                Some((_, Some(byte))) => return Mistake { place: place_of(&self.by, byte), message },
                Some((module, None)) => elsewhere = elsewhere.or(Some(module.to_owned())),
                None => {}
            }
        }
        let message = match elsewhere {
            Some(module) => format!("in package::{module}, which it imports: {message}"),
            None => message,
        };
        everywhere(&self.by, message)
    }
}

impl Variant {
    /// A kernel with a user's WGSL in place of its own.
    ///
    /// # Errors
    /// If the WGSL is not valid, or does not fit the kernel: with its place.
    pub fn replaced(
        kernel: Kernel,
        features: &Features,
        lists: &[LiveList],
        by: &Arc<Replacement>,
    ) -> Result<Self, ShaderError> {
        let features = &kernel.features(features);
        Self::of_user(kernel, features, lists, by).map_err(|mistake| ShaderError::Mistake(Box::new(mistake)))
    }

    fn of_user(
        kernel: Kernel,
        features: &Features,
        lists: &[LiveList],
        by: &Arc<Replacement>,
    ) -> Result<Self, Mistake> {
        let root = kernel.info().name;
        let modules = modules(kernel, features, lists);
        let options = features.list();
        let source = |name: &str| {
            if name == root {
                return Some(by.source.as_str());
            }
            modules.iter().find(|(module, _)| *module == name).map(|(_, source)| source.as_ref())
        };
        let option = |name: &str| match name {
            "live_lists" => Some(!lists.is_empty()),
            _ => options.iter().find(|(option, _)| *option == name).map(|&(_, is_on)| is_on),
        };
        let composed = compose_in_place(root, root, &source, &option).map_err(|e| not_composed(by, root, &e))?;
        let replaced = Replaced { by: by.clone(), composed, root };
        let text = &replaced.composed.text;

        let module = naga::front::wgsl::parse_str(text).map_err(|error| {
            let notes = error.notes().map(|note| format!(" ({note})"));
            let message = error.message().to_owned() + &notes.collect::<String>();
            replaced.mistake(error.labels().map(|(span, _)| span), message)
        })?;
        distinct(&replaced, &module)?;
        let info = Validator::new(ValidationFlags::all(), Capabilities::default())
            .validate(&module)
            .map_err(|error| not_valid(&replaced, &error))?;
        let entry = module
            .entry_points
            .iter()
            .position(|e| e.stage == ShaderStage::Compute && e.name == root)
            .ok_or_else(|| no_entry(by, root))?;
        fits(&replaced, kernel, &module, &info, entry)?;
        if let Some(span) = astray(&module, &module.entry_points[entry].function) {
            let message = "some threads of a workgroup may not reach this, and it has a barrier, for which all must \
                           arrive: call it outside of if and loop, and after no return"
                .to_owned();
            return Err(replaced.mistake([span], message));
        }
        let source = replaced.composed.text.clone();
        let unknown = |_: &str| everywhere(by, format!("its bindings are not those of {}", kernel.name()));
        let (bindings, structs, arrays) =
            reflected(kernel, &module, info.get_entry_point(entry)).map_err(|name| unknown(&name))?;
        // Rays that a kernel does not book are lost for those after it.
        let own = Self::new(kernel, features, lists).map_err(|error| everywhere(by, error.to_string()))?;
        let is_missing = |binding: &&super::Binding| {
            binding.writes
                && matches!(binding.resource, Resource::Live { .. })
                && !bindings.iter().any(|other| other.name == binding.name && other.writes)
        };
        if own.bindings.iter().any(|binding| is_missing(&binding)) {
            let message = "it does not say where its rays go: the last call of every thread must be send(lane, texel, \
                           tag), from package::live, with the tag that it stored or NOBODY"
                .to_owned();
            return Err(Mistake { place: declared(by, root), message });
        }
        Ok(Self { kernel, source, bindings, structs, arrays, replaced: Some(Arc::new(replaced)) })
    }

    /// A place of the composed source for messages: the line in a user's file, if it is from there.
    #[must_use]
    pub fn named_line(&self, line: usize) -> String {
        match &self.replaced {
            Some(replaced) => replaced.named_line(line),
            None => format!("line {line} of {}", self.label()),
        }
    }
}

fn no_entry(by: &Replacement, root: &str) -> Mistake {
    everywhere(by, format!("it has no @compute function named {root}, which is the kernel that it replaces"))
}

fn not_composed(by: &Replacement, root: &str, error: &ComposeError) -> Mistake {
    match error {
        ComposeError::Malformed { module, line, message } if module == root => {
            let at: usize = by.source.split_inclusive('\n').take(line - 1).map(str::len).sum();
            let indent = by.source[at..].len() - by.source[at..].trim_start_matches([' ', '\t']).len();
            Mistake { place: place_of(by, at + indent), message: message.clone() }
        }
        ComposeError::NoEntry { .. } => no_entry(by, root),
        ComposeError::NoModule { module, missing } if module == root => {
            let message = format!("no module is named package::{missing}");
            Mistake { place: found(by, missing), message }
        }
        ComposeError::NoItem { module, name, from } if module == root => {
            let message = format!("package::{from} does not declare {name} in this run");
            Mistake { place: found(by, name), message }
        }
        ComposeError::Twice { name, first, second } => {
            let other = if first == root { second } else { first };
            let message = if other == root {
                format!("{name} is declared twice in this file")
            } else {
                format!("{name} is declared here, and in package::{other}, from which declarations are imported")
            };
            Mistake { place: declared(by, name), message }
        }
        other => everywhere(by, other.to_string()),
    }
}

/// Where a word first stands in a file.
fn found(by: &Replacement, word: &str) -> Place {
    let words = crate::compose::words(&by.source);
    place_of(by, words.iter().find(|found| found.text == word).map_or(0, |found| found.start))
}

/// Where a name is declared in a file, for the last time.
fn declared(by: &Replacement, name: &str) -> Place {
    let words: Vec<_> = crate::compose::words(&by.source);
    let is_keyword = |text: &str| matches!(text, "fn" | "struct" | "const" | "alias" | ">" | "var" | "override");
    let at = words.windows(2).rev().find(|pair| pair[1].text == name && is_keyword(pair[0].text));
    at.map_or_else(|| found(by, name), |pair| place_of(by, pair[1].start))
}

fn not_valid(replaced: &Replaced, error: &WithSpan<ValidationError>) -> Mistake {
    let mut message = error.as_inner().to_string();
    let mut cause = error.as_inner().source();
    while let Some(inner) = cause {
        // The last says what is wrong; those around it, in which function.
        message = format!("{message}: {inner}");
        cause = inner.source();
    }
    replaced.mistake(error.spans().map(|(span, _)| *span), message)
}

/// Whether no two globals have the same binding.
fn distinct(replaced: &Replaced, module: &Module) -> Result<(), Mistake> {
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
fn fits(replaced: &Replaced, kernel: Kernel, module: &Module, info: &ModuleInfo, entry: usize) -> Result<(), Mistake> {
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
    let usage = info.get_entry_point(entry);
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
        let streams = kernel.program().stream(bound);
        if usage[handle].contains(GlobalUse::WRITE)
            && streams.is_some_and(|stream| stream.info().elements.name != kernel.instance().over.name)
        {
            return mistake(format!("{name} is a stream of other elements than those that {} works on", kernel.name()));
        }
    }
    Ok(())
}

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
    names.sort_unstable();
    format!("no {kind} is named {name}; there are {}", names.join(", "))
}

#[cfg(test)]
mod tests;
