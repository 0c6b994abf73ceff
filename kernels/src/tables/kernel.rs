//! Types in the rows of a program's kernels.

use super::state::Tag;

/// A transition from one state to another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Transition {
    /// State before the pass.
    pub from: Tag,
    /// The condition, in words.
    pub when: &'static str,
    /// State after the pass.
    pub to: Tag,
}

/// The role of a kernel in a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Generates rays; the first kernel of every sample.
    Source,
    /// Finds where a ray's walk begins.
    Enter,
    /// Advances a ray by one step of its walk.
    Step,
    /// Tests a ray against one item of its cell or leaf.
    Test,
    /// Advances a ray by several steps, including tests.
    Walk,
    /// Traces a ray from its start to the end of its walk.
    Whole,
    /// Computes a ray's result after its walk.
    Finish,
    /// Adds a sample's result to the previous ones; the last kernel of every sample.
    Sample,
    /// Counts the elements in each state, after a kernel that does not count them itself.
    Count,
    /// Runs once, on every element.
    Once,
}

impl Role {
    /// Every role, and its name in the files of users' programs.
    pub const NAMES: [(&'static str, Self); 10] = [
        ("source", Self::Source),
        ("enter", Self::Enter),
        ("step", Self::Step),
        ("test", Self::Test),
        ("walk", Self::Walk),
        ("whole", Self::Whole),
        ("finish", Self::Finish),
        ("sample", Self::Sample),
        ("count", Self::Count),
        ("once", Self::Once),
    ];

    /// Whether such a kernel runs repeatedly until no ray is walking.
    #[must_use]
    pub const fn is_walk(self) -> bool {
        matches!(self, Self::Step | Self::Test | Self::Walk)
    }
}

/// How a kernel without a list of rays is launched over all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Launch {
    /// In one dispatch.
    Whole,
    /// In bands of rows, each a dispatch and a submission of its own: a ray may take long, and systems reset the GPU
    /// when a dispatch takes too long. Not submitted together with other passes.
    Bands,
    /// Over elements that are stored one after the other, in one dispatch, unless it would take too long.
    List {
        /// Elements per thread.
        each: u32,
        /// About how many times as long an element takes as in a kernel that moves a few values: where the device is slow,
        /// or the elements are many, there are several dispatches, each a submission of its own.
        weight: u32,
    },
}

/// How the host learns to which states a kernel has sent its rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Counts {
    /// The kernel counts the rays that it sends to each state.
    Sent,
    /// It does not count: all rays go to this state, unless some may wait for the next dispatch; then they are
    /// recounted.
    AllTo(Tag),
    /// It does not count: the rays in each state are recounted after it.
    Anew,
    /// Its elements have no states.
    None,
}

/// A list of the rays that wait for a kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ListInfo {
    /// The name under which kernels that send rays there bind it.
    pub name: &'static str,
    /// The buffers of its slots in even and odd passes of its kernel: one is read as arguments while the other is
    /// written.
    pub slots: [&'static str; 2],
}
