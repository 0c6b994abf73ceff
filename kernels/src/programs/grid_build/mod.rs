//! The uniform grid, built on a device: counted, scanned and filled, bit for bit as [`grid::build`] builds it.
//!
//! | step | kernel | over | what it does |
//! |---|---|---|---|
//! | 1 | `bound` | triangles | the cells of each one's box, and how many spans they are |
//! | 2 | `scan`, `add` | any set | prefix sums, a level of 256 at a time |
//! | 3 | `span` | spans | tests up to 32 cells of a row against their triangle |
//! | 4 | `emit` | spans | a reference (cell, triangle) for each that overlaps |
//! | 5 | `histogram`, `scan`, `add`, `scatter` | references | sorts them by a digit of the cell, as often as the cells have digits |
//! | 6 | `mark` | references | where each cell's begin and end |
//! | 7 | `measure`, `scan`, `add` | cells | where each list starts |
//!
//! No kernel computes with floats. A device may contract a product and a sum, flush subnormals, and need not have f64;
//! so what the host decides in f64 is decided in u32 here (`soft_f64.wgsl`), and comes out the same on all of them.
//!
//! Spans ascend by triangle, references of a span by x, and the sort is stable: each list is ascending. No workgroup
//! waits for another, and atomics only count or set bits within one: nothing depends on the order in which they run.
//!
//! A kernel is `x.wgsl` and its CPU reference function, in `x.rs`.
//!
//! [`grid::build`]: crate::structures::grid::build

pub mod add;
pub mod bound;
pub mod buffers;
pub mod elements;
pub mod emit;
pub mod histogram;
pub mod kernels;
pub mod mark;
pub mod measure;
mod passes;
pub mod radix;
pub mod scan;
pub mod scatter;
pub mod schedule;
pub mod span;
pub mod streams;

use std::borrow::Cow;

use crate::options::features::Features;
use crate::program::Program;
use crate::shared;
use crate::tables::state::States;

/// The program.
pub static PROGRAM: Program = Program {
    name: "grid_build",
    summary: "the uniform grid, counted, scanned and filled",
    elements: &elements::ELEMENTS,
    streams: &streams::STREAMS,
    states: States(&[]),
    course: None,
    buffers: &buffers::BUFFERS,
    lists: &[],
    kernels: &kernels::KERNELS,
    modules,
};

/// WGSL modules that kernels import from, by name: `package::NAME`.
fn modules(_: &Features) -> Vec<(&'static str, Cow<'static, str>)> {
    let own = [
        ("soft_f64", include_str!("soft_f64.wgsl")),
        ("overlap", include_str!("overlap.wgsl")),
        ("saturating", include_str!("saturating.wgsl")),
        ("radix", include_str!("radix.wgsl")),
    ];
    shared::MODULES.iter().chain(&own).map(|&(name, source)| (name, Cow::Borrowed(source))).collect()
}

#[cfg(test)]
mod device {
    pub(super) mod tests;
}
#[cfg(all(test, feature = "gpu"))]
mod soft_f64 {
    mod tests;
}
#[cfg(test)]
mod tests;
