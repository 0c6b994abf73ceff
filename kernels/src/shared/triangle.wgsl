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
// becomes z, and sheared so that it points along z.
struct Shear {
    // The largest component is x, or y.
    x_last: bool,
    y_last: bool,
    // Across per along, and 1 / along.
    shear: vec3f,
}

fn shear_of(direction: vec3f) -> Shear {
    let magnitude = abs(direction);
    let x_last = magnitude.x > magnitude.y && magnitude.x > magnitude.z;
    let y_last = !x_last && magnitude.y > magnitude.z;
    let d = rotated(direction, x_last, y_last);
    return Shear(x_last, y_last, vec3f(d.x / d.z, d.y / d.z, 1.0 / d.z));
}

fn rotated(v: vec3f, x_last: bool, y_last: bool) -> vec3f {
    return select(select(v, v.zxy, y_last), v.yzx, x_last);
}

fn hit_triangle(origin: vec3f, direction: vec3f, shear: Shear, a: vec3f, b: vec3f, c: vec3f) -> Candidate {
    @if(robust) return watertight(origin, shear, a, b, c);
    @else return moller_trumbore(origin, direction, a, b, c);
}

// A corner as seen along the ray: x and y across it, z along it in units of t.
fn sheared(corner: vec3f, s: Shear) -> vec3f {
    let p = rotated(corner, s.x_last, s.y_last);
    return vec3f(p.x - s.shear.x * p.z, p.y - s.shear.y * p.z, s.shear.z * p.z);
}

fn watertight(origin: vec3f, shear: Shear, a: vec3f, b: vec3f, c: vec3f) -> Candidate {
    let p = sheared(a - origin, shear);
    let q = sheared(b - origin, shear);
    let r = sheared(c - origin, shear);

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
    let inverse = 1.0 / det;
    let t = (weight_a * p.z + weight_b * q.z + weight_c * r.z) * inverse;
    let is_hit = (front || back) && det != 0.0 && t > 0.0 && t < INF;
    return Candidate(t, weight_b * inverse, weight_c * inverse, is_hit);
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
