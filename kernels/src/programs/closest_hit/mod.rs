//! The paper's tracer: every ray to its closest hit, and its colour from there.
//!
//! A kernel is `x.wgsl` and its twin `x.rs`, and a row of [`kernels`]; [`schedule`] says in what order they run.

pub mod accumulate;
pub mod arrival;
mod breaks;
pub mod buffers;
pub mod count;
pub mod elements;
pub mod explain;
pub mod fused;
pub mod generate;
pub mod grid_lists;
pub mod intersect;
pub mod kernels;
pub mod ray;
mod ray_state;
pub mod rounding;
pub mod schedule;
pub mod setup;
pub mod shade;
pub mod states;
pub mod streams;
pub mod tracing;
pub mod traverse_bvh;
pub mod traverse_grid;
pub mod traverse_irregular;
pub mod walk;

use std::borrow::Cow;

use crate::options::features::Features;
use crate::program::{Course, Home, Program, Results};
use crate::shared;
use crate::tables::stream::Component;

/// The tables that its kernels name.
pub static HOME: Home = Home { streams: &streams::STREAMS, states: states::STATES };

/// The program.
pub static PROGRAM: Program = Program {
    name: "closest_hit",
    summary: "every ray to its closest hit, and its colour from there",
    elements: &[&elements::RAYS],
    streams: &streams::STREAMS,
    states: states::STATES,
    courses: &[Course {
        stream: streams::STATE,
        inputs: &streams::INPUTS,
        unborn: states::UNWRITTEN,
        born: states::TRAV_SETUP,
        given_up: states::BACKGROUND,
        done: states::DONE,
    }],
    rays: Some(ray_state::DECODING),
    results: Some(Results {
        origin: streams::RAY_ORIGIN,
        direction: streams::RAY_DIRECTION,
        interval: streams::RAY_INTERVAL,
        t: Component { stream: streams::STATE, layer: streams::STATE_T },
        triangle: Component { stream: streams::HIT, layer: streams::HIT_TRIANGLE },
        weights: [0, 1],
        color: streams::COLOR,
        mean: streams::ACCUMULATED,
        blocks: streams::BLOCKS,
        counters: streams::COUNTERS,
    }),
    buffers: buffers::BUFFERS,
    lists: &kernels::LISTS,
    kernels: &kernels::KERNELS,
    modules,
};

/// WGSL modules that kernels import from, by name: `package::NAME`.
fn modules(_: &Features) -> Vec<(&'static str, Cow<'static, str>)> {
    let own = [
        ("ray", include_str!("ray.wgsl")),
        ("arrival", include_str!("arrival.wgsl")),
        ("grid_lists", include_str!("grid_lists.wgsl")),
        ("tracing", include_str!("tracing.wgsl")),
    ];
    shared::MODULES.iter().chain(&own).map(|&(name, source)| (name, Cow::Borrowed(source))).collect()
}
