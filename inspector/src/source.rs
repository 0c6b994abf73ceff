//! A kernel's WGSL, line by line, with highlighting, and, for one ray in one pass, which lines ran.
//!
//! The branches taken follow from the ray's streams before and after the pass: a table
//! ([`conditions`](raystep_kernels::programs::closest_hit::conditions)) states for every condition in a kernel's file
//! what it means for them. What the streams do not show, such as a material's texture or a loop's count, is marked
//! [`Mark::Unknown`]: nothing is guessed, and nothing runs again.

mod block;
mod marks;
mod words;

use std::ops::Range;

use raystep_kernels::Kernel;
use raystep_kernels::export::trace::RayState;
use raystep_kernels::options::features::Features;
use raystep_kernels::programs::closest_hit::conditions::Case;
use raystep_kernels::shader::Variant;

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
    /// The ray's streams do not show whether it ran.
    Unknown,
    /// The run's options omit it from the kernel (`@if`).
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

/// A kernel's own file, including its options. `pass` is the ray before and after a pass of the kernel.
#[must_use]
pub fn kernel_file(kernel: Kernel, features: &Features, pass: Option<(&RayState, &RayState)>) -> Vec<Line> {
    let text = kernel.info().wgsl;
    let mut lines = lines(text);
    let case = pass.map(|(before, after)| Case { features, before, after });
    let marks = marks::marks(kernel, text, features, case.as_ref());
    for (line, mark) in lines.iter_mut().zip(marks) {
        line.mark = mark;
    }
    lines
}

/// The composed source for the device: options resolved, shared functions included. No line is marked.
#[must_use]
pub fn composed(variant: &Variant) -> Vec<Line> {
    lines(&variant.source)
}

/// The conditions of every `if`, `for`, `while`, `loop` and `switch` of a kernel's file, in order, with whitespace
/// normalised. `None` if the file cannot be parsed.
#[must_use]
pub fn conditions_in(kernel: Kernel) -> Option<Vec<String>> {
    let text = kernel.info().wgsl;
    block::functions(text, &words::words(text)).map(|file| file.conditions)
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
