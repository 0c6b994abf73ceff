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
