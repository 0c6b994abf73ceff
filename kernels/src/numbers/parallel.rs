//! The few loops that run on all cores if there are several: rayon with the feature `parallel`, the same loops in order
//! without it.

use std::ops::Range;

/// Calls `f` with consecutive ranges that cover `0..len`, at most `chunk` long each.
pub(crate) fn for_ranges(len: usize, chunk: usize, f: impl Fn(Range<usize>) + Sync) {
    let chunk = chunk.max(1);
    let range = |i: usize| i * chunk..((i + 1) * chunk).min(len);
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        (0..len.div_ceil(chunk)).into_par_iter().for_each(|i| f(range(i)));
    }
    #[cfg(not(feature = "parallel"))]
    (0..len.div_ceil(chunk)).for_each(|i| f(range(i)));
}

/// Calls `f` with consecutive chunks of `items`, `chunk` long each, and the index of their first item.
pub(crate) fn for_chunks<T: Send>(items: &mut [T], chunk: usize, f: impl Fn(usize, &mut [T]) + Sync) {
    let chunk = chunk.max(1);
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        items.par_chunks_mut(chunk).enumerate().for_each(|(i, piece)| f(i * chunk, piece));
    }
    #[cfg(not(feature = "parallel"))]
    items.chunks_mut(chunk).enumerate().for_each(|(i, piece)| f(i * chunk, piece));
}

/// Maps consecutive ranges that cover `0..len`; the results are in order.
pub fn map_ranges<T: Send>(len: usize, chunk: usize, f: impl Fn(Range<usize>) -> T + Sync) -> Vec<T> {
    let chunk = chunk.max(1);
    let range = |i: usize| i * chunk..((i + 1) * chunk).min(len);
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        (0..len.div_ceil(chunk)).into_par_iter().map(|i| f(range(i))).collect()
    }
    #[cfg(not(feature = "parallel"))]
    (0..len.div_ceil(chunk)).map(|i| f(range(i))).collect()
}
