//! What passes do to paths, for statistics by bounce.

use super::densities::{of_background, of_emitter_hit, of_light_sample};
use super::scattered::{BY_ABSORPTION, BY_DEPTH, BY_ESCAPE, BY_ROULETTE, BY_SURFACE};
use crate::program::RayState;
use crate::program::paths::{Added, Ending, PathStep, Paths, Shadow, Technique};
use crate::programs::closest_hit::states::{BACKGROUND, DONE, OCCLUDED, SCATTER, SHADE, SHADOW_SETUP, VISIBLE};
use crate::programs::closest_hit::streams::{
    BOUNCE, ENDED, HIT, LIGHT, PDF, PENDING, RADIANCE, RAY_DIRECTION, RAY_ORIGIN, SHADOW_DIRECTION, STATE, THROUGHPUT,
};
use crate::scene_data::SceneData;

/// Of paths over random bounces.
pub(super) const PATHS: Paths = Paths {
    streams: &[
        STATE,
        HIT,
        RAY_ORIGIN,
        RAY_DIRECTION,
        SHADOW_DIRECTION,
        PENDING,
        LIGHT,
        BOUNCE,
        THROUGHPUT,
        RADIANCE,
        PDF,
        ENDED,
    ],
    takes: &[SHADE, BACKGROUND, OCCLUDED, VISIBLE, SCATTER],
    step,
};

fn step(data: &SceneData, before: &RayState, after: &RayState) -> PathStep {
    let depth = before.bounce.map_or(0, |bounce| bounce.depth);
    if matches!(before.tag, SHADE | BACKGROUND) {
        arrival(data, before, after, depth)
    } else {
        departure(before, after, depth)
    }
}

/// The ray has ended: what is there, and whether a shadow ray is cast.
fn arrival(data: &SceneData, before: &RayState, after: &RayState, depth: u32) -> PathStep {
    let [from, to] = [before, after].map(|ray| ray.bounce.unwrap_or_default());
    // The sum so far begins with a path.
    let so_far = if depth == 0 { [0.0; 3] } else { from.radiance };
    let light = [0, 1, 2].map(|c| f64::from(to.radiance[c]) - f64::from(so_far[c]));
    let (technique, density) = match before.tag {
        BACKGROUND => (Technique::Background, Some(of_background(before))),
        _ if light == [0.0; 3] => (Technique::EmitterHit, None),
        _ => (Technique::EmitterHit, of_emitter_hit(data, before)),
    };
    let is_cast = after.tag == SHADOW_SETUP;
    PathStep {
        depth,
        arrived: Some(from.throughput),
        added: (light != [0.0; 3]).then_some(Added { technique, light, density }),
        shadow: is_cast.then(|| Shadow::Cast(of_light_sample(data, before, after))),
        ..PathStep::default()
    }
}

/// The path goes on, or ends.
fn departure(before: &RayState, after: &RayState, depth: u32) -> PathStep {
    let ending = match after.bounce.unwrap_or_default().ended {
        BY_ESCAPE => Some(Ending::Escape),
        BY_DEPTH => Some(Ending::Depth),
        BY_ABSORPTION => Some(Ending::Absorption),
        BY_SURFACE => Some(Ending::Surface),
        BY_ROULETTE => Some(Ending::Roulette),
        _ => None,
    };
    let is_over = after.tag == DONE;
    let (shadow, light) = match before.tag {
        OCCLUDED => (Some(Shadow::Occluded), None),
        VISIBLE => (Some(Shadow::Reached), before.pending),
        _ => (None, None),
    };
    let added =
        light.map(|light| Added { technique: Technique::LightSample, light: light.map(f64::from), density: None });
    PathStep { depth, added, shadow, ended: ending.filter(|_| is_over), goes_on: !is_over, ..PathStep::default() }
}
