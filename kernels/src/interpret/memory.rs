//! Reads and writes variables, buffers and streams.

use naga::{Expression, Handle, TypeInner};

use super::InterpretError;
use super::code::{CONSTANT, Global, Kind, Slot, kind, slots};
use super::compile::{part, pointee};
use super::machine::{Frame, Machine};
use super::recording::{KNOWN, OUTSIDE};

/// What a pointer is to, and what its indices depend on.
pub(super) struct Place<'a> {
    pub(super) root: Root,
    pub(super) inner: Inner<'a>,
    pub(super) from: u32,
}

/// A type, or that of a part of a vector or matrix, which need not be in the module.
#[derive(Clone)]
pub(super) enum Inner<'a> {
    Of(&'a TypeInner),
    Part(TypeInner),
}

impl Inner<'_> {
    pub(super) fn get(&self) -> &TypeInner {
        match self {
            Self::Of(inner) => inner,
            Self::Part(inner) => inner,
        }
    }
}

#[derive(Clone, Copy)]
pub(super) enum Root {
    /// Slots of the stack.
    Stack(usize),
    /// Slots of private memory.
    Private(usize),
    /// Slots of the workgroup's memory.
    Workgroup(usize),
    /// Bytes of a global.
    Bytes(usize, u64),
}

impl Root {
    /// As the slot of a function's argument.
    fn hold(self, from: u32) -> Slot {
        let (wide, first) = match self {
            Self::Stack(first) => (0.0, first),
            Self::Private(first) => (1.0, first),
            Self::Workgroup(first) => (2.0, first),
            Self::Bytes(global, first) => (3.0 + global as f64, usize::try_from(first).unwrap_or(usize::MAX)),
        };
        Slot { bits: u32::try_from(first).unwrap_or(u32::MAX), from, wide }
    }

    fn held(slot: Slot) -> Self {
        let first = slot.bits as usize;
        match slot.wide as usize {
            0 => Self::Stack(first),
            1 => Self::Private(first),
            2 => Self::Workgroup(first),
            global => Self::Bytes(global - 3, slot.bits.into()),
        }
    }
}

/// Bytes from a column of a matrix in a buffer to the next.
fn column_stride(rows: naga::VectorSize, scalar: naga::Scalar) -> u32 {
    let rows = if rows == naga::VectorSize::Bi { 2 } else { 4 };
    rows * u32::from(scalar.width)
}

impl<'a> Machine<'a> {
    /// A slot of the frame or of the constants.
    pub(super) fn at(&self, frame: &Frame<'a>, place: u32, lane: u32) -> Slot {
        let place = place + lane;
        match place & CONSTANT {
            0 => self.thread.stack[frame.base + place as usize],
            _ => self.kernel.code.constants[(place & !CONSTANT) as usize],
        }
    }

    /// A component of an expression's value; the only one of a scalar.
    pub(super) fn get(&self, frame: &Frame<'a>, expression: Handle<Expression>, lane: u32) -> Slot {
        let cell = frame.body.cells[expression.index()];
        self.at(frame, cell.place, if cell.width == 1 { 0 } else { lane })
    }

    pub(super) fn unsupported(&self, frame: &Frame<'a>, at: Handle<Expression>, what: &str) -> InterpretError {
        let span = frame.function.expressions.get_span(at).to_range();
        let line = span.map_or(0, |span| super::compile::line_of(&self.kernel.source, span.start) + 1);
        InterpretError::Unsupported { what: what.into(), line }
    }

    pub(super) fn place(
        &mut self,
        frame: &Frame<'a>,
        pointer: Handle<Expression>,
    ) -> Result<Place<'a>, InterpretError> {
        let module = &self.kernel.module;
        let types = &module.types;
        let (base, index, from) = match frame.function.expressions[pointer] {
            Expression::LocalVariable(local) => {
                let first = frame.base + frame.body.locals[local.index()].place as usize;
                let inner = Inner::Of(&types[frame.function.local_variables[local].ty].inner);
                return Ok(Place { root: Root::Stack(first), inner, from: KNOWN });
            }
            Expression::GlobalVariable(global) => {
                let root = match self.kernel.code.globals[global.index()] {
                    Global::Bytes(_) | Global::Launch => Root::Bytes(global.index(), 0),
                    Global::Private(first) => Root::Private(first as usize),
                    Global::Workgroup(first) => Root::Workgroup(first as usize),
                    Global::Stream(_) | Global::Other => {
                        return Err(self.unsupported(frame, pointer, "a variable of the launch"));
                    }
                };
                let inner = Inner::Of(&types[module.global_variables[global].ty].inner);
                return Ok(Place { root, inner, from: KNOWN });
            }
            Expression::FunctionArgument(index) => {
                let argument = frame.function.arguments.get(index as usize);
                let inner = argument.and_then(|argument| match types[argument.ty].inner {
                    TypeInner::Pointer { base, .. } => Some(Inner::Of(&types[base].inner)),
                    ref other => pointee(types, other).map(Inner::Part),
                });
                let held = frame.body.arguments.get(index as usize);
                let (Some(inner), Some(held)) = (inner, held) else {
                    return Err(self.unsupported(frame, pointer, "a pointer"));
                };
                let slot = self.thread.stack[frame.base + held.place as usize];
                return Ok(Place { root: Root::held(slot), inner, from: slot.from });
            }
            Expression::AccessIndex { base, index } => (base, index, KNOWN),
            Expression::Access { base, index } => {
                let index = self.get(frame, index, 0);
                (base, index.bits, index.from)
            }
            _ => return Err(self.unsupported(frame, pointer, "a pointer")),
        };
        let whole = self.place(frame, base)?;
        let from = self.join(whole.from, from);
        let part_of = |inner: TypeInner| Inner::Part(inner);
        let of = |ty: Handle<naga::Type>| Inner::Of(&types[ty].inner);
        let outer = whole.inner.get();
        let (inner, stride, count) = match *outer {
            TypeInner::Struct { ref members, .. } => match members.get(index as usize) {
                Some(member) => (of(member.ty), member.offset, u64::MAX),
                None => return Err(self.unsupported(frame, pointer, "a member")),
            },
            TypeInner::Array { base, size, stride } => {
                let count = match size {
                    naga::ArraySize::Constant(count) => u64::from(count.get()),
                    _ => match whole.root {
                        Root::Bytes(global, first) => {
                            (self.bytes[global].len() as u64).saturating_sub(first) / u64::from(stride.max(1))
                        }
                        _ => return Err(self.unsupported(frame, pointer, "an array of this size")),
                    },
                };
                (of(base), stride, count)
            }
            TypeInner::Matrix { columns, rows, scalar } => {
                (part_of(TypeInner::Vector { size: rows, scalar }), column_stride(rows, scalar), columns as u64)
            }
            TypeInner::Vector { size, scalar } => (part_of(TypeInner::Scalar(scalar)), 4, size as u64),
            _ => return Err(self.unsupported(frame, pointer, "a pointer")),
        };
        if u64::from(index) >= count {
            let name = match whole.root {
                Root::Bytes(global, _) => match &self.kernel.code.globals[global] {
                    Global::Bytes(name) => name.as_str(),
                    _ => "an array",
                },
                _ => "an array",
            };
            let what = format!("{name}, which has {count} elements");
            return Err(InterpretError::OutOfBounds { index: index.into(), what });
        }
        let slot = |first: usize| first + part(types, outer, index) as usize;
        let root = match whole.root {
            Root::Stack(first) => Root::Stack(slot(first)),
            Root::Private(first) => Root::Private(slot(first)),
            Root::Workgroup(first) => Root::Workgroup(slot(first)),
            Root::Bytes(global, first) => {
                let offset = match *outer {
                    TypeInner::Struct { .. } => u64::from(stride),
                    _ => u64::from(index) * u64::from(stride),
                };
                Root::Bytes(global, first + offset)
            }
        };
        Ok(Place { root, inner, from })
    }

    /// A pointer as the slot of a function's argument.
    pub(super) fn pointer(&mut self, frame: &Frame<'a>, pointer: Handle<Expression>) -> Result<Slot, InterpretError> {
        let Place { root, from, .. } = self.place(frame, pointer)?;
        Ok(root.hold(from))
    }

    /// The number of elements of an array that is as long as its buffer.
    pub(super) fn length(&mut self, frame: &Frame<'a>, array: Handle<Expression>) -> Result<u32, InterpretError> {
        let Place { root, inner, .. } = self.place(frame, array)?;
        match (root, inner.get()) {
            (Root::Bytes(global, first), TypeInner::Array { stride, .. }) => {
                let bytes = (self.bytes[global].len() as u64).saturating_sub(first);
                Ok(u32::try_from(bytes / u64::from(*stride).max(1)).unwrap_or(u32::MAX))
            }
            _ => Err(self.unsupported(frame, array, "the length of this array")),
        }
    }

    /// Copies what a pointer is to into the slots at `to`.
    pub(super) fn load(
        &mut self,
        frame: &Frame<'a>,
        pointer: Handle<Expression>,
        to: usize,
    ) -> Result<(), InterpretError> {
        let Place { root, inner, from } = self.place(frame, pointer)?;
        let inner = inner.get();
        let count = slots(&self.kernel.module.types, inner).unwrap_or(0) as usize;
        match root {
            Root::Stack(first) => self.thread.stack.copy_within(first..first + count, to),
            Root::Private(first) => {
                self.thread.stack[to..to + count].copy_from_slice(&self.thread.private[first..first + count])
            }
            Root::Workgroup(first) => {
                let is_atomic = matches!(inner, TypeInner::Atomic(_));
                for i in 0..count {
                    self.thread.stack[to + i] = self.load_shared(first + i, is_atomic);
                }
            }
            Root::Bytes(global, first) => {
                let mut at = to;
                self.load_bytes(global, first, inner, &mut at)?;
            }
        }
        if from != KNOWN && self.thread.recording.is_some() {
            for at in to..to + count {
                self.thread.stack[at].from = self.join(self.thread.stack[at].from, from);
            }
        }
        Ok(())
    }

    fn load_bytes(
        &mut self,
        global: usize,
        first: u64,
        inner: &TypeInner,
        to: &mut usize,
    ) -> Result<(), InterpretError> {
        let types = &self.kernel.module.types;
        match *inner {
            TypeInner::Scalar(_) => self.load_words(global, first, 1, kind(inner), to),
            TypeInner::Vector { size, .. } => self.load_words(global, first, size as u64, kind(inner), to),
            TypeInner::Matrix { columns, rows, scalar } => (0..columns as u64).try_for_each(|column| {
                let first = first + column * u64::from(column_stride(rows, scalar));
                self.load_words(global, first, rows as u64, kind(inner), to)
            }),
            TypeInner::Struct { ref members, .. } => members.iter().try_for_each(|member| {
                self.load_bytes(global, first + u64::from(member.offset), &types[member.ty].inner, to)
            }),
            TypeInner::Array { base, size: naga::ArraySize::Constant(count), stride } => {
                (0..count.get()).try_for_each(|i| {
                    self.load_bytes(global, first + u64::from(i) * u64::from(stride), &types[base].inner, to)
                })
            }
            _ => Err(InterpretError::Unsupported { what: "a type in a buffer".into(), line: self.line() }),
        }
    }

    fn load_words(
        &mut self,
        global: usize,
        first: u64,
        count: u64,
        kind: Kind,
        to: &mut usize,
    ) -> Result<(), InterpretError> {
        let bytes = self.bytes[global];
        let range = usize::try_from(first).ok().zip(usize::try_from(first.saturating_add(4 * count)).ok());
        let words = range.and_then(|(first, end)| bytes.get(first..end)).ok_or_else(|| {
            let name = match &self.kernel.code.globals[global] {
                Global::Bytes(name) => name.as_str(),
                _ => "a buffer",
            };
            InterpretError::OutOfBounds { index: first, what: format!("the {} bytes of {name}", bytes.len()) }
        })?;
        for word in words.chunks_exact(4) {
            let bits = u32::from_ne_bytes(word.try_into().unwrap_or_default());
            let wide = if kind.is_float() { f64::from(f32::from_bits(bits)) } else { 0.0 };
            self.thread.stack[*to] = Slot { bits, from: OUTSIDE, wide };
            *to += 1;
        }
        Ok(())
    }

    pub(super) fn store(
        &mut self,
        frame: &Frame<'a>,
        pointer: Handle<Expression>,
        value: Handle<Expression>,
    ) -> Result<(), InterpretError> {
        let Place { root, inner, from } = self.place(frame, pointer)?;
        let is_atomic = matches!(inner.get(), TypeInner::Atomic(_));
        let width = frame.body.cells[value.index()].width;
        for lane in 0..width {
            let mut slot = self.get(frame, value, lane);
            slot.from = self.join(slot.from, from);
            match root {
                Root::Stack(first) => {
                    // Nothing says after a branch that it may have been written in a function that was called.
                    if first < frame.base {
                        slot.from = self.join(slot.from, self.thread.control);
                    }
                    self.thread.stack[first + lane as usize] = slot;
                }
                Root::Private(first) => {
                    // Nor there.
                    slot.from = self.join(slot.from, self.thread.control);
                    self.thread.private[first + lane as usize] = slot;
                }
                Root::Workgroup(first) => {
                    slot.from = self.join(slot.from, self.thread.control);
                    self.store_shared(first + lane as usize, slot, is_atomic);
                }
                Root::Bytes(..) => return Err(self.unsupported(frame, pointer, "a store to a buffer")),
            }
        }
        Ok(())
    }
}
