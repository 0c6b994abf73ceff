//! What breaks a kernel on purpose: a change of its WGSL, and a run in which the comparison with its CPU reference must
//! notice that. A comparison that cannot fail proves nothing.

use crate::options::Options;

/// A change of a kernel's WGSL that must be noticed after its pass.
#[derive(Clone, Copy, Debug)]
pub struct Break {
    /// Makes the run, from one through a grid with one step a pass.
    pub run: fn(&mut Options),
    /// Most loop iterations of a dispatch, where only a walk that waits for the next one compiles that line.
    pub iterations: Option<u32>,
    /// A part of its WGSL, whatever white space lies in it.
    pub from: &'static str,
    /// What takes its place.
    pub to: &'static str,
    /// How it shows.
    pub shows: Shows,
}

/// How a broken kernel shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shows {
    /// A stream differs, after a pass of that kernel.
    Stream,
    /// The counts of the states do not agree with the tags.
    Counts,
}

impl Break {
    /// A change that shows in a stream.
    #[must_use]
    pub const fn new(run: fn(&mut Options), from: &'static str, to: &'static str) -> Self {
        Self { run, iterations: None, from, to, shows: Shows::Stream }
    }

    /// The same with few loop iterations a dispatch, so that walks wait between any two steps.
    #[must_use]
    pub(crate) const fn in_parts(self) -> Self {
        Self { iterations: Some(6), ..self }
    }

    /// The same where the counts show it.
    #[must_use]
    pub(crate) const fn in_counts(self) -> Self {
        Self { shows: Shows::Counts, ..self }
    }
}

/// The run as it is.
pub fn as_it_is(_: &mut Options) {}
