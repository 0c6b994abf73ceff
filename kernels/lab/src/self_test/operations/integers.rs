//! Operations on integers, and conversions from and to them.

use super::inputs::{beyond_integers, integers, of_any_size, to_convert, with_divisor};
use super::{CONVERSIONS, INTEGERS, Judge, Operation, operation};
use crate::self_test::probe::{Inputs, floats};

type Exact = fn(Inputs) -> u32;

fn yes(value: bool) -> u32 {
    u32::from(value)
}

/// Unsigned integers, modulo 2³².
const UNSIGNED: [(&str, Exact); 18] = [
    ("x + z", |i| i[0].wrapping_add(i[2])),
    ("x - z", |i| i[0].wrapping_sub(i[2])),
    ("x * z", |i| i[0].wrapping_mul(i[2])),
    ("x / y", |i| i[0] / i[1]),
    ("x % y", |i| i[0] % i[1]),
    ("(x & z) ^ (~x | y)", |i| (i[0] & i[2]) ^ (!i[0] | i[1])),
    ("(x << (y & 31u)) + (x >> (z & 31u))", |i| (i[0] << (i[1] & 31)).wrapping_add(i[0] >> (i[2] & 31))),
    ("select(0u, 1u, (x < z) != (y < w))", |i| yes((i[0] < i[2]) != (i[1] < i[3]))),
    ("countOneBits(x)", |i| i[0].count_ones()),
    ("countLeadingZeros(x)", |i| i[0].leading_zeros()),
    ("firstLeadingBit(x)", |i| i[0].checked_ilog2().unwrap_or(u32::MAX)),
    ("firstTrailingBit(x)", |i| if i[0] == 0 { u32::MAX } else { i[0].trailing_zeros() }),
    ("reverseBits(x)", |i| i[0].reverse_bits()),
    ("min(x, z) + max(y, w)", |i| i[0].min(i[2]).wrapping_add(i[1].max(i[3]))),
    ("clamp(x, min(z, w), max(z, w))", |i| i[0].clamp(i[2].min(i[3]), i[2].max(i[3]))),
    ("dot(vec3u(x, y, z), vec3u(y, z, w))", |[x, y, z, w]| {
        x.wrapping_mul(y).wrapping_add(y.wrapping_mul(z)).wrapping_add(z.wrapping_mul(w))
    }),
    ("select(0u, 1u, x < z) + select(0u, 2u, x <= z) + select(0u, 4u, x == z || x >= w)", |[x, _, z, w]| {
        yes(x < z) + 2 * yes(x <= z) + 4 * yes(x == z || x >= w)
    }),
    (
        "select(0u, 1u, all(vec2<bool>(x < z, y < w) | vec2<bool>(x > w, y > z)) & !(x == w)) + select(0u, 2u, x != z)",
        |i| {
            let [x, y, z, w] = i;
            yes((x < z || x > w) && (y < w || y > z) && x != w) + 2 * yes(x != z)
        },
    ),
];

/// Signed integers, modulo 2³². Divisors are positive, as in the kernels.
const SIGNED: [(&str, Exact); 9] = [
    ("u32(bitcast<i32>(x) / bitcast<i32>((y >> 1u) | 1u))", |i| (i[0] as i32 / ((i[1] >> 1) | 1) as i32) as u32),
    ("u32(bitcast<i32>(x) % bitcast<i32>((y >> 1u) | 1u))", |i| (i[0] as i32 % ((i[1] >> 1) | 1) as i32) as u32),
    ("u32(select(i32(x), i32(z), y < w))", |i| if i[1] < i[3] { i[2] } else { i[0] }),
    ("u32(bitcast<i32>(x) + bitcast<i32>(z))", |i| i[0].wrapping_add(i[2])),
    ("u32(bitcast<i32>(x) - bitcast<i32>(z))", |i| i[0].wrapping_sub(i[2])),
    ("u32(bitcast<i32>(x) * bitcast<i32>(z))", |i| i[0].wrapping_mul(i[2])),
    ("u32(-bitcast<i32>(x >> 1u)) + u32(abs(bitcast<i32>(x) >> 1u)) + u32(bitcast<i32>(z) << 1u)", |i| {
        (i[0] >> 1).wrapping_neg().wrapping_add((i[0] as i32 >> 1).unsigned_abs()).wrapping_add(i[2] << 1)
    }),
    (
        "u32(clamp(bitcast<i32>(x), min(bitcast<i32>(y), bitcast<i32>(z)), max(bitcast<i32>(y), bitcast<i32>(z))))",
        |i| {
            let [x, y, z, _] = i.map(|v| v as i32);
            x.clamp(y.min(z), y.max(z)) as u32
        },
    ),
    (COMPARISONS, |i| {
        let [x, y, z, w] = i.map(|v| v as i32);
        yes(x < z) + 2 * yes(x <= z) + 4 * yes(x > y) + 8 * yes(x >= y) + 16 * yes(x == w) + 32 * yes(x != w)
    }),
];

const COMPARISONS: &str = "select(0u, 1u, bitcast<i32>(x) < bitcast<i32>(z)) \
                           + select(0u, 2u, bitcast<i32>(x) <= bitcast<i32>(z)) \
                           + select(0u, 4u, bitcast<i32>(x) > bitcast<i32>(y)) \
                           + select(0u, 8u, bitcast<i32>(x) >= bitcast<i32>(y)) \
                           + select(0u, 16u, bitcast<i32>(x) == bitcast<i32>(w)) \
                           + select(0u, 32u, bitcast<i32>(x) != bitcast<i32>(w))";

pub(super) fn all() -> Vec<Operation> {
    use Judge::{Bits, Float, OneOf, Ulps};
    let of_type = |(wgsl, exact): (&'static str, Exact)| operation(INTEGERS, wgsl, with_divisor, Bits(exact));
    let mut all: Vec<Operation> = UNSIGNED.into_iter().chain(SIGNED).map(of_type).collect();
    all.extend([
        // What kernels convert is below 2^24, or below 2^25 where the last bit is free.
        operation(CONVERSIONS, "bitcast<u32>(f32(x >> 8u))", integers, Float(|i| (i[0] >> 8) as f32)),
        operation(
            CONVERSIONS,
            "bitcast<u32>(f32(bitcast<i32>(x) >> 8u))",
            integers,
            Float(|i| (i[0] as i32 >> 8) as f32),
        ),
        // Of larger ones WGSL allows either neighbour. SwiftShader does not always take the nearest.
        operation(CONVERSIONS, "bitcast<u32>(f32(x))", integers, Ulps(1.0, |i| f64::from(i[0]))),
        operation(CONVERSIONS, "bitcast<u32>(f32(bitcast<i32>(x)))", integers, Ulps(1.0, |i| f64::from(i[0] as i32))),
        operation(CONVERSIONS, "u32(i32(a))", to_convert, Bits(|i| floats(i)[0] as i32 as u32)),
        operation(CONVERSIONS, "u32(abs(a))", to_convert, Bits(|i| floats(i)[0].abs() as u32)),
        // WGSL: the nearest number of the type, or the nearest of those that are also floats.
        operation(
            CONVERSIONS,
            "u32(i32(a))",
            beyond_integers,
            OneOf(|i| match floats(i)[0] > 0.0 {
                true => vec![("clamped", i32::MAX as u32), ("clamped", 0x7fff_ff80)],
                false => vec![("clamped", i32::MIN as u32)],
            }),
        ),
        operation(
            CONVERSIONS,
            "u32(a)",
            beyond_integers,
            OneOf(|i| match floats(i)[0] > 0.0 {
                true => vec![("clamped", u32::MAX), ("clamped", 0xffff_ff00)],
                false => vec![("clamped", 0)],
            }),
        ),
        operation(CONVERSIONS, "bitcast<u32>(bitcast<f32>(bitcast<i32>(x)))", of_any_size, Bits(|i| i[0])),
        operation(CONVERSIONS, "bitcast<vec2u>(bitcast<vec2f>(vec2u(x, y))).y", of_any_size, Bits(|i| i[1])),
        operation(
            CONVERSIONS,
            "u32(bitcast<vec2i>(vec2f(a, b)).x) + u32(x > z)",
            of_any_size,
            Bits(|i| i[0].wrapping_add(yes(i[0] > i[2]))),
        ),
    ]);
    all
}
