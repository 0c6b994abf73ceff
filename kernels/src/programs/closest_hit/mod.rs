//! The paper's tracer: every ray to its closest hit, and its colour from there.
//!
//! A kernel is `x.wgsl` and its twin `x.rs`, and a row of [`kernels`]; [`schedule`] says in what order they run. What
//! differs between the structures that a scene can be traced through is in the folder `x`, a file for each of them.

pub mod accumulate;
pub mod arrival;
mod bounds;
pub(in crate::programs) mod breaks;
pub mod buffers;
pub mod count;
pub mod decide;
pub mod elements;
pub mod explain;
pub mod fused;
pub mod generate;
pub mod grid_lists;
pub mod intersect;
pub mod kernels;
mod later;
mod ordered;
pub(crate) mod plan;
pub mod ray;
pub(in crate::programs) mod ray_state;
pub mod rounding;
pub mod schedule;
pub mod setup;
pub mod shade;
pub mod states;
pub mod streams;
mod tested;
pub mod tracing;
pub mod traverse_bvh;
pub mod traverse_grid;
pub mod traverse_irregular;
pub mod walk;

use std::borrow::Cow;

use crate::options::features::{Features, StructureKind};
use crate::program::{Course, Home, Program, Results};
use crate::shared;
use crate::tables::stream::Component;

/// The tables that its kernels name.
pub static HOME: Home = Home { streams: &streams::STREAMS, states: states::STATES };

/// The course of a ray.
pub(in crate::programs) const COURSE: Course = Course {
    stream: streams::STATE,
    inputs: &streams::INPUTS,
    unborn: states::UNWRITTEN,
    born: states::TRAV_SETUP,
    given_up: |_| states::BACKGROUND,
    done: states::DONE,
};

/// Where the results of rays are.
pub(in crate::programs) const RESULTS: Results = Results {
    origin: streams::RAY_ORIGIN,
    direction: streams::RAY_DIRECTION,
    interval: streams::RAY_INTERVAL,
    last: streams::SURFACE,
    t: Component { stream: streams::STATE, layer: streams::STATE_T },
    triangle: Component { stream: streams::HIT, layer: streams::HIT_TRIANGLE },
    weights: [0, 1],
    color: streams::COLOR,
    mean: streams::ACCUMULATED,
    blocks: streams::BLOCKS,
    counters: streams::COUNTERS,
    albedo: shade::surface::albedo,
    hit_of: [fused::hit_of::<f32>, fused::hit_of::<f64>],
};

/// The program.
pub static PROGRAM: Program = Program {
    name: "closest_hit",
    summary: "every ray to its closest hit, and its colour from there",
    elements: &[&elements::RAYS],
    streams: streams::OWN,
    states: states::STATES,
    courses: &[Course { inputs: &streams::INPUTS_OF_ALL, ..COURSE }],
    rays: Some(ray_state::DECODING),
    results: Some(RESULTS),
    buffers: buffers::BUFFERS,
    lists: &kernels::LISTS,
    kernels: &kernels::KERNELS,
    modules,
    files: &[],
};

/// WGSL modules that kernels import from, by name: `package::NAME`.
fn modules(features: &Features) -> Vec<(&'static str, Cow<'static, str>)> {
    let own = [
        ("ray", include_str!("ray.wgsl")),
        ("per_axis", include_str!("per_axis.wgsl")),
        ("arrival", include_str!("arrival.wgsl")),
        ("bounds", include_str!("bounds.wgsl")),
        ("grid_lists", include_str!("grid_lists.wgsl")),
        ("tracing", include_str!("tracing.wgsl")),
        ("later", include_str!("later.wgsl")),
        ("ordered", include_str!("ordered.wgsl")),
        ("tested", include_str!("tested.wgsl")),
        ("fused_whole", include_str!("fused/whole.wgsl")),
        ("fused_waiting", include_str!("fused/waiting.wgsl")),
        ("fused_waiting_in_grid", include_str!("fused/waiting_in_grid.wgsl")),
        ("shade_surface", include_str!("shade/surface.wgsl")),
        ("shade_light", include_str!("shade/light.wgsl")),
        ("walk_place", include_str!("walk/place.wgsl")),
        ("intersect_acceptance", include_str!("intersect/acceptance.wgsl")),
        ("intersect_entry", include_str!("intersect/entry.wgsl")),
        ("intersect_cell_end", include_str!("intersect/cell_end.wgsl")),
        ("intersect_repetition", include_str!("intersect/repetition.wgsl")),
    ];
    let [mut fused, intersect, walk] = of_structure(features.structure());
    let taking = match features.decides {
        true => include_str!("fused/taking_open.wgsl"),
        false => include_str!("fused/taking.wgsl"),
    };
    if features.bvh && !features.wide {
        fused.1 = include_str!("fused/bvh_binary.wgsl");
    }
    let chosen = [shared::grid_walk_module(features.walk_rules()), ("fused_taking", taking), fused, intersect, walk];
    let files = shared::MODULES.iter().chain(&own).chain(&chosen);
    files.map(|&(name, source)| (name, Cow::Borrowed(source))).collect()
}

/// The part of each kernel that depends on the structure through which the scene is traced.
const fn of_structure(structure: StructureKind) -> [(&'static str, &'static str); 3] {
    macro_rules! parts {
        ($file:literal) => {
            [
                ("fused_structure", include_str!(concat!("fused/", $file))),
                ("intersect_structure", include_str!(concat!("intersect/", $file))),
                ("walk_structure", include_str!(concat!("walk/", $file))),
            ]
        };
    }
    match structure {
        StructureKind::None => parts!("all.wgsl"),
        StructureKind::Grid => parts!("grid.wgsl"),
        StructureKind::Irregular => parts!("irregular.wgsl"),
        StructureKind::Bvh => parts!("bvh.wgsl"),
    }
}
