//! The options of the light that a pixel receives.

use super::{Refusal, Row, Values, parse, text};
use crate::options::row::{Value, whole};
use crate::options::{
    Choices, Environment, Integrator, MAX_DEPTH as DEPTH, MOST_BOUNCES, MOST_DEPTH, ProgramName, Strategy as Found,
};

const fn traces_rays(c: &Choices) -> bool {
    matches!(c.program, ProgramName::ClosestHit)
}

pub(super) const INTEGRATOR: Row = Row::new(
    "integrator",
    Values::Names(|| Integrator::ALL.iter().map(|of| of.name()).collect()),
    |c| text(c.integrator),
    |c, value| parse(value, &mut c.integrator),
    "The light that a pixel receives: equation (1) of Mølhave's paper, in which every light counts (local), or only those \
     that a shadow ray from the hit reaches (shadows); with these also what mirrors and transparent surfaces reflect \
     and refract (whitted); or, in physical units, all light that surfaces emit and reflect, along random paths (path)",
)
.panel(
    "light",
    "the light that a pixel receives: from all lights, only from those that a shadow ray reaches, also by mirrors and \
     transparent surfaces, or all light, along random paths",
)
.applies(traces_rays)
.refused(|c| {
    let is_idle = c.integrator != Integrator::Local && !traces_rays(c);
    let why = || format!("--integrator {}: program {} computes no light; omit it", c.integrator, c.program);
    is_idle.then(|| Refusal::Idle(why()))
});

const fn bounces(c: &Choices) -> bool {
    matches!(c.integrator, Integrator::Whitted | Integrator::Path)
}

pub(super) const MAX_DEPTH: Row = Row::new(
    "max-depth",
    Values::Whole(0, MOST_BOUNCES),
    |c| Value::Number(c.max_depth),
    |c, value| whole(value, 0, MOST_BOUNCES).map(|number| c.max_depth = number),
    "How many times a ray is reflected or refracted, with --integrator whitted, or a path bounces, with path",
)
.panel("bounces", "how many times a ray is reflected or refracted, or a path bounces")
.applies(|c| traces_rays(c) && bounces(c))
.refused(|c| {
    let depth = c.max_depth;
    if c.integrator == Integrator::Whitted && depth > MOST_DEPTH {
        let why = format!("--max-depth {depth}: a tree of rays has at most {MOST_DEPTH} with --integrator whitted");
        return Some(Refusal::Impossible(why));
    }
    let is_idle = depth != DEPTH && !bounces(c);
    let why =
        || format!("--max-depth {depth} applies to --integrator whitted or path, not to {}: omit it", c.integrator);
    is_idle.then(|| Refusal::Idle(why()))
});

pub(super) const STRATEGY: Row = Row::new(
    "strategy",
    Values::Names(|| Found::ALL.iter().map(|of| of.name()).collect()),
    |c| text(c.strategy),
    |c, value| parse(value, &mut c.strategy),
    "How a path finds light, with --integrator path: by picking a light, or a point of a surface that glows (light), by \
     chance (bsdf), or both, each weighted by its pdf (mis)",
)
.panel("strategy", "how a path finds light: by picking it, by chance, or both, weighted by their pdfs")
.applies(|c| traces_rays(c) && c.integrator == Integrator::Path)
.refused(|c| {
    let is_idle = c.strategy != Found::default() && c.integrator != Integrator::Path;
    let why = || format!("--strategy {} applies to --integrator path, not to {}: omit it", c.strategy, c.integrator);
    is_idle.then(|| Refusal::Idle(why()))
});

pub(super) const ENVIRONMENT: Row = Row::new(
    "environment",
    Values::Names(|| Environment::ALL.iter().map(|of| of.name()).collect()),
    |c| text(c.environment),
    |c, value| parse(value, &mut c.environment),
    "What a path sees that leaves the scene, with --integrator path: a radiance of 1 from everywhere (white), nothing \
     (black), or the background of every picture, which is nearly black, and white only if nothing in the scene gives \
     light (auto)",
)
.panel("environment", "the light from around the scene: white, none, or white only if nothing in the scene gives light")
.applies(|c| traces_rays(c) && c.integrator == Integrator::Path)
.refused(|c| {
    let is_idle = c.environment != Environment::default() && c.integrator != Integrator::Path;
    let why =
        || format!("--environment {} applies to --integrator path, not to {}: omit it", c.environment, c.integrator);
    is_idle.then(|| Refusal::Idle(why()))
});
