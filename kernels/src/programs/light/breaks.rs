//! Deliberate defects of the program's own kernel.

use crate::options::Options;
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
        "textureStore(state, texel, 1, vec4u(t_bits));\n    textureStore(state, texel, 0, vec4u(DONE));",
        "textureStore(state, texel, 0, vec4u(DONE));",
    ),
    Break::new(counted, "textureLoad(shadow_counters, texel, 1, 0).x", "0u"),
];
