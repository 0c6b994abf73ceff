//! CPU reference of `measure.wgsl`.

/// The length of each cell's list, of which a scan makes where it starts.
pub fn measure(begin: &[u32], end: &[u32], start: &mut [u32]) {
    for ((start, begin), end) in start.iter_mut().zip(begin).zip(end) {
        *start = end.wrapping_sub(*begin);
    }
}
