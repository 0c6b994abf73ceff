// Whether a ray crosses a triangle, and which of two it crosses first, once its origin is moved by an infinitesimal: by e along
// x, e^2 along y and e^3 along z (Edelsbrunner and Mücke 1990). Such a ray passes through no edge and no corner, so it enters a
// closed surface as often as it leaves it, and whoever asks about it is told the same.
//
// What exact.wgsl decides by the sign of a sum, the first of three more sums decides that is not 0, if that is: those by which
// e, e^2 and e^3 are multiplied.

import package::exact::{Sum, add_volume, compare_exactly, compare_products, distance_sum, new_sum, settle, volume};

fn along_axis(axis: u32) -> vec3f {
    return vec3f(vec3u(axis) == vec3u(0u, 1u, 2u));
}

// On which side of an edge the ray passes; 0 only if the edge is parallel to it.
fn moved_side(origin: vec3f, direction: vec3f, tail: vec3f, head: vec3f) -> i32 {
    var sum = volume(direction, tail, head, origin);
    var side = settle(&sum);
    // d x (head - tail)
    for (var axis = 0u; axis < 3u && side == 0; axis++) {
        var moved = new_sum();
        add_volume(&moved, along_axis(axis), vec3f(0.0), direction, head, false);
        add_volume(&moved, along_axis(axis), vec3f(0.0), direction, tail, true);
        side = settle(&moved);
    }
    return side;
}

// Whether the ray crosses the triangle at t > 0. One that is seen edge-on is not crossed.
fn crosses_exactly(origin: vec3f, direction: vec3f, a: vec3f, b: vec3f, c: vec3f) -> bool {
    var tail = a;
    var head = b;
    var along = 0;
    for (var edge = 0u; edge < 3u; edge++) {
        let side = moved_side(origin, direction, tail, head);
        if (side == 0 || side == -along) {
            return false;
        }
        along = side;
        tail = head;
        head = select(c, a, edge == 1u);
    }
    // The sides add up to d.n, and t is a share of that.
    var distance = distance_sum(origin, a, b, c);
    var ahead = settle(&distance);
    for (var axis = 0u; axis < 3u && ahead == 0; axis++) {
        var normal = volume(along_axis(axis), a, b, c);
        ahead = -settle(&normal);
    }
    return ahead == along;
}

// Compares the t of two triangles that the ray crosses: the sign of their difference. It is 0 only if both are in one plane.
fn compare_crossings(
    origin: vec3f,
    direction: vec3f,
    a: vec3f,
    b: vec3f,
    c: vec3f,
    other_a: vec3f,
    other_b: vec3f,
    other_c: vec3f,
) -> i32 {
    var order = compare_exactly(origin, direction, a, b, c, other_a, other_b, other_c);
    if (order != 0) {
        return order;
    }
    // t moves by -n / d.n.
    var along = volume(direction, a, b, c);
    var other_along = volume(direction, other_a, other_b, other_c);
    let facing = -settle(&along);
    let other_facing = -settle(&other_along);
    for (var axis = 0u; axis < 3u && order == 0; axis++) {
        var by = volume(along_axis(axis), a, b, c);
        var other_by = volume(along_axis(axis), other_a, other_b, other_c);
        let way = facing * settle(&by);
        order = clamp(way - other_facing * settle(&other_by), -1, 1);
        if (order == 0) {
            order = way * compare_products(&by, &other_along, &other_by, &along);
        }
    }
    return order;
}
