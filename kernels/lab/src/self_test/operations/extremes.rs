//! Operations on subnormal floats, infinities and NaNs: what a driver does with them is told, and raystep works with
//! it.

use std::cmp::Ordering;

use super::inputs::{not_finite, small};
use super::{Judge, NOT_FINITE, Operation, SUBNORMALS, operation};
use crate::self_test::probe::floats;

/// What an operation may give: its result, or that of inputs of which subnormal ones were flushed to 0, or 0 if the
/// exact result is below the smallest normal float, also if it would be rounded to that.
fn kept_or_flushed([a, b]: [f32; 2], operation: fn(f64, f64) -> f64) -> Vec<(&'static str, u32)> {
    let flushed = |v: f32| if v.is_subnormal() { 0.0 } else { v };
    let exact = |a: f32, b: f32| operation(f64::from(a), f64::from(b));
    let (kept, of_flushed) = (exact(a, b), exact(flushed(a), flushed(b)));
    let is_small = |v: f64| v.abs() < f64::from(f32::MIN_POSITIVE);
    // The sign of a zero is free.
    let bits = |name, v: f32| match v {
        0.0 => vec![(name, 0), (name, 1 << 31)],
        _ => vec![(name, v.to_bits())],
    };
    let mut all = bits("kept", kept as f32);
    all.extend(bits("flushed", of_flushed as f32));
    if is_small(kept) || is_small(of_flushed) {
        all.extend(bits("flushed", 0.0));
    }
    all
}

/// Either answer of a comparison, of which one is right by IEEE 754.
fn either(answer: bool) -> Vec<(&'static str, u32)> {
    vec![("as by IEEE 754", u32::from(answer)), ("otherwise", u32::from(!answer))]
}

pub(super) fn all() -> Vec<Operation> {
    use Judge::OneOf;
    let of_small = |wgsl, all| operation(SUBNORMALS, wgsl, small, OneOf(all));
    let of_others = |wgsl, all| operation(NOT_FINITE, wgsl, not_finite, OneOf(all));
    vec![
        of_small("bitcast<u32>(a + b)", |i| kept_or_flushed([floats(i)[0], floats(i)[1]], |a, b| a + b)),
        of_small("bitcast<u32>(a - b)", |i| kept_or_flushed([floats(i)[0], floats(i)[1]], |a, b| a - b)),
        of_small("bitcast<u32>(a * c)", |i| kept_or_flushed([floats(i)[0], floats(i)[2]], |a, c| a * c)),
        of_small("bitcast<u32>(b * c)", |i| kept_or_flushed([floats(i)[1], floats(i)[2]], |b, c| b * c)),
        of_small("bitcast<u32>(max(a, b))", |i| kept_or_flushed([floats(i)[0], floats(i)[1]], f64::max)),
        of_others("select(0u, 1u, a <= b)", |i| either(floats(i)[0] <= floats(i)[1])),
        // With negated comparisons, kernels reject what is not a number.
        of_others("select(0u, 1u, !(a <= b))", |i| {
            let order = floats(i)[0].partial_cmp(&floats(i)[1]);
            either(!matches!(order, Some(Ordering::Less | Ordering::Equal)))
        }),
        of_others("select(0u, 1u, a + b < c)", |i| {
            let [a, b, c, _] = floats(i);
            either(a + b < c)
        }),
    ]
}
