// One ray against one triangle.
//
// watertight: Woop, Benthin and Wald (2013), without their fall-back to double precision. What is on
// an edge is decided by comparing the two products of the edge function: rounding is monotone, so
// where they differ the comparison is exact for the sheared corners, and a shared edge gives both of
// its triangles the same two products in opposite roles. Equal products count as inside for both.
//
// moller_trumbore: Möller and Trumbore (1997) as published, the paper's test.

import package::constants::{INF, PAPER_EPSILON};
import package::vector::{dot3, cross3};

struct Candidate {
    t: f32,
    // Weights of vertices 1 and 2.
    u: f32,
    v: f32,
    is_hit: bool,
}

// A ray's direction as the watertight test uses it: the axes are rotated so that its largest component
// becomes z, and sheared so that it points along z. Three rows, each with a 1 and a 0 or with two zeros, so
// that their products with a corner round as little as the rotated corner's would, whatever the order.
struct Shear {
    x: vec3f,
    y: vec3f,
    z: vec3f,
}

fn shear_of(direction: vec3f) -> Shear {
    let magnitude = abs(direction);
    let x_last = magnitude.x > magnitude.y && magnitude.x > magnitude.z;
    let y_last = !x_last && magnitude.y > magnitude.z;
    let d = select(select(direction, direction.zxy, y_last), direction.yzx, x_last);
    let x = vec3f(1.0, 0.0, -(d.x / d.z));
    let y = vec3f(0.0, 1.0, -(d.y / d.z));
    let z = vec3f(0.0, 0.0, 1.0 / d.z);
    return Shear(
        select(select(x, x.yzx, y_last), x.zxy, x_last),
        select(select(y, y.yzx, y_last), y.zxy, x_last),
        select(select(z, z.yzx, y_last), z.zxy, x_last),
    );
}

fn hit_triangle(origin: vec3f, direction: vec3f, shear: Shear, a: vec3f, b: vec3f, c: vec3f) -> Candidate {
    @if(robust) return watertight(origin, shear, a, b, c);
    @else return moller_trumbore(origin, direction, a, b, c);
}

// A corner relative to the origin, as seen across the ray.
fn across(corner: vec3f, s: Shear) -> vec2f {
    return vec2f(
        corner.x * s.x.x + corner.y * s.x.y + corner.z * s.x.z,
        corner.x * s.y.x + corner.y * s.y.y + corner.z * s.y.z,
    );
}

// The same along the ray, in units of t.
fn along(corner: vec3f, s: Shear) -> f32 {
    return corner.x * s.z.x + corner.y * s.z.y + corner.z * s.z.z;
}

fn watertight(origin: vec3f, shear: Shear, a: vec3f, b: vec3f, c: vec3f) -> Candidate {
    let oa = a - origin;
    let ob = b - origin;
    let oc = c - origin;
    let p = across(oa, shear);
    let q = across(ob, shear);
    let r = across(oc, shear);

    let qr = q.x * r.y;
    let rq = q.y * r.x;
    let rp = r.x * p.y;
    let pr = r.y * p.x;
    let pq = p.x * q.y;
    let qp = p.y * q.x;
    let front = qr >= rq && rp >= pr && pq >= qp;
    let back = qr <= rq && rp <= pr && pq <= qp;
    if (!(front || back)) {
        return Candidate(0.0, 0.0, 0.0, false);
    }
    let weight_a = qr - rq;
    let weight_b = rp - pr;
    let weight_c = pq - qp;
    let det = weight_a + weight_b + weight_c;
    let inverse = 1.0 / det;
    // Divided first: a weight times a depth is a length cubed, which underflows long before either does.
    let w = weight_a * inverse;
    let u = weight_b * inverse;
    let v = weight_c * inverse;
    let t = w * along(oa, shear) + u * along(ob, shear) + v * along(oc, shear);
    return Candidate(t, u, v, det != 0.0 && t > 0.0 && t < INF);
}

fn moller_trumbore(origin: vec3f, direction: vec3f, a: vec3f, b: vec3f, c: vec3f) -> Candidate {
    let edge1 = b - a;
    let edge2 = c - a;
    let p = cross3(direction, edge2);
    let det = dot3(edge1, p);
    let inverse = 1.0 / det;
    let s = origin - a;
    let u = dot3(s, p) * inverse;
    let q = cross3(s, edge1);
    let v = dot3(direction, q) * inverse;
    let t = dot3(edge2, q) * inverse;
    // Published as u + v <= 1, which a compiler may turn into (a + b) * inverse <= 1: Mesa's does.
    let is_hit = abs(det) >= PAPER_EPSILON && u >= 0.0 && u <= 1.0 && v >= 0.0 && v <= 1.0 - u && t > 0.0;
    return Candidate(t, u, v, is_hit);
}

// The order of hits: nearer first, then the smaller triangle id, so that the order in which triangles
// are tested does not show.
fn is_nearer(t: f32, triangle: u32, nearest_t: f32, nearest_triangle: u32) -> bool {
    return t < nearest_t || (t == nearest_t && triangle < nearest_triangle);
}
