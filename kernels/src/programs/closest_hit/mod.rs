//! The paper's tracer: every ray to its closest hit, and its colour from there.
//!
//! A kernel is `x.wgsl` and its twin `x.rs`, and a row of [`kernels`]; [`schedule`] says in what order they run.

pub mod accumulate;
pub mod fused;
pub mod generate;
pub mod grid_lists;
pub mod intersect;
pub mod kernels;
pub mod ray;
pub mod schedule;
pub mod setup;
pub mod shade;
pub mod tracing;
pub mod traverse_bvh;
pub mod traverse_grid;
pub mod walk;

use crate::shared::{self, constants};
use crate::tables::state;

/// Its name in labels of what it has on a GPU.
pub const NAME: &str = "closest_hit";

/// WGSL modules that kernels import from, by name: `package::NAME`. `stack` groups of siblings have room on a ray's
/// stack, and a dispatch has `turns` loop turns.
#[must_use]
pub(crate) fn modules(stack: u32, turns: u32) -> Vec<(&'static str, String)> {
    let own = [
        ("ray", include_str!("ray.wgsl")),
        ("grid_lists", include_str!("grid_lists.wgsl")),
        ("tracing", include_str!("tracing.wgsl")),
    ];
    let mut all = vec![("constants", constants::wgsl_module(stack, turns)), ("state", state::wgsl_module())];
    all.extend(shared::MODULES.iter().chain(&own).map(|&(name, source)| (name, source.to_owned())));
    all
}
