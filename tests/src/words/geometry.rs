//! Rays, planes and triangles in f64, with f32's error bounds.

use raystep_kernels::export::trace::RayState;
use raystep_kernels::scene_data::SceneData;

/// Half a unit in the last place of 1, in f32.
pub(super) const U: f64 = 1.0 / (1u64 << 24) as f64;

pub(super) type V = [f64; 3];

pub(super) fn sub(a: V, b: V) -> V {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn length(a: V) -> f64 {
    dot(a, a).sqrt()
}

/// The ray, exactly as in f32.
pub(super) fn ray(state: &RayState) -> (V, V) {
    (state.origin.map(f64::from), state.direction.map(f64::from))
}

/// t at which a ray meets a plane perpendicular to an axis, and f32's error bound: the plane's two roundings, the
/// difference's, the inverse's and the product's, with a safety factor of two.
pub(super) fn plane_t((o, d): (V, V), axis: usize, corner: f64, at: f64) -> (f64, f64) {
    let t = (at - o[axis]) / d[axis];
    let bound = 4.0 * U * ((at.abs() + corner.abs() + o[axis].abs()) / d[axis].abs() + t.abs());
    (t, bound)
}

/// The point where a ray meets a triangle's plane.
pub(super) struct OnPlane {
    /// t of the point.
    pub(super) t: f64,
    /// Weights of vertices 1, 2 and 0.
    pub(super) weights: V,
    /// Möller and Trumbore's determinant.
    pub(super) det: f64,
    /// f32's error bounds: of a weight, of t, and of the determinant.
    pub(super) bounds: V,
}

/// Computed in f64, by Cramer's rule.
pub(super) fn on_plane(data: &SceneData, (o, d): (V, V), triangle: u32) -> OnPlane {
    let first = 9 * triangle as usize;
    let v = &data.vertices[first..first + 9];
    let corner = |c: usize| [0, 1, 2].map(|a| f64::from(v[3 * c + a]));
    let (a, b, c) = (corner(0), corner(1), corner(2));
    let (e1, e2, s) = (sub(b, a), sub(c, a), sub(o, a));
    let p = cross(d, e2);
    let det = dot(e1, p);
    let q = cross(s, e1);
    let (u, v, t) = (dot(s, p) / det, dot(d, q) / det, dot(e2, q) / det);
    // A dozen roundings of products of distances to vertices, or of edges, divided by the smallest divisor.
    let reach = [a, b, c].map(|corner| length(sub(corner, o))).into_iter().fold(0.0, f64::max);
    let edges = length(e1).max(length(e2)).max(reach);
    let weight = 64.0 * U * reach * edges * length(d) / det.abs() + 16.0 * U;
    let depth = reach / length(d);
    let weights = [u, v, 1.0 - u - v];
    let largest = weights.iter().fold(1.0, |m: f64, w| m.max(w.abs()));
    let bounds =
        [weight * largest, 4.0 * weight * depth * largest + 64.0 * U * depth, 16.0 * U * length(d) * edges * edges];
    OnPlane { t, weights, det, bounds }
}

/// The interval of t in which a ray is inside a box enlarged by `by` on all sides; `None` if it misses the box.
pub(super) fn interval((o, d): (V, V), min: V, max: V, by: f64) -> Option<[f64; 2]> {
    let mut t = [f64::NEG_INFINITY, f64::INFINITY];
    for axis in 0..3 {
        let (low, high) = (min[axis] - by, max[axis] + by);
        if d[axis] == 0.0 {
            if o[axis] < low || o[axis] > high {
                return None;
            }
            continue;
        }
        let (a, b) = ((low - o[axis]) / d[axis], (high - o[axis]) / d[axis]);
        t = [t[0].max(a.min(b)), t[1].min(a.max(b))];
    }
    (t[0] <= t[1]).then_some(t)
}
