// Where a ray begins that leaves a surface, and where a ray to a light ends, without an epsilon: as far off as rounding can
// be wrong about the point, and about t in the test of the triangle. The idea is that of Pharr, Jakob and Humphreys (2016,
// 3.9.5), who bound another expression for the point, and leave the test's own error to their intersector.

import package::vector::{cross3, dot3, largest3, unit3};

// Half the distance between 1 and the next larger f32.
const ROUNDOFF: f32 = 0x1p-24f;
// Roundings of a point's products and sums, and of t, each of the size of the triangle.
const OF_TRIANGLE: f32 = 8.0;
// Roundings of the size of the point itself: of its sum, and of the step off the surface.
const OF_POINT: f32 = 2.0;
// Roundings at the end of a ray, each of the size of the scene or of the light's position.
const OF_END: f32 = 16.0;

// A point of a triangle.
struct Start {
    point: vec3f,
    // Across the triangle, to the side from which it is seen; length 1.
    normal: vec3f,
    // It is seen from behind: its corners are clockwise.
    is_back: bool,
    // A ray that begins this far off the triangle is on the side where it is meant to be.
    distance: f32,
}

// A weight that keeps a point off an edge.
fn off_edge(weight: f32, least: f32) -> f32 {
    return max(weight, select(1.0 / 3.0, least, least < 1.0 / 3.0));
}

// The point with these weights of vertices 1 and 2, seen along a direction. It lies within the triangle, off the edges by its bound: a point on an
// edge could be rounded to the other side of a surface that begins there.
fn start_of(a: vec3f, b: vec3f, c: vec3f, u: f32, v: f32, seen_along: vec3f) -> Start {
    let ab = b - a;
    let ac = c - a;
    let bc = c - b;
    var start: Start;
    let normal = unit3(cross3(unit3(ab), unit3(ac)));
    start.is_back = dot3(normal, seen_along) > 0.0;
    start.normal = select(normal, -normal, start.is_back);
    let extent = largest3(max(max(abs(ab), abs(ac)), abs(bc)));
    let size = largest3(max(max(abs(a), abs(b)), abs(c)));
    let bound = extent * (OF_TRIANGLE * ROUNDOFF) + size * (OF_POINT * ROUNDOFF);
    start.distance = bound * dot3(abs(start.normal), vec3f(1.0));

    // An edge's height is twice the area by its length.
    let across = cross3(ab, ac);
    let reach = 2.0 * bound / sqrt(dot3(across, across));
    let from_a = off_edge(1.0 - u - v, reach * sqrt(dot3(bc, bc)));
    let from_b = off_edge(u, reach * sqrt(dot3(ac, ac)));
    let from_c = off_edge(v, reach * sqrt(dot3(ab, ab)));
    let sum = from_a + from_b + from_c;
    start.point = a + (ab * (from_b / sum) + ac * (from_c / sum));
    return start;
}

// A normal on the side from which the point is seen.
fn on_side(start: Start, normal: vec3f) -> vec3f {
    return select(normal, -normal, dot3(normal, start.normal) < 0.0);
}

// The origin of a ray that leaves the surface on that side.
fn leaving(start: Start) -> vec3f {
    return start.point + start.normal * start.distance;
}

// The origin of a ray that goes through the surface.
fn through(start: Start) -> vec3f {
    return start.point - start.normal * start.distance;
}

// The t at which a ray ends whose direction leads to a light at t = 1: before the light, by what rounding can be wrong
// about a surface there.
fn end_before(light: vec3f, direction: vec3f) -> f32 {
    let bound = OF_END * ROUNDOFF * (1.0 + largest3(abs(light)));
    return 1.0 - min(bound / largest3(abs(direction)), 1.0);
}
