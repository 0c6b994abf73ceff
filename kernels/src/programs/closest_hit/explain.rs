//! Explains why a pass left a ray as it did. Whatever the streams before and after the pass tell is taken from them;
//! what they do not keep, such as the t of a missed triangle or of a skip, is computed again on the host by the
//! kernels' own functions. Where the device rounds differently from the host, the explanation follows the device.

mod grid;
mod irregular;
mod test;
mod tree;

use super::states;
use crate::options::features::StructureKind;
use crate::program::RayState;
use crate::scene_data::SceneData;
use crate::shared::constants::{LIGHTS_SUMMED, NO_TRIANGLE, NODES_A_STEP};
use crate::tables::state::StateRole;
use grid::{cell_at, explain_start, explain_step};
pub(super) use test::explain_intersect as of_intersect;
pub(super) use test::tested;
use tree::explain_node;

/// The triangle that a pass tested, if any, and why the pass left the ray as it did.
pub(super) type Why = (Option<u32>, String);

pub(super) fn of_generate(data: &SceneData, before: &RayState, _: &RayState) -> Why {
    let why = match data.features.samples {
        true => format!("sample {}: a ray through its place in the pixel", before.samples.unwrap_or_default() + 1),
        false => "a ray through the pixel's centre".into(),
    };
    (None, why)
}

pub(super) fn of_accumulate(data: &SceneData, _: &RayState, after: &RayState) -> Why {
    let samples = after.samples.unwrap_or_default();
    let next = if states::STATES.role(after.tag) == Some(StateRole::Finished) {
        "the picture has it"
    } else {
        "on to the next sample"
    };
    (None, format!("mean of {samples} of {} samples: {next}", data.sampling.samples))
}

pub(super) fn of_shade(data: &SceneData, before: &RayState, after: &RayState) -> Why {
    if after.tag == states::SHADE {
        let summed = after.item.saturating_sub(LIGHTS_SUMMED);
        let triangle = before.triangle.unwrap_or(NO_TRIANGLE);
        let lights = data.shading.lights;
        return (None, format!("equation (1) at triangle {triangle}: {summed} of {lights} lights summed so far"));
    }
    let rgb = after.color.unwrap_or_default();
    let source = match before.triangle.filter(|_| before.tag == states::SHADE) {
        Some(triangle) => format!("equation (1) at triangle {triangle}"),
        None => "nothing was hit: background".into(),
    };
    (None, format!("{source}: r {:.3} g {:.3} b {:.3}", rgb[0], rgb[1], rgb[2]))
}

pub(super) fn of_fused(_: &SceneData, _: &RayState, _: &RayState) -> Why {
    (None, "the whole walk in one kernel".into())
}

pub(super) fn of_decide(_: &SceneData, _: &RayState, _: &RayState) -> Why {
    (None, "the whole walk again, in integers where f32 cannot tell what is hit".into())
}

pub(super) fn of_setup(data: &SceneData, _: &RayState, after: &RayState) -> Why {
    (None, explain_setup(data, after))
}

pub(super) fn of_traverse_grid(data: &SceneData, before: &RayState, after: &RayState) -> Why {
    (None, explain_step(data, before, after))
}

pub(super) fn of_traverse_irregular(data: &SceneData, before: &RayState, after: &RayState) -> Why {
    (None, irregular::explain_step(data, before, after))
}

pub(super) fn of_traverse_bvh(data: &SceneData, before: &RayState, after: &RayState) -> Why {
    (None, explain_node(data, before, after))
}

pub(super) fn of_walk(data: &SceneData, before: &RayState, after: &RayState) -> Why {
    (None, explain_walk(data, before, after))
}

pub(super) fn of_count(_: &SceneData, _: &RayState, _: &RayState) -> Why {
    (None, String::new())
}

fn explain_setup(data: &SceneData, after: &RayState) -> String {
    match data.features.structure() {
        StructureKind::Grid => explain_start(data, after),
        StructureKind::Irregular => irregular::explain_start(data, after),
        _ if data.info.triangles == 0 => "no triangles: there is nothing to hit".into(),
        StructureKind::Bvh => format!("starts at the root of {} nodes", data.bvh_nodes.len()),
        StructureKind::None => format!("no grid: all {} triangles are tested", data.info.triangles),
    }
}

fn explain_walk(data: &SceneData, before: &RayState, after: &RayState) -> String {
    let (features, structure) = (&data.features, data.features.structure());
    let steps = data.info.steps;
    let most = match structure {
        StructureKind::Grid if features.skip => format!("up to {steps} steps or leaps"),
        StructureKind::Grid | StructureKind::Irregular => format!("up to {steps} steps"),
        StructureKind::Bvh => format!("up to {} nodes", u64::from(NODES_A_STEP) * u64::from(steps)),
        StructureKind::None => format!("up to {steps} triangles"),
    };
    let next = match after.tag {
        states::BACKGROUND => "over, nothing hit".into(),
        states::SHADE if features.any_hit => "over, any hit ends the ray".into(),
        states::SHADE => "over, the nearest hit is found".into(),
        _ => match structure {
            StructureKind::Grid => format!("now in {}", cell_at(data, after.cell_index)),
            StructureKind::Irregular => format!("now in {}", irregular::cell_at(data, after.cell_index)),
            StructureKind::Bvh => format!("now at node {}", after.cell_index),
            StructureKind::None => format!("{} of {} triangles tested", after.item, data.info.triangles),
        },
    };
    let found = match (after.triangle, after.t) {
        (Some(triangle), Some(t)) if has_new_hit(before, after) => {
            let nearer = if before.triangle.is_some() { "nearer " } else { "" };
            format!("; a {nearer}hit of triangle {triangle} at t {t}")
        }
        _ => String::new(),
    };
    format!("{most}: {next}{found}")
}

/// Whether the pass accepted a hit. A different triangle at the same t counts too: hits are ordered by (t, triangle).
fn has_new_hit(before: &RayState, after: &RayState) -> bool {
    (before.triangle, before.t) != (after.triangle, after.t)
}

/// Describes a list by its number of triangles, to follow the name of its cell or leaf.
fn listing(count: usize) -> String {
    match count {
        0 => "which is empty".into(),
        1 => "which lists 1 triangle".into(),
        _ => format!("which lists {count} triangles"),
    }
}
