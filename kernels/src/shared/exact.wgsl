// Whether a ray meets a triangle, and which of two it meets first: in integers, and so without any rounding, for the f32 of
// the ray and the corners.
//
// With d the ray's direction, o its origin and n = (b - a) x (c - a), the ray meets the plane at t = (a - o).n / d.n, on
// the side of the edge from p to q that the sign of d.((q - p) x (o - p)) tells. All of these are sums of products of
// three f32. An f32 is a multiple of 2^-149 below 2^128, so such a sum is a multiple of 2^-447, and 27 words of 32 bits
// hold it. Nearly always far fewer do (narrow.wgsl).

import package::constants::{INF};
import package::narrow::{compare_shares, joined, meets_narrowly, range, share_of, units_of, units_with};
import package::product::{product64};

const WORDS: u32 = 27u;

// A sum of products: those that are added in the first half, those that are subtracted in the second, so that no sign
// travels through all words. All words below `low` are 0, and those from `end` on.
struct Sum {
    words: array<u32, 54>,
    low: u32,
    end: u32,
}

fn add_product(sum: ptr<function, Sum>, factors: vec3f, is_negative: bool) {
    let bits = bitcast<vec3u>(factors);
    let exponents = (bits >> vec3u(23u)) & vec3u(0xffu);
    let digits = (bits & vec3u(0x7fffffu)) | select(vec3u(0x800000u), vec3u(0u), exponents == vec3u(0u));
    if (any(digits == vec3u(0u))) {
        return;
    }
    let pair = product64(digits.x, digits.y);
    let lower = product64(pair.y, digits.z);
    let upper = product64(pair.x, digits.z);
    let middle = lower.x + upper.y;
    let top = upper.x + u32(middle < lower.x);
    // In units of 2^-447; subnormal numbers have the exponent of the smallest normal ones.
    let exponent = max(exponents, vec3u(1u));
    let at = exponent.x + exponent.y + exponent.z - 3u;
    let shift = at % 32u;
    let shifted = vec4u(
        lower.y << shift,
        (middle << shift) | ((lower.y >> 1u) >> (31u - shift)),
        (top << shift) | ((middle >> 1u) >> (31u - shift)),
        (top >> 1u) >> (31u - shift),
    );
    let is_minus = (((bits.x ^ bits.y ^ bits.z) >> 31u) == 1u) != is_negative;
    let first = at / 32u;
    let half = select(0u, WORDS, is_minus);
    var place = first;
    var carry = 0u;
    for (var word = 0u; word < 4u || carry != 0u; word++) {
        let before = (*sum).words[half + place];
        let added = before + select(0u, shifted[min(word, 3u)], word < 4u);
        let all = added + carry;
        carry = u32(added < before) | u32(all < carry);
        (*sum).words[half + place] = all;
        place += 1u;
    }
    (*sum).low = min((*sum).low, first);
    (*sum).end = max((*sum).end, place);
}

fn new_sum() -> Sum {
    var sum: Sum;
    sum.low = WORDS;
    return sum;
}

// x.((q - p) x (r - p)) = x.(p x q + q x r + r x p)
fn add_volume(sum: ptr<function, Sum>, x: vec3f, p: vec3f, q: vec3f, r: vec3f, is_negative: bool) {
    var tail = p;
    var head = q;
    for (var edge = 0u; edge < 3u; edge++) {
        for (var axis = 0u; axis < 3u; axis++) {
            let next = (axis + 1u) % 3u;
            let last = (axis + 2u) % 3u;
            add_product(sum, vec3f(x[axis], tail[next], head[last]), is_negative);
            add_product(sum, vec3f(x[axis], tail[last], head[next]), !is_negative);
        }
        tail = head;
        head = select(r, p, edge == 1u);
    }
}

// Leaves the magnitude in the first half, and returns the sign.
fn settle(sum: ptr<function, Sum>) -> i32 {
    var sign = 0;
    for (var place = (*sum).end; place > (*sum).low && sign == 0; place--) {
        let plus = (*sum).words[place - 1u];
        let minus = (*sum).words[WORDS + place - 1u];
        sign = i32(plus > minus) - i32(plus < minus);
    }
    var borrow = 0u;
    for (var place = (*sum).low; place < (*sum).end; place++) {
        let plus = (*sum).words[place];
        let minus = (*sum).words[WORDS + place];
        let larger = select(minus, plus, sign > 0);
        let smaller = select(plus, minus, sign > 0);
        let difference = larger - smaller;
        (*sum).words[place] = difference - borrow;
        borrow = u32(larger < smaller) | u32(difference < borrow);
    }
    return sign;
}

// (a - o).n, of which t is the share of d.n.
fn distance_sum(origin: vec3f, a: vec3f, b: vec3f, c: vec3f) -> Sum {
    var sum = new_sum();
    add_volume(&sum, a, b, c, vec3f(0.0), false);
    add_volume(&sum, origin, a, b, c, true);
    return sum;
}

// x.n; with an edge and the ray's origin as the corners, which side of the edge the ray passes on.
fn volume(x: vec3f, p: vec3f, q: vec3f, r: vec3f) -> Sum {
    var sum = new_sum();
    add_volume(&sum, x, p, q, r, false);
    return sum;
}

// Whether the ray meets the triangle at t > 0, its edges and corners included. A triangle that is seen edge-on is not met.
fn meets_exactly(origin: vec3f, direction: vec3f, a: vec3f, b: vec3f, c: vec3f) -> bool {
    let units = units_with(origin, direction, a, b, c);
    if (units.fit) {
        return meets_narrowly(units, origin, direction, a, b, c);
    }
    return meets_widely(origin, direction, a, b, c);
}

fn meets_widely(origin: vec3f, direction: vec3f, a: vec3f, b: vec3f, c: vec3f) -> bool {
    var lowest = 0;
    var highest = 0;
    var tail = a;
    var head = b;
    for (var edge = 0u; edge < 3u; edge++) {
        var side = volume(direction, tail, head, origin);
        let sign = settle(&side);
        lowest = min(lowest, sign);
        highest = max(highest, sign);
        tail = head;
        head = select(c, a, edge == 1u);
    }
    if (lowest == highest || lowest * highest < 0) {
        return false;
    }
    var distance = distance_sum(origin, a, b, c);
    // The sides add up to d.n.
    return settle(&distance) == lowest + highest;
}

// The sign of a b - c d, of magnitudes.
fn compare_products(
    a: ptr<function, Sum>,
    b: ptr<function, Sum>,
    c: ptr<function, Sum>,
    d: ptr<function, Sum>,
) -> i32 {
    let low = min(min((*a).low, (*b).low), min((*c).low, (*d).low));
    let end = max(max((*a).end, (*b).end), max((*c).end, (*d).end));
    // Column by column, as on paper: a number of three words, in two's complement, is carried on.
    var carried = vec3u(0u);
    var is_equal = true;
    for (var column = 2u * low; column + 1u < 2u * end; column++) {
        for (var place = max(low, max(column + 1u, end) - end); place < end && place + low <= column; place++) {
            let more = product64((*a).words[place], (*b).words[column - place]);
            let less = product64((*c).words[place], (*d).words[column - place]);
            let added = vec2u(carried.x + more.y, carried.y + more.x);
            let carry = u32(added.x < more.y);
            let middle = added.y + carry;
            let top = carried.z + (u32(added.y < more.x) | u32(middle < carry));
            let borrow = u32(added.x < less.y);
            let rest = middle - less.x;
            carried = vec3u(
                added.x - less.y,
                rest - borrow,
                top - (u32(middle < less.x) | u32(rest < borrow)),
            );
        }
        is_equal = is_equal && carried.x == 0u;
        // The sign is that of the highest word.
        carried = vec3u(carried.y, carried.z, select(0u, 0xffffffffu, (carried.z >> 31u) == 1u));
    }
    if ((carried.y >> 31u) == 1u) {
        return -1;
    }
    return select(1, 0, is_equal && carried.x == 0u && carried.y == 0u);
}

// Whether the t of a triangle that the ray meets, rounded to the nearest f32, lies between two numbers; it is never rounded to 0.
fn rounds_between(interval: vec2f, origin: vec3f, direction: vec3f, a: vec3f, b: vec3f, c: vec3f) -> bool {
    var distance = distance_sum(origin, a, b, c);
    var along = volume(direction, a, b, c);
    settle(&distance);
    settle(&along);
    if (interval.x > 0.0 && !rounds_above(bitcast<u32>(interval.x), &distance, &along)) {
        return false;
    }
    // Either the number before the end is reached or the end is not.
    let end = bitcast<u32>(interval.y);
    return interval.y >= INF || (interval.y > 0.0 && end > 1u && !rounds_above(end - 1u, &distance, &along));
}

// Whether a quotient of magnitudes is rounded to an f32 above that of these bits: whether it is above the middle between this and
// the next one, or at it, if this one is odd.
fn rounds_above(bits: u32, above: ptr<function, Sum>, below: ptr<function, Sum>) -> bool {
    let exponent = bits >> 23u;
    let digits = (bits & 0x7fffffu) | select(0x800000u, 0u, exponent == 0u);
    // In units of 2^-151.
    var middle = shifted_number(2u * digits + 1u, max(exponent, 1u));
    var unit = shifted_number(1u, 151u);
    let order = compare_products(above, &unit, below, &middle);
    return order > 0 || (order == 0 && (bits & 1u) == 1u);
}

fn shifted_number(number: u32, by: u32) -> Sum {
    var sum: Sum;
    let part = by % 32u;
    sum.low = by / 32u;
    sum.end = sum.low + 2u;
    sum.words[sum.low] = number << part;
    sum.words[sum.low + 1u] = (number >> 1u) >> (31u - part);
    return sum;
}

// Compares the t of two triangles that the ray meets: the sign of their difference.
fn compare_exactly(
    origin: vec3f,
    direction: vec3f,
    a: vec3f,
    b: vec3f,
    c: vec3f,
    other_a: vec3f,
    other_b: vec3f,
    other_c: vec3f,
) -> i32 {
    let others = joined(joined(range(other_a), range(other_b)), range(other_c));
    let places = joined(joined(joined(range(origin), range(a)), joined(range(b), range(c))), others);
    let units = units_of(places, direction);
    if (units.fit) {
        let one = share_of(units, origin, direction, a, b, c);
        let order = compare_shares(one, share_of(units, origin, direction, other_a, other_b, other_c));
        if (order != 0) {
            return order;
        }
    }
    var distance = distance_sum(origin, a, b, c);
    var along = volume(direction, a, b, c);
    var other_distance = distance_sum(origin, other_a, other_b, other_c);
    var other_along = volume(direction, other_a, other_b, other_c);
    settle(&distance);
    settle(&along);
    settle(&other_distance);
    settle(&other_along);
    return compare_products(&distance, &other_along, &other_distance, &along);
}
