//! The test of a triangle, and what follows when a list ends.

use super::super::states;
use super::grid::leap_from;
use super::has_new_hit;
use crate::numbers::real::Vec3;
use crate::program::RayState;
use crate::scene_data::SceneData;
use crate::shared::constants::{INF, PAPER_EPSILON};
use crate::shared::triangle::{Candidate, Shear, hit_triangle, plane_hit};
use crate::shared::vector::{cross3, dot3};

/// The triangle that a pass tested, if any.
pub(in super::super) fn tested(data: &SceneData, before: &RayState, after: &RayState) -> Option<u32> {
    candidate(data, before).filter(|_| !is_looked_for(before, after))
}

/// The next triangle of the ray's list.
fn candidate(data: &SceneData, before: &RayState) -> Option<u32> {
    let (first, count) = data.list(before.cell_index);
    (before.item < count).then(|| data.listed(first + before.item))
}

/// Whether the search for an earlier test of the triangle goes on in the next pass.
fn is_looked_for(before: &RayState, after: &RayState) -> bool {
    after.item == before.item && after.tag == before.tag
}

/// The triangle that was tested, its result, and where the ray continues.
pub(in super::super) fn explain_intersect(
    data: &SceneData,
    before: &RayState,
    after: &RayState,
) -> (Option<u32>, String) {
    let (_, count) = data.list(before.cell_index);
    let tested = candidate(data, before);
    if let Some(triangle) = tested.filter(|_| is_looked_for(before, after)) {
        return (None, format!("triangle {triangle}: looked for in the cells before this one, not all of them yet"));
    }
    let is_still_here = matches!(after.tag, states::ISECT_HIT | states::ISECT_NO_HIT);
    let next = (!is_still_here).then(|| explain_end(data, before, after, tested, count));
    let test = tested.map(|triangle| explain_test(data, before, after, triangle));
    (tested, test.into_iter().chain(next).collect::<Vec<_>>().join("; "))
}

/// What follows when the list or the ray ends.
fn explain_end(data: &SceneData, before: &RayState, after: &RayState, tested: Option<u32>, count: u32) -> String {
    let features = &data.features;
    let has_cells = features.structure().has_cells();
    let exit = before.tmax.iter().flatten().fold(INF, |m, &t| m.min(t));
    let t = after.t.unwrap_or(INF);
    let ended = match tested {
        None if count == 0 && has_cells => "empty cell",
        None if count == 0 => "no triangles",
        Some(_) if !has_cells => "last triangle",
        _ => "list ended",
    };
    let on = if leap_from(data, before.cell_index) > 1 { "on past empty cells" } else { "on to the next cell" };
    match after.tag {
        states::TRAV if features.bvh => "the leaf is done".into(),
        states::SHADE if features.any_hit => "any hit ends the ray".into(),
        states::SHADE if !has_cells => format!("{ended}: the nearest hit is accepted"),
        states::SHADE if features.in_cell => format!("{ended} with a hit: accepted"),
        states::SHADE => format!("{ended}: t {t} <= exit {exit}, accepted"),
        states::BACKGROUND if has_cells && ray_end(before).is_some_and(|end| end <= exit) => {
            format!("{ended}: the ray ends at t {} <= exit {exit}, nothing hit", ray_end(before).unwrap_or(t))
        }
        states::BACKGROUND if has_cells => format!("{ended}: the ray ends at t {t} <= exit {exit}, nothing hit"),
        states::BACKGROUND => format!("{ended}: nothing hit"),
        _ if after.triangle.is_some() => format!("{ended}: t {t} is beyond the exit {exit}, kept; {on}"),
        _ => format!("{ended}: {on}"),
    }
}

fn explain_test(data: &SceneData, before: &RayState, after: &RayState, triangle: u32) -> String {
    if let (true, Some(t), Some([u, v])) = (has_new_hit(before, after), after.t, after.barycentric) {
        return format!("triangle {triangle}: hit at t {t}, u {u}, v {v}");
    }
    if before.surface == Some(triangle) {
        return format!("triangle {triangle}: the one that the ray leaves");
    }
    let [o, d] = [before.origin, before.direction].map(Vec3::<f32>::from_f32);
    let (rules, shear, corners) = (data.features.triangle_rules(), Shear::of(d), data.corners(triangle));
    let candidate = hit_triangle::<f32>(rules, o, d, &shear, corners);
    let why = if candidate.is_hit {
        explain_refused(data, before, triangle, candidate.t)
    } else if rules.watertight {
        explain_missed(&plane_hit(o, &shear, corners), None)
    } else {
        let [a, b, c] = corners;
        explain_missed(&candidate, Some(dot3(b - a, cross3(d, c - a))))
    };
    format!("triangle {triangle}: {why}")
}

/// The t at which a ray with an interval ends.
fn ray_end(ray: &RayState) -> Option<f32> {
    ray.interval.map(|[_, t_max]| t_max)
}

/// Why a hit found by the host does not count.
fn explain_refused(data: &SceneData, before: &RayState, triangle: u32, t: f32) -> String {
    if let Some([t_min, _]) = before.interval.filter(|[t_min, _]| t <= *t_min) {
        return format!("hit at t {t}, before the ray's t_min {t_min}");
    }
    match before.t.or_else(|| ray_end(before)) {
        Some(nearest) if before.triangle == Some(triangle) => format!("tested again, the same hit at t {nearest}"),
        Some(end) if t >= end && before.triangle.is_none() => format!("hit at t {t}, beyond the ray's end {end}"),
        Some(nearest) if t >= nearest => format!("hit at t {t}, not nearer than {nearest}"),
        _ if data.features.in_cell => format!("hit at t {t}, but outside of this cell"),
        // The device's own rounding decided.
        _ => "missed by less than a rounding".into(),
    }
}

/// Why it is no hit, judged by where the ray meets the triangle's plane, and for Möller and Trumbore's test by the
/// determinant.
fn explain_missed(c: &Candidate<f32>, determinant: Option<f32>) -> String {
    if !(c.u.is_finite() && c.v.is_finite()) {
        return "seen edge-on".into();
    }
    let weights = [("u", c.u), ("v", c.v), ("1 - u - v", 1.0 - c.u - c.v)];
    let (name, smallest) = weights.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or(weights[0]);
    if smallest < 0.0 {
        format!("{name} = {smallest}, outside")
    } else if c.t <= 0.0 {
        format!("t {}, behind the origin", c.t)
    } else {
        match determinant.filter(|d| d.abs() < PAPER_EPSILON) {
            Some(small) => format!("determinant {small} is below {PAPER_EPSILON}, taken as edge-on"),
            None => "outside by less than a rounding".into(),
        }
    }
}
