//! Reads and writes variables, buffers and streams.

use naga::{Expression, Handle, TypeInner};

use super::InterpretError;
use super::code::{CONSTANT, Global, Kind, Slot, kind, slots};
use super::compile::part;
use super::machine::{Frame, Machine};
use super::recording::{KNOWN, OUTSIDE};

/// What a pointer is to, and what its indices depend on.
struct Place<'a> {
    root: Root,
    inner: Inner<'a>,
    from: u32,
}

/// A type, or that of a vector's component, which is not in the module.
#[derive(Clone, Copy)]
enum Inner<'a> {
    Of(&'a TypeInner),
    Component(naga::Scalar),
}

enum Root {
    /// Slots of the stack.
    Stack(usize),
    /// Slots of private memory.
    Private(usize),
    /// Bytes of a global.
    Bytes(usize, u64),
}

impl<'a> Machine<'a> {
    /// A slot of the frame or of the constants.
    pub(super) fn at(&self, frame: &Frame<'a>, place: u32, lane: u32) -> Slot {
        let place = place + lane;
        match place & CONSTANT {
            0 => self.stack[frame.base + place as usize],
            _ => self.kernel.code.constants[(place & !CONSTANT) as usize],
        }
    }

    /// A component of an expression's value; the only one of a scalar.
    pub(super) fn get(&self, frame: &Frame<'a>, expression: Handle<Expression>, lane: u32) -> Slot {
        let cell = frame.body.cells[expression.index()];
        self.at(frame, cell.place, if cell.width == 1 { 0 } else { lane })
    }

    fn unsupported(&self, frame: &Frame<'a>, at: Handle<Expression>, what: &str) -> InterpretError {
        let span = frame.function.expressions.get_span(at).to_range();
        let line = span.map_or(0, |span| super::compile::line_of(&self.kernel.source, span.start) + 1);
        InterpretError::Unsupported { what: what.into(), line }
    }

    fn place(&mut self, frame: &Frame<'a>, pointer: Handle<Expression>) -> Result<Place<'a>, InterpretError> {
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
                    Global::Bytes(_) => Root::Bytes(global.index(), 0),
                    Global::Private(first) => Root::Private(first as usize),
                    Global::Stream(_) | Global::Other => {
                        return Err(self.unsupported(frame, pointer, "a variable of the launch"));
                    }
                };
                let inner = Inner::Of(&types[module.global_variables[global].ty].inner);
                return Ok(Place { root, inner, from: KNOWN });
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
        let Inner::Of(outer) = whole.inner else { return Err(self.unsupported(frame, pointer, "a pointer")) };
        let (inner, stride, count) = match *outer {
            TypeInner::Struct { ref members, .. } => match members.get(index as usize) {
                Some(member) => (Inner::Of(&types[member.ty].inner), 0, u64::MAX),
                None => return Err(self.unsupported(frame, pointer, "a member")),
            },
            TypeInner::Array { base, size, stride } => {
                let count = match size {
                    naga::ArraySize::Constant(count) => u64::from(count.get()),
                    _ => match whole.root {
                        Root::Bytes(global, first) => {
                            (self.bytes[global].len() as u64).saturating_sub(first) / u64::from(stride.max(1))
                        }
                        _ => u64::MAX,
                    },
                };
                (Inner::Of(&types[base].inner), stride, count)
            }
            TypeInner::Vector { size, scalar } => (Inner::Component(scalar), 4, size as u64),
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
        let root = match whole.root {
            Root::Stack(first) => Root::Stack(first + part(types, outer, index) as usize),
            Root::Private(first) => Root::Private(first + part(types, outer, index) as usize),
            Root::Bytes(global, first) => {
                let offset = match *outer {
                    TypeInner::Struct { ref members, .. } => u64::from(members[index as usize].offset),
                    _ => u64::from(index) * u64::from(stride),
                };
                Root::Bytes(global, first + offset)
            }
        };
        Ok(Place { root, inner, from })
    }

    /// Copies what a pointer is to into the slots at `to`.
    pub(super) fn load(
        &mut self,
        frame: &Frame<'a>,
        pointer: Handle<Expression>,
        to: usize,
    ) -> Result<(), InterpretError> {
        let Place { root, inner, from } = self.place(frame, pointer)?;
        let component;
        let inner = match inner {
            Inner::Of(inner) => inner,
            Inner::Component(scalar) => {
                component = TypeInner::Scalar(scalar);
                &component
            }
        };
        let count = slots(&self.kernel.module.types, inner).unwrap_or(0) as usize;
        match root {
            Root::Stack(first) => self.stack.copy_within(first..first + count, to),
            Root::Private(first) => self.stack[to..to + count].copy_from_slice(&self.private[first..first + count]),
            Root::Bytes(global, first) => {
                let mut at = to;
                self.load_bytes(global, first, inner, &mut at)?;
            }
        }
        if from != KNOWN && self.recording.is_some() {
            for at in to..to + count {
                self.stack[at].from = self.join(self.stack[at].from, from);
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
            TypeInner::Struct { ref members, .. } => members.iter().try_for_each(|member| {
                self.load_bytes(global, first + u64::from(member.offset), &types[member.ty].inner, to)
            }),
            TypeInner::Array { base, size: naga::ArraySize::Constant(count), stride } => {
                (0..count.get()).try_for_each(|i| {
                    self.load_bytes(global, first + u64::from(i) * u64::from(stride), &types[base].inner, to)
                })
            }
            _ => Err(InterpretError::Unsupported { what: "a type in a buffer".into(), line: 0 }),
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
        let range = usize::try_from(first).ok().zip(usize::try_from(first + 4 * count).ok());
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
            self.stack[*to] = Slot { bits, from: OUTSIDE, wide };
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
        let Place { root, from, .. } = self.place(frame, pointer)?;
        let width = frame.body.cells[value.index()].width;
        for lane in 0..width {
            let mut slot = self.get(frame, value, lane);
            slot.from = self.join(slot.from, from);
            match root {
                Root::Stack(first) => self.stack[first + lane as usize] = slot,
                Root::Private(first) => {
                    // Nothing says after a branch that it may have been written there.
                    slot.from = self.join(slot.from, self.control);
                    self.private[first + lane as usize] = slot;
                }
                Root::Bytes(..) => return Err(self.unsupported(frame, pointer, "a store to a buffer")),
            }
        }
        Ok(())
    }

    /// The component of the element's row that a kernel reads or writes.
    fn component(
        &self,
        frame: &Frame<'a>,
        image: Handle<Expression>,
        texel: Handle<Expression>,
        layer: Handle<Expression>,
    ) -> Result<usize, InterpretError> {
        let stream = match frame.function.expressions[image] {
            Expression::GlobalVariable(global) => match self.kernel.code.globals[global.index()] {
                Global::Stream(stream) => Some(stream),
                _ => None,
            },
            _ => None,
        };
        let stream = stream.ok_or_else(|| self.unsupported(frame, image, "a texture that is not a stream"))?;
        let at = [0, 1].map(|lane| self.get(frame, texel, lane).bits);
        if at != self.element.texel {
            return Err(InterpretError::Other(at[0], at[1], stream.name()));
        }
        let layer = self.get(frame, layer, 0).bits;
        let first = self.kernel.layout.first[stream.index()].filter(|_| (layer as usize) < stream.layers());
        let what = || format!("the {} layers of {}", stream.layers(), stream.name());
        let first = first.ok_or_else(|| InterpretError::OutOfBounds { index: layer.into(), what: what() })?;
        Ok(first + layer as usize)
    }

    pub(super) fn image_load(
        &mut self,
        frame: &Frame<'a>,
        image: Handle<Expression>,
        texel: Handle<Expression>,
        layer: Handle<Expression>,
        to: usize,
        is_float: bool,
    ) -> Result<(), InterpretError> {
        let component = self.component(frame, image, texel, layer)?;
        // A texel of one channel reads as (value, 0, 0, 1), in the texture's type.
        let one = match is_float {
            true => Slot { bits: 1f32.to_bits(), from: KNOWN, wide: 1.0 },
            false => Slot { bits: 1, ..Slot::default() },
        };
        self.stack[to] = self.row[component];
        self.stack[to + 1] = Slot::default();
        self.stack[to + 2] = Slot::default();
        self.stack[to + 3] = one;
        Ok(())
    }

    /// Returns the component that is written.
    pub(super) fn image_store(
        &mut self,
        frame: &Frame<'a>,
        image: Handle<Expression>,
        texel: Handle<Expression>,
        layer: Handle<Expression>,
        value: Handle<Expression>,
    ) -> Result<usize, InterpretError> {
        let component = self.component(frame, image, texel, layer)?;
        let mut slot = self.get(frame, value, 0);
        slot.from = self.join(slot.from, self.control);
        self.row[component] = slot;
        self.written[component] = true;
        Ok(component)
    }
}
