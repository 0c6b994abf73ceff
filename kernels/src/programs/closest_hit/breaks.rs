//! Deliberate defects of each kernel.

use crate::options::samples::Samples;
use crate::options::{Accelerator, Numerics, Options, Order, ScheduleKind, Skip, Traversal};
pub(super) use crate::program::breaks::{Break, as_it_is};
use crate::shared::samples::Sampler;

fn leaping(options: &mut Options) {
    options.skip = Skip::On;
}

/// Several steps per pass, over lists of live rays.
fn several(options: &mut Options) {
    (options.schedule, options.steps_per_pass) = (ScheduleKind::Compact, 8);
}

fn several_leaping(options: &mut Options) {
    several(options);
    leaping(options);
}

fn several_bvh(options: &mut Options) {
    several(options);
    bvh(options);
}

fn several_none(options: &mut Options) {
    several(options);
    none(options);
}

fn bvh(options: &mut Options) {
    options.accelerator = Accelerator::Bvh;
}

fn irregular(options: &mut Options) {
    options.accelerator = Accelerator::Irregular;
}

fn several_irregular(options: &mut Options) {
    several(options);
    irregular(options);
}

fn fused_irregular(options: &mut Options) {
    fused(options);
    irregular(options);
}

fn none(options: &mut Options) {
    options.accelerator = Accelerator::None;
}

fn listed_bvh(options: &mut Options) {
    options.schedule = ScheduleKind::Compact;
    bvh(options);
}

fn fused(options: &mut Options) {
    options.schedule = ScheduleKind::Fused;
}

fn fused_leaping(options: &mut Options) {
    fused(options);
    leaping(options);
}

fn fused_paper(options: &mut Options) {
    fused(options);
    options.numerics = Numerics::Paper;
}

fn dda(options: &mut Options) {
    (options.numerics, options.traversal) = (Numerics::Paper, Traversal::Dda3d);
}

fn several_dda(options: &mut Options) {
    several(options);
    dda(options);
}

fn fused_dda(options: &mut Options) {
    fused(options);
    dda(options);
}

fn fused_bvh(options: &mut Options) {
    fused(options);
    bvh(options);
}

fn fused_none(options: &mut Options) {
    fused(options);
    none(options);
}

/// The fused kernel generates its rays itself.
fn fused_eye_rays(options: &mut Options) {
    fused_bvh(options);
    options.shade = false;
}

fn sobol(options: &mut Options) {
    several(options);
    options.samples = Samples { count: 5, seed: 1, ..Samples::default() };
}

fn blocks(options: &mut Options) {
    sobol(options);
    options.samples.count = Samples::BLOCK + 3;
}

fn random(options: &mut Options) {
    sobol(options);
    options.samples.sampler = Sampler::Random;
}

pub(super) const OF_GENERATE: &[Break] = &[
    Break::new(as_it_is, "0.5", "0.4995"),
    Break::new(sobol, "(digits & 0x33333333u) << 2u", "(digits & 0x33333333u) << 3u"),
    Break::new(sobol, "0x05526c56u", "0x05526c54u"),
    Break::new(sobol, "hashed(sampling.seed)", "hashed(0u)"),
    Break::new(sobol, "sampling.first + ", "sampling.first + 1u + "),
    Break::new(random, "hashed(hashed(sample) + second_seed)", "hashed(sample + second_seed)"),
];

pub(super) const OF_SETUP: &[Break] = &[
    Break::new(as_it_is, "floor(position)", "ceil(position)"),
    Break::new(as_it_is, "let next = ISECT_NO_HIT", "let next = BACKGROUND"),
    Break::new(bvh, "vec4u(NO_NODE)", "vec4u(0u)"),
    Break::new(dda, "low + 1.0 - position", "low + 1.001 - position"),
];

pub(super) const OF_TRAVERSE_GRID: &[Break] = &[
    Break::new(as_it_is, "select(vec3i(-1), vec3i(1)", "select(vec3i(1), vec3i(-1)"),
    Break::new(as_it_is, "tmax.x < tmax.y && ", ""),
    Break::new(leaping, "forward * (distance - 1)", "forward * distance"),
    Break::new(dda, "control.x * slope.y > control.y * slope.x", "control.x > control.y"),
    Break::new(dda, "any(axis & driving_axis(slope))", "any(axis)"),
];

pub(super) const OF_TRAVERSE_IRREGULAR: &[Break] = &[
    // More than the one virtual cell that rounding may change.
    Break::new(irregular, "rounded_down(position)", "rounded_down(position - 3.0)"),
    Break::new(irregular, "let beyond = select(exit.ahead - vec3i(1), exit.ahead, is_up)", "let beyond = exit.ahead"),
    Break::new(irregular, "below.z << depth", "below.z"),
];

pub(super) const OF_TRAVERSE_BVH: &[Break] =
    &[Break::new(bvh, "((at.node - 1u) ^ 1u) + 1u", "at.node"), Break::new(listed_bvh, "min(t0, t1)", "t0")];

pub(super) const OF_INTERSECT: &[Break] = &[
    Break::new(as_it_is, "nearest_t <= exit", "nearest_t < 0.5 * exit"),
    Break::new(as_it_is, "let u = weight_b * inverse", "let u = weight_a * inverse"),
    Break::new(bvh, "bvh_items[list.first + item]", "bvh_items[list.first]"),
    Break::new(as_it_is, "keep_scan(texel, index, per_axis(walk))", "keep_scan(texel, cell, per_axis(walk))")
        .in_parts(),
];

pub(super) const OF_WALK: &[Break] = &[
    Break::new(several, "step < scene.steps", "step + 1u < scene.steps"),
    Break::new(several, "trace.u = candidate.u", "trace.u = candidate.v"),
    Break::new(several_leaping, "8u * (index % 4u)", "8u * (index % 3u)"),
    Break::new(several_leaping, "min(walk.cell, last)", "walk.cell"),
    Break::new(several_dda, "textureStore(control, texel, 1, vec4f(along.y))", ""),
    Break::new(several_bvh, "var item = node.first", "var item = node.first + 1u"),
    Break::new(several_bvh, "select(0u, 1u, goes_down", "select(1u, 0u, goes_down"),
    Break::new(several_none, "3u * entry + 2u", "3u * entry + 1u"),
    Break::new(several_irregular, "goes_on = (entry & LAST_ITEM) == 0u", "goes_on = false"),
    Break::new(several, "item + 1u - first", "item + 2u - first").in_parts(),
    Break::new(several_bvh, "at.in_leaf = waiting_item(place) > 0u", "at.in_leaf = false").in_parts(),
    Break::new(several_none, "is_spent(place.trace)", "false").in_parts(),
];

pub(super) const OF_FUSED: &[Break] = &[
    Break::new(fused, "farthest(trace) <= smallest3(walk.tmax)", "trace.triangle != NO_TRIANGLE"),
    Break::new(fused_leaping, "distance > 1", "distance > 2"),
    Break::new(fused_irregular, "farthest(trace) <= smallest3(exit.tmax)", "trace.triangle != NO_TRIANGLE"),
    Break::new(fused_bvh, "bitcast<i32>(nearest_t)", "bitcast<i32>(0.5 * nearest_t)"),
    Break::new(fused_bvh, "leaves.base + countOneBits", "leaves.base + 0u * countOneBits"),
    Break::new(fused_eye_rays, "0.5", "0.4995"),
    Break::new(fused, "item + 1u - first", "item - first").in_parts(),
    Break::new(fused_dda, "place, wait.texel, 5, vec4u(along.y)", "place, wait.texel, 5, vec4u(along.x)").in_parts(),
    Break::new(fused_paper, "u32(left)", "u32(left + 1)").in_parts(),
    Break::new(fused_bvh, "level + 1u, NO_CHILD", "level + 1u, 0u").in_parts(),
    Break::new(fused_bvh, "(1u << (24u + child)) - 1u", "(2u << (24u + child)) - 1u").in_parts(),
    Break::new(fused_none, "wait_at(0u, triangle + 1u)", "wait_at(0u, triangle + 2u)").in_parts(),
];

/// Rays that pass near edges, in integers.
fn exactly(options: &mut Options) {
    options.order = Order::Exact;
}

fn fused_exactly(options: &mut Options) {
    fused_bvh(options);
    exactly(options);
}

fn stepped_exactly_bvh(options: &mut Options) {
    bvh(options);
    exactly(options);
}

pub(super) const OF_DECIDE: &[Break] = &[
    Break::new(exactly, "return tag == EXACT", "return false"),
    Break::new(fused_exactly, "let sign = a.sign ^ b.sign.yzx", "let sign = a.sign"),
    Break::new(stepped_exactly_bvh, "at.in_leaf = waiting_item() > 0u", "at.in_leaf = true"),
];

pub(super) const OF_SHADE: &[Break] =
    &[Break::new(as_it_is, "max(dot3(normal, to_light), 0.0)", "abs(dot3(normal, to_light))")];

pub(super) const OF_ACCUMULATE: &[Break] = &[
    Break::new(sobol, "/ of_block", "* 0.5"),
    Break::new(blocks, "of_block == f32(BLOCK)", "of_block == 2.0"),
    Break::new(blocks, "stored, vec4f(0.0), of_block", "vec4f(0.0), stored, of_block"),
    Break::new(blocks, "/ (complete + part)", "/ complete"),
    Break::new(sobol, "!= NO_TRIANGLE", "!= 0u"),
    Break::new(sobol, "samples < f32(sampling.samples)", "samples < 3.0"),
    Break::new(sobol, "textureStore(color, texel, 1, vec4f(all.y))", "textureStore(color, texel, 1, vec4f(all.x))"),
    Break::new(sobol, "atomicAdd(&sent_here[tag], 1u)", "").in_counts(),
];

pub(super) const OF_COUNT: &[Break] =
    &[Break::new(fused, "atomicAdd(&in_workgroup[tag], 1u)", "atomicAdd(&in_workgroup[tag], 2u)").in_counts()];
