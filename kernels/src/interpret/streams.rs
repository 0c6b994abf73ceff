//! Reads and writes streams: the texels of one element, or in a whole pass those of all.

use naga::{Expression, Handle, ImageQuery};

use super::InterpretError;
use super::code::{Global, NONE, Slot};
use super::machine::{Frame, Machine};
use super::recording::{KNOWN, OUTSIDE};
use crate::tables::stream::Stream;

impl<'a> Machine<'a> {
    /// The index of the global variable that a texture is.
    pub(super) fn texture(&self, frame: &Frame<'a>, image: Handle<Expression>) -> Option<u32> {
        match frame.function.expressions[image] {
            Expression::GlobalVariable(global) => Some(global.index() as u32),
            Expression::FunctionArgument(index) => {
                let held = frame.body.arguments.get(index as usize)?;
                Some(self.thread.stack[frame.base + held.place as usize].bits).filter(|&global| global != NONE)
            }
            _ => None,
        }
    }

    fn stream(&self, frame: &Frame<'a>, image: Handle<Expression>) -> Result<Stream, InterpretError> {
        let global = self.texture(frame, image).and_then(|global| self.kernel.code.globals.get(global as usize));
        match global {
            Some(Global::Stream(stream)) => Ok(*stream),
            _ => Err(self.unsupported(frame, image, "a texture that is not a stream")),
        }
    }

    /// What a query of a texture returns: its columns and rows, or the number of its layers or levels.
    pub(super) fn queried(
        &self,
        frame: &Frame<'a>,
        image: Handle<Expression>,
        query: ImageQuery,
    ) -> Result<[u32; 2], InterpretError> {
        match (query, &self.group) {
            (ImageQuery::Size { .. }, None) => Ok(self.element.size),
            (ImageQuery::Size { .. }, Some(group)) => Ok(group.size(self.stream(frame, image)?)),
            (ImageQuery::NumLayers, _) => Ok([self.stream(frame, image)?.layers() as u32, 0]),
            (ImageQuery::NumLevels | ImageQuery::NumSamples, _) => Ok([1, 0]),
        }
    }

    /// The component that a kernel reads or writes: of the element's row, or of all streams.
    fn component(
        &self,
        frame: &Frame<'a>,
        image: Handle<Expression>,
        [texel, layer]: [Handle<Expression>; 2],
    ) -> Result<(usize, Stream), InterpretError> {
        let stream = self.stream(frame, image)?;
        let at = [0, 1].map(|lane| self.get(frame, texel, lane).bits);
        if self.group.is_none() && at != self.element.texel {
            return Err(InterpretError::Other(at[0], at[1], stream.name()));
        }
        let layer = self.get(frame, layer, 0).bits;
        let first = self.kernel.layout.first[stream.index()].filter(|_| (layer as usize) < stream.layers());
        let what = || format!("the {} layers of {}", stream.layers(), stream.name());
        let first = first.ok_or_else(|| InterpretError::OutOfBounds { index: layer.into(), what: what() })?;
        match &self.group {
            None => Ok((first + layer as usize, stream)),
            Some(group) => Ok((group.component(stream, layer, at)?, stream)),
        }
    }

    pub(super) fn image_load(
        &mut self,
        frame: &Frame<'a>,
        image: Handle<Expression>,
        [texel, layer]: [Handle<Expression>; 2],
        level: Option<Handle<Expression>>,
        to: usize,
        is_float: bool,
    ) -> Result<(), InterpretError> {
        let (component, stream) = self.component(frame, image, [texel, layer])?;
        let level = level.map_or(0, |level| self.get(frame, level, 0).bits);
        if level > 0 && self.group.is_some() {
            return Err(InterpretError::OutOfBounds {
                index: level.into(),
                what: format!("the level of {}", stream.name()),
            });
        }
        // A texel of one channel reads as (value, 0, 0, 1), in the texture's type.
        let one = match is_float {
            true => Slot { bits: 1f32.to_bits(), from: KNOWN, wide: 1.0 },
            false => Slot { bits: 1, ..Slot::default() },
        };
        let value = match &mut self.group {
            None => self.row[component],
            Some(group) => {
                let slot = group.load(component, stream, is_float);
                // What depends on where it was read depends on that too.
                let from = self.get(frame, texel, 0).from;
                let other = self.get(frame, texel, 1).from;
                let from = self.join(from, other);
                Slot { from: self.join(slot.from, from), ..slot }
            }
        };
        self.thread.stack[to] = value;
        self.thread.stack[to + 1] = Slot::default();
        self.thread.stack[to + 2] = Slot::default();
        self.thread.stack[to + 3] = one;
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
        let (component, stream) = self.component(frame, image, [texel, layer])?;
        let mut slot = self.get(frame, value, 0);
        slot.from = self.join(slot.from, self.thread.control);
        match &mut self.group {
            None => {
                self.row[component] = slot;
                self.written[component] = true;
            }
            Some(group) => group.store(component, stream, slot, self.thread.at),
        }
        Ok(component)
    }
}

/// A value that was read from a stream.
pub(super) fn read(bits: u32, is_float: bool) -> Slot {
    Slot { bits, from: OUTSIDE, wide: if is_float { f64::from(f32::from_bits(bits)) } else { 0.0 } }
}
