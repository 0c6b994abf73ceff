//! The walk through the grid: its start, steps, skips over empty cells, and the paper's wrap over a face.

use super::super::states;
use super::listing;
use crate::numbers::real::Vec3;
use crate::program::RayState;
use crate::scene_data::SceneData;
use crate::shared::constants::INF;
use crate::shared::dda;
use crate::shared::grid_walk::{GridRay, smallest_axis};

const AXES: [&str; 3] = ["x", "y", "z"];

/// Where the walk starts.
pub(super) fn explain_start(data: &SceneData, after: &RayState) -> String {
    let robust = data.features.robust;
    if after.tag == states::BACKGROUND {
        let misses = "misses the grid's box";
        let outside = "starts outside of the grid, which the paper's rules do not handle";
        return if robust { misses } else { outside }.into();
    }
    // With the paper's rules, a ray's start is known only by its cell's 1-D index.
    let start = data.grid.enter(data.features.walk_rules(), &ray_of(data, after)).cell;
    let is_wrapped = !robust && !data.grid.is_in_grid(start) && data.grid.cell_index(start) == after.cell_index;
    let how = if is_wrapped { "starts outside of the grid, where the index is that of" } else { "starts in" };
    format!("{how} {}, {}", cell_name(data, after.cell_index), listing_of(data, after.cell_index))
}

/// A step to the next cell, or a skip over empty cells.
pub(super) fn explain_step(data: &SceneData, before: &RayState, after: &RayState) -> String {
    let distance = leap_from(data, before.cell_index);
    let how = if distance > 1 { leap(data, before, after, distance) } else { step(data, before, after) };
    match after.tag {
        states::BACKGROUND => format!("{how}; nothing hit"),
        states::SHADE => format!("{how}; the kept hit is the nearest"),
        states::ISECT_HIT => format!("{how}, {}; the hit is kept", listing_of(data, after.cell_index)),
        _ => format!("{how}, {}", listing_of(data, after.cell_index)),
    }
}

/// Most cells that a skip from this cell advances along an axis; 1 for a step.
pub(super) fn leap_from(data: &SceneData, cell: u32) -> i32 {
    data.empty_distance(cell).max(1)
}

/// A cell with its list, in words.
pub(super) fn cell_at(data: &SceneData, cell: u32) -> String {
    format!("{}, {}", cell_name(data, cell), listing_of(data, cell))
}

fn step(data: &SceneData, before: &RayState, after: &RayState) -> String {
    let ray = ray_of(data, before);
    let forward = forward(data, &ray);
    let (from, to) = (data.grid.cell_of_index(before.cell_index), data.grid.cell_of_index(after.cell_index));
    let smallest = first_of(match before.control {
        Some(control) => dda::crossed_axis(Vec3::from(control), ray.per_axis),
        None => smallest_axis(Vec3::from(before.tmax.map(|t| t.unwrap_or(INF)))),
    });
    let went = |axis: usize| {
        let mut next = from;
        next[axis] += forward[axis];
        next
    };
    let is_out = has_left(after);
    // If two are equal up to rounding, the cell tells which of them the device took.
    let axis = (0..3).find(|&axis| !is_out && forward[axis] != 0 && went(axis) == to).unwrap_or(smallest);
    let why = match before.control {
        Some(control) => why_by_control(control, &ray, axis, smallest),
        None => why_by_tmax(before.tmax, axis, smallest),
    };
    let Some(why) = why else {
        let stays = if is_out { "out of it".into() } else { format!("stays in {}", cell_name(data, after.cell_index)) };
        return format!("crosses no plane of the grid: {stays}");
    };
    let step = format!("{why}: step {}{}", sign(forward[axis]), AXES[axis]);
    if is_out {
        format!("{step}, out of the grid")
    } else if went(axis) == to {
        format!("{step} to {}", cell_name(data, after.cell_index))
    } else {
        format!("{step}, over the grid's face, where the index is that of {}", cell_name(data, after.cell_index))
    }
}

/// Why a step went along an axis; `None` if no axis is ever crossed. `smallest`: the axis that the host takes.
fn why_by_tmax(tmax: [Option<f32>; 3], axis: usize, smallest: usize) -> Option<String> {
    let (t, name) = (tmax[axis]?, AXES[axis]);
    Some(match tmax[smallest].filter(|_| axis != smallest) {
        Some(other) => format!("tmax.{name} {t} is smallest but for rounding, as is tmax.{} {other}", AXES[smallest]),
        None => {
            let equal = (0..3).find(|&other| other != axis && tmax[other] == Some(t));
            let too = equal.map_or_else(String::new, |other| format!(", as is tmax.{}", AXES[other]));
            format!("tmax.{name} {t} is smallest{too}")
        }
    })
}

/// The same for a 3D-DDA.
fn why_by_control(control: [f32; 3], ray: &GridRay<f32>, axis: usize, host: usize) -> Option<String> {
    let (driving, name) = (dda::driving_axis(ray.per_axis), AXES[axis]);
    let past: Vec<usize> = (0..3).filter(|&a| control[a] > 0.0).collect();
    let term = |a: usize| format!("control.{} {}", AXES[a], control[a]);
    Some(match past[..] {
        _ if axis != host => format!("{name} is next but for rounding, as is {}", AXES[host]),
        // With a term of 0, the ray goes through an edge of the cell.
        [] if axis == driving => format!("no control term is above 0, so {name}, the driving axis, is next"),
        [] => format!("{} is 0, a tie with {}, the driving axis", term(axis), AXES[driving]),
        [_] => format!("{} is above 0, so {name} is before {}, the driving axis", term(axis), AXES[driving]),
        [a, b, ..] => {
            format!("{} and {} are above 0, and by its slope {name} is first", term(a), term(b))
        }
    })
}

fn leap(data: &SceneData, before: &RayState, after: &RayState, distance: i32) -> String {
    let ray = ray_of(data, before);
    let forward = forward(data, &ray);
    let (from, to) = (data.grid.cell_of_index(before.cell_index), data.grid.cell_of_index(after.cell_index));
    let moved = [0, 1, 2].map(|axis| to[axis] - from[axis]);
    let last = [0, 1, 2].map(|axis| from[axis] + forward[axis] * (distance - 1));
    let exit = data.grid.cell_exit::<f32>(last, &ray);
    let is_out = has_left(after);
    // Along the axis by which the ray leaves the cube, and only there, it moves by the full distance.
    let left = (0..3).find(|&axis| !is_out && moved[axis] == forward[axis] * distance);
    let axis = left.unwrap_or_else(|| first_of(smallest_axis(exit)));
    let t = exit.to_array()[axis];
    let empty = match distance - 1 {
        1 => "empty for 1 cell around".into(),
        around => format!("empty for {around} cells around"),
    };
    if t >= INF {
        return format!("{empty}: crosses no plane of the grid: out of it");
    }
    let leaves = format!("leaving the empty ones through {}{} at t {t}", sign(forward[axis]), AXES[axis]);
    if is_out {
        return format!("{empty}: leaps out of the grid, {leaves}");
    }
    // Single steps would have entered this many cells in between.
    let passed = moved.iter().map(|n| n.abs()).sum::<i32>() - 1;
    let cells = if passed == 1 { "cell" } else { "cells" };
    let along = (0..3).filter(|&axis| moved[axis] != 0).map(|axis| format!("{} {:+}", AXES[axis], moved[axis]));
    let along = along.collect::<Vec<_>>().join(", ");
    let to = cell_name(data, after.cell_index);
    format!("{empty}: leaps by {along}, over {passed} empty {cells}, {leaves}, to {to}")
}

fn has_left(after: &RayState) -> bool {
    matches!(after.tag, states::BACKGROUND | states::SHADE)
}

fn ray_of(data: &SceneData, ray: &RayState) -> GridRay<f32> {
    let [origin, direction] = [ray.origin, ray.direction].map(Vec3::from_f32);
    data.grid.ray(data.features.walk_rules(), origin, direction)
}

/// Direction of the ray through the cells, per axis.
fn forward(data: &SceneData, ray: &GridRay<f32>) -> [i32; 3] {
    let direction = ray.direction.to_array();
    let robust = data.features.robust;
    let way = |axis: usize| match direction[axis] {
        d if d > 0.0 => 1,
        d if d < 0.0 || robust => -1,
        _ => 0,
    };
    [0, 1, 2].map(way)
}

fn sign(forward: i32) -> char {
    if forward < 0 { '-' } else { '+' }
}

fn first_of(axes: [bool; 3]) -> usize {
    axes.iter().position(|&is_it| is_it).unwrap_or(2)
}

fn cell_name(data: &SceneData, cell: u32) -> String {
    let [x, y, z] = data.grid.cell_of_index(cell);
    format!("cell ({x}, {y}, {z})")
}

fn listing_of(data: &SceneData, cell: u32) -> String {
    let cell = cell as usize;
    listing(match (data.grid_cells.get(cell), data.grid_cells.get(cell + 1)) {
        (Some(&first), Some(&end)) => end.saturating_sub(first) as usize,
        _ => 0,
    })
}
