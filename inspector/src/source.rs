//! A kernel's WGSL, line by line, with highlighting: its own files with what the options leave out, or the composed
//! source. Which lines ran for a ray, [`crate::branches`] says.

mod functions;
mod marks;
mod words;

use std::ops::Range;

use raystep_kernels::Kernel;
use raystep_kernels::options::features::Features;
use raystep_kernels::shader::{FileLine, Sourced, Variant, own_source};

pub use words::Class;

/// A line's mark for one ray in one pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mark {
    /// Not executable, or no pass is selected.
    #[default]
    Plain,
    /// It ran.
    Run,
    /// It did not run.
    NotRun,
    /// The run's options omit it from the kernel (`@if`), or nothing calls it with them.
    LeftOut,
}

/// A line of a source.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// The line, without its line ending.
    pub text: String,
    /// Byte ranges of the line with their classes; together the whole line.
    pub spans: Vec<(Range<usize>, Class)>,
    /// Its mark.
    pub mark: Mark,
}

/// A kernel's own files, including their options. In a plan that has a variant of it, functions that the variant does
/// not call are left out as well.
#[must_use]
pub fn kernel_files(kernel: Kernel, variant: Option<&Variant>, features: &Features) -> Vec<Line> {
    let text = file(kernel, variant, features);
    let marks = marks::marks(kernel.info().name, &text, variant.map(|variant| variant.source.as_str()), features);
    let mut lines = lines(&text);
    for (line, mark) in lines.iter_mut().zip(marks) {
        line.mark = mark;
    }
    lines
}

/// The kernel's own files, or the user's file in their place.
fn file(kernel: Kernel, variant: Option<&Variant>, features: &Features) -> String {
    match variant.and_then(|variant| variant.replaced.as_ref()) {
        Some(replaced) => replaced.by.source.clone(),
        None => own_source(kernel, features),
    }
}

/// The composed source for the device: options resolved, shared functions included. No line is marked.
#[must_use]
pub fn composed(variant: &Variant) -> Vec<Line> {
    lines(&variant.source)
}

/// For every line of a kernel's own files, the line of the composed source that it became; `None` for lines outside of
/// functions, and for those that were left out.
#[must_use]
pub fn in_composed(variant: &Variant, features: &Features) -> Vec<Option<usize>> {
    let text = file(variant.kernel, Some(variant), features);
    let marks = marks::marks(variant.kernel.info().name, &text, Some(&variant.source), features);
    functions::in_composed(&text, &marks, &variant.source)
}

/// The line of a kernel's files that a line of its composed source is, from 0; `None` if it is in none of their functions.
#[must_use]
pub fn in_files(of: &Sourced, variant: &Variant, features: &Features, line: usize) -> Option<FileLine> {
    of.files.iter().enumerate().find_map(|(file, source)| {
        let marks = marks::marks(&source.module, &source.text, Some(&variant.source), features);
        let placed = functions::in_composed(&source.text, &marks, &variant.source);
        let at = placed.iter().position(|placed| *placed == Some(line))?;
        Some(FileLine { file, line: at + 1 })
    })
}

/// The lines of a function, from its head to its closing brace.
#[must_use]
pub fn function(lines: &[Line], name: &str) -> Option<Range<usize>> {
    let head = format!("fn {name}(");
    let first = lines.iter().position(|line| line.text.starts_with(&head))?;
    let length = lines[first..].iter().position(|line| line.text.starts_with('}'))?;
    Some(first..first + length + 1)
}

/// Splits text into lines, and each line into words.
#[must_use]
pub fn lines(text: &str) -> Vec<Line> {
    let words = words::words(text);
    let mut all = Vec::new();
    let mut start = 0;
    for line in text.split('\n') {
        let end = start + line.len();
        let first = words.partition_point(|w| w.range.end <= start);
        let mut spans: Vec<(Range<usize>, Class)> = Vec::new();
        let mut add = |from: usize, to: usize, class: Class| match spans.last_mut() {
            _ if from == to => {}
            Some((range, last)) if *last == class => range.end = to,
            _ => spans.push((from..to, class)),
        };
        let mut at = start;
        for word in words[first..].iter().take_while(|w| w.range.start < end) {
            // A comment of several lines is split at line ends.
            let (from, to) = (word.range.start.max(start), word.range.end.min(end));
            add(at - start, from - start, Class::Plain);
            add(from - start, to - start, word.class);
            at = to;
        }
        add(at - start, end - start, Class::Plain);
        all.push(Line { text: line.into(), spans, mark: Mark::Plain });
        start = end + 1;
    }
    if text.ends_with('\n') || text.is_empty() {
        all.pop();
    }
    all
}
