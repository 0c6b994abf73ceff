//! Deliberate defects of a kernel: a change of its WGSL, and a run in which the comparison with its CPU reference must
//! detect it. A comparison that cannot fail proves nothing.

use crate::options::Options;

/// A change of a kernel's WGSL that must be detected after its pass.
#[derive(Clone, Copy, Debug)]
pub struct Break {
    /// Makes the run from one that uses the grid and one step per pass.
    pub run: fn(&mut Options),
    /// Most loop iterations per dispatch, if the changed line is compiled only for walks that wait for the next
    /// dispatch.
    pub iterations: Option<u32>,
    /// A part of its WGSL, white space is ignored.
    pub from: &'static str,
    /// The replacement.
    pub to: &'static str,
    /// How it is detected.
    pub shows: Shows,
}

/// How a broken kernel is detected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shows {
    /// A stream differs, after a pass of that kernel.
    Stream,
    /// The counts of the states do not agree with the tags.
    Counts,
}

impl Break {
    /// A change that is detected in a stream.
    #[must_use]
    pub const fn new(run: fn(&mut Options), from: &'static str, to: &'static str) -> Self {
        Self { run, iterations: None, from, to, shows: Shows::Stream }
    }

    /// The same with few loop iterations per dispatch, so that walks wait between any two steps.
    #[must_use]
    pub(crate) const fn in_parts(self) -> Self {
        Self { iterations: Some(6), ..self }
    }

    /// The same, detected in the counts.
    #[must_use]
    pub(crate) const fn in_counts(self) -> Self {
        Self { shows: Shows::Counts, ..self }
    }
}

/// Leaves the run as it is.
pub fn as_it_is(_: &mut Options) {}
