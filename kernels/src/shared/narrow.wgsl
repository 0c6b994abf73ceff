// What exact.wgsl decides, in registers: for coordinates that 60 bits hold in one unit, as those of nearly all rays are.
// Differences of them have 61 bits then, as the direction may have, cross products of these 123, and their products with
// a third one 186.

import package::product::{product64};

// Powers of 2, above 2^-149: all places are multiples of the first, and the direction is one of the second.
struct Units {
    place: i32,
    direction: i32,
    // Whether the multiples are small enough.
    fit: bool,
}

// Three magnitudes of 64 bits, the lower words first, and all ones where the number is negative.
struct Longs {
    low: vec3u,
    high: vec3u,
    sign: vec3u,
}

// A cross product: three signed numbers of 128 bits, the lowest word first.
struct Cross {
    x: vec4u,
    y: vec4u,
    z: vec4u,
}

// A signed number of 192 bits, the lowest word first.
struct Volume {
    low: vec2u,
    high: vec4u,
}

// The lowest bit of three numbers, and the one above their highest, above 2^-149: those that are 0 have none.
fn range(v: vec3f) -> vec2i {
    let bits = bitcast<vec3u>(v);
    let exponents = (bits >> vec3u(23u)) & vec3u(0xffu);
    let digits = (bits & vec3u(0x7fffffu)) | select(vec3u(0x800000u), vec3u(0u), exponents == vec3u(0u));
    let at = max(exponents, vec3u(1u)) - vec3u(1u);
    let is_zero = digits == vec3u(0u);
    let low = select(at + countTrailingZeros(digits), vec3u(1000u), is_zero);
    let end = select(at + vec3u(32u) - countLeadingZeros(digits), vec3u(0u), is_zero);
    return vec2i(vec2u(min(min(low.x, low.y), low.z), max(max(end.x, end.y), end.z)));
}

fn joined(a: vec2i, b: vec2i) -> vec2i {
    return vec2i(min(a.x, b.x), max(a.y, b.y));
}

fn units_of(places: vec2i, direction: vec3f) -> Units {
    let steps = range(direction);
    return Units(places.x, steps.x, places.y - places.x <= 60 && steps.y - steps.x <= 61);
}

// The units of a ray and a triangle.
fn units_with(origin: vec3f, direction: vec3f, a: vec3f, b: vec3f, c: vec3f) -> Units {
    return units_of(joined(joined(range(origin), range(a)), joined(range(b), range(c))), direction);
}

// Multiples of a unit, in two's complement.
fn multiples(v: vec3f, unit: i32) -> array<vec3u, 2> {
    let bits = bitcast<vec3u>(v);
    let exponents = (bits >> vec3u(23u)) & vec3u(0xffu);
    let digits = (bits & vec3u(0x7fffffu)) | select(vec3u(0x800000u), vec3u(0u), exponents == vec3u(0u));
    // Digits below the unit are 0.
    let shift = vec3i(max(exponents, vec3u(1u))) - vec3i(unit + 1);
    let whole = digits >> vec3u(clamp(-shift, vec3i(0), vec3i(31)));
    let left = vec3u(max(shift, vec3i(0)));
    let part = left & vec3u(31u);
    let is_far = left >= vec3u(32u);
    let low = select(whole << part, vec3u(0u), is_far);
    let high = select((whole >> vec3u(1u)) >> (vec3u(31u) - part), whole << part, is_far);
    let sign = vec3u(0u) - (bits >> vec3u(31u));
    return negated(low, high, sign);
}

// Low and high words, with the other sign where `sign` is all ones.
fn negated(low: vec3u, high: vec3u, sign: vec3u) -> array<vec3u, 2> {
    return array(
        (low ^ sign) - sign,
        (high ^ sign) + select(vec3u(0u), sign & vec3u(1u), low == vec3u(0u)),
    );
}

// v - origin
fn difference(v: vec3f, origin: vec3f, unit: i32) -> Longs {
    let to = multiples(v, unit);
    let less = multiples(origin, unit);
    let low = to[0] - less[0];
    let high = to[1] - less[1] - select(vec3u(0u), vec3u(1u), to[0] < less[0]);
    let sign = vec3u(0u) - (high >> vec3u(31u));
    let magnitude = negated(low, high, sign);
    return Longs(magnitude[0], magnitude[1], sign);
}

fn plus128(a: vec4u, b: vec4u) -> vec4u {
    let x = a.x + b.x;
    let x_carry = u32(x < a.x);
    let y = a.y + b.y;
    let y_sum = y + x_carry;
    let y_carry = u32(y < a.y) | u32(y_sum < x_carry);
    let z = a.z + b.z;
    let z_sum = z + y_carry;
    let z_carry = u32(z < a.z) | u32(z_sum < y_carry);
    return vec4u(x, y_sum, z_sum, a.w + b.w + z_carry);
}

// The product of two magnitudes, negated if the sign is all ones.
fn times(a: vec2u, b: vec2u, sign: u32) -> vec4u {
    let low = product64(a.x, b.x);
    let one = product64(a.x, b.y);
    let other = product64(a.y, b.x);
    let high = product64(a.y, b.y);
    let ends = plus128(vec4u(low.yx, high.yx), vec4u(0u, one.yx, 0u));
    let product = plus128(ends, vec4u(0u, other.yx, 0u));
    return plus128(product ^ vec4u(sign), vec4u(sign & 1u, 0u, 0u, 0u));
}

fn cross_of(a: Longs, b: Longs) -> Cross {
    let ax = vec2u(a.low.x, a.high.x);
    let ay = vec2u(a.low.y, a.high.y);
    let az = vec2u(a.low.z, a.high.z);
    let bx = vec2u(b.low.x, b.high.x);
    let by = vec2u(b.low.y, b.high.y);
    let bz = vec2u(b.low.z, b.high.z);
    let sign = a.sign ^ b.sign.yzx;
    let other = ~(a.sign.yzx ^ b.sign);
    return Cross(
        plus128(times(ay, bz, sign.y), times(az, by, other.y)),
        plus128(times(az, bx, sign.z), times(ax, bz, other.z)),
        plus128(times(ax, by, sign.x), times(ay, bx, other.x)),
    );
}

// a.n
fn volume_of(a: Longs, n: Cross) -> Volume {
    let signs = vec3u(0u) - (vec3u(n.x.w, n.y.w, n.z.w) >> vec3u(31u));
    let x = times_wide(vec2u(a.low.x, a.high.x), n.x, a.sign.x, signs.x);
    let y = times_wide(vec2u(a.low.y, a.high.y), n.y, a.sign.y, signs.y);
    let z = times_wide(vec2u(a.low.z, a.high.z), n.z, a.sign.z, signs.z);
    let low = plus128(plus128(x[0], y[0]), z[0]);
    let high = plus128(plus128(x[1], y[1]), z[1]);
    let sign = 0u - (low.w >> 31u);
    return Volume(low.xy, plus128(high, vec4u(low.zw, sign, sign)));
}

// A product with 128 bits: that of their low half, and that of their high half.
fn times_wide(a: vec2u, b: vec4u, a_sign: u32, b_sign: u32) -> array<vec4u, 2> {
    let magnitude = plus128(b ^ vec4u(b_sign), vec4u(b_sign & 1u, 0u, 0u, 0u));
    return array(times(a, magnitude.xy, a_sign ^ b_sign), times(a, magnitude.zw, a_sign ^ b_sign));
}

fn sign_of(v: Volume) -> i32 {
    let is_zero = all(v.low == vec2u(0u)) && all(v.high == vec4u(0u));
    return select(select(1, -1, (v.high.w >> 31u) == 1u), 0, is_zero);
}

// See meets_exactly.
fn meets_narrowly(units: Units, origin: vec3f, direction: vec3f, a: vec3f, b: vec3f, c: vec3f) -> bool {
    let along = difference(direction, vec3f(0.0), units.direction);
    let first = difference(a, origin, units.place);
    let last = difference(c, origin, units.place);
    var tail = first;
    var head = difference(b, origin, units.place);
    var lowest = 0;
    var highest = 0;
    var distance = 0;
    for (var edge = 0u; edge < 3u; edge++) {
        let n = cross_of(tail, head);
        let side = sign_of(volume_of(along, n));
        lowest = min(lowest, side);
        highest = max(highest, side);
        if (edge == 1u) {
            distance = sign_of(volume_of(first, n));
        }
        tail = head;
        head = last;
        if (edge == 1u) {
            head = first;
        }
    }
    // The sides add up to d.n.
    return lowest * highest == 0 && distance != 0 && distance == lowest + highest;
}

// How many bits a number's magnitude has, and the first 32 of them. 0 has none.
fn leading(v: Volume) -> vec2u {
    let words = array<u32, 6>(v.low.x, v.low.y, v.high.x, v.high.y, v.high.z, v.high.w);
    let sign = 0u - (v.high.w >> 31u);
    var carry = sign & 1u;
    var before = 0u;
    var top = 0u;
    var next = 0u;
    var end = 0u;
    for (var place = 0u; place < 6u; place++) {
        let word = (words[place] ^ sign) + carry;
        carry = select(0u, carry, word == 0u);
        if (word != 0u) {
            top = word;
            next = before;
            end = 32u * place + 32u;
        }
        before = word;
    }
    if (top == 0u) {
        return vec2u(0u);
    }
    let shift = countLeadingZeros(top);
    return vec2u(end - shift, (top << shift) | ((next >> 1u) >> (31u - shift)));
}

// (a - o).n and d.n, of which t is the quotient in these units, as `leading` tells them.
fn share_of(units: Units, origin: vec3f, direction: vec3f, a: vec3f, b: vec3f, c: vec3f) -> vec4u {
    let n = cross_of(difference(b, a, units.place), difference(c, a, units.place));
    let distance = volume_of(difference(a, origin, units.place), n);
    let along = volume_of(difference(direction, vec3f(0.0), units.direction), n);
    return vec4u(leading(distance), leading(along));
}

// Compares two quotients: the sign of their difference, or 0 if the first bits do not tell.
fn compare_shares(one: vec4u, other: vec4u) -> i32 {
    if (one.x == 0u || other.x == 0u) {
        return i32(one.x > 0u) - i32(other.x > 0u);
    }
    let bits = i32(one.x + other.z) - i32(other.x + one.z);
    if (abs(bits) > 1) {
        return sign(bits);
    }
    // Each product has 63 or 64 bits, and its first 32 are too small by less than 3.
    let left = product64(one.y, other.w).x >> u32(bits < 0);
    let right = product64(other.y, one.w).x >> u32(bits > 0);
    return i32(left > right + 2u) - i32(right > left + 2u);
}
