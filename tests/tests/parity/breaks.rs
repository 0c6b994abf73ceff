//! What breaks each kernel on purpose: parts of its WGSL, and what takes their place.

use raystep_kernels::programs::closest_hit::kernels;
use raystep_kernels::{Accelerator, Kernel, Sampler, ScheduleKind};
use raystep_tests::ways::{STEPPED, Way};

/// A kernel of a way to trace, a part of its WGSL, and what takes its place.
pub(crate) type Break = (Kernel, Way, &'static str, &'static str);

pub(crate) const BREAKS: [Break; 24] = {
    use Accelerator::{Bvh, Grid, None};
    use ScheduleKind::{Compact, Fused, Second};
    const fn few_steps(accelerator: Accelerator) -> Way {
        Way::new(accelerator, Compact, 8)
    }
    [
        (kernels::GENERATE, STEPPED, "0.5", "0.4995"),
        (kernels::SETUP, STEPPED, "floor(position)", "ceil(position)"),
        (kernels::SETUP, STEPPED, "let next = ISECT_NO_HIT", "let next = BACKGROUND"),
        (kernels::SETUP, Way::new(Bvh, Second, 1), "vec4u(NO_NODE)", "vec4u(0u)"),
        (kernels::TRAVERSE_GRID, STEPPED, "select(vec3i(-1), vec3i(1)", "select(vec3i(1), vec3i(-1)"),
        (kernels::TRAVERSE_GRID, STEPPED, "tmax.x < tmax.y && ", ""),
        (kernels::TRAVERSE_GRID, STEPPED.leaping(), "forward * (distance - 1)", "forward * distance"),
        (kernels::TRAVERSE_BVH, Way::new(Bvh, Second, 1), "((at.node - 1u) ^ 1u) + 1u", "at.node"),
        (kernels::TRAVERSE_BVH, Way::new(Bvh, Compact, 1), "min(t0, t1)", "t0"),
        (kernels::INTERSECT, STEPPED, "nearest_t <= exit", "nearest_t < 0.5 * exit"),
        (kernels::INTERSECT, STEPPED, "let u = weight_b * inverse", "let u = weight_a * inverse"),
        (kernels::INTERSECT, Way::new(Bvh, Second, 1), "bvh_items[first + item]", "bvh_items[first]"),
        (kernels::WALK, few_steps(Grid), "step < scene.steps", "step + 1u < scene.steps"),
        (kernels::WALK, few_steps(Grid), "trace.u = candidate.u", "trace.u = candidate.v"),
        (kernels::WALK, few_steps(Grid).leaping(), "8u * (index % 4u)", "8u * (index % 3u)"),
        (kernels::WALK, few_steps(Grid).leaping(), "min(walk.cell, last)", "walk.cell"),
        (kernels::WALK, few_steps(Bvh), "let first = node.first", "let first = node.first + 1u"),
        (kernels::WALK, few_steps(Bvh), "select(0u, 1u, goes_down", "select(1u, 0u, goes_down"),
        (kernels::WALK, few_steps(None), "3u * entry + 2u", "3u * entry + 1u"),
        (kernels::FUSED, Way::new(Grid, Fused, 1), "trace.t <= smallest3(walk.tmax)", "trace.triangle != NO_TRIANGLE"),
        (kernels::FUSED, Way::new(Grid, Fused, 1).leaping(), "distance > 1", "distance > 2"),
        (kernels::FUSED, Way::new(Bvh, Fused, 1), "bitcast<i32>(nearest_t)", "bitcast<i32>(0.5 * nearest_t)"),
        (kernels::FUSED, Way::new(Bvh, Fused, 1), "leaves.base + countOneBits", "leaves.base + 0u * countOneBits"),
        (kernels::SHADE, STEPPED, "max(dot3(normal, to_light), 0.0)", "abs(dot3(normal, to_light))"),
    ]
};

/// The same of what only runs with few loop turns a dispatch compile.
pub(crate) const TURN_BREAKS: [Break; 9] = {
    use Accelerator::{Bvh, Grid, None};
    use ScheduleKind::{Compact, Fused};
    [
        (kernels::WALK, Way::new(Grid, Compact, 8), "item + 1u - grid_cells", "item + 2u - grid_cells"),
        (kernels::WALK, Way::new(Bvh, Compact, 8), "at.in_leaf = place.item > 0u", "at.in_leaf = false"),
        (kernels::WALK, Way::new(None, Compact, 8), "is_spent(place.trace)", "false"),
        (kernels::FUSED, Way::new(Grid, Fused, 1), "item + 1u - grid_cells", "item - grid_cells"),
        (kernels::FUSED, Way::new(Grid, Fused, 1).paper(), "u32(left)", "u32(left + 1)"),
        (kernels::FUSED, Way::new(Bvh, Fused, 1), "level + 1u, NO_CHILD", "level + 1u, 0u"),
        (kernels::FUSED, Way::new(Bvh, Fused, 1), "(1u << (24u + child)) - 1u", "(2u << (24u + child)) - 1u"),
        (kernels::FUSED, Way::new(None, Fused, 1), "wait_at(0u, triangle + 1u)", "wait_at(0u, triangle + 2u)"),
        (kernels::INTERSECT, STEPPED, "keep_scan(texel, index, walk.tmax)", "keep_scan(texel, cell, walk.tmax)"),
    ]
};

/// The same of what only runs with several samples a pixel compile, with a sampler.
pub(crate) const SAMPLING_BREAKS: [(Kernel, Sampler, &str, &str); 8] = [
    (kernels::GENERATE, Sampler::Sobol, "column ^= column >> 1u", "column = column >> 1u"),
    (kernels::GENERATE, Sampler::Sobol, "0x05526c56u", "0x05526c54u"),
    (kernels::GENERATE, Sampler::Sobol, "hashed(sampling.seed)", "hashed(0u)"),
    (kernels::GENERATE, Sampler::Random, "hashed(hashed(sample) + second_seed)", "hashed(sample + second_seed)"),
    (kernels::ACCUMULATE, Sampler::Sobol, "/ samples", "* 0.5"),
    (kernels::ACCUMULATE, Sampler::Sobol, "!= NO_TRIANGLE", "!= 0u"),
    (kernels::ACCUMULATE, Sampler::Sobol, "samples < f32(sampling.samples)", "samples < 3.0"),
    (
        kernels::ACCUMULATE,
        Sampler::Sobol,
        "textureStore(color, texel, 1, vec4f(mean.y))",
        "textureStore(color, texel, 1, vec4f(mean.x))",
    ),
];
