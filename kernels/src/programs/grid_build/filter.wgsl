// A floating-point filter (Fortune and Van Wyk, 1993): decides in f32 whether a triangle overlaps a box where that is
// certain, however a device contracts, flushes or rounds. Uncertain cases are left to soft_f64.wgsl.
//
// A test is certain if the magnitude of its value exceeds 2^-19 times the sum of its terms' magnitudes, plus a bound on
// the errors of the box's centre and of the exact test in f64. The longest chain has nine operations, each with a
// relative error of at most 2^-23.

import package::build::{build, vertices};

const NO: u32 = 0u;
const YES: u32 = 1u;
const UNCERTAIN: u32 = 2u;

const BOUND: f32 = 0x1p-19f;
// Beyond these magnitudes, products may underflow or overflow.
const LEAST: f32 = 1e-30;
const MOST: f32 = 1e30;

// How much the computed coordinates of planes and centres may be off, for each axis: nothing, if all of them are exact in
// f32; then this is for the rounding of the exact test, in f64.
fn slack() -> vec3f {
    let corner = bitcast<vec3f>(build.corner);
    let reach = abs(corner) + vec3f(build.cells) * bitcast<vec3f>(build.width);
    return reach * select(vec3f(0x1p-21f), vec3f(0x1p-40f), is_exact());
}

fn is_exact() -> vec3<bool> {
    return (vec3u(build.flags) & vec3u(2u, 4u, 8u)) != vec3u(0u);
}

// Size of a cell after so many halvings.
fn width_after(halvings: u32) -> vec3f {
    return bitcast<vec3f>(build.width) * bitcast<f32>((127u - halvings) << 23u);
}

fn corner_bits(triangle: u32, corner: u32) -> vec3u {
    let first = 9u * triangle + 3u * corner;
    return vec3u(vertices[first], vertices[first + 1u], vertices[first + 2u]);
}

// A value that a box or a triangle is tested by, with the sum of the magnitudes of its terms.
fn sign_of(value: f32, magnitude: f32, off_by: f32) -> u32 {
    let bound = BOUND * magnitude + off_by;
    if (magnitude > LEAST && magnitude < MOST) {
        if (value > bound) {
            return YES;
        }
        if (value < -bound) {
            return NO;
        }
    }
    return UNCERTAIN;
}

var<private> p0: vec3f;
var<private> p1: vec3f;
var<private> p2: vec3f;
var<private> e0: vec3f;
var<private> e1: vec3f;
var<private> e2: vec3f;
// Where an edge is exactly parallel to an axis, its projection along it is a point, which is no obstacle.
var<private> free0: vec3<bool>;
var<private> free1: vec3<bool>;
var<private> free2: vec3<bool>;
var<private> normal_f32: vec3f;
// Sums of the magnitudes of its terms.
var<private> weight: vec3f;
// On which side of the edges' projections the triangle is.
var<private> flip: vec3f;
var<private> grown: f32;
var<private> off: vec3f;

// The other two of three components, of which both hold.
fn both_others(v: vec3<bool>) -> vec3<bool> {
    return v.yzx & v.zxy;
}

// Prepares a triangle; false if nothing is certain about it.
fn filter_triangle(triangle: u32) -> bool {
    let b0 = corner_bits(triangle, 0u);
    let b1 = corner_bits(triangle, 1u);
    let b2 = corner_bits(triangle, 2u);
    p0 = bitcast<vec3f>(b0);
    p1 = bitcast<vec3f>(b1);
    p2 = bitcast<vec3f>(b2);
    e0 = p1 - p0;
    e1 = p2 - p1;
    e2 = p0 - p2;
    // By their bits: a small difference may be flushed.
    let zero0 = b0 == b1;
    let zero1 = b1 == b2;
    free0 = both_others(zero0);
    free1 = both_others(zero1);
    free2 = both_others(b2 == b0);
    normal_f32 = e0.yzx * e1.zxy - e1.yzx * e0.zxy;
    weight = abs(e0.yzx * e1.zxy) + abs(e1.yzx * e0.zxy);
    grown = bitcast<f32>(build.growth);
    off = slack();
    let is_zero = (zero0.yzx | zero1.zxy) & (zero1.yzx | zero0.zxy);
    let is_certain = (abs(normal_f32) > BOUND * weight) & (weight > vec3f(LEAST)) & (weight < vec3f(MOST));
    flip = select(vec3f(-1.0), vec3f(1.0), is_zero | (normal_f32 > vec3f(0.0)));
    return all(is_zero | is_certain);
}

// The tests of an edge, for its projections along the three axes.
fn edge_tests(edge: vec3f, is_free: vec3<bool>, d: vec3f, half: vec3f) -> u32 {
    let length = abs(edge);
    let span = abs(d) + half;
    let value = flip * (edge.yzx * d.zxy - edge.zxy * d.yzx) + length.zxy * half.yzx + length.yzx * half.zxy;
    let magnitude = length.zxy * span.yzx + length.yzx * span.zxy;
    let bound = BOUND * magnitude + length.zxy * off.yzx + length.yzx * off.zxy;
    let in_range = (magnitude > vec3f(LEAST)) & (magnitude < vec3f(MOST));
    if (any(in_range & !is_free & (value < -bound))) {
        return NO;
    }
    return select(UNCERTAIN, YES, all(is_free | (in_range & (value > bound))));
}

// Whether the triangle overlaps the box with this centre and half size, grown by `grown` on every side.
fn filter_box(centre: vec3f, half_size: vec3f) -> u32 {
    let half = half_size + grown;
    let d0 = centre - p0;
    let by_plane = sign_of(
        dot(abs(normal_f32), half) - abs(dot(normal_f32, d0)),
        dot(weight, abs(d0) + half),
        dot(weight, off),
    );
    if (by_plane == NO) {
        return NO;
    }
    let by_edge0 = edge_tests(e0, free0, d0, half);
    if (by_edge0 == NO) {
        return NO;
    }
    let by_edge1 = edge_tests(e1, free1, centre - p1, half);
    if (by_edge1 == NO) {
        return NO;
    }
    let by_edge2 = edge_tests(e2, free2, centre - p2, half);
    if (by_edge2 == NO) {
        return NO;
    }
    return max(max(by_plane, by_edge0), max(by_edge1, by_edge2));
}

// Whether coordinates, moved by the growth, are at or above planes, for each axis.
fn are_above(coordinate: vec3f, growth: f32, plane: vec3f, off_by: vec3f) -> vec3u {
    return vec3u(
        is_above(coordinate.x, growth, plane.x, off_by.x),
        is_above(coordinate.y, growth, plane.y, off_by.y),
        is_above(coordinate.z, growth, plane.z, off_by.z),
    );
}

// Whether a coordinate, moved by the growth, is at or above a plane of an axis.
fn is_above(coordinate: f32, growth: f32, plane: f32, off_by: f32) -> u32 {
    let distance = coordinate - plane;
    return sign_of(distance + growth, abs(distance) + abs(growth), off_by);
}
