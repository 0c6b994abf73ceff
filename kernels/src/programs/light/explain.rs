//! Explains what a pass of the program's own kernel did.

use crate::program::RayState;
use crate::programs::closest_hit::states::{BACKGROUND, DONE, OCCLUDED, SHADE, VISIBLE};
use crate::scene_data::SceneData;
use crate::shared::constants::LIGHTS_SUMMED;

/// What the shadow ray before brought, and what is next.
pub(super) fn of_illuminate(data: &SceneData, before: &RayState, after: &RayState) -> (Option<u32>, String) {
    let lights = data.shading.lights;
    let light = |ray: &RayState| ray.light.map_or_else(String::new, |light| format!("light {light} of {lights}"));
    let rgb = |v: [f32; 3]| format!("r {:.3} g {:.3} b {:.3}", v[0], v[1], v[2]);
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
        SHADE => format!("{} lights considered so far", after.item.saturating_sub(LIGHTS_SUMMED)),
        _ => format!("a shadow ray to {}", light(after)),
    };
    (None, format!("{brought}; {next}"))
}
