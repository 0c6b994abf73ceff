//! A kernel's text for the interpreter in which every line has a place in a file: the user's, or one of ours.
//!
//! What the options leave out becomes spaces, in all modules, so that lines stay where they are. A device never gets this text.

use std::sync::Arc;

use super::statements::{Start, Statements, line_starts};
use super::{ShaderError, Variant, modules};
use crate::compose::{Composed, compose_in_place};
use crate::options::features::Features;
use crate::program::live::LiveList;

/// A file that a kernel's text is from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceFile {
    /// The module that it is.
    pub module: String,
    /// What it is called: a user's file as they call it, one of ours `MODULE.wgsl`.
    pub name: String,
    /// Its text.
    pub text: String,
    /// Whether it is a user's.
    pub is_own: bool,
}

impl SourceFile {
    /// Whether a reader may mean it by this name: its own with or without folders, or without the ending.
    #[must_use]
    pub fn is_called(&self, name: &str) -> bool {
        let short = self.name.rsplit(['/', '\\']).next().unwrap_or(&self.name);
        self.name == name || short == name || short.strip_suffix(".wgsl") == Some(name) || self.module == name
    }
}

/// A line of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct FileLine {
    /// Index of the file in [`Sourced::files`].
    pub file: usize,
    /// The line, from 1.
    pub line: usize,
}

/// A kernel's text for the interpreter, and where its lines are from.
#[derive(Clone, Debug)]
pub struct Sourced {
    /// The kernel with this text.
    pub variant: Variant,
    /// The files, that of the kernel first.
    pub files: Vec<SourceFile>,
    /// Of each line of the text.
    lines: Vec<Option<FileLine>>,
    pub(super) statements: Arc<Statements>,
}

impl Sourced {
    /// The text of a variant of a plan with these options; `lists` are those of [`live::lists_of`].
    ///
    /// [`live::lists_of`]: crate::program::live::lists_of
    ///
    /// # Errors
    /// If the WGSL is invalid: the plan has found it valid.
    pub fn new(variant: &Variant, features: &Features, lists: &[LiveList]) -> Result<Self, ShaderError> {
        let kernel = variant.kernel;
        let features = &kernel.features(features);
        let own = variant.replaced.as_ref();
        let root = own.map_or(kernel.info().name, |own| own.root);
        let modules = modules(kernel, features, lists);
        let (variant, composed) = match own {
            Some(own) => {
                let variant = Variant::of_user(kernel, features, lists, &own.by, root, true);
                let variant = variant.map_err(|mistake| ShaderError::Mistake(Box::new(mistake)))?;
                let composed = variant.replaced.as_ref().map(|own| own.composed.clone()).unwrap_or_default();
                (variant, composed)
            }
            None => {
                let composed = in_place(variant, root, features, lists, &modules)
                    .map_err(|source| ShaderError::Compose { kernel: kernel.name(), source })?;
                (Variant { source: composed.text.clone(), ..variant.clone() }, composed)
            }
        };
        let users = kernel.program().files;
        let mut files = Vec::new();
        let mut lines = Vec::new();
        // What loads from copies has the same lines, in other places, and more behind them.
        for &first in &line_starts(&composed.text) {
            let Some((module, Some(byte))) = composed.origin(first) else {
                lines.push(None);
                continue;
            };
            let at = files.iter().position(|file: &SourceFile| file.module == module).unwrap_or(files.len());
            if at == files.len() {
                let user = users.iter().find(|file| file.module == module).map(|file| (file.file, file.source));
                let replaced = own.filter(|_| module == root).map(|own| (&*own.by.file, &*own.by.source));
                let (name, text) = match user.or(replaced) {
                    Some((name, text)) => (name.to_owned(), text.to_owned()),
                    None if module == root => (format!("{module}.wgsl"), kernel.info().wgsl.to_owned()),
                    None => {
                        let text = modules.iter().find(|(name, _)| *name == module).map(|(_, text)| text.as_ref());
                        (format!("{module}.wgsl"), text.unwrap_or_default().to_owned())
                    }
                };
                let is_own = user.or(replaced).is_some();
                files.push(SourceFile { module: module.to_owned(), name, text, is_own });
            }
            let text = &files[at].text;
            let line = text.as_bytes().iter().take(byte).filter(|&&b| b == b'\n').count() + 1;
            lines.push(Some(FileLine { file: at, line }));
        }
        lines.resize(line_starts(&variant.source).len(), None);
        let statements = Arc::new(Statements::of(&variant.source));
        let mut sourced = Self { variant, files, lines, statements };
        sourced.put_first(root);
        Ok(sourced)
    }

    /// Puts a module's file before the others.
    fn put_first(&mut self, root: &str) {
        let Some(at) = self.files.iter().position(|file| file.module == root) else { return };
        self.files[..=at].rotate_right(1);
        for place in self.lines.iter_mut().flatten() {
            place.file = if place.file == at { 0 } else { place.file + usize::from(place.file < at) };
        }
    }

    /// Where a line of the text is from, from 0; `None` if it is from no file.
    #[must_use]
    pub fn place(&self, line: usize) -> Option<FileLine> {
        self.lines.get(line).copied().flatten()
    }

    /// A line of the text, from 1, as `FILE:LINE`.
    #[must_use]
    pub fn named_line(&self, line: usize) -> String {
        match line.checked_sub(1).and_then(|line| self.place(line)) {
            Some(place) => format!("{}:{}", self.files[place.file].name, place.line),
            None => format!("line {line} of {}", self.variant.label()),
        }
    }

    /// The text of a file's line.
    #[must_use]
    pub fn text_of(&self, place: FileLine) -> &str {
        let file = self.files.get(place.file).map_or("", |file| &file.text);
        file.lines().nth(place.line.saturating_sub(1)).unwrap_or_default()
    }

    /// The first statement that begins in a line of a file.
    #[must_use]
    pub fn statement(&self, at: FileLine) -> Option<usize> {
        let is_there = |start: &Start| start.is_open && self.place(start.line) == Some(at);
        self.statements.starts.iter().position(is_there)
    }

    /// The lines of a file in which a statement begins, in ascending order.
    #[must_use]
    pub fn statement_lines(&self, file: usize) -> Vec<usize> {
        let open = self.statements.starts.iter().filter(|start| start.is_open);
        let mut lines: Vec<usize> =
            open.filter_map(|start| self.place(start.line)).filter(|at| at.file == file).map(|at| at.line).collect();
        lines.sort_unstable();
        lines.dedup();
        lines
    }

    /// The line of a statement; `None` if it is from no file.
    #[must_use]
    pub fn line_of_statement(&self, statement: usize) -> Option<FileLine> {
        self.place(self.statements.starts.get(statement)?.line)
    }
}

/// A kernel of ours, composed in place.
fn in_place(
    variant: &Variant,
    root: &str,
    features: &Features,
    lists: &[LiveList],
    modules: &[crate::program::Module],
) -> Result<Composed, crate::compose::ComposeError> {
    let options = features.list();
    let source = |name: &str| {
        if name == root {
            return Some(variant.kernel.info().wgsl);
        }
        modules.iter().find(|(module, _)| *module == name).map(|(_, source)| source.as_ref())
    };
    let option = |name: &str| match name {
        "live_lists" => Some(!lists.is_empty()),
        _ => options.iter().find(|(option, _)| *option == name).map(|&(_, is_on)| is_on),
    };
    let all: Vec<&'static str> = modules.iter().map(|(name, _)| *name).chain([variant.kernel.info().name]).collect();
    compose_in_place(root, root, &all, &source, &option)
}
