//! The walk through the irregular grid: its start, and steps from box to box.

use super::super::states;
use super::listing;
use crate::program::RayState;
use crate::scene_data::SceneData;
use crate::shared::constants::INF;

const AXES: [&str; 3] = ["x", "y", "z"];

/// Where the walk starts.
pub(super) fn explain_start(data: &SceneData, after: &RayState) -> String {
    if after.tag == states::BACKGROUND {
        return "misses the grid's box".into();
    }
    format!("starts in {}", cell_at(data, after.cell_index))
}

/// The step from the space around the grid into it.
fn explain_entry(data: &SceneData, before: &RayState, after: &RayState) -> String {
    match (after.tag, before.tmax[0]) {
        (states::BACKGROUND, _) => "misses the grid's box; nothing hit".into(),
        (states::SHADE, _) => "misses the grid's box; the kept hit is the nearest".into(),
        (_, t) => {
            let kept = if after.tag == states::ISECT_HIT { "; the hit is kept" } else { "" };
            format!("enters the grid at t {}, in {}{kept}", t.unwrap_or(0.0), cell_at(data, after.cell_index))
        }
    }
}

/// A step to the next cell. The face by which the ray leaves is the one that it reaches first.
pub(super) fn explain_step(data: &SceneData, before: &RayState, after: &RayState) -> String {
    if data.is_outside(before.cell_index) {
        return explain_entry(data, before, after);
    }
    let exits = before.tmax.map(|t| t.unwrap_or(INF));
    let axis = (1..3).fold(0, |best: usize, axis| if exits[axis] < exits[best] { axis } else { best });
    let way = match before.tmax[axis] {
        Some(t) => {
            let sign = if before.direction[axis] < 0.0 { '-' } else { '+' };
            format!("tmax.{name} {t} is smallest: leaves the box by its face {sign}{name}", name = AXES[axis])
        }
        None => "crosses no plane of the grid".into(),
    };
    match after.tag {
        states::BACKGROUND => format!("{way}, out of the grid; nothing hit"),
        states::SHADE => format!("{way}, out of the grid; the kept hit is the nearest"),
        states::ISECT_HIT => format!("{way}, to {}; the hit is kept", cell_at(data, after.cell_index)),
        _ => format!("{way}, to {}", cell_at(data, after.cell_index)),
    }
}

/// A cell with its size in virtual cells and its list, in words.
pub(super) fn cell_at(data: &SceneData, cell: u32) -> String {
    let Some([low, high]) = data.irregular_cells.get(cell as usize).map(|cell| cell.corners()) else {
        return format!("cell {cell}, which does not exist");
    };
    let listed = listing(data.list(cell).1 as usize);
    if data.is_outside(cell) {
        return format!("the space around the grid, {listed}");
    }
    let [x, y, z] = [0, 1, 2].map(|axis| high[axis] - low[axis]);
    format!("cell {cell} of {x} x {y} x {z} voxels, {listed}")
}
