//! Twin of `start.wgsl`: where a ray begins that leaves a surface, and where a ray to a light ends.

use crate::numbers::real::{Real, Vec3};
use crate::shared::vector::{cross3, dot3, largest3, unit3};

/// Half the distance between 1 and the next larger f32, whatever the twin computes in: what it bounds is what a GPU does.
const ROUNDOFF: f32 = 1.0 / (1u32 << 24) as f32;
/// Roundings of a point's products and sums, and of t, each of the size of the triangle.
const OF_TRIANGLE: f32 = 8.0;
/// Roundings of the size of the point itself: of its sum, and of the step off the surface.
const OF_POINT: f32 = 2.0;
/// Roundings at the end of a ray, each of the size of the scene or of the light's position.
const OF_END: f32 = 16.0;

/// A point of a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Start<R> {
    /// The point.
    pub point: Vec3<R>,
    /// Across the triangle, to the side from which it is seen; length 1.
    pub normal: Vec3<R>,
    /// It is seen from behind: its corners are clockwise.
    pub is_back: bool,
    /// A ray that begins this far off the triangle is on the side where it is meant to be.
    pub distance: R,
}

/// A weight that keeps a point off an edge.
fn off_edge<R: Real>(weight: R, least: R) -> R {
    let third = R::one() / R::from_f32(3.0);
    weight.max(if least < third { least } else { third })
}

fn largest<R: Real>(a: Vec3<R>, b: Vec3<R>) -> Vec3<R> {
    Vec3::new(a.x.max(b.x), a.y.max(b.y), a.z.max(b.z))
}

/// The point with these weights of vertices 1 and 2, seen along a direction. It lies within the triangle, off the edges by its bound: a point on an
/// edge could be rounded to the other side of a surface that begins there.
pub fn start_of<R: Real>([a, b, c]: [Vec3<R>; 3], [u, v]: [R; 2], seen_along: Vec3<R>) -> Start<R> {
    let ab = b - a;
    let ac = c - a;
    let bc = c - b;
    let normal = unit3(cross3(unit3(ab), unit3(ac)));
    let is_back = dot3(normal, seen_along) > R::zero();
    let normal = if is_back { -normal } else { normal };
    let extent = largest3(largest(largest(ab.abs(), ac.abs()), bc.abs()));
    let size = largest3(largest(largest(a.abs(), b.abs()), c.abs()));
    let bound = extent * R::from_f32(OF_TRIANGLE * ROUNDOFF) + size * R::from_f32(OF_POINT * ROUNDOFF);
    let distance = bound * dot3(normal.abs(), Vec3::splat(R::one()));

    // An edge's height is twice the area by its length.
    let across = cross3(ab, ac);
    let reach = R::from_f32(2.0) * bound / dot3(across, across).sqrt();
    let from_a = off_edge(R::one() - u - v, reach * dot3(bc, bc).sqrt());
    let from_b = off_edge(u, reach * dot3(ac, ac).sqrt());
    let from_c = off_edge(v, reach * dot3(ab, ab).sqrt());
    let sum = from_a + from_b + from_c;
    Start { point: a + (ab * (from_b / sum) + ac * (from_c / sum)), normal, is_back, distance }
}

/// A normal on the side from which the point is seen.
pub fn on_side<R: Real>(start: &Start<R>, normal: Vec3<R>) -> Vec3<R> {
    if dot3(normal, start.normal) < R::zero() { -normal } else { normal }
}

/// The origin of a ray that leaves the surface on that side.
pub fn leaving<R: Real>(start: &Start<R>) -> Vec3<R> {
    start.point + start.normal * start.distance
}

/// The origin of a ray that goes through the surface.
pub fn through<R: Real>(start: &Start<R>) -> Vec3<R> {
    start.point - start.normal * start.distance
}

/// The t at which a ray ends whose direction leads to a light at t = 1: before the light, by what rounding can be wrong
/// about a surface there.
pub fn end_before<R: Real>(light: Vec3<R>, direction: Vec3<R>) -> R {
    let bound = R::from_f32(OF_END * ROUNDOFF) * (R::one() + largest3(light.abs()));
    R::one() - (bound / largest3(direction.abs())).min(R::one())
}
