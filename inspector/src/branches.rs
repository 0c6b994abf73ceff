//! What a ray did in a kernel, line by line: which lines ran, how conditions came out, and the values that they compared,
//! from the [interpreter](raystep_kernels::interpret)'s recording.

use raystep_kernels::interpret::{Interpreter, Recording};
use raystep_lab::branch::branch;
pub use raystep_lab::branch::{Branch, Note};

use crate::source::Mark;

/// What a ray did in a pass.
#[derive(Clone, Debug, PartialEq)]
pub struct Branches {
    /// For every line of the composed source.
    pub marks: Vec<Mark>,
    /// In the order in which the ray reached them first; each once.
    pub reached: Vec<Branch>,
    /// Which of them is the deciding one.
    pub deciding: Option<usize>,
}

impl Branches {
    /// Reads a recording.
    #[must_use]
    pub fn new(kernel: &Interpreter, recording: &Recording) -> Self {
        let mut reached: Vec<Branch> = Vec::new();
        for decision in &recording.decisions {
            let site = decision.site;
            let is_known = reached.iter().any(|branch| branch.site == site);
            if !is_known && let Some(branch) = branch(kernel, recording, site) {
                reached.push(branch);
            }
        }
        let deciding = recording.deciding.and_then(|index| recording.decisions.get(index)).map(|d| d.site);
        let deciding = deciding.and_then(|site| reached.iter().position(|branch| branch.site == site));
        Self { marks: marks(kernel, recording), reached, deciding }
    }
}

/// A line ran if any of its statements did.
fn marks(kernel: &Interpreter, recording: &Recording) -> Vec<Mark> {
    let source = kernel.source();
    let starts: Vec<usize> = std::iter::once(0).chain(source.match_indices('\n').map(|(at, _)| at + 1)).collect();
    let line = |byte: usize| starts.partition_point(|&start| start <= byte).saturating_sub(1);
    let mut marks = vec![Mark::Plain; starts.len()];
    for (span, &has_run) in kernel.statements().iter().zip(&recording.ran) {
        if span.is_empty() {
            continue;
        }
        for mark in marks.iter_mut().take(line(span.end - 1) + 1).skip(line(span.start)) {
            *mark = if has_run || *mark == Mark::Run { Mark::Run } else { Mark::NotRun };
        }
    }
    marks
}
