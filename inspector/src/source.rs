//! A kernel's WGSL, line by line, with what is needed to read it: classes of words for highlighting, and for one ray
//! in one pass which lines ran.
//!
//! Which arms were taken is told by the ray's streams before and after the pass: every condition of a kernel's file is
//! named in a table ([`conditions`](raystep_kernels::programs::closest_hit::conditions)) with what it means for them. What they do not tell, a material's
//! texture or a loop's count, is marked [`Mark::Unknown`]: nothing is guessed, and nothing is run again.

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

/// What a line did for one ray in one pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mark {
    /// It does nothing: a comment, a declaration, no pass is looked at.
    #[default]
    Plain,
    /// It ran.
    Run,
    /// It did not run.
    NotRun,
    /// The ray's streams do not tell whether it ran.
    Unknown,
    /// The run's options leave it out of the kernel (`@if`).
    LeftOut,
}

/// A line of a source.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// The line, without its end.
    pub text: String,
    /// Bytes of the line and what they are; together the whole line.
    pub spans: Vec<(Range<usize>, Class)>,
    /// What it did.
    pub mark: Mark,
}

/// A kernel's own file, with the options still in it. `pass` is the ray before and after a pass of the kernel.
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

/// What the device is given: options decided, shared functions included. No line is marked.
#[must_use]
pub fn composed(variant: &Variant) -> Vec<Line> {
    lines(&variant.source)
}

/// The conditions of every `if`, `for`, `while`, `loop` and `switch` of a kernel's file, in order, spaces made one.
/// `None` where the file is not understood.
#[must_use]
pub fn conditions_in(kernel: Kernel) -> Option<Vec<String>> {
    let text = kernel.info().wgsl;
    block::functions(text, &words::words(text)).map(|file| file.conditions)
}

/// Text as lines, each cut into words.
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
            // A comment of several lines is cut at their ends.
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
