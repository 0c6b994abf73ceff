// Tests a ray against a triangle.
//
// watertight: Woop, Benthin and Wald (2013). Which side of an edge the ray is on is decided by comparing the two
// products of the edge function: rounding is monotone, so if they differ the comparison is exact for the sheared
// corners, and a shared edge gives both of its triangles the same two products in opposite roles. If they are equal,
// integers decide instead of the double precision of the paper. A ray exactly on an edge is inside both triangles.
//
// contracted: the same with an explicit fma for every product that is added to something, as a compiler may contract.
//
// exact_order: what f32 cannot tell for sure is left to integers (exact.wgsl). The same sheared corners and edge functions,
// with bounds on all of their errors: the ray misses for sure, hits for sure, or may hit.
//
// moller_trumbore: Möller and Trumbore (1997) as published, the paper's test.

import package::constants::{INF, MIN_NORMAL, PAPER_EPSILON, EDGE_ERROR, CORNER_ERROR, DEPTH_ERROR, END_ERROR, UNDERFLOW};
import package::vector::{dot3, cross3, smallest3, largest3};

struct Candidate {
    t: f32,
    // Weights of vertices 1 and 2.
    u: f32,
    v: f32,
    // exact_order: it may be one.
    is_hit: bool,
    // The ray hits the triangle at a t that is off by at most the error.
    @if(exact_order) is_sure: bool,
    @if(exact_order) error: f32,
}

// A ray's direction in the form that the watertight test uses: z and the axis of its largest component change places,
// and the axes are sheared so that it points along z. The paper rotates them; places changed take fewer selections, and
// four registers here take less time than the nine of rows to multiply by.
struct Shear {
    // Slopes across the ray, negated, and 1 / largest component.
    x: f32,
    y: f32,
    z: f32,
    // The axis that changes places with z.
    axis: u32,
}

fn shear_of(direction: vec3f) -> Shear {
    let magnitude = abs(direction);
    let x_largest = magnitude.x > magnitude.y && magnitude.x > magnitude.z;
    let y_largest = !x_largest && magnitude.y > magnitude.z;
    let axis = select(select(2u, 1u, y_largest), 0u, x_largest);
    let d = with_largest_last(direction, axis);
    return Shear(-(d.x / d.z), -(d.y / d.z), 1.0 / d.z, axis);
}

// A vector whose z and component `axis` have changed places.
fn with_largest_last(v: vec3f, axis: u32) -> vec3f {
    return vec3f(
        select(v.x, v.z, axis == 0u),
        select(v.y, v.z, axis == 1u),
        select(select(v.z, v.y, axis == 1u), v.x, axis == 0u),
    );
}

fn hit_triangle(origin: vec3f, direction: vec3f, shear: Shear, a: vec3f, b: vec3f, c: vec3f) -> Candidate {
    @if(exact_order) return bounded(origin, shear, a, b, c);
    @else @if(watertight) return watertight(origin, shear, a, b, c);
    @else return moller_trumbore(origin, direction, a, b, c);
}

// The candidate, which is a hit only between two t; neither end counts. With an exact order, it is the rounded exact t that has
// to lie there, so near an end a hit is not sure.
@if(intervals)
fn between(candidate: Candidate, interval: vec2f) -> Candidate {
    var found = candidate;
    @if(exact_order) {
        let error = candidate.error + END_ERROR * abs(candidate.t) + MIN_NORMAL;
        found.is_hit = candidate.is_hit && candidate.t + error > interval.x && candidate.t - error < interval.y;
        found.is_sure = candidate.is_sure && candidate.t - error > interval.x && candidate.t + error < interval.y;
    }
    @else found.is_hit = candidate.is_hit && candidate.t > interval.x && candidate.t < interval.y;
    return found;
}

// a b + c
fn times_plus(a: f32, b: f32, c: f32) -> f32 {
    @if(contracted) return fma(a, b, c);
    @else return a * b + c;
}

// A corner relative to the origin, its axes changed as above, projected across the ray.
fn across(corner: vec3f, s: Shear) -> vec2f {
    return vec2f(times_plus(corner.z, s.x, corner.x), times_plus(corner.z, s.y, corner.y));
}

// 2^exponent, for exponents of -126 to 127.
fn power_of_two(exponent: i32) -> f32 {
    return bitcast<f32>(u32(exponent + 127) << 23u);
}

// a b - c d for two products that round to the same f32. They differ by less than 2^25 units in the last place of the
// exact products, so the low 32 bits of these tell by how much. 0 if they are too small to be rounded alike.
fn below_rounding(a: f32, b: f32, c: f32, d: f32) -> f32 {
    let bits = bitcast<vec4u>(vec4f(a, b, c, d));
    let exponents = vec4i((bits >> vec4u(23u)) & vec4u(0xffu));
    if (abs(a * b) < MIN_NORMAL || any(exponents == vec4i(0))) {
        return 0.0;
    }
    let digits = (bits & vec4u(0x7fffffu)) | vec4u(0x800000u);
    let ab = exponents.x + exponents.y;
    let cd = exponents.z + exponents.w;
    let last = min(ab, cd);
    let difference = bitcast<i32>(((digits.x * digits.y) << u32(ab - last)) - ((digits.z * digits.w) << u32(cd - last)));
    let magnitude = select(difference, -difference, ((bits.x ^ bits.y) >> 31u) == 1u);
    // The exponents are 127 too large each, and the digits 2^23 times; in two steps, as 2^-172 is not an f32.
    let exponent = last - 300;
    let half = exponent / 2;
    return f32(magnitude) * power_of_two(half) * power_of_two(exponent - half);
}

// With u = 2^-24 (see docs/numerics.md): m is the largest sheared coordinate, r the largest depth. A sheared coordinate is
// off by at most 8 u r + 2 u m, and an edge function by 32 u r m + 12 u m^2 + 2 (8 u r + 2 u m)^2, which is less than
// 34 u (r + m) (m + 4 u (r + m)); what underflows is below 2^-120. t, a mean of the depths with the edge functions as
// weights, moves by 2 sum |z - t| / |det| of that if det is at least 8 times as large, and by 30 u of the largest depth
// in its own arithmetic; else it lies somewhere between the depths.
@if(exact_order)
fn bounded(origin: vec3f, shear: Shear, a: vec3f, b: vec3f, c: vec3f) -> Candidate {
    let oa = with_largest_last(a - origin, shear.axis);
    let ob = with_largest_last(b - origin, shear.axis);
    let oc = with_largest_last(c - origin, shear.axis);
    let p = across(oa, shear);
    let q = across(ob, shear);
    let r = across(oc, shear);
    let weight_a = times_plus(q.x, r.y, -(q.y * r.x));
    let weight_b = times_plus(r.x, p.y, -(r.y * p.x));
    let weight_c = times_plus(p.x, q.y, -(p.y * q.x));

    let widest = max(max(abs(p), abs(q)), abs(r));
    let m = max(widest.x, widest.y);
    let reach = largest3(abs(vec3f(oa.z, ob.z, oc.z))) + m;
    let bound = EDGE_ERROR * reach * (CORNER_ERROR * reach + m) + UNDERFLOW;
    let least = min(min(weight_a, weight_b), weight_c);
    let most = max(max(weight_a, weight_b), weight_c);
    var candidate: Candidate;
    if (least < -bound && most > bound) {
        return candidate;
    }
    let det = weight_a + weight_b + weight_c;
    let inverse = 1.0 / det;
    let w = weight_a * inverse;
    let u = weight_b * inverse;
    let v = weight_c * inverse;
    // Depths, in units of t.
    let z = vec3f(oa.z, ob.z, oc.z) * shear.z;
    let t = times_plus(w, z.x, times_plus(u, z.y, v * z.z));
    let near = smallest3(z);
    let far = largest3(z);
    let is_thin = abs(det) < 8.0 * bound;
    let off = abs(z - t);
    let moved = select(2.0 * bound * (off.x + off.y + off.z) * abs(inverse), 0.5 * (far - near), is_thin);
    candidate.t = select(t, 0.5 * (far + near), is_thin);
    // Weights may be nothing but rounding then, or not even numbers; others begin rays there.
    let is_off = is_thin && !(min(u, v) >= 0.0 && u + v <= 1.0);
    candidate.u = select(u, 1.0 / 3.0, is_off);
    candidate.v = select(v, 1.0 / 3.0, is_off);
    candidate.error = moved + (DEPTH_ERROR * max(abs(near), abs(far)) + UNDERFLOW);
    candidate.is_sure = (least > bound || most < -bound) && candidate.t > candidate.error;
    candidate.is_hit = candidate.t > -candidate.error && candidate.t < INF;
    return candidate;
}

@if(!exact_order)
fn watertight(origin: vec3f, shear: Shear, a: vec3f, b: vec3f, c: vec3f) -> Candidate {
    let oa = with_largest_last(a - origin, shear.axis);
    let ob = with_largest_last(b - origin, shear.axis);
    let oc = with_largest_last(c - origin, shear.axis);
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
    var weight_a = times_plus(q.x, r.y, -rq);
    var weight_b = times_plus(r.x, p.y, -pr);
    var weight_c = times_plus(p.x, q.y, -qp);
    if (qr == rq || rp == pr || pq == qp) {
        // A loop, so that this rarely needed code exists once: three copies take registers from every ray, and up to
        // 11% more time on an H200; the loop takes 3% at most.
        var tail = q;
        var head = r;
        for (var edge = 0; edge < 3; edge++) {
            if (tail.x * head.y == tail.y * head.x) {
                let weight = below_rounding(tail.x, head.y, tail.y, head.x);
                weight_a = select(weight_a, weight, edge == 0);
                weight_b = select(weight_b, weight, edge == 1);
                weight_c = select(weight_c, weight, edge == 2);
            }
            let next = select(p, q, edge == 1);
            tail = head;
            head = next;
        }
        if (min(min(weight_a, weight_b), weight_c) < 0.0 && max(max(weight_a, weight_b), weight_c) > 0.0) {
            return Candidate(0.0, 0.0, 0.0, false);
        }
    }
    let det = weight_a + weight_b + weight_c;
    let inverse = 1.0 / det;
    // Divided first: a weight times a depth is a cubed length, which underflows long before either factor does.
    let w = weight_a * inverse;
    let u = weight_b * inverse;
    let v = weight_c * inverse;
    // Depths, in units of t.
    let z = vec3f(oa.z, ob.z, oc.z) * shear.z;
    let t = times_plus(w, z.x, times_plus(u, z.y, v * z.z));
    return Candidate(t, u, v, det != 0.0 && t > 0.0 && t < INF);
}

@if(!exact_order)
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

// Orders hits: nearer first, then by smaller triangle id, so that the order of the tests does not matter.
fn is_nearer(t: f32, triangle: u32, nearest_t: f32, nearest_triangle: u32) -> bool {
    return t < nearest_t || (t == nearest_t && triangle < nearest_triangle);
}
