//! Explains what a pass of the program's own kernels did.

use super::scattered::{BY_ABSORPTION, BY_DEPTH, BY_ESCAPE, BY_ROULETTE, BY_SURFACE};
use crate::program::RayState;
use crate::programs::closest_hit::states::{BACKGROUND, DONE, OCCLUDED, SHADOW_SETUP, VISIBLE};
use crate::scene_data::SceneData;
use crate::shared::emitters::PUNCTUAL;

fn rgb(v: [f32; 3]) -> String {
    format!("r {:.3} g {:.3} b {:.3}", v[0], v[1], v[2])
}

/// What a shadow ray leads to.
pub(in crate::programs) fn emitter(ray: &RayState) -> String {
    match ray.light.unwrap_or_default() {
        id if id & PUNCTUAL != 0 => format!("light {}", (id ^ PUNCTUAL) + 1),
        id => format!("glowing triangle {id}"),
    }
}

/// Why a path ended, in words.
pub(in crate::programs) fn why_ended(why: u32) -> &'static str {
    match why {
        BY_ESCAPE => "nothing was hit",
        BY_DEPTH => "it has as many bounces as it may have",
        BY_ABSORPTION => "the surface reflects nothing",
        BY_SURFACE => "the direction leads below the triangle",
        BY_ROULETTE => "by chance, as it carries little",
        _ => "",
    }
}

/// What the surface emits, and to what a shadow ray is cast.
pub(super) fn of_sample_light(_: &SceneData, before: &RayState, after: &RayState) -> (Option<u32>, String) {
    let at = match (before.tag, before.triangle) {
        (BACKGROUND, _) | (_, None) => "nothing was hit: the background".into(),
        (_, Some(triangle)) => format!("at triangle {triangle}"),
    };
    let next = match after.tag {
        SHADOW_SETUP => format!(
            "a shadow ray to {}, by which {} arrives if nothing is in its way",
            emitter(after),
            rgb(after.pending.unwrap_or_default())
        ),
        _ => "no shadow ray".into(),
    };
    (None, format!("{at}; {next}"))
}

/// What the shadow ray brought, and where the path goes on or why it ended.
pub(super) fn of_sample_bsdf(data: &SceneData, before: &RayState, after: &RayState) -> (Option<u32>, String) {
    let brought = match before.tag {
        OCCLUDED => {
            let by = before.triangle.map_or_else(String::new, |triangle| format!(" by triangle {triangle}"));
            format!("{} is occluded{by}; ", emitter(before))
        }
        VISIBLE => format!("{} is visible: adds {}; ", emitter(before), rgb(before.pending.unwrap_or_default())),
        _ => String::new(),
    };
    let bounce = after.bounce.unwrap_or_default();
    let next = match (after.tag, bounce.ended) {
        (DONE, why) => format!("the path ends: {}; {}", why_ended(why), rgb(after.color.unwrap_or_default())),
        _ => {
            let how = match bounce.pdf {
                0.0 => "by a mirror or glass".into(),
                pdf => format!("pdf {pdf:.4}"),
            };
            let (depth, most) = (bounce.depth, data.features.depth);
            format!("goes on at depth {depth} of {most}, {how}, throughput {}", rgb(bounce.throughput))
        }
    };
    (None, format!("{brought}{next}"))
}

/// Why the path ended, and what it brought.
pub(super) fn of_fused_path(_: &SceneData, _: &RayState, after: &RayState) -> (Option<u32>, String) {
    let why = why_ended(after.bounce.unwrap_or_default().ended);
    (None, format!("the path ends: {why}; {}", rgb(after.color.unwrap_or_default())))
}
