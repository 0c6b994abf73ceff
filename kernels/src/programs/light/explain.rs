//! Explains what a pass of the program's own kernels did.

use super::optics::optics_of;
use crate::program::RayState;
use crate::programs::closest_hit::states::{BACKGROUND, DONE, OCCLUDED, SCATTER, SHADE, VISIBLE};
use crate::scene_data::SceneData;
use crate::shared::constants::LIGHTS_SUMMED;
use crate::shared::shading::{DIELECTRIC, DIFFUSE, MIRROR};

fn rgb(v: [f32; 3]) -> String {
    format!("r {:.3} g {:.3} b {:.3}", v[0], v[1], v[2])
}

/// What the shadow ray before brought, and what is next.
pub(super) fn of_illuminate(data: &SceneData, before: &RayState, after: &RayState) -> (Option<u32>, String) {
    let lights = data.shading.lights;
    let light = |ray: &RayState| ray.light.map_or_else(String::new, |light| format!("light {light} of {lights}"));
    let brought = match before.tag {
        BACKGROUND => "nothing was hit: background".into(),
        OCCLUDED => {
            let by = before.triangle.map_or_else(String::new, |triangle| format!(" by triangle {triangle}"));
            format!("{} is occluded{by}", light(before))
        }
        VISIBLE => format!("{} is visible: adds {}", light(before), rgb(before.pending.unwrap_or_default())),
        _ => format!("equation (1) at triangle {}", before.triangle.unwrap_or_default()),
    };
    let next = match after.tag {
        DONE => rgb(after.color.unwrap_or_default()),
        SCATTER => "the light of the hit is known".into(),
        SHADE => format!("{} lights considered so far", after.item.saturating_sub(LIGHTS_SUMMED)),
        _ => format!("a shadow ray to {}", light(after)),
    };
    (None, format!("{brought}; {next}"))
}

/// Which ray goes on, and which waits.
pub(super) fn of_scatter(data: &SceneData, before: &RayState, after: &RayState) -> (Option<u32>, String) {
    let [from, to] = [before, after].map(|ray| ray.bounce.unwrap_or_default());
    let ended = match before.triangle {
        None => "nothing was hit".into(),
        Some(triangle) => {
            let kind = match optics_of(data, triangle).kind {
                DIFFUSE => "diffuse",
                MIRROR => "a mirror",
                DIELECTRIC => "a dielectric",
                _ => "a transparent sheet",
            };
            let is_deepest = from.depth >= data.features.depth && kind != "diffuse";
            let why = if is_deepest { ", at the largest depth" } else { "" };
            format!("triangle {triangle} is {kind}{why}")
        }
    };
    if after.tag == DONE {
        return (None, format!("{ended}: no ray goes on; {}", rgb(after.color.unwrap_or_default())));
    }
    // What is sent on leaves the triangle that was hit, one deeper; a ray that waited, another or less deep.
    let is_child = to.waiting & !from.waiting != 0 || to.waiting == from.waiting;
    let what = match (is_child, to.waiting != from.waiting) {
        (true, true) => "a ray is reflected, and a refracted one waits",
        (true, false) => "a ray goes on",
        (false, _) => "no ray goes on: the ray that waits deepest is next",
    };
    let share = rgb(to.throughput);
    (None, format!("{ended}; {what}, at depth {} of {}, throughput {share}", to.depth, data.features.depth))
}
