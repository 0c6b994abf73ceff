// Whether a ray crosses a triangle, and which of two it crosses first, once its origin is moved by an infinitesimal: by e along
// x, e^2 along y and e^3 along z (Edelsbrunner and Mücke 1990). Such a ray passes through no edge and no corner, so it enters a
// closed surface as often as it leaves it, and whoever asks about it is told the same.
//
// What exact.wgsl decides by the sign of a sum, the first of three more sums decides that is not 0, if that is: those by which
// e, e^2 and e^3 are multiplied.

// A device may run every loop that the code has once for each triangle, whether it is needed or not, and compiles each copy of a
// function: so there is one place that adds, for whatever is asked.

import package::exact::{Sum, add_volume, compare_products, new_sum, settle};

// x.n of the triangle p, q, r, less y.n of the triangle s, t, u.
struct Volumes {
    x: vec3f,
    p: vec3f,
    q: vec3f,
    r: vec3f,
    y: vec3f,
    s: vec3f,
    t: vec3f,
    u: vec3f,
}

fn difference(of_both: Volumes) -> Sum {
    var sum = new_sum();
    var x = of_both.x;
    var p = of_both.p;
    var q = of_both.q;
    var r = of_both.r;
    for (var part = 0u; part < 2u; part++) {
        add_volume(&sum, x, p, q, r, part == 1u);
        x = of_both.y;
        p = of_both.s;
        q = of_both.t;
        r = of_both.u;
    }
    return sum;
}

// The axis along which the power of e moves the origin; 0 for the power 0.
fn axis_of(power: u32) -> vec3f {
    return vec3f(vec3u(power) == vec3u(1u, 2u, 3u));
}

// On which side of an edge the ray passes: d.((head - tail) x (o - tail)), or what a power of e is multiplied by in that,
// d x (head - tail). All of these are 0 only if the edge is parallel to the ray.
fn side_of(power: u32, origin: vec3f, direction: vec3f, tail: vec3f, head: vec3f) -> Volumes {
    let none = vec3f(0.0);
    let axis = axis_of(power);
    if (power == 0u) {
        return Volumes(direction, tail, head, origin, none, none, none, none);
    }
    return Volumes(axis, none, direction, head, axis, none, direction, tail);
}

// (a - o).n, of which t is the share of d.n, or what a power of e is multiplied by in that: -n.
fn distance_of(power: u32, origin: vec3f, a: vec3f, b: vec3f, c: vec3f) -> Volumes {
    let none = vec3f(0.0);
    if (power == 0u) {
        return Volumes(a, b, c, none, origin, a, b, c);
    }
    return Volumes(none, none, none, none, axis_of(power), a, b, c);
}

// Whether the ray crosses the triangle at t > 0. One that is seen edge-on is not crossed.
fn crosses_exactly(origin: vec3f, direction: vec3f, a: vec3f, b: vec3f, c: vec3f) -> bool {
    var along = 0;
    var tail = a;
    var head = b;
    // Three sides, which add up to d.n, and the distance.
    for (var part = 0u; part < 4u; part++) {
        var sign_here = 0;
        for (var power = 0u; power < 4u && sign_here == 0; power++) {
            var volumes = side_of(power, origin, direction, tail, head);
            if (part == 3u) {
                volumes = distance_of(power, origin, a, b, c);
            }
            var sum = difference(volumes);
            sign_here = settle(&sum);
        }
        if (sign_here == 0 || sign_here == -along) {
            return false;
        }
        along = sign_here;
        tail = head;
        head = select(c, a, part == 1u);
    }
    return true;
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
    let none = vec3f(0.0);
    var along: Sum;
    var other_along: Sum;
    var share: Sum;
    var other_share: Sum;
    var facing = 0;
    var other_facing = 0;
    var order = 0;
    // First d.n of both, then the distances, then what the powers of e are multiplied by in these.
    for (var turn = 0u; turn < 5u && order == 0; turn++) {
        var way = 0;
        var other_way = 0;
        var p = a;
        var q = b;
        var r = c;
        for (var which = 0u; which < 2u; which++) {
            var volumes = Volumes(direction, p, q, r, none, none, none, none);
            if (turn > 0u) {
                volumes = distance_of(turn - 1u, origin, p, q, r);
            }
            var sum = difference(volumes);
            other_way = settle(&sum);
            if (which == 0u) {
                way = other_way;
                share = sum;
            } else {
                other_share = sum;
            }
            p = other_a;
            q = other_b;
            r = other_c;
        }
        if (turn == 0u) {
            facing = way;
            other_facing = other_way;
            along = share;
            other_along = other_share;
        } else {
            order = clamp(facing * way - other_facing * other_way, -1, 1);
            if (order == 0) {
                order = facing * way * compare_products(&share, &other_along, &other_share, &along);
            }
        }
    }
    return order;
}
