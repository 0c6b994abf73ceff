//! Cuts convex polygons by axis-aligned planes, in f64.

use glam::{DVec3, Vec3A};

/// The part of `polygon` with `sign * point[axis] <= sign * at`; fewer than three corners if there is none. A polygon
/// that only touches the plane from the other side leaves its edge or corner.
pub(super) fn cut(polygon: &[DVec3], axis: usize, at: f64, sign: f64) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    let Some(&last) = polygon.last() else { return kept };
    let mut from = last;
    for &to in polygon {
        let (before, after) = (sign * (from[axis] - at), sign * (to[axis] - at));
        if before < 0.0 && after > 0.0 || before > 0.0 && after < 0.0 {
            let mut crossing = from + (to - from) * (before / (before - after));
            crossing[axis] = at;
            kept.push(crossing);
        }
        if after <= 0.0 {
            kept.push(to);
        }
        from = to;
    }
    kept
}

/// The part of a triangle inside a box.
pub(super) fn clip(corners: [Vec3A; 3], min: [f64; 3], max: [f64; 3]) -> Vec<DVec3> {
    let mut polygon: Vec<DVec3> = corners.iter().map(|c| c.as_dvec3()).collect();
    for axis in 0..3 {
        if polygon.iter().any(|p| p[axis] < min[axis]) {
            polygon = cut(&polygon, axis, min[axis], -1.0);
        }
        if polygon.iter().any(|p| p[axis] > max[axis]) {
            polygon = cut(&polygon, axis, max[axis], 1.0);
        }
    }
    polygon
}

/// The sum of its projected areas along x, y and z: the limit of the sum of half areas of its pieces' boxes as it is
/// cut ever finer.
pub(super) fn projected_area(polygon: &[DVec3]) -> f64 {
    let Some(&first) = polygon.first() else { return 0.0 };
    let doubled: DVec3 = polygon.windows(2).map(|edge| (edge[0] - first).cross(edge[1] - first)).sum();
    doubled.abs().element_sum() * 0.5
}

/// Whether the boxes cover the triangle: the part that each box leaves uncovered is passed on to the next.
pub(super) fn covered(corners: [Vec3A; 3], boxes: impl Iterator<Item = [[f64; 3]; 2]>) -> bool {
    let mut rest: Vec<Vec<DVec3>> = vec![corners.iter().map(|c| c.as_dvec3()).collect()];
    for [min, max] in boxes {
        let mut outside = Vec::new();
        for polygon in rest {
            let apart = (0..3).any(|a| polygon.iter().all(|p| p[a] < min[a]) || polygon.iter().all(|p| p[a] > max[a]));
            if apart {
                outside.push(polygon);
                continue;
            }
            let mut inside = polygon;
            for axis in 0..3 {
                for (at, sign) in [(min[axis], -1.0), (max[axis], 1.0)] {
                    if inside.iter().any(|p| sign * p[axis] > sign * at) {
                        outside.push(cut(&inside, axis, at, -sign));
                        inside = cut(&inside, axis, at, sign);
                    }
                }
            }
        }
        rest = outside;
    }
    rest.is_empty()
}
