//! Explains what a pass of the program's own kernels did to a ray from the camera, or to a photon.

use super::look_up::BY_GATHERING;
use super::reflected::is_diffuse;
use super::stored::{cell_around, radius};
use crate::program::RayState;
use crate::program::ray_state::{Gather, Photon};
use crate::programs::closest_hit::states::{DONE, GATHER, GATHERED, OCCLUDED, PHOTON_LEAVES, VISIBLE};
use crate::programs::path::explain::{emitter, why_ended};
use crate::programs::path::scattered::BY_ROULETTE;
use crate::scene_data::SceneData;

/// What a pass tested and why, as a row of a history has it.
type Explained = (Option<u32>, String);

fn rgb(v: [f32; 3]) -> String {
    format!("r {:.3} g {:.3} b {:.3}", v[0], v[1], v[2])
}

/// The power of a photon, one of many: a small number.
fn watts([r, g, b]: [f32; 3]) -> String {
    format!("r {r:.3e} g {g:.3e} b {b:.3e}")
}

/// What the shadow ray or photons brought, and what is next.
pub(super) fn of_look_up(data: &SceneData, before: &RayState, after: &RayState) -> Explained {
    let brought = match before.tag {
        OCCLUDED => {
            let by = before.triangle.map_or_else(String::new, |triangle| format!(" by triangle {triangle}"));
            format!("{} is occluded{by}; ", emitter(before))
        }
        VISIBLE => format!("{} is visible: adds {}; ", emitter(before), rgb(before.pending.unwrap_or_default())),
        GATHERED => format!("adds {} by {}; ", gained(before, after), found(data, &before.gather.unwrap_or_default())),
        _ => String::new(),
    };
    let bounce = after.bounce.unwrap_or_default();
    let next = match (after.tag, bounce.ended) {
        (GATHER, _) => {
            let gather = after.gather.unwrap_or_default();
            format!("looks for photons{} near the hit, none farther away than {}", of_map(&gather), gather.limit)
        }
        (DONE, BY_GATHERING) => format!("the pixel is done; {}", rgb(after.color.unwrap_or_default())),
        (DONE, why) => format!("the ray ends: {}; {}", why_ended(why), rgb(after.color.unwrap_or_default())),
        _ => format!("goes on at depth {} of {}", bounce.depth, data.features.depth),
    };
    (None, format!("{brought}{next}"))
}

/// The light that a pass added to the pixel.
fn gained(before: &RayState, after: &RayState) -> String {
    let sum = |ray: &RayState| ray.color.unwrap_or_else(|| ray.bounce.unwrap_or_default().radiance);
    let [before, now] = [before, after].map(sum);
    rgb([0, 1, 2].map(|part| now[part] - before[part]))
}

fn of_map(gather: &Gather) -> &'static str {
    if gather.is_caustic { " of the caustic map" } else { "" }
}

/// What a search found, and within which distance of the hit.
fn found(data: &SceneData, gather: &Gather) -> String {
    let within = radius(data, gather);
    format!("{}{}, none farther away than {within}", counted(gather.found), of_map(gather))
}

fn counted(photons: u32) -> String {
    format!("{photons} photon{}", if photons == 1 { "" } else { "s" })
}

/// Which cell was searched, how many of its photons, and what was found so far; or why the search is over.
pub(super) fn of_gather(data: &SceneData, before: &RayState, after: &RayState) -> Explained {
    let (was, now) = (before.gather.unwrap_or_default(), after.gather.unwrap_or_default());
    let text = match (after.tag, cell_around(data, after)) {
        (GATHERED, _) => format!("no cell is left that is near enough: {}", found(data, &now)),
        (_, Some([x, y, z])) => {
            let goes_on = was.around == now.around && was.item < was.end;
            let from = if goes_on { format!("from {} ", was.item) } else { String::new() };
            format!(
                "cell ({x}, {y}, {z}) of the map: looked at sorted photons {from}to {} of those before {}, took {}; {}",
                now.item,
                now.end,
                now.found.saturating_sub(was.found),
                match now.found {
                    0 => "none so far".into(),
                    so_far => format!("{so_far} so far, none farther away than {}", now.farthest),
                }
            )
        }
        _ => format!(
            "{} found, {} wanted: searches again, for those not farther away than {}",
            counted(was.found),
            data.photon_map.nearest,
            now.limit
        ),
    };
    (None, text)
}

/// Where a photon begins.
pub(super) fn of_emit_photons(data: &SceneData, _: &RayState, after: &RayState) -> Explained {
    let Photon { power, leaves, .. } = after.photon.unwrap_or_default();
    let by = match leaves {
        Some(triangle) => format!("glowing triangle {triangle}"),
        None if data.lights.len() == 1 => "light 1".into(),
        None => "a light".into(),
    };
    (None, format!("emitted by {by}, carries {}", watts(power)))
}

/// Where a photon is stored, and whether it goes on.
pub(super) fn of_scatter_photons(data: &SceneData, before: &RayState, after: &RayState) -> Explained {
    let (was, now) = (before.photon.unwrap_or_default(), after.photon.unwrap_or_default());
    let is_new = |after: u32, before: u32| after & !before != 0;
    let at = before.triangle.map_or_else(String::new, |triangle| format!("at triangle {triangle}; "));
    let stored = match before.triangle {
        _ if is_new(now.stored_caustic, was.stored_caustic) => "stored in the caustic map; ",
        _ if is_new(now.stored, was.stored) => "stored in the map; ",
        Some(triangle) if !is_diffuse(data, triangle) => "not stored on a mirror or glass; ",
        Some(_) if was.hits == 0 => "not stored, as shadow rays find the light that comes straight from an emitter; ",
        _ => "",
    };
    let next = match (before.tag, now.ended) {
        (PHOTON_LEAVES, _) => format!("leaves the scene with {}", watts(was.power)),
        (_, 0) => format!("bounce {} of {}, carries {}", now.hits, data.features.depth, watts(now.power)),
        (_, BY_ROULETTE) => "ends: absorbed, by chance".into(),
        (_, why) => format!("ends: {}", why_ended(why)),
    };
    (None, format!("{at}{stored}{next}"))
}
