//! Where the statements of a text begin, and which names each of them can use: from its words alone.

use std::ops::Range;

use crate::compose::{Word, WordKind, words};

/// Where a statement begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Start {
    /// The byte.
    pub(crate) at: usize,
    /// Its line, from 0.
    pub(crate) line: usize,
    /// Whether another statement can be put before it: not before `else` and `case`.
    pub(crate) is_open: bool,
}

/// A name that a function declares.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Declared {
    pub(crate) name: String,
    /// The byte at which the name stands.
    pub(crate) at: usize,
    /// Where it can be used.
    pub(crate) scope: Range<usize>,
    pub(crate) by: By,
}

/// What declares a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum By {
    /// The head of the function.
    Argument,
    /// `let` or `const`.
    Value,
    /// `var`.
    Variable,
}

/// A text's statements and names.
#[derive(Clone, Debug, Default)]
pub(crate) struct Statements {
    /// In the order of the text.
    pub(crate) starts: Vec<Start>,
    declared: Vec<Declared>,
}

/// What a brace opens.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Brace {
    Block,
    Switch,
    Members,
}

/// A block that has begun.
struct Open {
    brace: Brace,
    /// The first declaration in it.
    first: usize,
}

impl Statements {
    pub(crate) fn of(text: &str) -> Self {
        let mut all = words(text);
        all.retain(|word| word.kind != WordKind::Comment);
        let ends = line_starts(text);
        let line = |at: usize| ends.partition_point(|&first| first <= at) - 1;
        let mut found = Self::default();
        let mut open: Vec<Open> = Vec::new();
        let (mut depth, mut next, mut is_function) = (0usize, Brace::Block, false);
        // Declared between the parentheses of a function or of `for`: for the block that follows.
        let mut ahead = 0;
        let mut before = ";";
        for (index, word) in all.iter().enumerate() {
            let is_in_block = open.last().is_some_and(|open| open.brace != Brace::Members);
            if depth == 0 && is_in_block && matches!(before, "{" | "}" | ";") && !matches!(word.text, "}" | ";") {
                let is_open = !matches!(word.text, "else" | "case" | "default" | "continuing");
                found.starts.push(Start { at: word.start, line: line(word.start), is_open });
                ahead = found.declared.len();
            }
            match word.text {
                "fn" if open.is_empty() => (is_function, ahead) = (true, found.declared.len()),
                "struct" => next = Brace::Members,
                "switch" => next = Brace::Switch,
                "(" | "[" => depth += 1,
                ")" | "]" => depth = depth.saturating_sub(1),
                "{" => open.push(Open { brace: std::mem::replace(&mut next, Brace::Block), first: ahead }),
                "}" => {
                    if let Some(closed) = open.pop() {
                        let inside = found.declared.iter_mut().skip(closed.first);
                        inside.filter(|d| d.scope.end == usize::MAX).for_each(|d| d.scope.end = word.start);
                    }
                    ahead = found.declared.len();
                    is_function &= !open.is_empty();
                }
                _ => {}
            }
            if is_function
                && word.kind == WordKind::Name
                && let Some(by) = declares(&all, index, open.is_empty())
            {
                let scope = word.end()..usize::MAX;
                found.declared.push(Declared { name: word.text.to_owned(), at: word.start, scope, by });
            }
            before = word.text;
        }
        found
    }

    /// The names that can be used at a byte, the last declared first, each once.
    pub(crate) fn names(&self, at: usize) -> Vec<&Declared> {
        let mut names: Vec<&Declared> = Vec::new();
        // What a statement declares can be used behind it.
        let begin = self.starts.partition_point(|start| start.at <= at).checked_sub(1);
        let begin = begin.map_or(0, |index| self.starts[index].at);
        for declared in self.declared.iter().rev() {
            let is_before = declared.at < begin || declared.by == By::Argument;
            let is_there = is_before && declared.scope.contains(&at);
            if is_there && !names.iter().any(|other| other.name == declared.name) {
                names.push(declared);
            }
        }
        names
    }
}

/// What declares a name here, if it is declared.
fn declares(all: &[Word<'_>], index: usize, is_head: bool) -> Option<By> {
    let before = |back: usize| index.checked_sub(back).and_then(|at| all.get(at)).map_or("", |word| word.text);
    match before(1) {
        "let" | "const" => Some(By::Value),
        "var" => Some(By::Variable),
        // `var<function> x`
        ">" if before(2) == "function" => Some(By::Variable),
        _ if is_head && all.get(index + 1).is_some_and(|after| after.text == ":") => Some(By::Argument),
        _ => None,
    }
}

/// The first byte of each line.
pub(crate) fn line_starts(text: &str) -> Vec<usize> {
    std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect()
}

#[cfg(test)]
mod tests;
