// Which of the eight octants of a cell ("halves" in names) a triangle overlaps: in f32 where that is certain, and
// exactly. The exact test matches its CPU reference, `halves` in structures/grid/overlap.rs, operation by operation.

import package::build::{build, vertices};
import package::overlap::{halvings, prepare, enter_row, meets, width_at};
import package::filter::{NO, YES, UNCERTAIN, filter_box, filter_triangle, grown, are_above, off, p0, p1, p2, width_after};
import package::soft_f64::{F64, f64_add, f64_sub, f64_mul, f64_ge, f64_min, f64_max, f64_from_f32, f64_from_i32};

// A coordinate's plane at the lower end of a half.
fn plane_of(half: u32, axis: u32) -> F64 {
    return f64_add(f64_from_f32(build.corner[axis]), f64_mul(f64_from_i32(i32(half)), width_at(axis)));
}

// The bits of the two halves of a row, of the eight halves, x fastest. `cell` is counted in units of its size; `level` is
// that of its halves. Four threads find those of a triangle in less time than one.
fn halves_of_row(triangle: u32, cell: vec3u, level: u32, row: u32) -> u32 {
    halvings = level;
    let growth = f64_from_f32(build.growth);
    // For each axis, a bit for each of the two halves that the triangle's box touches.
    var near: array<u32, 3>;
    for (var a = 0u; a < 3u; a++) {
        let p0 = f64_from_f32(vertices[9u * triangle + a]);
        let p1 = f64_from_f32(vertices[9u * triangle + a + 3u]);
        let p2 = f64_from_f32(vertices[9u * triangle + a + 6u]);
        let low = f64_sub(f64_min(f64_min(p0, p1), p2), growth);
        let high = f64_add(f64_max(f64_max(p0, p1), p2), growth);
        var plane = plane_of(2u * cell[a], a);
        near[a] = 0u;
        for (var half = 0u; half < 2u; half++) {
            let next = plane_of(2u * cell[a] + half + 1u, a);
            near[a] |= u32(f64_ge(high, plane) && f64_ge(next, low)) << half;
            plane = next;
        }
    }
    let y = row & 1u;
    let z = row >> 1u;
    if (((near[1] >> y) & (near[2] >> z) & 1u) == 0u) {
        return 0u;
    }
    prepare(triangle);
    var mask = 0u;
    if (enter_row(2u * cell.y + y, 2u * cell.z + z)) {
        for (var x = 0u; x < 2u; x++) {
            if (((near[0] >> x) & 1u) != 0u && meets(2u * cell.x + x)) {
                mask |= 1u << (x + 2u * row);
            }
        }
    }
    return mask;
}

// The mask stands for nothing: the halves are not certain.
const NOT_CERTAIN: u32 = 0x100u;

// Whether a box touches the halves between these planes and the next ones, along each axis.
fn touches_between(low: vec3f, high: vec3f, corner: vec3f, width: vec3f, plane: vec3u) -> vec3u {
    let ends_above = are_above(high, grown, corner + vec3f(plane) * width, off);
    // A coordinate that is certainly above is certainly not at the plane or below it.
    let is_over = are_above(low, -grown, corner + vec3f(plane + vec3u(1u)) * width, off);
    let reaches = select(select(vec3u(UNCERTAIN), vec3u(NO), is_over == vec3u(YES)), vec3u(YES), is_over == vec3u(NO));
    let is_apart = (ends_above == vec3u(NO)) | (reaches == vec3u(NO));
    return select(max(ends_above, reaches), vec3u(NO), is_apart);
}

// The bits of all eight, where all of them are certain.
fn certain_halves(triangle: u32, cell: vec3u, level: u32) -> u32 {
    if (!filter_triangle(triangle)) {
        return NOT_CERTAIN;
    }
    let low = min(min(p0, p1), p2);
    let high = max(max(p0, p1), p2);
    let width = width_after(level);
    let corner = bitcast<vec3f>(build.corner);
    let near_lower = touches_between(low, high, corner, width, 2u * cell);
    let near_upper = touches_between(low, high, corner, width, 2u * cell + vec3u(1u));
    var mask = 0u;
    for (var i = 0u; i < 8u; i++) {
        let half = (vec3u(i) >> vec3u(0u, 1u, 2u)) & vec3u(1u);
        let touches = select(near_lower, near_upper, half == vec3u(1u));
        if (any(touches == vec3u(NO))) {
            continue;
        }
        var overlaps = filter_box(corner + (vec3f(2u * cell + half) + 0.5) * width, 0.5 * width);
        if (overlaps != NO && any(touches == vec3u(UNCERTAIN))) {
            overlaps = UNCERTAIN;
        }
        if (overlaps == UNCERTAIN) {
            return NOT_CERTAIN;
        }
        mask |= overlaps << i;
    }
    return mask;
}
