//! Operations on normal floats.

use super::inputs::{near_products, of_any_size, ordinary, positive, to_cancel, to_divide, to_round};
use super::{
    COMPARED, CONTRACTION, DIVISION, DIVISION_ULPS, DOT, EXACT, FMA, Judge, ORDER, Operation, ROOT, ROOT_ULPS,
    SIMPLIFIED, SUMS, operation,
};
use crate::self_test::probe::{Inputs, floats, wide};

/// Rounded to nearest. The exact result of the operations for which this is asked is an f64.
const NEAREST: f64 = 0.5;

fn yes(value: bool) -> u32 {
    u32::from(value)
}

/// a b + c, rounded after the product and after the sum, or only after the sum.
fn once_or_twice(a: f32, b: f32, c: f32) -> Vec<(&'static str, u32)> {
    vec![("rounded twice", (a * b + c).to_bits()), ("rounded once", a.mul_add(b, c).to_bits())]
}

pub(super) fn all() -> Vec<Operation> {
    use Judge::{Bits, Float, Near, OneOf, Ulps};
    vec![
        operation(SUMS, "bitcast<u32>(a + b)", ordinary, Ulps(NEAREST, |i| wide(i[0]) + wide(i[1]))),
        operation(SUMS, "bitcast<u32>(a - b)", ordinary, Ulps(NEAREST, |i| wide(i[0]) - wide(i[1]))),
        operation(SUMS, "bitcast<u32>(a * b)", of_any_size, Ulps(NEAREST, |i| wide(i[0]) * wide(i[1]))),
        operation(SUMS, "bitcast<u32>(-a)", ordinary, Bits(|i| i[0] ^ (1 << 31))),
        operation(
            CONTRACTION,
            "bitcast<u32>(a * b + c)",
            ordinary,
            OneOf(|i| {
                let [a, b, c, _] = floats(i);
                once_or_twice(a, b, c)
            }),
        ),
        operation(
            CONTRACTION,
            "bitcast<u32>(c - a * b)",
            ordinary,
            OneOf(|i| {
                let [a, b, c, _] = floats(i);
                once_or_twice(-a, b, c)
            }),
        ),
        // As in an edge function of the triangle test. Either product may be the one that is not rounded.
        operation(
            CONTRACTION,
            "bitcast<u32>(a * b - c * d)",
            near_products,
            OneOf(|i| {
                let [a, b, c, d] = floats(i);
                let mut all = once_or_twice(a, b, -(c * d));
                all.push(("rounded once", (-c).mul_add(d, a * b).to_bits()));
                all
            }),
        ),
        operation(
            FMA,
            "bitcast<u32>(fma(a, b, c))",
            ordinary,
            OneOf(|i| {
                let [a, b, c, _] = floats(i);
                once_or_twice(a, b, c)
            }),
        ),
        operation(
            COMPARED,
            "select(0u, 1u, a * b >= c * d) + select(0u, 2u, a * b <= c * d) + select(0u, 4u, a * b == c * d)",
            near_products,
            Bits(|i| {
                let [a, b, c, d] = floats(i);
                let (ab, cd) = (a * b, c * d);
                yes(ab >= cd) + 2 * yes(ab <= cd) + 4 * yes(ab == cd)
            }),
        ),
        operation(
            ORDER,
            "bitcast<u32>((a + b) + c)",
            to_cancel,
            Float(|i| {
                let [a, b, c, _] = floats(i);
                (a + b) + c
            }),
        ),
        operation(
            ORDER,
            "bitcast<u32>((a * b) * d)",
            to_cancel,
            Float(|i| {
                let [a, b, _, d] = floats(i);
                (a * b) * d
            }),
        ),
        operation(
            SIMPLIFIED,
            "bitcast<u32>(a * d + b * d)",
            ordinary,
            OneOf(|i| {
                let [a, b, _, d] = floats(i);
                let as_written = ("as written", (a * d + b * d).to_bits());
                let contracted = [a.mul_add(d, b * d), b.mul_add(d, a * d)].map(|v| ("as written", v.to_bits()));
                vec![as_written, contracted[0], contracted[1], ("simplified", ((a + b) * d).to_bits())]
            }),
        ),
        operation(
            SIMPLIFIED,
            "bitcast<u32>((a + b) - a)",
            to_cancel,
            OneOf(|i| {
                let [a, b, ..] = floats(i);
                vec![("as written", ((a + b) - a).to_bits()), ("simplified", b.to_bits())]
            }),
        ),
        operation(DIVISION, "bitcast<u32>(a / b)", to_divide, Ulps(DIVISION_ULPS, |i| wide(i[0]) / wide(i[1]))),
        operation(DIVISION, "bitcast<u32>(1.0 / b)", to_divide, Ulps(DIVISION_ULPS, |i| 1.0 / wide(i[1]))),
        operation(ROOT, "bitcast<u32>(sqrt(a))", positive, Ulps(ROOT_ULPS, |i| wide(i[0]).sqrt())),
        // In any order and with any contraction, a product takes part in three roundings at most.
        operation(
            DOT,
            "bitcast<u32>(dot(vec3f(a, b, c), vec3f(d, a, b)))",
            ordinary,
            Near(|i| {
                let [a, b, c, d] = i.map(wide);
                let products = [a * d, b * a, c * b];
                let sizes: f64 = products.iter().map(|product| product.abs()).sum();
                [products.iter().sum(), 3.000_001 * sizes * 24f64.exp2().recip()]
            }),
        ),
        operation(EXACT, "bitcast<u32>(abs(a))", to_round, Float(|i| floats(i)[0].abs())),
        operation(EXACT, "bitcast<u32>(floor(a))", to_round, Float(|i| floats(i)[0].floor())),
        operation(
            EXACT,
            "bitcast<u32>(sign(a))",
            to_round,
            Float(|i| match floats(i)[0] {
                0.0 => 0.0,
                a => a.signum(),
            }),
        ),
        operation(EXACT, "bitcast<u32>(min(a, b))", to_round, Float(|i| floats(i)[0].min(floats(i)[1]))),
        operation(EXACT, "bitcast<u32>(max(a, b))", to_round, Float(|i| floats(i)[0].max(floats(i)[1]))),
        operation(
            EXACT,
            "bitcast<u32>(clamp(a, min(b, c), max(b, c)))",
            to_round,
            Float(|i| {
                let [a, b, c, _] = floats(i);
                a.clamp(b.min(c), b.max(c))
            }),
        ),
        operation(
            EXACT,
            "bitcast<u32>(select(a, b, c < d))",
            to_round,
            Float(|i| {
                let [a, b, c, d] = floats(i);
                if c < d { b } else { a }
            }),
        ),
        operation(EXACT, COMPARISONS, to_round, Bits(comparisons)),
    ]
}

const COMPARISONS: &str = "select(0u, 1u, any(vec2f(a, b) < vec2f(c, d))) \
                           + select(0u, 2u, all(vec2f(a, b) <= vec2f(c, d))) \
                           + select(0u, 4u, a > b || c == d) + select(0u, 8u, a >= b && c != d) \
                           + select(0u, 16u, !(a > c))";

fn comparisons(i: Inputs) -> u32 {
    let [a, b, c, d] = floats(i);
    yes(a < c || b < d)
        + 2 * yes(a <= c && b <= d)
        + 4 * yes(a > b || c == d)
        + 8 * yes(a >= b && c != d)
        + 16 * yes(a <= c)
}
