//! What is executed: a kernel's functions with a place for every value, and its conditions.

use std::ops::Range;

use naga::{AtomicFunction, Barrier, Expression, Function, Handle, LocalVariable, Type};

use super::work::Work;
use crate::tables::stream::Stream;

/// The type of a scalar, or of a vector's components.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `f32`
    F32,
    /// `u32`
    U32,
    /// `i32`
    I32,
    /// `bool`
    Bool,
}

impl Kind {
    pub(super) fn is_float(self) -> bool {
        self == Self::F32
    }

    /// A scalar in words.
    #[must_use]
    pub fn told(self, bits: u32) -> String {
        match self {
            Self::F32 => format!("{:?}", f32::from_bits(bits)),
            Self::U32 => bits.to_string(),
            Self::I32 => bits.cast_signed().to_string(),
            Self::Bool => (bits != 0).to_string(),
        }
    }
}

/// A scalar at run time.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Slot {
    pub(super) bits: u32,
    /// The node of the recording that it depends on, see [`super::recording`].
    pub(super) from: u32,
    /// The shadow of a float; for a boolean 1 if it would be true in f64. Other integers that are a float's bits keep
    /// that float's shadow, all others have 0.
    pub(super) wide: f64,
}

/// What kind of condition it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SiteKind {
    /// An `if`.
    If,
    /// The condition of a loop, which is true while the loop goes on.
    Loop,
    /// A `select`.
    Select,
    /// A `select` component by component; it is true if any component is.
    SelectEach,
    /// A `switch`, which is true if a case other than `default` was taken.
    Switch,
    /// The left side of `&&` or `||`; true if the right side was evaluated.
    ShortCircuit,
}

/// A condition in a kernel's source.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Site {
    /// Its kind.
    pub kind: SiteKind,
    /// Bytes of the condition in the composed source.
    pub span: Range<usize>,
    /// The line of the condition's first byte, from 0.
    pub line: usize,
}

/// In the constants instead of the frame.
pub(super) const CONSTANT: u32 = 1 << 31;
/// No place, no site.
pub(super) const NONE: u32 = u32::MAX;

/// Where an expression's value is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    /// Slot in the frame, or in the constants.
    pub(super) place: u32,
    /// Number of slots.
    pub(super) width: u32,
    pub(super) kind: Kind,
    /// The site of a `select`.
    pub(super) site: u32,
    /// Rows of a matrix; 0 for other types.
    pub(super) rows: u8,
}

/// A global variable.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Global {
    /// A buffer or uniform of scene data, by its name.
    Bytes(String),
    /// A stream.
    Stream(Stream),
    /// In private memory, from this slot on.
    Private(u32),
    /// In the workgroup's memory, from this slot on; only in a whole pass.
    Workgroup(u32),
    /// The parameters of the launch; only in a whole pass.
    Launch,
    /// Of the launch or the workgroup.
    Other,
}

/// An argument of a function.
#[derive(Clone, Copy, Debug)]
pub(super) struct Argument {
    /// Its slots in the frame. A pointer and a texture have one, which tells where the variable is.
    pub(super) place: u32,
    pub(super) width: u32,
    pub(super) holds: Holds,
}

/// What is handed to a function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Holds {
    Value,
    Pointer,
    Texture,
}

/// A local variable.
#[derive(Clone, Copy, Debug)]
pub(super) struct Local {
    pub(super) place: u32,
    pub(super) width: u32,
    /// Its initial value in the constants; [`NONE`] for zeros.
    pub(super) init: u32,
}

/// A function; without statements if it is not called.
#[derive(Debug, Default)]
pub(super) struct Body {
    /// `None` for the entry point.
    pub(super) handle: Option<Handle<Function>>,
    pub(super) cells: Vec<Cell>,
    pub(super) arguments: Vec<Argument>,
    pub(super) locals: Vec<Local>,
    /// Slots of a frame.
    pub(super) frame: u32,
    pub(super) ops: Vec<Op>,
}

/// A statement, with the index of its span.
#[derive(Debug)]
pub(super) struct Op {
    pub(super) statement: u32,
    pub(super) what: What,
}

#[derive(Debug)]
pub(super) enum What {
    Emit(Vec<Handle<Expression>>),
    Block(Vec<Op>),
    If(Box<If>),
    Switch {
        site: u32,
        selector: Handle<Expression>,
        cases: Vec<Case>,
    },
    Loop {
        body: Vec<Op>,
        continuing: Vec<Op>,
        break_if: Option<(Handle<Expression>, u32)>,
    },
    Break,
    Continue,
    Return(Option<Handle<Expression>>),
    Store {
        pointer: Handle<Expression>,
        value: Handle<Expression>,
    },
    ImageStore {
        image: Handle<Expression>,
        texel: Handle<Expression>,
        layer: Handle<Expression>,
        value: Handle<Expression>,
    },
    Call {
        function: usize,
        arguments: Vec<Handle<Expression>>,
        result: Option<Handle<Expression>>,
    },
    Atomic {
        pointer: Handle<Expression>,
        fun: AtomicFunction,
        value: Handle<Expression>,
        result: Option<Handle<Expression>>,
    },
    /// Waits for the other threads of the workgroup.
    Barrier(Barrier),
    /// The same before and after a load.
    UniformLoad {
        pointer: Handle<Expression>,
        result: Handle<Expression>,
    },
    /// The element's texel.
    Texel(Handle<Expression>),
    /// Prints a value.
    Note(usize, Handle<Expression>),
    /// Asserts a condition.
    Assertion(usize, Handle<Expression>),
    /// Keeps whether a condition holds.
    Stop(Box<StopOp>),
    /// The beginning of a statement of the source.
    At(u32),
    /// Whether what follows concerns the thread now.
    Now(Handle<Expression>),
    /// Of no concern for one element.
    /// Tells the host and other passes to which state the element goes.
    Book(Handle<Expression>),
    Nothing,
    Unsupported(&'static str),
}

/// A variable of a condition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Watched {
    /// Its index among the condition's variables.
    pub index: usize,
    /// Its type: that of a vector's components.
    pub kind: Kind,
    /// Number of components.
    pub words: u32,
}

impl Watched {
    /// Its value in words.
    #[must_use]
    pub fn told(&self, values: &[u32]) -> String {
        let told: Vec<String> = values.iter().map(|&bits| self.kind.told(bits)).collect();
        told.join(" ")
    }
}

/// A stop.
#[derive(Debug)]
pub(super) struct StopOp {
    pub(super) index: usize,
    pub(super) condition: Handle<Expression>,
    /// The variables, and where their values are.
    pub(super) watched: Vec<(Watched, Handle<Expression>)>,
}

/// A value, its statements, and whether those of the next case follow.
pub(super) type Case = (Option<u32>, Vec<Op>, bool);

#[derive(Debug)]
pub(super) struct If {
    pub(super) site: u32,
    pub(super) condition: Handle<Expression>,
    pub(super) accept: Vec<Op>,
    pub(super) reject: Vec<Op>,
    /// Whether an arm may leave by a jump: then what follows depends on the condition too.
    pub(super) has_jump: bool,
    /// Slots of the frame that an arm may write: after it they depend on the condition.
    pub(super) writes: Vec<(u32, u32)>,
    /// The variable that holds the result of `&&` or `||`.
    pub(super) result: Option<Handle<LocalVariable>>,
}

/// A kernel.
#[derive(Debug, Default)]
pub(super) struct Code {
    /// The module's functions in its order, and last the entry point.
    pub(super) bodies: Vec<Body>,
    pub(super) entry: usize,
    pub(super) constants: Vec<Slot>,
    pub(super) globals: Vec<Global>,
    /// Private memory before the first statement.
    pub(super) private: Vec<Slot>,
    /// Slots of the workgroup's memory, and where each of its variables begins.
    pub(super) workgroup: u32,
    pub(super) shared: Vec<(u32, String)>,
    /// What its barriers order.
    pub(super) barriers: Barrier,
    pub(super) sites: Vec<Site>,
    /// Spans of statements.
    pub(super) statements: Vec<Range<usize>>,
    /// What each of them takes, without those inside of it and without its expressions.
    pub(super) costs: Vec<Work>,
    /// What their expressions take: the statement, the expression's first byte, and its work.
    pub(super) parts: Vec<(u32, usize, Work)>,
    /// The variables of each stop.
    pub(super) stops: Vec<Vec<Watched>>,
}

impl Code {
    /// What statements took that ran so often.
    pub(super) fn work(&self, runs: &[u64]) -> Work {
        let mut sum = Work::default();
        self.costs.iter().zip(runs).for_each(|(cost, &times)| sum.add(cost, times));
        for (statement, _, cost) in &self.parts {
            sum.add(cost, runs.get(*statement as usize).copied().unwrap_or_default());
        }
        sum
    }
}

/// Most slots of a variable, a frame or a kind of memory: beyond, it is refused. WGSL has 8 KiB in functions and private memory,
/// 16 KiB in a workgroup, and devices rarely more than 64.
pub(super) const MOST_SLOTS: u32 = 1 << 18;

/// Number of slots of a type; `None` for one without values.
pub(super) fn slots(types: &naga::UniqueArena<Type>, inner: &naga::TypeInner) -> Option<u32> {
    use naga::TypeInner as T;
    match *inner {
        T::Scalar(_) | T::Atomic(_) => Some(1),
        T::Vector { size, .. } => Some(size as u32),
        T::Matrix { columns, rows, .. } => Some(columns as u32 * rows as u32),
        T::Array { base, size: naga::ArraySize::Constant(count), .. } => {
            slots(types, &types[base].inner)?.checked_mul(count.get())
        }
        T::Struct { ref members, .. } => {
            members.iter().try_fold(0u32, |sum, m| sum.checked_add(slots(types, &types[m.ty].inner)?))
        }
        _ => None,
    }
}

/// The kind of a type's scalars; [`Kind::U32`] for a composite.
pub(super) fn kind(inner: &naga::TypeInner) -> Kind {
    match inner.scalar_kind() {
        Some(naga::ScalarKind::Float) => Kind::F32,
        Some(naga::ScalarKind::Sint) => Kind::I32,
        Some(naga::ScalarKind::Bool) => Kind::Bool,
        _ => Kind::U32,
    }
}
