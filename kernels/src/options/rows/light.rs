//! The options of the light that a pixel receives.

use super::{Refusal, Row, Values, parse, text};
use crate::options::row::{Value, whole};
use crate::options::{
    Choices, Environment, Integrator, MAX_DEPTH as DEPTH, MOST_BOUNCES, MOST_DEPTH, ProgramName, Strategy as Found,
};

const fn traces_rays(c: &Choices) -> bool {
    matches!(c.program, ProgramName::ClosestHit)
}

pub(super) const INTEGRATOR: Row = named!(
    "integrator",
    Integrator,
    integrator,
    "What light a pixel receives: from every light, by equation (1) of Mølhave's paper (local); only from lights that a \
     shadow ray reaches (shadows); also what mirrors and smooth glass reflect and refract (whitted); all light, in \
     physical units, along random paths (path), or estimated from photons that are followed from the lights (photons). \
     Rough metal and rough glass are drawn as diffuse surfaces"
)
.panel(
    "light",
    "what light a pixel receives: from every light, only from those that a shadow ray reaches, also by mirrors and \
     smooth glass, or all light, along random paths or from photons",
)
.applies(traces_rays)
.refused(|c| {
    let is_idle = c.integrator != Integrator::Local && !traces_rays(c);
    let why = || format!("--integrator {}: program {} computes no light; omit it", c.integrator, c.program);
    is_idle.then(|| Refusal::Idle(why()))
});

const fn bounces(c: &Choices) -> bool {
    matches!(c.integrator, Integrator::Whitted | Integrator::Path | Integrator::Photons)
}

pub(super) const MAX_DEPTH: Row = Row::new(
    "max-depth",
    Values::Whole(0, MOST_BOUNCES),
    |c| Value::Number(c.max_depth),
    |c, value| whole(value, 0, MOST_BOUNCES).map(|number| c.max_depth = number),
    "How often a ray may be reflected or refracted, with --integrator whitted; or how often light may bounce on its way \
     from a lamp to the eye, with path and photons",
)
.panel("bounces", "most reflections and refractions of a ray, or bounces of light from a lamp to the eye")
.applies(|c| traces_rays(c) && bounces(c))
.refused(|c| {
    let depth = c.max_depth;
    if c.integrator == Integrator::Whitted && depth > MOST_DEPTH {
        let why = format!("--max-depth {depth}: a tree of rays has at most {MOST_DEPTH} with --integrator whitted");
        return Some(Refusal::Impossible(why));
    }
    if c.integrator == Integrator::Photons && depth > MOST_DEPTH {
        let why = format!("--max-depth {depth}: a photon bounces at most {MOST_DEPTH} times with --integrator photons");
        return Some(Refusal::Impossible(why));
    }
    let is_idle = depth != DEPTH && !bounces(c);
    let why = || {
        format!(
            "--max-depth {depth} applies to --integrator whitted, path or photons, not to {}: omit it",
            c.integrator
        )
    };
    is_idle.then(|| Refusal::Idle(why()))
});

pub(super) const STRATEGY: Row = named!(
    "strategy",
    Found,
    strategy,
    "How a path finds surfaces that glow, with --integrator path: it casts shadow rays to points of them (light), its \
     random directions hit them (bsdf), or both, each weighted by its pdf (mis). Point, directional and spot lights \
     always get shadow rays"
)
.panel(
    "strategy",
    "how a path finds surfaces that glow: by shadow rays, by its random directions, or both, weighted by their pdfs",
)
.applies(|c| traces_rays(c) && c.integrator == Integrator::Path)
.refused(|c| {
    let is_idle = c.strategy != Found::default() && c.integrator != Integrator::Path;
    let why = || format!("--strategy {} applies to --integrator path, not to {}: omit it", c.strategy, c.integrator);
    is_idle.then(|| Refusal::Idle(why()))
});

pub(super) const ENVIRONMENT: Row = named!(
    "environment",
    Environment,
    environment,
    "What a path sees that leaves the scene, with --integrator path: a radiance of 1 from everywhere (white), nothing \
     (black), or the background of every picture, which is nearly black, and white only if nothing in the scene gives \
     light (auto)"
)
.panel("environment", "the light from around the scene: white, none, or white only if nothing in the scene gives light")
.applies(|c| traces_rays(c) && c.integrator == Integrator::Path)
.refused(|c| {
    let is_idle = c.environment != Environment::default() && c.integrator != Integrator::Path;
    let why =
        || format!("--environment {} applies to --integrator path, not to {}: omit it", c.environment, c.integrator);
    is_idle.then(|| Refusal::Idle(why()))
});
