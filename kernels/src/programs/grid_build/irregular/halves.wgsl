// Which halves of a cell a triangle overlaps. The CPU reference is `halves` in structures/grid/overlap.rs, operation by
// operation.

import package::build::{build, vertices};
import package::overlap::{halvings, prepare, enter_row, meets, width_at};
import package::soft_f64::{F64, f64_add, f64_sub, f64_mul, f64_ge, f64_min, f64_max, f64_from_f32, f64_from_i32};

// A coordinate's plane at the lower end of a half.
fn plane_of(half: u32, axis: u32) -> F64 {
    return f64_add(f64_from_f32(build.corner[axis]), f64_mul(f64_from_i32(i32(half)), width_at(axis)));
}

// A bit for each of the eight halves, x fastest. `cell` is counted in units of its size; `level` is that of its halves.
fn halves(triangle: u32, cell: vec3u, level: u32) -> u32 {
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
    prepare(triangle);
    var mask = 0u;
    for (var row = 0u; row < 4u; row++) {
        let y = row & 1u;
        let z = row >> 1u;
        let is_near = ((near[1] >> y) & (near[2] >> z) & 1u) != 0u;
        if (is_near && enter_row(2u * cell.y + y, 2u * cell.z + z)) {
            for (var x = 0u; x < 2u; x++) {
                if (((near[0] >> x) & 1u) != 0u && meets(2u * cell.x + x)) {
                    mask |= 1u << (x + 2u * row);
                }
            }
        }
    }
    return mask;
}
