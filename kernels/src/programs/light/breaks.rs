//! Deliberate defects of the program's own kernels.

use crate::options::{Integrator, Options};
use crate::program::breaks::{Break, as_it_is};

fn counted(options: &mut Options) {
    options.counters = true;
}

pub(super) const OF_ILLUMINATE: &[Break] = &[
    Break::new(as_it_is, "if (tag == VISIBLE)", "if (tag == OCCLUDED)"),
    Break::new(as_it_is, "vec4u(i + 1u)", "vec4u(i)"),
    Break::new(as_it_is, "all(rgb == vec3f(0.0))", "false"),
    Break::new(as_it_is, "start.normal * start.distance", "start.normal * (64.0 * start.distance)"),
    Break::new(as_it_is, "end = end_before(lights[i].position, direction)", "end = 1.0"),
    Break::new(as_it_is, "dot3(start.normal, direction) <= 0.0", "false"),
    Break::new(as_it_is, "max(weight, select", "min(weight, select"),
    Break::new(
        as_it_is,
        "textureStore(state, texel, 1, vec4u(t_bits));\n    textureStore(state, texel, 0, vec4u(LIT));",
        "textureStore(state, texel, 0, vec4u(LIT));",
    ),
    Break::new(counted, "textureLoad(shadow_counters, texel, 1, 0).x", "0u"),
];

fn with_mirrors(options: &mut Options) {
    options.integrator = Integrator::Whitted;
}

fn counted_with_mirrors(options: &mut Options) {
    counted(options);
    with_mirrors(options);
}

pub(super) const OF_SCATTER: &[Break] = &[
    Break::new(with_mirrors, "sum *= carried", "sum *= 1.0"),
    Break::new(with_mirrors, "depth < DEPTH", "depth <= DEPTH"),
    Break::new(with_mirrors, "select(normal, -normal, dot3(normal, start.normal) < 0.0)", "normal"),
    Break::new(
        with_mirrors,
        "start.point - start.normal * start.distance",
        "start.point - start.normal * (64.0 * start.distance)",
    ),
    Break::new(with_mirrors, "tint * (1.0 - at.reflectance)", "tint"),
    Break::new(with_mirrors, "waiting |= 1u << depth", "waiting = 1u << depth"),
    Break::new(with_mirrors, "waiting ^= 1u << deepest", "waiting = 0u"),
    Break::new(with_mirrors, "next_depth = deepest + 1u", "next_depth = depth + 1u"),
    Break::new(with_mirrors, "first + 9u, vec4u(next.triangle)", "first + 9u, vec4u(NO_TRIANGLE)"),
    Break::new(with_mirrors, "surface, texel, 0, vec4u(triangle)", "surface, texel, 0, vec4u(NO_TRIANGLE)"),
    Break::new(with_mirrors, "keep_primary(texel);", ""),
    Break::new(with_mirrors, "put_back_primary(texel);", ""),
    Break::new(with_mirrors, "select(1.0 / optic.ior, optic.ior", "select(optic.ior, optic.ior"),
    Break::new(with_mirrors, "ratio * cosine - cosine_beyond)", "ratio * cosine + cosine_beyond)"),
    Break::new(with_mirrors, "across * across + along * along", "across * across + across * across"),
    Break::new(counted_with_mirrors, "select(textureLoad(spent, texel, layer).x, 0u, is_first)", "0u"),
];
