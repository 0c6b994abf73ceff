//! Grids, built on a device: bit for bit equal to the results of [`grid::build`], and of
//! [`irregular::build`](crate::structures::irregular::build).
//!
//! | step | kernel | over | what it does |
//! |---|---|---|---|
//! | 1 | `bound` | triangles | finds the cells of each bounding box, and its number of spans |
//! | 2 | `scan`, `add` | any set | prefix sums, in blocks of 8,192 |
//! | 3 | `span` | spans | tests up to 32 cells of a row against their triangle |
//! | 4 | `emit` | spans | writes a reference (cell, triangle) for each cell that overlaps |
//! | 5 | `histogram`, `scan`, `add`, `scatter` | references | sorts them by the cell index, digit by digit |
//! | 6 | `mark` | references | finds where the references to each cell begin and end |
//! | 7 | `measure`, `scan`, `add` | cells | finds where each list starts |
//!
//! Further passes (`irregular/`) divide the cells of a two-level or irregular grid and write its voxel map; those of an
//! irregular grid are then merged and expanded. The last passes count faults (`checks/`); a valid grid has none.
//!
//! Whether a triangle overlaps a cell is decided in f32 where that is certain, however a device contracts, flushes or
//! rounds (`filter.wgsl`), and otherwise in f64 emulated in u32 (`soft_f64.wgsl`), with the same result on every device
//! and on the host. All other decisions are made in integers.
//!
//! Spans ascend by triangle, references of a span by x, and the sort is stable: each list is ascending. No workgroup
//! waits for another, and atomics only count or set bits within one, so nothing depends on the order in which they run.
//!
//! `scan`, `add`, `histogram` and `scatter` are those of [`primitives`]. A kernel is `x.wgsl` and its CPU reference function,
//! in `x.rs` or, for several kernels, in a file of their folder.
//!
//! [`grid::build`]: crate::structures::grid::build

pub mod bound;
pub mod buffers;
mod checks;
pub mod elements;
pub mod emit;
pub mod instances;
mod irregular;
pub mod kernels;
pub mod mark;
pub mod measure;
mod passes;
pub(crate) mod plan;
mod reasons;
mod rows;
pub mod schedule;
pub mod span;
pub mod streams;

use std::borrow::Cow;

use crate::options::features::Features;
use crate::program::Program;
use crate::programs::primitives;
use crate::shared;
use crate::tables::state::States;

/// The program.
pub static PROGRAM: Program = Program {
    name: "grid_build",
    summary: "a uniform or irregular grid, counted, sorted, divided, merged and checked",
    elements: &elements::ELEMENTS,
    streams: &streams::STREAMS,
    states: States(&[]),
    courses: &[],
    rays: None,
    results: None,
    buffers: &buffers::BUFFERS,
    lists: &[],
    kernels: &instances::KERNELS,
    modules,
    files: &[],
};

/// WGSL modules that kernels import from, by name: `package::NAME`.
fn modules(_: &Features) -> Vec<(&'static str, Cow<'static, str>)> {
    let own = [
        ("soft_f64", include_str!("soft_f64.wgsl")),
        ("overlap", include_str!("overlap.wgsl")),
        ("counting", include_str!("checks/counting.wgsl")),
        ("filter", include_str!("filter.wgsl")),
        ("candidate", include_str!("irregular/candidate.wgsl")),
        ("halves", include_str!("irregular/halves.wgsl")),
        ("in_list", include_str!("irregular/in_list.wgsl")),
        ("leaf", include_str!("irregular/leaf.wgsl")),
        ("leaf_level", include_str!("irregular/leaf_level.wgsl")),
        ("map_entry", include_str!("irregular/map_entry.wgsl")),
        ("merging", include_str!("irregular/merging.wgsl")),
        ("ranks", include_str!("irregular/ranks.wgsl")),
        ("sums", include_str!("irregular/sums.wgsl")),
        ("tree", include_str!("irregular/tree.wgsl")),
        ("u64", include_str!("irregular/u64.wgsl")),
        ("voxel_map", include_str!("irregular/voxel_map.wgsl")),
    ];
    shared::MODULES
        .iter()
        .chain(primitives::MODULES)
        .chain(&own)
        .map(|&(name, source)| (name, Cow::Borrowed(source)))
        .collect()
}

#[cfg(test)]
pub(crate) mod device {
    pub(crate) mod tests;
}
#[cfg(all(test, feature = "gpu"))]
mod soft_f64 {
    mod tests;
}
#[cfg(test)]
mod tests;
