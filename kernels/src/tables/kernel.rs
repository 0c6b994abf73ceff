//! What the rows of a program's kernels are made of.

use super::state::Tag;

/// One way of a ray from a state to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Transition {
    /// State before the pass.
    pub from: Tag,
    /// Condition, in words.
    pub when: &'static str,
    /// State after the pass.
    pub to: Tag,
}

/// What a kernel is for in a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Makes rays; the first kernel of every sample.
    Source,
    /// Finds where a ray's walk begins.
    Enter,
    /// Takes a ray one step of its walk on.
    Step,
    /// Tests a ray against one item of where it is.
    Test,
    /// Takes a ray several steps on, tests included.
    Walk,
    /// Takes a ray from its start to the end of its walk.
    Whole,
    /// Makes the result from where a ray's walk has ended.
    Finish,
    /// Adds a sample's result to those before it; the last kernel of every sample.
    Sample,
    /// Counts the elements in each state, after a kernel that does not count them itself.
    Count,
    /// Does its work once, on every element.
    Once,
}

impl Role {
    /// Whether such a kernel runs again and again until no ray walks.
    #[must_use]
    pub const fn is_walk(self) -> bool {
        matches!(self, Self::Step | Self::Test | Self::Walk)
    }
}

/// How a kernel that has no list of rays is launched over all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Launch {
    /// In one dispatch.
    Whole,
    /// In bands of rows, each a dispatch and a submission of its own: a ray may take long there, and systems take the
    /// GPU away from a dispatch that lasts. It is not submitted together with other passes.
    Bands,
    /// In one dispatch, over elements that lie one after the other.
    List {
        /// Elements of a thread.
        each: u32,
    },
}

/// How the host learns where a kernel has sent its rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Counts {
    /// The kernel counts the rays that it sends into each state.
    Sent,
    /// It does not count: all rays go to this state, but where some may wait for the next dispatch; then they are
    /// counted anew.
    AllTo(Tag),
    /// It does not count: the rays in each state are counted anew after it.
    Anew,
    /// Its elements have no states.
    None,
}

/// A list of the rays that wait for a kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ListInfo {
    /// What kernels that send rays there bind.
    pub name: &'static str,
    /// The buffers of its slots in even and odd passes of its kernel: one is read as arguments while the other is
    /// written.
    pub slots: [&'static str; 2],
}
