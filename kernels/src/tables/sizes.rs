//! Sizes of the buffers that the GPU executor keeps for itself: what the plan counts and the executor allocates.

use crate::tables::stream::{STREAMS, Stream};

/// Passes of one batch at most: one slot each in the GPU executor's housekeeping buffers.
pub const COUNT_SLOTS: u64 = 256;
/// Bytes between two slots: a dynamic offset's alignment on every adapter.
pub const COUNT_SLOT_BYTES: u64 = 256;
/// Texels of each constant with which the GPU executor fills streams.
pub const FILL_TEXELS: u32 = 1 << 18;
/// Lists of rays that exist at a time: for each of two kernels the one that it works on, and the next.
pub const LIVE_REGIONS: u64 = 4;

/// Texels between two rows in a buffer: a copy wants them 256 bytes apart.
pub(crate) fn pitch(width: u32) -> u32 {
    width.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT / 4)
}

/// The values that streams begin with.
pub(crate) fn fill_values() -> Vec<u32> {
    let mut values: Vec<u32> = STREAMS.iter().flat_map(|s| s.unwritten).copied().collect();
    values.sort_unstable();
    values.dedup();
    values
}

/// Rows that one copy of a constant fills.
pub(crate) fn fill_rows(width: u32, height: u32) -> u32 {
    (FILL_TEXELS / pitch(width)).clamp(1, height)
}

/// Bytes of the constants.
pub(crate) fn fill_bytes(width: u32, height: u32) -> u64 {
    4 * u64::from(pitch(width)) * u64::from(fill_rows(width, height)) * fill_values().len() as u64
}

/// Bytes of the copy of a given stream.
pub(crate) fn given_bytes(stream: Stream, width: u32, height: u32) -> u64 {
    4 * u64::from(pitch(width)) * u64::from(height) * stream.layers() as u64
}
