// Which cells of a row along x a triangle overlaps. The CPU reference is structures/grid/overlap.rs, operation by
// operation.

import package::build::{build, vertices};
import package::soft_f64::{F64, F64_HALF, f64_add, f64_sub, f64_mul, f64_neg, f64_abs, f64_ge, f64_from_f32, f64_from_i32};

// For each axis along which triangle and cells are projected: the inward normals of the three edges, and the distance
// of a cell's farthest corner.
struct Edge {
    ni: F64,
    nj: F64,
    offset: F64,
}

var<private> edges: array<array<Edge, 3>, 3>;
var<private> normal: array<vec2u, 3>;
var<private> plane: F64;
var<private> plane_reach: F64;

// For a row: the parts of the plane's and the edges' expressions that are the same for all of its cells.
struct Side {
    along: F64,
    row: F64,
    offset: F64,
}

// How often the grid's cells are halved along each axis to get those of the tests.
var<private> halvings: u32;

// Width of a cell. Halving is exact: it lowers the exponent.
fn width_at(axis: u32) -> F64 {
    return f64_from_f32(build.width[axis]) - vec2u(halvings << 20u, 0u);
}

var<private> plane_row: F64;
var<private> sides: array<Side, 6>;

fn dot2(ax: F64, bx: F64, ay: F64, by: F64) -> F64 {
    return f64_add(f64_mul(ax, bx), f64_mul(ay, by));
}

// Computes what does not depend on the cell.
fn prepare(triangle: u32) {
    var p: array<array<vec2u, 3>, 3>;
    for (var c = 0u; c < 3u; c++) {
        for (var a = 0u; a < 3u; a++) {
            p[c][a] = f64_from_f32(vertices[9u * triangle + 3u * c + a]);
        }
    }
    let growth = f64_from_f32(build.growth);
    var extent: array<vec2u, 3>;
    var edge: array<array<vec2u, 3>, 3>;
    for (var a = 0u; a < 3u; a++) {
        extent[a] = f64_add(f64_mul(width_at(a), F64_HALF), growth);
        for (var e = 0u; e < 3u; e++) {
            edge[e][a] = f64_sub(p[(e + 1u) % 3u][a], p[e][a]);
        }
    }
    var distance = vec2u(0u);
    plane_reach = vec2u(0u);
    for (var axis = 0u; axis < 3u; axis++) {
        let i = (axis + 1u) % 3u;
        let j = (axis + 2u) % 3u;
        normal[axis] = f64_sub(f64_mul(edge[0][i], edge[1][j]), f64_mul(edge[1][i], edge[0][j]));
        // A sum that starts at 0 equals one that starts with its first term, except for the sign of a zero, which no
        // comparison sees.
        distance = f64_add(distance, f64_mul(normal[axis], p[0][axis]));
        plane_reach = f64_add(plane_reach, f64_mul(f64_abs(normal[axis]), extent[axis]));
        let is_flipped = !f64_ge(normal[axis], vec2u(0u));
        for (var e = 0u; e < 3u; e++) {
            let ni = select(f64_neg(edge[e][j]), edge[e][j], is_flipped);
            let nj = select(edge[e][i], f64_neg(edge[e][i]), is_flipped);
            var offset = f64_neg(dot2(ni, p[e][i], nj, p[e][j]));
            offset = f64_add(offset, f64_mul(f64_abs(ni), extent[i]));
            offset = f64_add(offset, f64_mul(f64_abs(nj), extent[j]));
            edges[axis][e] = Edge(ni, nj, offset);
        }
    }
    plane = f64_neg(distance);
}

// Centre of a cell.
fn center(axis: u32, cell: u32) -> F64 {
    let cells = f64_add(f64_from_i32(i32(cell)), F64_HALF);
    return f64_add(f64_from_f32(build.corner[axis]), f64_mul(cells, width_at(axis)));
}

// Whether any cell of a row may overlap: the projection along x is the same for all of them.
fn enter_row(y: u32, z: u32) -> bool {
    let cy = center(1u, y);
    let cz = center(2u, z);
    for (var e = 0u; e < 3u; e++) {
        let edge = edges[0][e];
        if (!f64_ge(f64_add(dot2(edge.ni, cy, edge.nj, cz), edge.offset), vec2u(0u))) {
            return false;
        }
    }
    plane_row = f64_add(dot2(normal[1], cy, normal[2], cz), plane);
    for (var e = 0u; e < 3u; e++) {
        let along_y = edges[1][e];
        let along_z = edges[2][e];
        sides[e] = Side(along_y.nj, f64_mul(along_y.ni, cz), along_y.offset);
        sides[3u + e] = Side(along_z.ni, f64_mul(along_z.nj, cy), along_z.offset);
    }
    return true;
}

// Whether a cell of the row overlaps; touching counts.
fn meets(x: u32) -> bool {
    let cx = center(0u, x);
    if (!f64_ge(plane_reach, f64_abs(f64_add(f64_mul(normal[0], cx), plane_row)))) {
        return false;
    }
    for (var s = 0u; s < 6u; s++) {
        let side = sides[s];
        if (!f64_ge(f64_add(f64_add(f64_mul(side.along, cx), side.row), side.offset), vec2u(0u))) {
            return false;
        }
    }
    return true;
}
