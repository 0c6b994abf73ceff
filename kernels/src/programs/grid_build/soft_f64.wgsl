// IEEE 754 binary64 in u32, rounded to nearest even: bit for bit equal to f64, its CPU reference, even on devices that
// contract a product and a sum, and on those without f64.
//
// A number is vec2u(hi, lo): sign, 11 bits of exponent and the upper 20 bits of the fraction are in hi. The algorithms
// are those of Hauser's SoftFloat: significands have ten extra bits, of which the lowest is sticky.
//
// **No subnormals**: as inputs or results they are replaced by 0. The grid's build has none: its inputs are f32, whose
// lowest bit is 2^-149 or more; it adds them, and multiplies at most three such sums (one with a halved term). Each
// result is thus a multiple of 2^-448, also after rounding; no quotient is below 2^-149 / 2^130. All are 0 or far above
// 2^-1022, and far below 2^1024.
//
// NaN and infinities are handled as in IEEE 754, but not which NaN results.

import package::product::{product64};

alias F64 = vec2u;

const F64_SIGN: u32 = 0x80000000u;
const F64_INFINITY: u32 = 0x7ff00000u;
const F64_NAN: vec2u = vec2u(0x7ff80000u, 0u);
const F64_HALF: vec2u = vec2u(0x3fe00000u, 0u);

fn add64(a: vec2u, b: vec2u) -> vec2u {
    let low = a.y + b.y;
    return vec2u(a.x + b.x + u32(low < a.y), low);
}

fn sub64(a: vec2u, b: vec2u) -> vec2u {
    return vec2u(a.x - b.x - u32(a.y < b.y), a.y - b.y);
}

fn less64(a: vec2u, b: vec2u) -> bool {
    return a.x < b.x || (a.x == b.x && a.y < b.y);
}

// Shifts left by less than 64.
fn shl64(v: vec2u, by: u32) -> vec2u {
    if (by == 0u) {
        return v;
    }
    if (by >= 32u) {
        return vec2u(v.y << (by - 32u), 0u);
    }
    return vec2u((v.x << by) | (v.y >> (32u - by)), v.y << by);
}

// Shifts right by any amount; the lowest bit is set if a set bit is lost.
fn shr64_sticky(v: vec2u, by: u32) -> vec2u {
    if (by == 0u) {
        return v;
    }
    if (by >= 64u) {
        return vec2u(0u, u32((v.x | v.y) != 0u));
    }
    if (by >= 32u) {
        let lost = v.y | (v.x & ((1u << (by - 32u)) - 1u));
        return vec2u(0u, (v.x >> (by - 32u)) | u32(lost != 0u));
    }
    let lost = v.y & ((1u << by) - 1u);
    return vec2u(v.x >> by, (v.x << (32u - by)) | (v.y >> by) | u32(lost != 0u));
}

fn f64_exponent(a: F64) -> u32 {
    return (a.x >> 20u) & 0x7ffu;
}

// The significand with its leading one, bit 52; 0 for zeros and subnormals.
fn f64_significand(a: F64) -> vec2u {
    if (f64_exponent(a) == 0u) {
        return vec2u(0u);
    }
    return vec2u((a.x & 0xfffffu) | 0x100000u, a.y);
}

fn f64_abs(a: F64) -> F64 {
    return vec2u(a.x & ~F64_SIGN, a.y);
}

fn f64_neg(a: F64) -> F64 {
    return vec2u(a.x ^ F64_SIGN, a.y);
}

fn f64_is_nan(a: F64) -> bool {
    return less64(vec2u(F64_INFINITY, 0u), f64_abs(a));
}

fn f64_is_zero(a: F64) -> bool {
    return f64_exponent(a) == 0u;
}

// The number with this exponent whose significand has its leading one in bit 62.
fn f64_rounded(sign: u32, exponent: i32, significand: vec2u) -> F64 {
    let spare = significand.y & 0x3ffu;
    let up = add64(significand, vec2u(0u, 0x200u));
    var kept = vec2u(up.x >> 10u, (up.x << 22u) | (up.y >> 10u));
    if (spare == 0x200u) {
        kept.y &= ~1u;
    }
    // The leading one, and a carry beyond it, increment the exponent.
    let biased = exponent - 1 + i32(kept.x >> 20u);
    if (biased <= 0) {
        return vec2u(sign, 0u);
    }
    if (biased >= 0x7ff) {
        return vec2u(sign | F64_INFINITY, 0u);
    }
    return vec2u(sign | (u32(biased) << 20u) | (kept.x & 0xfffffu), kept.y);
}

// The same with the leading one anywhere below bit 63, or without one.
fn f64_normalized(sign: u32, exponent: i32, significand: vec2u) -> F64 {
    if ((significand.x | significand.y) == 0u) {
        return vec2u(sign, 0u);
    }
    let zeros = select(countLeadingZeros(significand.x), 32u + countLeadingZeros(significand.y), significand.x == 0u);
    return f64_rounded(sign, exponent - i32(zeros - 1u), shl64(significand, zeros - 1u));
}

fn f64_add(a: F64, b: F64) -> F64 {
    let is_swapped = less64(f64_abs(a), f64_abs(b));
    let large = select(a, b, is_swapped);
    let small = select(b, a, is_swapped);
    let exponent = f64_exponent(large);
    let differ = ((large.x ^ small.x) & F64_SIGN) != 0u;
    if (exponent == 0x7ffu) {
        let is_undefined = f64_is_nan(large) || (differ && f64_exponent(small) == 0x7ffu);
        return select(large, F64_NAN, is_undefined);
    }
    // The leading one in bit 61, so that a sum has room.
    let kept = shl64(f64_significand(large), 9u);
    let shifted = shr64_sticky(shl64(f64_significand(small), 9u), exponent - f64_exponent(small));
    var sign = large.x & F64_SIGN;
    var sum = add64(kept, shifted);
    if (differ) {
        sum = sub64(kept, shifted);
        // A sum that cancels out is +0.
        sign = select(sign, 0u, (sum.x | sum.y) == 0u);
    }
    return f64_normalized(sign, i32(exponent) + 1, sum);
}

fn f64_sub(a: F64, b: F64) -> F64 {
    return f64_add(a, f64_neg(b));
}

fn f64_mul(a: F64, b: F64) -> F64 {
    let sign = (a.x ^ b.x) & F64_SIGN;
    if (f64_exponent(a) == 0x7ffu || f64_exponent(b) == 0x7ffu) {
        let is_undefined = f64_is_nan(a) || f64_is_nan(b) || f64_is_zero(a) || f64_is_zero(b);
        return select(vec2u(sign | F64_INFINITY, 0u), F64_NAN, is_undefined);
    }
    // Leading ones in bits 62 and 63: the upper half of the product has its own in bit 61 or 62.
    let p = shl64(f64_significand(a), 10u);
    let q = shl64(f64_significand(b), 11u);
    let low = product64(p.y, q.y);
    let middle = add64(product64(p.y, q.x), vec2u(0u, low.x));
    let other = add64(product64(p.x, q.y), vec2u(0u, middle.y));
    var high = add64(product64(p.x, q.x), vec2u(0u, middle.x));
    high = add64(high, vec2u(0u, other.x));
    high.y |= u32((low.y | other.y) != 0u);
    return f64_normalized(sign, i32(f64_exponent(a) + f64_exponent(b)) - 1022, high);
}

// One bit of the quotient per iteration: 55, of which one is spare; the remainder sets the sticky bit.
fn f64_div(a: F64, b: F64) -> F64 {
    let sign = (a.x ^ b.x) & F64_SIGN;
    let a_is_last = f64_exponent(a) == 0x7ffu;
    let b_is_last = f64_exponent(b) == 0x7ffu;
    if (f64_is_nan(a) || f64_is_nan(b) || (a_is_last && b_is_last) || (f64_is_zero(a) && f64_is_zero(b))) {
        return F64_NAN;
    }
    if (a_is_last || f64_is_zero(b)) {
        return vec2u(sign | F64_INFINITY, 0u);
    }
    if (b_is_last || f64_is_zero(a)) {
        return vec2u(sign, 0u);
    }
    let divisor = f64_significand(b);
    var rest = f64_significand(a);
    var exponent = i32(f64_exponent(a)) - i32(f64_exponent(b)) + 1023;
    if (less64(rest, divisor)) {
        rest = shl64(rest, 1u);
        exponent -= 1;
    }
    var quotient = vec2u(0u);
    for (var bit = 0u; bit < 55u; bit++) {
        quotient = shl64(quotient, 1u);
        if (!less64(rest, divisor)) {
            rest = sub64(rest, divisor);
            quotient.y |= 1u;
        }
        rest = shl64(rest, 1u);
    }
    quotient = shl64(quotient, 8u);
    quotient.y |= u32((rest.x | rest.y) != 0u);
    return f64_rounded(sign, exponent, quotient);
}

// An integer that is ordered like the numbers; zeros of both signs are equal.
fn f64_order(a: F64) -> vec2u {
    if (f64_is_zero(a)) {
        return vec2u(F64_SIGN, 0u);
    }
    return select(vec2u(a.x | F64_SIGN, a.y), ~a, (a.x & F64_SIGN) != 0u);
}

fn f64_lt(a: F64, b: F64) -> bool {
    return !f64_is_nan(a) && !f64_is_nan(b) && less64(f64_order(a), f64_order(b));
}

fn f64_ge(a: F64, b: F64) -> bool {
    return !f64_is_nan(a) && !f64_is_nan(b) && !less64(f64_order(a), f64_order(b));
}

// As in Rust: the minimum of a number and a NaN is the number; of two zeros, the first.
fn f64_min(a: F64, b: F64) -> F64 {
    return select(a, b, f64_is_nan(a) || f64_lt(b, a));
}

fn f64_max(a: F64, b: F64) -> F64 {
    return select(a, b, f64_is_nan(a) || f64_lt(a, b));
}

// Truncated and saturated, 0 for NaN, like Rust's `as`.
fn f64_to_i32(a: F64) -> i32 {
    let exponent = f64_exponent(a);
    if (exponent < 1023u || f64_is_nan(a)) {
        return 0;
    }
    let is_negative = (a.x & F64_SIGN) != 0u;
    if (exponent >= 1023u + 31u) {
        return select(0x7fffffff, i32(F64_SIGN), is_negative);
    }
    let by = 1075u - exponent;
    let significand = f64_significand(a);
    var whole = significand.x >> (by & 31u);
    if (by < 32u) {
        whole = (significand.x << (32u - by)) | (significand.y >> by);
    }
    return select(i32(whole), -i32(whole), is_negative);
}

fn f64_from_i32(a: i32) -> F64 {
    return f64_normalized(u32(a) & F64_SIGN, 1023 + 62, vec2u(0u, u32(abs(a))));
}

fn f64_from_f32(bits: u32) -> F64 {
    let sign = bits & 0x80000000u;
    var exponent = i32((bits >> 23u) & 0xffu);
    var fraction = bits & 0x7fffffu;
    if (exponent == 0xff) {
        return vec2u(sign | F64_INFINITY | (fraction >> 3u), fraction << 29u);
    }
    if (exponent == 0) {
        if (fraction == 0u) {
            return vec2u(sign, 0u);
        }
        let by = countLeadingZeros(fraction) - 8u;
        fraction = (fraction << by) & 0x7fffffu;
        exponent = 1 - i32(by);
    }
    return vec2u(sign | (u32(exponent + 896) << 20u) | (fraction >> 3u), fraction << 29u);
}
