//! A second witness for t: rational arithmetic, without any rounding or bound of the other reference.

use std::cmp::Ordering;

use num_bigint::{BigInt, Sign};

use super::exact::integer;

/// The error of a computed t: its distance from the exact t at which the ray meets the triangle's plane, rounded once,
/// to f64. `None` if the triangle is exactly edge-on, or t is not finite.
#[must_use]
pub fn error_of_t(t: f64, origin: [f32; 3], direction: [f32; 3], corners: [[f32; 3]; 3]) -> Option<f64> {
    if !t.is_finite() {
        return None;
    }
    let [off, along] = fraction(origin, direction, corners);
    if along.sign() == Sign::NoSign {
        return None;
    }
    let (mantissa, exponent) = parts(t);
    // t - off / along = (mantissa * along * 2^exponent - off) / along
    let difference = match exponent {
        0.. => ((mantissa * &along) << exponent.unsigned_abs()) - off,
        _ => mantissa * &along - (off << exponent.unsigned_abs()),
    };
    let denominator = if exponent < 0 { along << exponent.unsigned_abs() } else { along };
    Some(quotient(&difference, &denominator).abs())
}

/// Numerator and denominator of t, in the same units; the denominator is not negative, and 0 if the triangle is edge-on.
fn fraction(origin: [f32; 3], direction: [f32; 3], corners: [[f32; 3]; 3]) -> [BigInt; 2] {
    let [o, d] = [origin, direction].map(|v| v.map(integer));
    let p = corners.map(|corner| corner.map(integer));
    let [ab, ac] = [1, 2].map(|k| [0, 1, 2].map(|axis| &p[k][axis] - &p[0][axis]));
    let normal = [(1, 2), (2, 0), (0, 1)].map(|(i, j)| &ab[i] * &ac[j] - &ab[j] * &ac[i]);
    let dot = |v: [&BigInt; 3]| (0..3).map(|axis| &normal[axis] * v[axis]).sum::<BigInt>();
    let off = [0, 1, 2].map(|axis| &p[0][axis] - &o[axis]);
    let fraction = [dot([&off[0], &off[1], &off[2]]), dot([&d[0], &d[1], &d[2]])];
    if fraction[1].sign() == Sign::Minus { fraction.map(|part| -part) } else { fraction }
}

/// Compares the t at which a ray meets the planes of two triangles, neither of which it sees edge-on.
pub(super) fn compare_t(origin: [f32; 3], direction: [f32; 3], corners: [[[f32; 3]; 3]; 2]) -> Ordering {
    let [[off, along], [other_off, other_along]] = corners.map(|corners| fraction(origin, direction, corners));
    (off * other_along).cmp(&(other_off * along))
}

/// Whether a ray meets the plane of a triangle at a t that is rounded to an f32 below `end`, if it does not see the triangle
/// edge-on: below the middle between `end` and the f32 before it, or at it, if `end` is the odd one.
pub(super) fn is_before(end: f32, origin: [f32; 3], direction: [f32; 3], corners: [[f32; 3]; 3]) -> bool {
    let [off, along] = fraction(origin, direction, corners);
    let (mantissa, exponent) = parts((f64::from(end.next_down()) + f64::from(end)) / 2.0);
    let (shift, is_large) = (exponent.unsigned_abs(), exponent >= 0);
    let order =
        if is_large { off.cmp(&((mantissa * along) << shift)) } else { (off << shift).cmp(&(mantissa * along)) };
    order.is_lt() || (order.is_eq() && end.to_bits() % 2 == 1)
}

/// Whether a ray meets the plane of a triangle at t > 0.
pub(super) fn is_in_front(origin: [f32; 3], direction: [f32; 3], corners: [[f32; 3]; 3]) -> bool {
    fraction(origin, direction, corners).iter().all(|part| part.sign() == Sign::Plus)
}

/// `value = mantissa * 2^exponent`
fn parts(value: f64) -> (BigInt, i64) {
    let bits = value.to_bits();
    let (biased, fraction) = (((bits >> 52) & 0x7ff) as i64, bits & ((1 << 52) - 1));
    let mantissa = if biased > 0 { fraction | (1 << 52) } else { fraction };
    let mantissa = if value < 0.0 { -BigInt::from(mantissa) } else { BigInt::from(mantissa) };
    (mantissa, biased.max(1) - 1075)
}

/// a / b, rounded; b is not 0.
fn quotient(a: &BigInt, b: &BigInt) -> f64 {
    // 64 or 65 digits of the quotient are more than f64 has.
    let shift = 64 + b.bits() as i64 - a.bits() as i64;
    let digits = if shift >= 0 { (a << shift.unsigned_abs()) / b } else { a / (b << shift.unsigned_abs()) };
    let value = digits.iter_u64_digits().rev().fold(0.0, |sum, digit| sum * 2f64.powi(64) + digit as f64);
    let sign = if digits.sign() == Sign::Minus { -1.0 } else { 1.0 };
    // In two steps: a power below the smallest number may belong to a product that is not.
    let half = (shift / 2) as i32;
    sign * value * 2f64.powi(-half) * 2f64.powi(half - shift as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_is_known_to_its_last_digit() {
        // The plane z = 3; from z = 1 along (0, 0, 3) it is met at t = 2/3.
        let corners = [[0.0, 0.0, 3.0], [1.0, 0.0, 3.0], [0.0, 1.0, 3.0]];
        let error = |t: f64| error_of_t(t, [0.25, 0.25, 1.0], [0.0, 0.0, 3.0], corners).expect("a t");
        // The nearest f64 to 2/3 is below it by 2⁻⁵³ · 2/3 · ½: 3 · f64(2/3) = 2 - 2⁻⁵³ · 1.
        let two_thirds = 2.0f64 / 3.0;
        let exact = f64::EPSILON / 2.0 / 3.0;
        assert!((error(two_thirds) / exact - 1.0).abs() < 1e-12, "{:e} is not {exact:e}", error(two_thirds));
        let f32_error = (f64::from(2.0f32 / 3.0) - two_thirds).abs();
        assert!((error(f64::from(2.0f32 / 3.0)) / f32_error - 1.0).abs() < 1e-7);
        assert_eq!(
            error_of_t(1.0, [0.0; 3], [0.0, 0.0, 1.0], [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]]),
            Some(0.0)
        );
        assert_eq!(error_of_t(1.0, [0.0; 3], [1.0, 0.0, 0.0], corners), None, "edge-on");
        // Extreme scales: the quotient of huge integers is an ordinary number.
        let tiny = corners.map(|c| c.map(|v: f32| v * 1e-30));
        let tiny_error = error_of_t(2.0, [0.0, 0.0, 1e-30], [0.0, 0.0, 1e-30], tiny).expect("a t");
        assert!(tiny_error < 1e-6, "{tiny_error}");
    }
}
