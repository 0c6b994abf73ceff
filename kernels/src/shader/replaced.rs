//! Kernels whose WGSL is a user's: composed and checked like ours, but a mistake is named with its place in their file.

mod fits;

use std::error::Error;
use std::sync::Arc;

use naga::valid::{CallError, Capabilities, FunctionError, ModuleInfo, ValidationError, ValidationFlags, Validator};
use naga::{Module, ShaderStage, Span, WithSpan};

use super::before::from_copies;
use super::mistake::{Mistake, Place, place_in, place_of};
use super::notes::{Marked, Notes};
use super::uniform::astray;
use super::{Reflected, Resource, ShaderError, Variant, modules, reflected};
use crate::compose::{ComposeError, Composed, WordKind, compose_in_place};
use crate::options::features::Features;
use crate::options::replacement::Replacement;
use crate::program::live::LiveList;
use crate::program::{Kernel, UserFile};
use crate::tables::kernel::Counts;
use crate::tables::stream::Stream;
use fits::{distinct, fits};

/// What a kernel's WGSL was replaced by.
#[derive(Clone, Debug)]
pub struct Replaced {
    /// The user's file.
    pub by: Arc<Replacement>,
    pub(super) composed: Composed,
    /// The module that it is.
    pub(super) root: &'static str,
    /// The files of the program, if it is a user's.
    files: &'static [UserFile],
    /// What it prints and asserts.
    pub notes: Notes,
}

const NOT_BOOKED: &str = "it does not tell where its elements go: the last call of every thread must be \
                          send(lane, texel, tag) or book(lane, tag), from package::live, with the tag that it stored or NOBODY";

/// A mistake that has no place.
fn everywhere(by: &Replacement, message: String) -> Mistake {
    Mistake { place: Place { file: by.file.clone(), line: 0, column: 0, text: String::new() }, message }
}

impl Replaced {
    /// The place in the user's file of a byte of the composed source; `None` if that is from another module.
    #[must_use]
    pub fn place(&self, at: usize) -> Option<Place> {
        let (module, byte) = self.composed.origin(at)?;
        byte.map(|byte| self.place_in(module, byte))
    }

    /// The place of a byte of a user's module: the file that replaces a kernel, or one of a program's.
    fn place_in(&self, module: &str, byte: usize) -> Place {
        match self.files.iter().find(|file| file.module == module) {
            Some(file) => place_in(file.file, file.source, byte),
            None => place_of(&self.by, byte),
        }
    }

    /// The first byte of a line of the composed source, from 1.
    fn first_of(&self, line: usize) -> usize {
        self.composed.text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum()
    }

    /// The place in the user's file of a line of the composed source, from 1.
    #[must_use]
    pub fn place_of_line(&self, line: usize) -> Option<Place> {
        let (text, first) = (&self.composed.text, self.first_of(line));
        let indent = text[first..].len() - text[first..].trim_start_matches([' ', '\t']).len();
        self.place(first + indent)
    }

    /// A place of the composed source as a reader finds it: in their file, or in a module that they import from.
    #[must_use]
    pub fn named_line(&self, line: usize) -> String {
        match (self.place_of_line(line), self.composed.origin(self.first_of(line))) {
            (Some(place), _) => format!("{}:{}", place.file, place.line),
            (None, Some((module, _))) => format!("package::{module}"),
            (None, None) => self.by.file.clone(),
        }
    }

    /// A mistake at the first of these places that is in the user's file.
    fn mistake(&self, spans: impl IntoIterator<Item = Span>, message: String) -> Mistake {
        let mut elsewhere = None;
        for range in spans.into_iter().filter_map(Span::to_range) {
            match self.composed.origin(range.start) {
                Some((module, Some(byte))) => return Mistake { place: self.place_in(module, byte), message },
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
        let root = kernel.info().name;
        Self::of_user(kernel, features, lists, by, root, false)
            .map_err(|mistake| ShaderError::Mistake(Box::new(mistake)))
    }

    /// A kernel of a user's program.
    ///
    /// # Errors
    /// If the WGSL is not valid, or does not fit the program: with its place.
    pub(crate) fn of_folder(kernel: Kernel, features: &Features, lists: &[LiveList]) -> Result<Self, ShaderError> {
        let source = kernel.info().wgsl;
        let file = kernel.program().files.iter().find(|file| std::ptr::eq(file.source, source));
        let (module, file) = file.map_or((kernel.info().name, kernel.name()), |file| (file.module, file.file));
        let by = Replacement { kernel: kernel.name().to_owned(), file: file.to_owned(), source: source.to_owned() };
        let features = &kernel.features(features);
        let variant = Self::of_user(kernel, features, lists, &Arc::new(by), module, false);
        variant.map_err(|mistake| ShaderError::Mistake(Box::new(mistake)))
    }

    /// `is_in_place`: whether all modules are composed in place, not only the user's.
    pub(super) fn of_user(
        kernel: Kernel,
        features: &Features,
        lists: &[LiveList],
        by: &Arc<Replacement>,
        root: &'static str,
        is_in_place: bool,
    ) -> Result<Self, Mistake> {
        let name = kernel.info().name;
        let files = kernel.program().files;
        let modules = modules(kernel, features, lists);
        let options = features.list();
        let marked = Marked::new(by)?;
        let own = marked.text.clone();
        let source = |name: &str| {
            if name == root {
                return Some(own.as_str());
            }
            modules.iter().find(|(module, _)| *module == name).map(|(_, source)| source.as_ref())
        };
        let option = |name: &str| match name {
            "live_lists" => Some(!lists.is_empty()),
            _ => options.iter().find(|(option, _)| *option == name).map(|&(_, is_on)| is_on),
        };
        let all = modules.iter().map(|(module, _)| *module).filter(|_| is_in_place);
        let in_place: Vec<&'static str> = files.iter().map(|file| file.module).chain([root]).chain(all).collect();
        let composed = compose_in_place(root, name, &in_place, &source, &option);
        let mut composed = composed.map_err(|error| not_composed(by, files, [root, name], &error))?;
        let notes = marked.declare(by, &mut composed.text)?;
        let replaced = Replaced { by: by.clone(), composed, root, files, notes };
        let text = &replaced.composed.text;

        let module = naga::front::wgsl::parse_str(text).map_err(|error| {
            let notes = error.notes().map(|note| format!(" ({note})"));
            let message = error.message().to_owned() + &notes.collect::<String>();
            replaced.mistake(error.labels().map(|(span, _)| span), message)
        })?;
        distinct(&replaced, &module)?;
        let entry = module
            .entry_points
            .iter()
            .position(|e| e.stage == ShaderStage::Compute && e.name == name)
            .ok_or_else(|| no_entry(by, name))?;
        let info = Validator::new(ValidationFlags::all(), Capabilities::default())
            .validate(&module)
            .map_err(|error| not_valid(&replaced, &error))?;
        fits(&replaced, kernel, &module, &info, entry)?;
        if let Some(span) = astray(&module, &module.entry_points[entry].function) {
            let message = "some threads of a workgroup may not reach this, and it has a barrier, for which all must \
                           arrive: call it where no condition before it or around it differs between threads"
                .to_owned();
            return Err(replaced.mistake([span], message));
        }
        let unknown = |_: &str| everywhere(by, format!("its bindings are not those of {}", kernel.name()));
        let with = |source: String, (bindings, structs, arrays): Reflected| Self {
            kernel,
            source,
            bindings,
            structs,
            arrays,
            replaced: Some(Arc::new(replaced.clone())),
        };
        let bound = reflected(kernel, &module, info.get_entry_point(entry)).map_err(|name| unknown(&name))?;
        if !files.is_empty() {
            let books =
                bound.0.iter().any(|binding| binding.writes && matches!(binding.resource, Resource::Live { .. }));
            if !bound.0.iter().any(|binding| binding.writes) {
                let message = "it writes no stream, so it has no effect".to_owned();
                return Err(Mistake { place: declared(by, name), message });
            }
            if kernel.counts() == Counts::Sent && !books {
                return Err(Mistake { place: declared(by, name), message: NOT_BOOKED.to_owned() });
            }
            let Some((source, module, info)) = loading_copies(&replaced, kernel)? else {
                return Ok(with(replaced.composed.text.clone(), bound));
            };
            let bound = reflected(kernel, &module, info.get_entry_point(entry)).map_err(|name| unknown(&name))?;
            return Ok(with(source, bound));
        }
        // Rays that a kernel does not book are lost for those after it.
        let own = Self::new(kernel, features, lists).map_err(|error| everywhere(by, error.to_string()))?;
        let is_missing = |binding: &&super::Binding| {
            binding.writes
                && matches!(binding.resource, Resource::Live { .. })
                && !bound.0.iter().any(|other| other.name == binding.name && other.writes)
        };
        if own.bindings.iter().any(|binding| is_missing(&binding)) {
            return Err(Mistake { place: declared(by, name), message: NOT_BOOKED.to_owned() });
        }
        Ok(with(replaced.composed.text.clone(), bound))
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

/// The shader of a kernel of a user's program that loads some streams as they were before the pass, if it does.
fn loading_copies(replaced: &Replaced, kernel: Kernel) -> Result<Option<(String, Module, ModuleInfo)>, Mistake> {
    let copied: Vec<_> = kernel.instance().copies.iter().map(|(_, from)| *from).collect();
    if copied.is_empty() {
        return Ok(None);
    }
    let binds = kernel.instance().binds;
    let named = |stream: &Stream| {
        let own = binds.iter().find(|(_, bound)| *bound == stream.name()).map_or(stream.name(), |(own, _)| *own);
        (own.to_owned(), stream.info().texel)
    };
    let names: Vec<_> = copied.iter().map(named).collect();
    let source = from_copies(&replaced.composed.text, &names).map_err(|at| {
        let message = "this texture is read at other elements than it is written at, so it must not be given to a function: \
                       use it in textureLoad and textureStore, where its name says which stream it is";
        replaced.mistake([Span::new(at as u32, at as u32 + 1)], message.into())
    })?;
    let failed = |message: String| everywhere(&replaced.by, message);
    let module = naga::front::wgsl::parse_str(&source).map_err(|error| failed(error.emit_to_string(&source)))?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::default())
        .validate(&module)
        .map_err(|error| failed(error.emit_to_string(&source)))?;
    Ok(Some((source, module, info)))
}

fn no_entry(by: &Replacement, root: &str) -> Mistake {
    everywhere(by, format!("it has no @compute function named {root}, which is the kernel that it replaces"))
}

fn not_composed(
    by: &Replacement,
    files: &'static [UserFile],
    [root, entry]: [&str; 2],
    error: &ComposeError,
) -> Mistake {
    // What is wrong with another file of the user's.
    let other = |module: &str| {
        let file = files.iter().find(|file| file.module == module && module != root)?;
        let [kernel, file, source] = [module, file.file, file.source].map(str::to_owned);
        Some(Replacement { kernel, file, source })
    };
    let wrong = match error {
        ComposeError::Malformed { module, .. }
        | ComposeError::NoModule { module, .. }
        | ComposeError::NoItem { module, .. } => other(module).map(|by| (by, module.as_str())),
        _ => None,
    };
    if let Some((by, root)) = wrong {
        return not_composed(&by, &[], [root, entry], error);
    }
    match error {
        ComposeError::Malformed { module, line, message } if module == root => {
            let at: usize = by.source.split_inclusive('\n').take(line - 1).map(str::len).sum();
            let words = crate::compose::words(&by.source);
            let first = words.iter().find(|word| word.start >= at && word.kind != WordKind::Comment);
            Mistake { place: place_of(by, first.map_or(at, |word| word.start)), message: message.clone() }
        }
        ComposeError::NoEntry { .. } => no_entry(by, entry),
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
    let mut words = crate::compose::words(&by.source);
    words.retain(|word| word.kind != WordKind::Comment);
    let is_keyword = |text: &str| matches!(text, "fn" | "struct" | "const" | "alias" | ">" | "var" | "override");
    let at = words.windows(2).rev().find(|pair| pair[1].text == name && is_keyword(pair[0].text));
    at.map_or_else(|| found(by, name), |pair| place_of(by, pair[1].start))
}

fn not_valid(replaced: &Replaced, error: &WithSpan<ValidationError>) -> Mistake {
    let error_of = error.as_inner();
    // The last says what is wrong; those around it only where, as the place does.
    let mut last: &dyn Error = error_of;
    while let Some(inner) = last.source() {
        last = inner;
    }
    let message = match error_of {
        ValidationError::Function {
            name, source: FunctionError::InvalidReturnType { expression: None, .. }, ..
        } => {
            format!("a way through {name} ends without a return")
        }
        // Types and values have numbers in its message.
        ValidationError::Function {
            source: FunctionError::InvalidCall { error: CallError::ArgumentType { index, .. }, .. },
            ..
        } => {
            format!("argument {} has another type than the function's parameter", index + 1)
        }
        _ => last.to_string(),
    };
    // The smallest is nearest to it; others are the whole function, or what it is part of.
    let mut spans: Vec<Span> = error.spans().map(|(span, _)| *span).filter(Span::is_defined).collect();
    spans.sort_by_key(|span| span.to_range().map(|range| range.len()));
    replaced.mistake(spans, message)
}

#[cfg(test)]
mod tests;
