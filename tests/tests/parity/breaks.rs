//! What breaks each kernel on purpose: parts of its WGSL, and what takes their place.

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
        (Kernel::Generate, STEPPED, "0.5", "0.4995"),
        (Kernel::Setup, STEPPED, "floor(position)", "ceil(position)"),
        (Kernel::Setup, STEPPED, "let next = ISECT_NO_HIT", "let next = BACKGROUND"),
        (Kernel::Setup, Way::new(Bvh, Second, 1), "vec4u(NO_NODE)", "vec4u(0u)"),
        (Kernel::TraverseGrid, STEPPED, "select(vec3i(-1), vec3i(1)", "select(vec3i(1), vec3i(-1)"),
        (Kernel::TraverseGrid, STEPPED, "tmax.x < tmax.y && ", ""),
        (Kernel::TraverseGrid, STEPPED.leaping(), "forward * (distance - 1)", "forward * distance"),
        (Kernel::TraverseBvh, Way::new(Bvh, Second, 1), "((at.node - 1u) ^ 1u) + 1u", "at.node"),
        (Kernel::TraverseBvh, Way::new(Bvh, Compact, 1), "min(t0, t1)", "t0"),
        (Kernel::Intersect, STEPPED, "nearest_t <= exit", "nearest_t < 0.5 * exit"),
        (Kernel::Intersect, STEPPED, "let u = weight_b * inverse", "let u = weight_a * inverse"),
        (Kernel::Intersect, Way::new(Bvh, Second, 1), "bvh_items[first + item]", "bvh_items[first]"),
        (Kernel::Walk, few_steps(Grid), "step < scene.steps", "step + 1u < scene.steps"),
        (Kernel::Walk, few_steps(Grid), "trace.u = candidate.u", "trace.u = candidate.v"),
        (Kernel::Walk, few_steps(Grid).leaping(), "8u * (index % 4u)", "8u * (index % 3u)"),
        (Kernel::Walk, few_steps(Grid).leaping(), "min(walk.cell, last)", "walk.cell"),
        (Kernel::Walk, few_steps(Bvh), "let first = node.first", "let first = node.first + 1u"),
        (Kernel::Walk, few_steps(Bvh), "select(0u, 1u, goes_down", "select(1u, 0u, goes_down"),
        (Kernel::Walk, few_steps(None), "3u * entry + 2u", "3u * entry + 1u"),
        (Kernel::Fused, Way::new(Grid, Fused, 1), "trace.t <= smallest3(walk.tmax)", "trace.triangle != NO_TRIANGLE"),
        (Kernel::Fused, Way::new(Grid, Fused, 1).leaping(), "distance > 1", "distance > 2"),
        (Kernel::Fused, Way::new(Bvh, Fused, 1), "bitcast<i32>(nearest_t)", "bitcast<i32>(0.5 * nearest_t)"),
        (Kernel::Fused, Way::new(Bvh, Fused, 1), "leaves.base + countOneBits", "leaves.base + 0u * countOneBits"),
        (Kernel::Shade, STEPPED, "max(dot3(normal, to_light), 0.0)", "abs(dot3(normal, to_light))"),
    ]
};

/// The same of what only runs with few loop turns a dispatch compile.
pub(crate) const TURN_BREAKS: [Break; 9] = {
    use Accelerator::{Bvh, Grid, None};
    use ScheduleKind::{Compact, Fused};
    [
        (Kernel::Walk, Way::new(Grid, Compact, 8), "item + 1u - grid_cells", "item + 2u - grid_cells"),
        (Kernel::Walk, Way::new(Bvh, Compact, 8), "at.in_leaf = place.item > 0u", "at.in_leaf = false"),
        (Kernel::Walk, Way::new(None, Compact, 8), "is_spent(place.trace)", "false"),
        (Kernel::Fused, Way::new(Grid, Fused, 1), "item + 1u - grid_cells", "item - grid_cells"),
        (Kernel::Fused, Way::new(Grid, Fused, 1).paper(), "u32(left)", "u32(left + 1)"),
        (Kernel::Fused, Way::new(Bvh, Fused, 1), "level + 1u, NO_CHILD", "level + 1u, 0u"),
        (Kernel::Fused, Way::new(Bvh, Fused, 1), "(1u << (24u + child)) - 1u", "(2u << (24u + child)) - 1u"),
        (Kernel::Fused, Way::new(None, Fused, 1), "wait_at(0u, triangle + 1u)", "wait_at(0u, triangle + 2u)"),
        (Kernel::Intersect, STEPPED, "keep_scan(texel, index, walk.tmax)", "keep_scan(texel, cell, walk.tmax)"),
    ]
};

/// The same of what only runs with several samples a pixel compile, with a sampler.
pub(crate) const SAMPLING_BREAKS: [(Kernel, Sampler, &str, &str); 8] = [
    (Kernel::Generate, Sampler::Sobol, "column ^= column >> 1u", "column = column >> 1u"),
    (Kernel::Generate, Sampler::Sobol, "0x05526c56u", "0x05526c54u"),
    (Kernel::Generate, Sampler::Sobol, "hashed(sampling.seed)", "hashed(0u)"),
    (Kernel::Generate, Sampler::Random, "hashed(hashed(sample) + second_seed)", "hashed(sample + second_seed)"),
    (Kernel::Accumulate, Sampler::Sobol, "/ samples", "* 0.5"),
    (Kernel::Accumulate, Sampler::Sobol, "!= NO_TRIANGLE", "!= 0u"),
    (Kernel::Accumulate, Sampler::Sobol, "samples < f32(sampling.samples)", "samples < 3.0"),
    (
        Kernel::Accumulate,
        Sampler::Sobol,
        "textureStore(color, texel, 1, vec4f(mean.y))",
        "textureStore(color, texel, 1, vec4f(mean.x))",
    ),
];
