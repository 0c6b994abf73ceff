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
pub mod build;
pub mod emit;
pub mod histogram;
pub mod launch;
pub mod mark;
pub mod measure;
pub mod radix;
pub mod scan;
pub mod scatter;
pub mod span;

/// Its name in labels of what it has on a GPU.
pub const NAME: &str = "grid_build";

/// Each kernel's name, which is that of its entry point, and its WGSL.
pub const KERNELS: &[(&str, &str)] = &[
    ("bound", include_str!("bound.wgsl")),
    ("scan", include_str!("scan.wgsl")),
    ("add", include_str!("add.wgsl")),
    ("span", include_str!("span.wgsl")),
    ("emit", include_str!("emit.wgsl")),
    ("histogram", include_str!("histogram.wgsl")),
    ("scatter", include_str!("scatter.wgsl")),
    ("mark", include_str!("mark.wgsl")),
    ("measure", include_str!("measure.wgsl")),
];

/// WGSL modules that kernels import from, by name: `package::NAME`.
#[must_use]
pub fn modules() -> Vec<(&'static str, String)> {
    let own = [
        ("launch", include_str!("launch.wgsl")),
        ("build", include_str!("build.wgsl")),
        ("soft_f64", include_str!("soft_f64.wgsl")),
        ("overlap", include_str!("overlap.wgsl")),
        ("saturating", include_str!("saturating.wgsl")),
        ("radix", include_str!("radix.wgsl")),
    ];
    own.iter().map(|&(name, source)| (name, source.to_owned())).collect()
}

#[cfg(test)]
mod device {
    pub(super) mod tests;
}
#[cfg(test)]
mod soft_f64 {
    mod tests;
}
#[cfg(test)]
mod tests;
