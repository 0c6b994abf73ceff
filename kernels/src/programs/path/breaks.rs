//! Deliberate defects of the program's own kernels.

use crate::options::{Options, Strategy};
use crate::program::breaks::{Break, as_it_is};

fn counted(options: &mut Options) {
    options.counters = true;
}

fn by_light(options: &mut Options) {
    options.strategy = Strategy::Light;
}

pub(super) const OF_SAMPLE_LIGHT: &[Break] = &[
    Break::new(
        as_it_is,
        "decided_by(at.texel, at.sample, at.depth, FOR_POINT)",
        "decided_by(at.texel, at.sample, at.depth, FOR_EMITTER)",
    ),
    Break::new(as_it_is, "if (by.y < emitter.keep)", "if (by.y > emitter.keep)"),
    Break::new(as_it_is, "side * (1.0 - by.y)", "side * by.y"),
    Break::new(as_it_is, "arrives *= weight(to.pdf, cosine * INVERSE_PI)", "arrives *= 1.0"),
    Break::new(as_it_is, "return 1.0 / (1.0 + ratio * ratio)", "return 1.0 / (1.0 + ratio)"),
    Break::new(as_it_is, "dot3(way, way)\n        / abs", "1.0 / abs"),
    Break::new(as_it_is, "(!to.is_lit || cosine <= 0.0 || dot3(at.start.normal, to.direction) <= 0.0)", "(false)"),
    Break::new(as_it_is, "at.start.is_back && material", "!at.start.is_back && material"),
    Break::new(as_it_is, "keep_primary(texel);", ""),
    Break::new(by_light, "return select(0.0, 1.0, of_direction == 0.0)", "return 1.0"),
];

pub(super) const OF_SAMPLE_BSDF: &[Break] = &[
    Break::new(as_it_is, "if (tag == VISIBLE)", "if (tag == OCCLUDED)"),
    Break::new(as_it_is, "on_circle(by.y) * sqrt(by.x)", "on_circle(by.y) * by.x"),
    Break::new(as_it_is, "let quarter = floor(4.0 * turns + 0.5)", "let quarter = floor(4.0 * turns)"),
    Break::new(as_it_is, "next.throughput *= 1.0 / goes_on", "next.throughput *= 1.0"),
    Break::new(as_it_is, "chance.x < split.reflectance", "chance.x > split.reflectance"),
    Break::new(
        as_it_is,
        "start.point - start.normal * start.distance",
        "start.point - start.normal * (64.0 * start.distance)",
    ),
    Break::new(as_it_is, "* INVERSE_PI;\n        if", ";\n        if"),
    Break::new(as_it_is, "depth < DEPTH", "depth <= DEPTH"),
    Break::new(as_it_is, "textureStore(pdf, texel, 0, vec4f(0.0))", ""),
    Break::new(as_it_is, "textureStore(ended, texel, 0, vec4u(why))", ""),
    Break::new(counted, "if (tag != SCATTER) {", "if (tag == SCATTER) {"),
];

pub(super) const OF_FUSED_PATH: &[Break] = &[
    Break::new(as_it_is, "sum += pending;", ""),
    Break::new(as_it_is, "trace.is_shadow = true;", ""),
    Break::new(as_it_is, "pdf = next.pdf;", ""),
    Break::new(as_it_is, "depth == DEPTH", "depth > DEPTH"),
    Break::new(as_it_is, "leaves = trace.triangle;", ""),
    Break::new(as_it_is, "carried = next.throughput;", ""),
    Break::new(as_it_is, "if (depth == 0u)", "if (depth == 1u)"),
    Break::new(as_it_is, "sum += carried * shading.background;", "sum += shading.background;"),
    Break::new(as_it_is, "textureStore(ended, texel, 0, vec4u(next.ended));", ""),
    Break::new(counted, "trace.ended = trace.is_shadow", "trace.ended = false"),
    Break::new(counted, "spent += vec2u(trace.cells, trace.tests)", "spent = vec2u(trace.cells, trace.tests)"),
];
