//! Why something cannot be interpreted.

use std::fmt;

/// Why a kernel, or one ray's pass through it, cannot be interpreted.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum InterpretError {
    /// The elements of the kernel read each other.
    #[error("{0} cannot be interpreted for one element: its elements read each other")]
    NotAlone(&'static str),
    /// A texel of another element is read or written.
    #[error("the texel {0},{1} of {2} belongs to another element, whose thread runs at the same time")]
    Other(u32, u32, &'static str),
    /// The source is not valid. This is a bug in raystep.
    #[error("{kernel} is not valid WGSL: {message}")]
    Invalid {
        /// The kernel.
        kernel: &'static str,
        /// naga's message.
        message: String,
    },
    /// A part of WGSL that the interpreter does not know.
    #[error("{}{what} is not supported by the interpreter", Line(*line))]
    Unsupported {
        /// What it is.
        what: String,
        /// Its line in the composed source, from 1; 0 if it has none.
        line: usize,
    },
    /// An index outside of what it indexes: what a device reads there is its own choice.
    #[error("index {index} is outside of {what}")]
    OutOfBounds {
        /// The index or offset.
        index: u64,
        /// What it indexes.
        what: String,
    },
    /// A barrier that some threads of a workgroup do not reach.
    #[error("not all threads of a workgroup wait at this barrier: {0}")]
    Barrier(Absentee),
    /// A stream that the kernel binds is not there.
    #[error("the stream {0} is not part of the run, or its elements are not counted yet")]
    Missing(&'static str),
    /// There is not enough memory.
    #[error("{0} bytes do not fit in memory")]
    Memory(u64),
    /// It did not end.
    #[error("not finished after {0} steps")]
    Steps(u64),
    /// What a user's kernel asserts does not hold.
    #[error("the assertion {0:?} does not hold")]
    Assertion(String),
    /// A thread of a user's kernel tells another state than it leaves its element in.
    #[error(
        "it tells the state {told}, but leaves the element in {state}: the tag of send or book is the one that was stored"
    )]
    Booked {
        /// The state that it tells.
        told: String,
        /// The element's.
        state: String,
    },
    /// It tells a state, but the pass does not work on its element, or it has none.
    #[error("it tells the state {0}, but the pass does not work on this element: send or book must be given NOBODY")]
    BookedNobody(String),
    /// It does not tell the state.
    #[error("it ends without send or book, and leaves the element in {0}")]
    NotBooked(String),
    /// A kernel of a user's program does what its row does not say.
    #[error("it sends the element from {from} to {to}, which the kernel's 'sends' does not list")]
    NotSent {
        /// The state before.
        from: String,
        /// The state after.
        to: String,
    },
    /// A loop of a user's kernel did not end.
    #[error("a loop has not ended after {0} turns")]
    Turns(u32),
    /// The texels given do not belong to the kernel.
    #[error("{given} components given for a kernel whose rays have {needed}")]
    Texels {
        /// Number of components that were given.
        given: usize,
        /// Number of components that are needed.
        needed: usize,
    },
}

/// A thread that does not wait where others do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Absentee {
    /// Its index in the workgroup.
    pub thread: u32,
    /// Whether it has come to its end; if not, it waits elsewhere, or in another turn of a loop.
    pub has_ended: bool,
}

impl fmt::Display for Absentee {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let how = if self.has_ended { "has returned" } else { "waits at another, or in another turn of a loop" };
        write!(f, "thread {} {how}", self.thread)
    }
}

/// A line at the beginning of a message; nothing if it is 0.
struct Line(usize);

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0 > 0 { write!(f, "line {}: ", self.0) } else { Ok(()) }
    }
}
