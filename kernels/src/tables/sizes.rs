//! Sizes of the GPU executor's own buffers, for the plan to count and the executor to allocate.

use crate::tables::elements::Size;
use crate::tables::stream::{Stream, StreamInfo};

/// Most passes per batch: each has a slot in the executor's buffers of counters.
pub const COUNT_SLOTS: u64 = 256;
/// Bytes between two slots: room for the counts of [`MOST_STATES`](super::state::MOST_STATES), and satisfies the alignment of dynamic offsets on every adapter.
pub const COUNT_SLOT_BYTES: u64 = 256;
/// Texels of each constant that the GPU executor fills streams with.
pub const FILL_TEXELS: u32 = 1 << 18;
/// Texels in the longest row of any texture.
const LONGEST_ROW: u64 = 1 << 15;
/// Bytes between two rows in a buffer: copies require a multiple of 256.
pub(crate) const ROW_ALIGNMENT: u32 = 256;

/// Texels between two rows in a buffer.
pub(crate) fn pitch(width: u32) -> u32 {
    width.next_multiple_of(ROW_ALIGNMENT / 4)
}

/// The initial values of a program's streams.
pub(crate) fn fill_values(streams: &[StreamInfo]) -> Vec<u32> {
    let mut values: Vec<u32> = streams.iter().flat_map(|s| s.unwritten).copied().collect();
    values.sort_unstable();
    values.dedup();
    values
}

/// Rows that one copy of a constant fills.
pub(crate) fn fill_rows(width: u32, height: u32) -> u32 {
    (FILL_TEXELS / pitch(width)).clamp(1, height)
}

/// Words of each constant, if the program's first set of elements has this size: at least a row of any other set.
pub(crate) fn fill_words(size: Size, sets: usize) -> u64 {
    let words = u64::from(pitch(size.width)) * u64::from(fill_rows(size.width, size.height));
    if sets > 1 { words.max(LONGEST_ROW) } else { words }
}

/// Bytes of the constants of a program with these streams and this many sets of elements.
pub(crate) fn fill_bytes(size: Size, sets: usize, streams: &[StreamInfo]) -> u64 {
    4 * fill_words(size, sets) * fill_values(streams).len() as u64
}

/// Bytes of the copy of an input stream.
pub(crate) fn given_bytes(stream: Stream, width: u32, height: u32) -> u64 {
    4 * u64::from(pitch(width)) * u64::from(height) * stream.layers() as u64
}
