//! Streams as one row of texels per element.

use crate::numbers::parallel::for_chunks;
use crate::plan::Bytes;
use crate::program::kernel::Precision;
use crate::tables::elements::Size;
use crate::tables::state::{StateCounts, States};
use crate::tables::stream::Stream;
use crate::tables::texels::Layout;

use super::ELEMENTS_PER_TASK;

/// The streams of one set of elements.
#[derive(Clone, Debug)]
pub(super) struct Rows<R: Precision> {
    pub(super) layout: Layout,
    /// `None` for elements that have not been counted yet.
    pub(super) size: Option<Size>,
    pub(super) texels: Vec<R::Bits>,
}

/// The streams do not fit in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("not enough memory: the streams need {}; use a smaller image", Bytes(*bytes))]
pub struct OutOfMemory {
    /// Bytes they need.
    pub bytes: u64,
}

impl<R: Precision> Rows<R> {
    /// Allocates memory for this many elements, all unwritten.
    pub(super) fn resize(&mut self, size: Option<Size>) -> Result<(), OutOfMemory> {
        let count = size.map_or(0, |size| size.texels() as usize * self.layout.stride);
        let bytes = (count * size_of::<R::Bits>()) as u64;
        // If the allocation fails, the set is left without elements.
        (self.size, self.texels) = (None, Vec::new());
        self.texels.try_reserve_exact(count).map_err(|_| OutOfMemory { bytes })?;
        self.texels.resize(count, R::Bits::default());
        self.size = size;
        Ok(())
    }

    /// Resets every stream to its unwritten value.
    pub(super) fn clear(&mut self, streams: &[Stream]) {
        let mut row = vec![R::Bits::default(); self.layout.stride];
        for &stream in streams {
            let Some(first) = self.layout.first[stream.index()] else { continue };
            for (layer, &bits) in stream.info().unwritten.iter().enumerate() {
                row[first + layer] = from_stream_bits::<R>(stream, layer, bits);
            }
        }
        let stride = self.layout.stride.max(1);
        for_chunks(&mut self.texels, ELEMENTS_PER_TASK * stride, |_, texels| {
            texels.chunks_exact_mut(stride).for_each(|texel| texel.copy_from_slice(&row));
        });
    }
}

/// Elements in each state, of rows that have the tag at this place.
pub(super) fn count_tags<R: Precision>(texels: &[R::Bits], stride: usize, tag: usize, states: States) -> StateCounts {
    let mut counts = StateCounts::none(states);
    for row in texels.chunks_exact(stride) {
        counts.add(R::bits_to_u32(row[tag]), 1);
    }
    counts
}

pub(crate) fn from_stream_bits<R: Precision>(stream: Stream, layer: usize, bits: u32) -> R::Bits {
    if stream.is_float_layer(layer) { R::from_f32(f32::from_bits(bits)).to_bits() } else { R::bits_from_u32(bits) }
}

pub(crate) fn to_stream_bits<R: Precision>(stream: Stream, layer: usize, bits: R::Bits) -> u32 {
    if stream.is_float_layer(layer) { (R::from_bits(bits).to_f64() as f32).to_bits() } else { R::bits_to_u32(bits) }
}
