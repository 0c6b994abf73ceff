//! Twin of `triangle.wgsl`: one ray against one triangle.

use super::constants::{INF, PAPER_EPSILON};
use super::vector::{cross3, dot3};
use crate::real::{Real, Vec3};

/// The result of one test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate<R> {
    /// Parameter of the hit point; meaningless without a hit.
    pub t: R,
    /// Weight of vertex 1.
    pub u: R,
    /// Weight of vertex 2.
    pub v: R,
    /// Whether the ray meets the triangle at `0 < t < INF`.
    pub is_hit: bool,
}

/// A ray's direction as the watertight test uses it: the axes are rotated so that its largest component
/// becomes z, and sheared so that it points along z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shear<R> {
    x_last: bool,
    y_last: bool,
    /// Across per along, and 1 / along.
    shear: Vec3<R>,
}

impl<R: Real> Shear<R> {
    /// Of a direction.
    pub fn of(direction: Vec3<R>) -> Self {
        let magnitude = direction.abs();
        let x_last = magnitude.x > magnitude.y && magnitude.x > magnitude.z;
        let y_last = !x_last && magnitude.y > magnitude.z;
        let d = rotated(direction, x_last, y_last);
        Self { x_last, y_last, shear: Vec3::new(d.x / d.z, d.y / d.z, R::one() / d.z) }
    }

    /// A corner as seen along the ray: x and y across it, z along it in units of t.
    fn of_corner(&self, corner: Vec3<R>) -> Vec3<R> {
        let (p, s) = (rotated(corner, self.x_last, self.y_last), self.shear);
        Vec3::new(p.x - s.x * p.z, p.y - s.y * p.z, s.z * p.z)
    }
}

fn rotated<R: Real>(v: Vec3<R>, x_last: bool, y_last: bool) -> Vec3<R> {
    if x_last {
        Vec3::new(v.y, v.z, v.x)
    } else if y_last {
        Vec3::new(v.z, v.x, v.y)
    } else {
        v
    }
}

/// Tests by the rules of `--numerics`; `shear` is the direction's.
pub fn hit_triangle<R: Real>(
    robust: bool,
    origin: Vec3<R>,
    direction: Vec3<R>,
    shear: &Shear<R>,
    corners: [Vec3<R>; 3],
) -> Candidate<R> {
    if robust { watertight(origin, shear, corners) } else { moller_trumbore(origin, direction, corners) }
}

/// Woop, Benthin and Wald (2013): no ray passes between two triangles that share an edge.
pub fn watertight<R: Real>(origin: Vec3<R>, shear: &Shear<R>, [a, b, c]: [Vec3<R>; 3]) -> Candidate<R> {
    let p = shear.of_corner(a - origin);
    let q = shear.of_corner(b - origin);
    let r = shear.of_corner(c - origin);

    let qr = q.x * r.y;
    let rq = q.y * r.x;
    let rp = r.x * p.y;
    let pr = r.y * p.x;
    let pq = p.x * q.y;
    let qp = p.y * q.x;
    let front = qr >= rq && rp >= pr && pq >= qp;
    let back = qr <= rq && rp <= pr && pq <= qp;

    let weight_a = qr - rq;
    let weight_b = rp - pr;
    let weight_c = pq - qp;
    let det = weight_a + weight_b + weight_c;
    let inverse = R::one() / det;
    let t = (weight_a * p.z + weight_b * q.z + weight_c * r.z) * inverse;
    let is_hit = (front || back) && det != R::zero() && t > R::zero() && t < R::from_f32(INF);
    Candidate { t, u: weight_b * inverse, v: weight_c * inverse, is_hit }
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
    Candidate { t, u, v, is_hit }
}

/// The order of hits: nearer first, then the smaller triangle id.
pub fn is_nearer<R: Real>(t: R, triangle: u32, nearest_t: R, nearest_triangle: u32) -> bool {
    t < nearest_t || (t == nearest_t && triangle < nearest_triangle)
}
