//! CPU reference of `measure.wgsl`.

/// The length of each cell's list; a scan turns the lengths into starts.
pub fn measure(begin: &[u32], end: &[u32], start: &mut [u32]) {
    for ((start, begin), end) in start.iter_mut().zip(begin).zip(end) {
        *start = end.wrapping_sub(*begin);
    }
}
