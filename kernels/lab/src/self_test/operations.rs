//! The operations of WGSL that kernels use, each with inputs and with what its result may be.
//!
//! Bounds are those of the WGSL specification (*Floating point accuracy*) on which the kernels' own bounds rely
//! (`docs/numerics.md`). Sums, differences and products have to be rounded to nearest, which WGSL does not promise, but
//! which every bound assumes. `pow`, `exp2`, `sin` and `cos` are not here, since no kernel calls them; a test shows
//! that whatever a kernel does call is here.

mod extremes;
mod floats;
mod inputs;
mod integers;

use super::probe::Inputs;

/// What a result may be.
#[derive(Clone, Copy)]
pub(super) enum Judge {
    /// These bits.
    Bits(fn(Inputs) -> u32),
    /// This float; the sign of a zero is free.
    Float(fn(Inputs) -> f32),
    /// This number, by so many units in its last place.
    Ulps(f64, fn(Inputs) -> f64),
    /// The first number, by at most the second one.
    Near(fn(Inputs) -> [f64; 2]),
    /// One of these bits, which have names.
    OneOf(fn(Inputs) -> Vec<(&'static str, u32)>),
}

/// Makes inputs from random bits.
type Make = fn([u64; 4]) -> Inputs;

/// An operation.
pub(super) struct Operation {
    /// The check that it is for.
    pub(super) check: &'static str,
    /// As a value of type u32, of the floats a, b, c and d, and of their bits x, y, z and w.
    pub(super) wgsl: &'static str,
    /// Its inputs.
    pub(super) inputs: Make,
    /// What its result may be.
    pub(super) judge: Judge,
}

const fn operation(check: &'static str, wgsl: &'static str, inputs: Make, judge: Judge) -> Operation {
    Operation { check, wgsl, inputs, judge }
}

pub(super) const SUMS: &str = "a + b, a * b";
pub(super) const CONTRACTION: &str = "a * b + c";
pub(super) const FMA: &str = "fma(a, b, c)";
pub(super) const COMPARED: &str = "a * b >= c * d";
pub(super) const ORDER: &str = "(a + b) + c";
pub(super) const SIMPLIFIED: &str = "a + b - a";
pub(super) const DIVISION: &str = "a / b";
pub(super) const ROOT: &str = "sqrt(a)";
pub(super) const DOT: &str = "dot(v, w)";
pub(super) const EXACT: &str = "floor, min, …";
pub(super) const CONVERSIONS: &str = "conversions";
pub(super) const INTEGERS: &str = "integers";
pub(super) const SUBNORMALS: &str = "subnormals";
pub(super) const NOT_FINITE: &str = "NaN, infinity";

/// WGSL's bound for a / b where b and the quotient are normal; `docs/numerics.md` assumes it.
pub(super) const DIVISION_ULPS: f64 = 2.5;

/// WGSL's sqrt is as accurate as 1 / inverseSqrt: 2 units in the last place of the latter, which are up to 4 in that of
/// its inverse, and those of the division.
pub(super) const ROOT_ULPS: f64 = 4.0 + DIVISION_ULPS;

/// All operations.
pub(super) fn all() -> Vec<Operation> {
    let mut all = floats::all();
    all.extend(integers::all());
    all.extend(extremes::all());
    all
}
