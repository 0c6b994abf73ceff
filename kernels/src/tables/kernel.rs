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
}

impl Role {
    /// Whether such a kernel runs again and again until no ray walks.
    #[must_use]
    pub const fn is_walk(self) -> bool {
        matches!(self, Self::Step | Self::Test | Self::Walk)
    }
}
