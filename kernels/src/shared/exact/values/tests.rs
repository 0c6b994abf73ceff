//! Compares rounded values with quotients of integers of any size.

use std::cmp::Ordering;

use num_bigint::{BigInt, Sign};

use super::*;
use crate::shared::exact::tests::{KINDS, given, parts};

/// 2¹⁵⁰ times the middle between two f32.
fn middle(a: f32, b: f32) -> BigInt {
    let (bits, sum) = ((f64::from(a) + f64::from(b)).to_bits(), f64::from(a) + f64::from(b));
    let exponent = (bits >> 52) as i64 - 1075 + 149;
    let digits = BigInt::from(bits & ((1 << 52) - 1) | 1 << 52);
    match sum {
        0.0 => BigInt::ZERO,
        _ if exponent < 0 => digits >> -exponent,
        _ => digits << exponent,
    }
}

/// Whether a quotient rounds to an f32.
fn rounds_to(above: &BigInt, below: &BigInt, value: f32) -> bool {
    let scaled: BigInt = above << 150u32;
    let is_even = value.to_bits() & 1 == 0;
    let is_within = |order: Ordering, outside: Ordering| order != outside && (order != Ordering::Equal || is_even);
    let (lower, upper) = (middle(value.next_down().max(0.0), value), middle(value, value.next_up()));
    (value == 0.0 || is_within(scaled.cmp(&(lower * below)), Ordering::Less))
        && (value == f32::MAX || is_within(scaled.cmp(&(upper * below)), Ordering::Greater))
}

#[test]
fn values_are_the_exact_ones_rounded_once() {
    let mut random = fastrand::Rng::with_seed(49);
    let (mut met, mut subnormal) = (0, 0);
    for i in 0..80_000 {
        let ray = given(&mut random, i % KINDS);
        let [o, d, a, b, c, ..] = ray;
        let found = rounded_values(o, d, [a, b, c]);
        let (parts, along) = parts(o, d, [a, b, c]);
        let is_met = along != BigInt::ZERO && parts.iter().all(|part| part.sign() != Sign::Minus);
        assert_eq!(found.is_some(), is_met, "{ray:?}");
        let Some(found) = found else { continue };
        let [t, _, u, v] = parts;
        if found[0].to_bits() == 1 {
            assert!(t.sign() == Sign::Plus, "{ray:?}");
            continue;
        }
        for (above, value) in [t, u, v].into_iter().zip(found) {
            assert!(rounds_to(&above, &along, value), "{value:e} of {found:?} in {ray:?}");
            subnormal += u32::from(value.is_subnormal());
        }
        // Integers alone.
        let other = in_integers(o, d, [a, b, c]).map(|values| values.map(f32::to_bits));
        assert_eq!(other, Some(found.map(f32::to_bits)), "{ray:?}");
        met += 1;
    }
    assert!(met > 20_000 && subnormal > 0, "{met} met, {subnormal} subnormal values");
}
