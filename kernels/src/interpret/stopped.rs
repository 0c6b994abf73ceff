//! What an element did at the stops of a kernel, see [`crate::shader::Stop`].

/// What an element did at a stop.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Stopped {
    /// How often it came there.
    pub reached: u32,
    /// How often the condition held.
    pub held: u32,
    /// The values of the condition's variables when it held for the first time, one after the other, see
    /// [`Interpreter::watched`](super::Interpreter::watched); if it never held, when the element came there first.
    pub values: Vec<u32>,
}

/// Most stops of a kernel.
pub(super) const MOST_STOPS: usize = 255;
