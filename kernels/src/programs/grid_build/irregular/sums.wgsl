// Sums of the values before an element: a scan leaves those of its block, and those of all blocks before.

import package::leaf::{load, load_at};
import package::saturating::{saturating_add};

// Number of values that share one of `sums`: those of a workgroup of scan.
const SUMMED: u32 = 8192u;

// The sum before element i, which is at a place in `values`.
fn sum_before(values: texture_2d_array<u32>, at: vec2u, sums: texture_2d_array<u32>, i: u32, layer: u32) -> u32 {
    return saturating_add(load(sums, i / SUMMED, layer), load_at(values, at, layer));
}
