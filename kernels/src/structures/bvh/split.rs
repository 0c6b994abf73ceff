//! Cuts large oblique triangles before the tree is built: a box around a long diagonal is mostly empty.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec3;
use obvhs::aabb::Aabb;

use super::polygon::{clip, cut, projected_area};
use super::references::{References, corners};
use super::{down, up};
use crate::numbers::parallel::map_ranges;

/// Boxes smaller than this many times the mean are not cut: there are enough of them already.
const LARGE: f64 = 3.0;

/// After a cut, the two boxes together must have at most this share of the original box's area.
const WORTHWHILE: f64 = 0.7;

/// Most successive cuts: at most 64 pieces per triangle.
const LEVELS: u8 = 6;

/// Cuts triangles in halves, those with the most empty space first, until there are `share` additional references per
/// triangle or no cut is worthwhile.
pub(super) fn split(vertices: &[f32], references: &mut References, share: f64) {
    let count = references.boxes.len();
    let most = count + (count as f64 * share.clamp(0.0, 1.0)) as usize;
    if most == count {
        return;
    }
    let sums = map_ranges(count, 1 << 16, |range| {
        references.boxes[range].iter().map(|b| f64::from(b.half_area())).sum::<f64>()
    });
    let large = LARGE * sums.iter().sum::<f64>() / count as f64;
    // The heap orders by bits, which works for positive floats.
    let key = |waste: f64| (waste as f32).max(0.0).to_bits();
    let mut heap: BinaryHeap<(u32, Reverse<u32>, u8)> = BinaryHeap::new();
    for (i, bounds) in references.boxes.iter().enumerate() {
        if f64::from(bounds.half_area()) > large {
            let polygon = corners(vertices, i as u32).map(|c| c.as_dvec3());
            let waste = f64::from(bounds.half_area()) - projected_area(&polygon);
            heap.push((key(waste), Reverse(i as u32), 0));
        }
    }
    while let Some((_, Reverse(reference), level)) = heap.pop() {
        if references.boxes.len() == most {
            break;
        }
        let triangle = references.triangles[reference as usize];
        let bounds = references.boxes[reference as usize];
        let Some(halves) = halves(vertices, triangle, &bounds) else { continue };
        let places = [reference, references.boxes.len() as u32];
        references.boxes[reference as usize] = halves[0].0;
        references.boxes.push(halves[1].0);
        references.triangles.push(triangle);
        for (place, (bounds, waste)) in places.into_iter().zip(halves) {
            if level + 1 < LEVELS && f64::from(bounds.half_area()) > large {
                heap.push((key(waste), Reverse(place), level + 1));
            }
        }
    }
}

/// The boxes of the two halves of a piece, cut in the middle of its box's longest side, and the empty part of their
/// half areas. `None` if the cut is not worthwhile.
fn halves(vertices: &[f32], triangle: u32, bounds: &Aabb) -> Option<[(Aabb, f64); 2]> {
    let corners = corners(vertices, triangle);
    let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
    let axis = bounds.largest_axis();
    let at = f64::from(((min[axis] + max[axis]) * 0.5) as f32);
    // Many times the rounding error of f64 in the intersections; the corners of the boxes are moved outwards by this
    // much.
    let largest = corners.iter().fold(0.0f32, |m, c| m.max(c.abs().max_element()));
    let slack = f64::from(largest) * 2.0f64.powi(-46);
    let polygon = clip(corners, min.to_array(), max.to_array());
    let half = |sign: f64| {
        let half = cut(&polygon, axis, at, sign);
        let (low, high) = half.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
        if half.len() < 3 {
            return None;
        }
        let low = (low - slack).to_array().map(down);
        let high = (high + slack).to_array().map(up);
        // A piece is bounded by its own box and by the plane.
        let mut bounds = Aabb::new(bounds.min.max(low.into()), bounds.max.min(high.into()));
        if sign > 0.0 {
            bounds.max[axis] = bounds.max[axis].min(at as f32);
        } else {
            bounds.min[axis] = bounds.min[axis].max(at as f32);
        }
        let waste = f64::from(bounds.half_area()) - projected_area(&half);
        bounds.valid().then_some((bounds, waste))
    };
    let (below, above) = (half(1.0)?, half(-1.0)?);
    let areas = f64::from(below.0.half_area()) + f64::from(above.0.half_area());
    (areas < WORTHWHILE * f64::from(bounds.half_area())).then_some([below, above])
}
