//! The options of the light that a pixel receives.

use super::{Refusal, Row, Values, parse, text};
use crate::options::row::{Value, whole};
use crate::options::{Choices, Integrator, MAX_DEPTH as DEPTH, MOST_DEPTH, ProgramName};

const fn traces_rays(c: &Choices) -> bool {
    matches!(c.program, ProgramName::ClosestHit)
}

pub(super) const INTEGRATOR: Row = Row::new(
    "integrator",
    Values::Names(|| Integrator::ALL.iter().map(|of| of.name()).collect()),
    |c| text(c.integrator),
    |c, value| parse(value, &mut c.integrator),
    "The light that a pixel receives: equation (1) of Mølhave's paper, in which every light counts (local), or only those \
     that a shadow ray from the hit reaches (shadows); and with these also what mirrors and transparent surfaces reflect \
     and refract (whitted)",
)
.panel(
    "light",
    "the light that a pixel receives: from all lights, only from those that a shadow ray reaches, or also by mirrors and \
     transparent surfaces",
)
.applies(traces_rays)
.refused(|c| {
    let is_idle = c.integrator != Integrator::Local && !traces_rays(c);
    let why = || format!("--integrator {}: program {} computes no light; omit it", c.integrator, c.program);
    is_idle.then(|| Refusal::Idle(why()))
});

pub(super) const MAX_DEPTH: Row = Row::new(
    "max-depth",
    Values::Whole(0, MOST_DEPTH),
    |c| Value::Number(c.max_depth),
    |c, value| whole(value, 0, MOST_DEPTH).map(|number| c.max_depth = number),
    "How many times a ray is reflected or refracted, with --integrator whitted",
)
.panel("bounces", "how many times a ray is reflected or refracted")
.applies(|c| traces_rays(c) && c.integrator == Integrator::Whitted)
.refused(|c| {
    let is_idle = c.max_depth != DEPTH && c.integrator != Integrator::Whitted;
    let why =
        || format!("--max-depth {} applies to --integrator whitted, not to {}: omit it", c.max_depth, c.integrator);
    is_idle.then(|| Refusal::Idle(why()))
});
