//! The streams of all sets, for twins whose elements read each other.

use super::{CpuExecutor, from_stream_bits, to_stream_bits};
use crate::program::kernel::Precision;
use crate::program::schedule::Call;
use crate::tables::stream::Stream;
use crate::tables::texels::Columns;

pub(super) struct All<'a, R: Precision>(pub(super) &'a mut CpuExecutor<R>, pub(super) Call);

impl<R: Precision> Columns for All<'_, R> {
    fn stream(&self, name: &str) -> Option<Stream> {
        let kernel = self.1.kernel;
        kernel.program().stream(kernel.bound(name))
    }

    fn parameter(&self) -> u32 {
        self.1.parameter
    }

    fn len(&self, stream: Stream) -> usize {
        self.0.rows_of(stream).and_then(|(rows, _)| rows.size).map_or(0, |size| size.count as usize)
    }

    fn load(&self, stream: Stream, layer: usize, element: usize) -> u32 {
        let Some((rows, first)) = self.0.rows_of(stream) else { return 0 };
        let bits = rows.texels.get(element * rows.layout.stride + first + layer);
        bits.map_or(0, |&bits| to_stream_bits::<R>(stream, layer, bits))
    }

    fn store(&mut self, stream: Stream, layer: usize, element: usize, value: u32) {
        let Some((rows, first)) = self.0.rows_of_mut(stream) else { return };
        let at = element * rows.layout.stride + first + layer;
        if let Some(texel) = rows.texels.get_mut(at) {
            *texel = from_stream_bits::<R>(stream, layer, value);
        }
    }
}
