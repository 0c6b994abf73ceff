//! Composes one WGSL text from modules: a kernel and the functions it calls, with the options decided.
//!
//! A module is WGSL with two additions, both written as in WESL (<https://wesl-lang.dev>):
//!
//! - `import package::MODULE::{NAME, …};` imports declarations from another module. A name that the options leave
//!   unmentioned is not looked up, so an import needs no condition.
//! - `@if(EXPRESSION)` before a declaration, an import, a struct member or a statement keeps it only if the expression
//!   of options is true; an `@else` right after it is kept if it is false. `@else @if(EXPRESSION)` begins another
//!   branch of the same choice: the first branch whose condition is true is kept, and no other.
//!
//! The result holds the declarations that the entry point reaches, verbatim, comments included, in the order of their
//! files and under their own names: names of globals are names of streams and buffers. WESL's own crate parses all of
//! WGSL and prints it again; it took an eighth of raystep's build time, and five times as long to compose a kernel.

mod condition;
mod items;
mod options;
mod words;

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use items::Module;
pub use options::left_out;
pub(crate) use words::blanked;
pub use words::{Word, WordKind, words};

/// Why modules cannot be composed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ComposeError {
    /// An attribute, import or declaration cannot be parsed.
    #[error("{module}, line {line}: {message}")]
    Malformed {
        /// The module.
        module: String,
        /// Line, from 1; for an import or declaration of a module that is not composed in place, counted after the options
        /// have been decided.
        line: usize,
        /// What is wrong.
        message: String,
    },
    /// There is no such module.
    #[error("{module} imports from {missing:?}, which is no module")]
    NoModule {
        /// The importing module.
        module: String,
        /// The module it names.
        missing: String,
    },
    /// A module does not declare what is imported from it.
    #[error("{module} imports {name:?} from {from}, which does not declare it with these options")]
    NoItem {
        /// The importing module.
        module: String,
        /// The imported name.
        name: String,
        /// The module it is imported from.
        from: String,
    },
    /// The root does not declare its entry point.
    #[error("{module} has no function {name:?}")]
    NoEntry {
        /// The root.
        module: String,
        /// The entry point.
        name: String,
    },
    /// Two declarations have the same name.
    #[error("{name:?} is declared twice, in {first} and in {second}")]
    Twice {
        /// The name.
        name: String,
        /// One module.
        first: String,
        /// The other module, or the same one.
        second: String,
    },
}

/// Composes the function `entry` of the module `root` and everything it reaches. `source` returns a module's text by
/// name, `option` an option's value.
///
/// # Errors
/// If the modules do not fit together or cannot be parsed.
pub fn compose<'a>(
    root: &str,
    entry: &str,
    source: &dyn Fn(&str) -> Option<&'a str>,
    option: &dyn Fn(&str) -> Option<bool>,
) -> Result<String, ComposeError> {
    let linker = Linker { source, option, in_place: &[], modules: BTreeMap::new(), order: Vec::new() };
    linker.composed(root, entry).map(|composed| composed.text)
}

/// A composed text that knows where its declarations are from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Composed {
    /// Plain WGSL.
    pub text: String,
    /// Of each declaration: its bytes in the text, its module, and where it begins in the module's text.
    origins: Vec<(Range<usize>, String, usize)>,
    in_place: Vec<&'static str>,
}

impl Composed {
    /// The module that a byte of the text is from, and which byte of it, if that is composed in place.
    #[must_use]
    pub fn origin(&self, at: usize) -> Option<(&str, Option<usize>)> {
        let (range, module, first) = self.origins.iter().find(|(range, ..)| range.contains(&at))?;
        Some((module, self.in_place.contains(&module.as_str()).then_some(first + at - range.start)))
    }
}

/// As [`compose`], but in the text of some modules, what the options leave out becomes spaces: every place in it has a place
/// in the module's file.
///
/// # Errors
/// As [`compose`].
pub fn compose_in_place<'a>(
    root: &str,
    entry: &str,
    in_place: &[&'static str],
    source: &dyn Fn(&str) -> Option<&'a str>,
    option: &dyn Fn(&str) -> Option<bool>,
) -> Result<Composed, ComposeError> {
    Linker { source, option, in_place, modules: BTreeMap::new(), order: Vec::new() }.composed(root, entry)
}

struct Linker<'f, 'a> {
    source: &'f dyn Fn(&str) -> Option<&'a str>,
    option: &'f dyn Fn(&str) -> Option<bool>,
    /// The modules in which what the options leave out becomes spaces.
    in_place: &'f [&'static str],
    modules: BTreeMap<String, Module>,
    /// Loaded modules, in the order in which they were first reached.
    order: Vec<String>,
}

impl Linker<'_, '_> {
    fn composed(mut self, root: &str, entry: &str) -> Result<Composed, ComposeError> {
        if !self.load(root)? || !self.modules[root].declares(entry) {
            return Err(ComposeError::NoEntry { module: root.to_owned(), name: entry.to_owned() });
        }
        let reached = self.reached(root, entry)?;
        self.print(&reached)
    }

    /// Reads a module once; returns false if there is none of that name.
    fn load(&mut self, name: &str) -> Result<bool, ComposeError> {
        if self.modules.contains_key(name) {
            return Ok(true);
        }
        let Some(text) = (self.source)(name) else { return Ok(false) };
        let is_in_place = self.in_place.contains(&name);
        let text = options::decided(name, text, self.option, is_in_place)?;
        let module = Module::parse(name, &text)?;
        // A declaration would silently take the place of what is imported under its name.
        if let Some((name_of, from)) = module.imports.iter().find(|(imported, _)| module.declares(imported)) {
            let (first, second) = (name.to_owned(), from.clone());
            return Err(ComposeError::Twice { name: name_of.clone(), first, second });
        }
        self.modules.insert(name.to_owned(), module);
        self.order.push(name.to_owned());
        Ok(true)
    }

    /// All declarations reachable from the entry point, as (module, name).
    fn reached(&mut self, root: &str, entry: &str) -> Result<BTreeSet<(String, String)>, ComposeError> {
        let mut reached = BTreeSet::new();
        let mut waiting = vec![(root.to_owned(), entry.to_owned())];
        while let Some(place) = waiting.pop() {
            if reached.contains(&place) {
                continue;
            }
            let (module, name) = &place;
            let own = self.modules[module].items.iter().filter(|item| item.name == *name);
            let mentions: BTreeSet<String> = own.flat_map(|item| item.mentions.iter().cloned()).collect();
            for mention in mentions {
                if let Some(found) = self.resolve(module, &mention)? {
                    waiting.push(found);
                }
            }
            reached.insert(place);
        }
        Ok(reached)
    }

    /// The module and name under which a name used in `module` is declared; `None` for local names and WGSL's own.
    fn resolve(&mut self, module: &str, name: &str) -> Result<Option<(String, String)>, ComposeError> {
        let here = &self.modules[module];
        if here.declares(name) {
            return Ok(Some((module.to_owned(), name.to_owned())));
        }
        let Some(from) = here.imports.get(name).cloned() else { return Ok(None) };
        if !self.load(&from)? {
            return Err(ComposeError::NoModule { module: module.to_owned(), missing: from });
        }
        if !self.modules[&from].declares(name) {
            return Err(ComposeError::NoItem { module: module.to_owned(), name: name.to_owned(), from });
        }
        Ok(Some((from, name.to_owned())))
    }

    fn print(&self, reached: &BTreeSet<(String, String)>) -> Result<Composed, ComposeError> {
        let (mut text, mut origins) = (String::new(), Vec::new());
        let mut names: BTreeMap<&str, &str> = BTreeMap::new();
        for module in &self.order {
            let items = self.modules[module].items.iter();
            let items: Vec<_> = items.filter(|i| reached.contains(&(module.clone(), i.name.clone()))).collect();
            for item in items {
                if let Some(first) = names.insert(&item.name, module) {
                    let (first, second) = (first.to_owned(), module.clone());
                    return Err(ComposeError::Twice { name: item.name.clone(), first, second });
                }
                let has_several_lines = item.text.contains('\n');
                if has_several_lines && !text.is_empty() && !text.ends_with("\n\n") {
                    text.push('\n');
                }
                origins.push((text.len()..text.len() + item.text.len(), module.clone(), item.start));
                text.push_str(&item.text);
                text.push_str(if has_several_lines { "\n\n" } else { "\n" });
            }
        }
        text.truncate(text.trim_end().len());
        text.push('\n');
        Ok(Composed { text, origins, in_place: self.in_place.to_vec() })
    }
}

#[cfg(test)]
mod tests;
