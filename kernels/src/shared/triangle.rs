//! Twin of `triangle.wgsl`: tests a ray against a triangle.

use super::constants::{CORNER_ERROR, DEPTH_ERROR, EDGE_ERROR, END_ERROR, INF, MIN_NORMAL, PAPER_EPSILON, UNDERFLOW};
use super::vector::{cross3, dot3};
use crate::numbers::real::{Real, Vec3};

/// The result of one test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate<R> {
    /// Parameter of the hit point; meaningless without a hit.
    pub t: R,
    /// Weight of vertex 1.
    pub u: R,
    /// Weight of vertex 2.
    pub v: R,
    /// Whether the ray meets the triangle at `0 < t < INF`; with an exact order, whether it may.
    pub is_hit: bool,
    /// Whether it does for sure, at a t that is off by at most the error.
    pub is_sure: bool,
    /// With an exact order, a bound on the error of t.
    pub error: R,
}

/// A ray's direction in the form that the watertight test uses: z and the axis of its largest component change places,
/// and the axes are sheared so that it points along z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shear<R> {
    /// Slopes across the ray, negated, and 1 / largest component.
    x: R,
    y: R,
    z: R,
    /// The axis that changes places with z.
    axis: usize,
}

impl<R: Real> Candidate<R> {
    fn miss() -> Self {
        Self { t: R::zero(), u: R::zero(), v: R::zero(), is_hit: false, is_sure: false, error: R::zero() }
    }

    /// The candidate, which is a hit only between two t; neither end counts. With an exact order, it is the rounded exact t
    /// that has to lie there, so near an end a hit is not sure.
    #[must_use]
    #[inline]
    pub fn between(self, rules: TriangleRules, [t_min, t_max]: [R; 2]) -> Self {
        if !rules.exact_order {
            return Self { is_hit: self.is_hit && self.t > t_min && self.t < t_max, ..self };
        }
        let error = self.error + R::from_f32(END_ERROR) * self.t.abs() + R::from_f32(MIN_NORMAL);
        let [first, last] = [self.t - error, self.t + error];
        let is_hit = self.is_hit && last > t_min && first < t_max;
        Self { is_hit, is_sure: self.is_sure && first > t_min && last < t_max, ..self }
    }
}

impl<R: Real> Shear<R> {
    /// The shear for a direction.
    pub fn of(direction: Vec3<R>) -> Self {
        let magnitude = direction.abs();
        let x_largest = magnitude.x > magnitude.y && magnitude.x > magnitude.z;
        let y_largest = !x_largest && magnitude.y > magnitude.z;
        let axis = if x_largest {
            0
        } else if y_largest {
            1
        } else {
            2
        };
        let [x, y, z] = with_largest_last(direction, axis);
        Self { x: -(x / z), y: -(y / z), z: R::one() / z, axis }
    }

    /// The corners relative to the origin, their axes changed.
    #[inline(always)]
    fn seen(&self, origin: Vec3<R>, [a, b, c]: [Vec3<R>; 3]) -> [[R; 3]; 3] {
        let seen = |corner: Vec3<R>| with_largest_last(corner - origin, self.axis);
        [seen(a), seen(b), seen(c)]
    }

    /// Such a corner, projected across the ray.
    #[inline(always)]
    fn across<const CONTRACTED: bool>(&self, [x, y, z]: [R; 3]) -> [R; 2] {
        if CONTRACTED {
            return [z.fused(self.x, x), z.fused(self.y, y)];
        }
        [z * self.x + x, z * self.y + y]
    }
}

/// A vector whose z and component `axis` have changed places.
#[inline(always)]
fn with_largest_last<R: Real>(v: Vec3<R>, axis: usize) -> [R; 3] {
    let (is_x, is_y) = (axis == 0, axis == 1);
    let last = if is_y { v.y } else { v.z };
    [if is_x { v.z } else { v.x }, if is_y { v.z } else { v.y }, if is_x { v.x } else { last }]
}

/// The rules of the triangle test.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct TriangleRules {
    /// [`watertight`], else [`moller_trumbore`].
    pub watertight: bool,
    /// With an explicit fma for every product that is added to something, as a compiler may contract.
    pub contracted: bool,
    /// With bounds on all errors, see [`bounded`].
    pub exact_order: bool,
}

/// Tests a triangle by the rules of a run; `shear` belongs to the direction.
#[inline(always)]
pub fn hit_triangle<R: Real>(
    rules: TriangleRules,
    origin: Vec3<R>,
    direction: Vec3<R>,
    shear: &Shear<R>,
    corners: [Vec3<R>; 3],
) -> Candidate<R> {
    match rules {
        TriangleRules { exact_order: true, contracted: false, .. } => bounded::<R, false>(origin, shear, corners),
        TriangleRules { exact_order: true, contracted: true, .. } => bounded::<R, true>(origin, shear, corners),
        TriangleRules { watertight: true, contracted: false, .. } => watertight::<R, false>(origin, shear, corners),
        TriangleRules { watertight: true, contracted: true, .. } => watertight::<R, true>(origin, shear, corners),
        TriangleRules { watertight: false, .. } => moller_trumbore(origin, direction, corners),
    }
}

/// The same projection and edge functions as in [`watertight`], with bounds on all of their errors: what they cannot tell
/// for sure is left to [integers](super::exact).
#[inline(always)]
pub fn bounded<R: Real, const CONTRACTED: bool>(
    origin: Vec3<R>,
    shear: &Shear<R>,
    corners: [Vec3<R>; 3],
) -> Candidate<R> {
    // In f64, errors are as much smaller as its unit is.
    let unit = R::from_f64(R::UNIT_ROUNDOFF * f64::from(1 << 24));
    let errors = [EDGE_ERROR, CORNER_ERROR, DEPTH_ERROR].map(|error| R::from_f32(error) * unit);
    bounded_by::<R, CONTRACTED>(errors, origin, shear, corners)
}

/// The same with these bounds: of an edge function, of a sheared corner, and of t.
#[inline(always)]
fn bounded_by<R: Real, const CONTRACTED: bool>(
    [edge, corner, depth]: [R; 3],
    origin: Vec3<R>,
    shear: &Shear<R>,
    corners: [Vec3<R>; 3],
) -> Candidate<R> {
    let seen = shear.seen(origin, corners);
    let [p, q, r] = [0, 1, 2].map(|corner: usize| shear.across::<CONTRACTED>(seen[corner]));
    let minus = |x: R, y: R, other: R| if CONTRACTED { x.fused(y, -other) } else { x * y - other };
    let weights = [minus(q[0], r[1], q[1] * r[0]), minus(r[0], p[1], r[1] * p[0]), minus(p[0], q[1], p[1] * q[0])];

    let underflow = R::from_f32(UNDERFLOW);
    let least = weights[0].min(weights[1]).min(weights[2]);
    let most = weights[0].max(weights[1]).max(weights[2]);
    let wide = |axis: usize| p[axis].abs().max(q[axis].abs()).max(r[axis].abs());
    let m = wide(0).max(wide(1));
    let reach = seen[0][2].abs().max(seen[1][2].abs()).max(seen[2][2].abs()) + m;
    let bound = edge * reach * (corner * reach + m) + underflow;
    if least < -bound && most > bound {
        return Candidate::miss();
    }
    let det = weights[0] + weights[1] + weights[2];
    let on_plane = on_plane::<R, CONTRACTED>(shear, seen, weights);
    let z = [seen[0][2] * shear.z, seen[1][2] * shear.z, seen[2][2] * shear.z];
    let (near, far) = (z[0].min(z[1]).min(z[2]), z[0].max(z[1]).max(z[2]));
    let two = R::from_f32(2.0);
    let half = R::from_f32(0.5);
    let Candidate { mut u, mut v, .. } = on_plane;
    let (t, moved) = if det.abs() < R::from_f32(8.0) * bound {
        // Weights may be nothing but rounding here, or not even numbers; others begin rays there.
        if !(u.min(v) >= R::zero() && u + v <= R::one()) {
            (u, v) = (R::from_f32(1.0 / 3.0), R::from_f32(1.0 / 3.0));
        }
        (half * (far + near), half * (far - near))
    } else {
        let off = |z: R| (z - on_plane.t).abs();
        (on_plane.t, two * bound * (off(z[0]) + off(z[1]) + off(z[2])) * (R::one() / det).abs())
    };
    let error = moved + (depth * near.abs().max(far.abs()) + underflow);
    let is_sure = (least > bound || most < -bound) && t > error;
    Candidate { t, u, v, error, is_sure, is_hit: t > -error && t < R::from_f32(INF) }
}

/// Woop, Benthin and Wald (2013): no ray passes between two triangles that share an edge.
#[inline(always)]
pub fn watertight<R: Real, const CONTRACTED: bool>(
    origin: Vec3<R>,
    shear: &Shear<R>,
    corners: [Vec3<R>; 3],
) -> Candidate<R> {
    let seen = shear.seen(origin, corners);
    let (weights, is_inside) = weights::<R, CONTRACTED>(shear, seen);
    if !is_inside {
        return Candidate::miss();
    }
    let on_plane = on_plane::<R, CONTRACTED>(shear, seen, weights);
    let det = weights[0] + weights[1] + weights[2];
    let is_hit = det != R::zero() && on_plane.t > R::zero() && on_plane.t < R::from_f32(INF);
    Candidate { is_hit, ..on_plane }
}

/// Where the ray meets the triangle's plane, inside the triangle or not: explains why [`watertight`] missed.
pub fn plane_hit<R: Real>(origin: Vec3<R>, shear: &Shear<R>, corners: [Vec3<R>; 3]) -> Candidate<R> {
    let seen = shear.seen(origin, corners);
    on_plane::<R, false>(shear, seen, weights::<R, false>(shear, seen).0)
}

/// The corners' weights, not yet divided by their sum, and whether all have the same sign.
#[inline(always)]
fn weights<R: Real, const CONTRACTED: bool>(shear: &Shear<R>, [a, b, c]: [[R; 3]; 3]) -> ([R; 3], bool) {
    let [p, q, r] = [shear.across::<CONTRACTED>(a), shear.across::<CONTRACTED>(b), shear.across::<CONTRACTED>(c)];
    let qr = q[0] * r[1];
    let rq = q[1] * r[0];
    let rp = r[0] * p[1];
    let pr = r[1] * p[0];
    let pq = p[0] * q[1];
    let qp = p[1] * q[0];
    let front = qr >= rq && rp >= pr && pq >= qp;
    let back = qr <= rq && rp <= pr && pq <= qp;
    let minus = |x: R, y: R, product: R, other: R| if CONTRACTED { x.fused(y, -other) } else { product - other };
    let weights = [minus(q[0], r[1], qr, rq), minus(r[0], p[1], rp, pr), minus(p[0], q[1], pq, qp)];
    if !(front || back) {
        return (weights, false);
    }
    if qr == rq || rp == pr || pq == qp { on_edges([p, q, r], weights) } else { (weights, true) }
}

/// The same for a ray on an edge, as far as f32's products tell.
#[cold]
fn on_edges<R: Real>([p, q, r]: [[R; 2]; 3], mut weights: [R; 3]) -> ([R; 3], bool) {
    let (mut tail, mut head) = (q, r);
    for (edge, next) in [p, q, r].into_iter().enumerate() {
        if tail[0] * head[1] == tail[1] * head[0] {
            weights[edge] = R::below_rounding([tail[0], head[1]], [tail[1], head[0]]);
        }
        (tail, head) = (head, next);
    }
    let (one, other) = (weights.iter().any(|w| *w < R::zero()), weights.iter().any(|w| *w > R::zero()));
    (weights, !(one && other))
}

#[inline(always)]
fn on_plane<R: Real, const CONTRACTED: bool>(
    shear: &Shear<R>,
    corners: [[R; 3]; 3],
    [a, b, c]: [R; 3],
) -> Candidate<R> {
    let inverse = R::one() / (a + b + c);
    // Depths, in units of t.
    let [p, q, r] = corners.map(|[_, _, depth]| depth * shear.z);
    // Divided first: a weight times a depth is a cubed length, which underflows long before either factor does.
    let [w, u, v] = [a * inverse, b * inverse, c * inverse];
    let t = if CONTRACTED { w.fused(p, u.fused(q, v * r)) } else { w * p + (u * q + v * r) };
    Candidate { t, u, v, ..Candidate::miss() }
}

/// Möller and Trumbore (1997), as published, with its threshold on the determinant.
pub fn moller_trumbore<R: Real>(origin: Vec3<R>, direction: Vec3<R>, [a, b, c]: [Vec3<R>; 3]) -> Candidate<R> {
    let edge1 = b - a;
    let edge2 = c - a;
    let p = cross3(direction, edge2);
    let det = dot3(edge1, p);
    let inverse = R::one() / det;
    let s = origin - a;
    let u = dot3(s, p) * inverse;
    let q = cross3(s, edge1);
    let v = dot3(direction, q) * inverse;
    let t = dot3(edge2, q) * inverse;
    let (zero, one) = (R::zero(), R::one());
    let is_hit =
        det.abs() >= R::from_f32(PAPER_EPSILON) && u >= zero && u <= one && v >= zero && v <= one - u && t > zero;
    Candidate { t, u, v, is_hit, ..Candidate::miss() }
}

/// Orders hits: nearer first, then by smaller triangle id.
pub fn is_nearer<R: Real>(t: R, triangle: u32, nearest_t: R, nearest_triangle: u32) -> bool {
    t < nearest_t || (t == nearest_t && triangle < nearest_triangle)
}

#[cfg(test)]
mod tests;
