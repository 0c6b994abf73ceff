//! Explains what a pass of the program's own kernels did to a ray from the camera.

use super::look_up::BY_GATHERING;
use crate::program::RayState;
use crate::programs::closest_hit::states::{DONE, GATHER, GATHERED, OCCLUDED, VISIBLE};
use crate::programs::path::explain::{emitter, why_ended};
use crate::scene_data::SceneData;

fn rgb(v: [f32; 3]) -> String {
    format!("r {:.3} g {:.3} b {:.3}", v[0], v[1], v[2])
}

/// What the shadow ray or photons brought, and what is next.
pub(super) fn of_look_up(data: &SceneData, before: &RayState, after: &RayState) -> (Option<u32>, String) {
    let brought = match before.tag {
        OCCLUDED => {
            let by = before.triangle.map_or_else(String::new, |triangle| format!(" by triangle {triangle}"));
            format!("{} is occluded{by}; ", emitter(before))
        }
        VISIBLE => format!("{} is visible: adds {}; ", emitter(before), rgb(before.pending.unwrap_or_default())),
        GATHERED => "adds the light that photons bring; ".into(),
        _ => String::new(),
    };
    let bounce = after.bounce.unwrap_or_default();
    let next = match (after.tag, bounce.ended) {
        (GATHER, _) => "looks for photons near the hit".into(),
        (DONE, BY_GATHERING) => format!("the pixel is done; {}", rgb(after.color.unwrap_or_default())),
        (DONE, why) => format!("the ray ends: {}; {}", why_ended(why), rgb(after.color.unwrap_or_default())),
        _ => format!("goes on at depth {} of {}, by a mirror or glass", bounce.depth, data.features.depth),
    };
    (None, format!("{brought}{next}"))
}

/// Whether the search goes on.
pub(super) fn of_gather(_: &SceneData, _: &RayState, after: &RayState) -> (Option<u32>, String) {
    let what = match after.tag {
        GATHERED => "no cell is left that is near enough",
        _ => "looked at photons of a cell",
    };
    (None, what.into())
}
