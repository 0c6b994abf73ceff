//! Kernels that any program may take: prefix sums, a radix sort of pairs of keys and values, and compaction.
//!
//! | kernel | over | binds | what it does |
//! |---|---|---|---|
//! | `scan` | elements, or their blocks | `values`, `sums` | replaces the values in each block of 8,192 by the sums of those before them |
//! | `add` | elements | `values`, `sums` | adds the sums of all blocks before |
//! | `histogram` | elements | `key_in`, `tally` | counts a digit of the keys in each block of 256 |
//! | `scatter` | elements | `key_in`, `value_in`, `tally`, `key_out`, `value_out` | moves pairs to their places by this digit |
//! | `compact` | elements | `place`, `total`, `value_in`, `value_out` | moves the values that are kept side by side |
//!
//! Prefix sums of a set take three passes: `scan` over it, `scan` over its blocks, whose sums are one element, and `add`. A
//! pass of the sort is `histogram`, the prefix sums of the tallies, and `scatter`, with the digit as parameter: keys have one
//! layer, values any number. `compact` follows the prefix sums of ones and zeros. A program has a set for what it sorts, and
//! sets made by [`blocks`] and [`tallies`]; its instances bind its own streams to the names above. docs/adding-a-program.md
//! shows how.
//!
//! Sums saturate at `u32::MAX`, so that a program sees when there is too much of something. A set has at most 2²⁶ elements,
//! [`MOST_ELEMENTS`](crate::shared::launch::MOST_ELEMENTS): plans refuse more.

pub mod add;
pub mod compact;
pub mod histogram;
pub mod radix;
pub mod scan;
pub mod scatter;

use crate::options::reasons::{Because, Reason, Run};
use crate::program::KernelInfo;
use crate::program::breaks::{Break, as_it_is};
use crate::shared::launch::BLOCK;
use crate::tables::elements::{Count, Elements};
use crate::tables::kernel::Launch;
use crate::tables::stream::Stream;
use crate::tables::texels::Columns;

/// WGSL that the kernels import, by name: part of the modules of a program that has one of them.
pub const MODULES: &[(&str, &str)] =
    &[("radix", include_str!("radix.wgsl")), ("saturating", include_str!("saturating.wgsl"))];

/// The set of blocks in which [`SCAN`] sums the elements of another.
#[must_use]
pub const fn blocks(name: &'static str, of: &'static str) -> Elements {
    Elements { name, count: Count::Per { of, per: scan::SCAN_BLOCK as u32, each: 1 } }
}

/// The set of tallies of [`HISTOGRAM`]: how often each digit occurs in each block of another set.
#[must_use]
pub const fn tallies(name: &'static str, of: &'static str) -> Elements {
    Elements { name, count: Count::Per { of, per: BLOCK as u32, each: radix::DIGITS as u32 } }
}

fn every(_: &Run<'_>) -> Reason {
    (Because::Options, "needed only to sum, sort or compact")
}

/// Sums the values before each one, in blocks.
pub const SCAN: KernelInfo = KernelInfo {
    launch: Launch::List { each: scan::EACH, weight: 1 },
    ..KernelInfo::once(
        ("scan", include_str!("scan.wgsl")),
        scan::pass,
        [66, 124, 200],
        "sums the values before each one, in blocks",
        every,
        &[Break::new(as_it_is, "from_side][lane - 1u]", "from_side][lane]")],
    )
};

/// Adds the sums of all blocks before an element's own.
pub const ADD: KernelInfo = KernelInfo::once(
    ("add", include_str!("add.wgsl")),
    add::pass,
    [66, 124, 200],
    "adds the sum of all blocks before its own",
    every,
    &[Break::new(as_it_is, "saturating_add(before,", "saturating_add(0u,")],
);

/// Counts a digit of the keys in each block.
pub const HISTOGRAM: KernelInfo = KernelInfo::once(
    ("histogram", include_str!("histogram.wgsl")),
    histogram::pass,
    [150, 120, 190],
    "counts a digit of the keys in each block",
    every,
    &[Break::new(as_it_is, "counts[digit_of(key)], 1u", "counts[digit_of(key)], 2u")],
);

/// Moves each pair of key and value to its place by a digit.
pub const SCATTER: KernelInfo = KernelInfo::once(
    ("scatter", include_str!("scatter.wgsl")),
    scatter::pass,
    [200, 80, 140],
    "moves each key and its value to their place by a digit",
    every,
    &[Break::new(as_it_is, "(bit - 1u)", "(bit | (bit - 1u))")],
);

/// Moves the values that are kept side by side.
pub const COMPACT: KernelInfo = KernelInfo::once(
    ("compact", include_str!("compact.wgsl")),
    compact::pass,
    [90, 165, 90],
    "moves the values that are kept side by side",
    every,
    &[Break::new(as_it_is, "if (next != to)", "if (next == to)")],
);

/// Number of layers of the stream that is bound to a name.
pub(crate) fn layers(columns: &dyn Columns, name: &str) -> usize {
    columns.stream(name).map_or(0, Stream::layers)
}

/// All values of a layer.
pub(crate) fn load(columns: &dyn Columns, name: &str, layer: usize) -> Vec<u32> {
    let Some(stream) = columns.stream(name) else { return Vec::new() };
    (0..columns.len(stream)).map(|element| columns.load(stream, layer, element)).collect()
}

/// Replaces the values of a layer, from the first element on.
pub(crate) fn store(columns: &mut dyn Columns, name: &str, layer: usize, values: impl IntoIterator<Item = u32>) {
    let Some(stream) = columns.stream(name) else { return };
    for (element, value) in values.into_iter().enumerate() {
        columns.store(stream, layer, element, value);
    }
}

#[cfg(test)]
pub(crate) mod tests;
