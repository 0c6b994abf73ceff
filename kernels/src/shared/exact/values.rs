//! t, u and v of a hit, each the exact value rounded once: for the f32 of the ray and the corners.
//!
//! With d the ray's direction, o its origin and n = (b − a) × (c − a), t = (a − o) · n / d · n, and a corner's weight is
//! d · ((q − o) × (p − o)) / d · n for the edge opposite, from q to p. In f64 nearly all of them are known well enough to
//! tell to which f32 they round (Ziv, 1991); integers tell the rest.

use std::cmp::Ordering;

use super::{Point, Sum, WORDS, distance, volume as sum_of_volume};

/// Rounding of f64.
const UNIT: f64 = f64::EPSILON / 2.0;

/// A number, and a bound on its error in units of [`UNIT`].
#[derive(Clone, Copy)]
struct Bounded {
    value: f64,
    error: f64,
}

/// x · (p × q), with p and q relative to the same point.
///
/// With u the rounding of f64: coordinates of p and q are off by at most u of themselves, their products by 3u, the
/// differences of these by 4u of the products' magnitudes, and the products with x, which may be off by u too, by 6u; two
/// sums add 2u of all magnitudes. 9 instead of 8 is more than what is left out, squares of u. Nothing under- or overflows:
/// products of three f32 or of their differences are between 2⁻⁴⁴⁷ and 2³⁸⁷, or 0.
fn volume(x: [f64; 3], p: [f64; 3], q: [f64; 3]) -> Bounded {
    let (mut value, mut error) = (0.0, 0.0);
    for (i, j, k) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
        let (plus, minus) = (p[j] * q[k], p[k] * q[j]);
        value += x[i] * (plus - minus);
        error += x[i].abs() * (plus.abs() + minus.abs());
    }
    Bounded { value, error: 9.0 * error }
}

/// The f32 to which a quotient rounds, if its bound tells.
fn quotient(above: Bounded, below: Bounded) -> Option<f32> {
    let middle = above.value / below.value;
    // Of a divisor that is off by at most a thousandth. The quotient's own rounding, and that of the bound, is the 4.
    let below_error = below.error / below.value.abs();
    if below_error * UNIT > 1e-3 || below.value == 0.0 {
        return None;
    }
    let error = 1.01 * UNIT * ((above.error / below.value).abs() + middle.abs() * (below_error + 4.0));
    let [low, high] = [middle - error, middle + error].map(|end| end as f32);
    // An exact 0 has no sign, and what may be on either side of it is left to integers.
    (low == high && (low != 0.0 || error == 0.0)).then_some(low + 0.0)
}

/// t and the weights of vertices 1 and 2 where a ray meets a triangle: `None` if it does not meet it at t ≥ 0. What is above
/// all f32 is the largest one, and a t above 0 is never rounded to it.
#[must_use]
pub fn rounded_values(origin: Point, direction: Point, corners: [Point; 3]) -> Option<[f32; 3]> {
    let wide = |v: Point| v.map(f64::from);
    let minus = |p: Point, q: Point| [0, 1, 2].map(|axis| f64::from(p[axis]) - f64::from(q[axis]));
    let [a, b, c] = corners;
    let [to_a, to_b, to_c] = corners.map(|corner| minus(corner, origin));
    let (edge, other) = (minus(b, a), minus(c, a));
    let (d, along) = (wide(direction), volume(wide(direction), edge, other));
    let values = [volume(to_a, edge, other), volume(d, to_c, to_a), volume(d, to_a, to_b)];
    let [t, u, v] = values.map(|value| quotient(value, along).filter(|value| value.is_finite()));
    let rest = volume(d, to_b, to_c);
    let is_inside = rest.value.abs() > 1.01 * UNIT * rest.error && (rest.value > 0.0) == (along.value > 0.0);
    if let (Some(t), Some(u), Some(v)) = (t, u, v)
        && is_inside
        && t > 0.0
        && u >= 0.0
        && v >= 0.0
    {
        return Some([t, u, v]);
    }
    in_integers(origin, direction, corners)
}

/// The same, by integers alone.
fn in_integers(origin: Point, direction: Point, corners: [Point; 3]) -> Option<[f32; 3]> {
    let [a, b, c] = corners;
    let side = |tail: Point, head: Point| sum_of_volume(direction, [tail, head, origin]);
    let mut parts = [distance(origin, corners), side(c, a), side(a, b), side(b, c)];
    let mut along = sum_of_volume(direction, corners);
    let sign = along.settle();
    let outside = parts.each_mut().map(Sum::settle).contains(&sign.reverse());
    let [t, u, v] = [0, 1, 2].map(|part| rounded_quotient(&parts[part], &along));
    // What is above 0 stays there.
    let least = if parts[0].bit_length() > 0 { f32::from_bits(1) } else { 0.0 };
    (sign.is_ne() && !outside).then_some([t.max(least), u, v])
}

/// The quotient of two magnitudes, rounded to the nearest f32, of two equally near ones to the even one.
fn rounded_quotient(above: &Sum, below: &Sum) -> f32 {
    let [above_bits, below_bits] = [above, below].map(Sum::bit_length);
    if above_bits == 0 || below_bits == 0 {
        return 0.0;
    }
    // Both get the same number of bits, so that the quotient is above 1/2 and below 2; then a bit of it at a time.
    let bits = above_bits.max(below_bits);
    let (mut above, below) = (above.shifted_up(bits - above_bits), below.shifted_up(bits - below_bits));
    let (low, end) = (above.low.min(below.low), (above.end.max(below.end) + 1).min(WORDS));
    let (mut digits, mut is_rest) = (0u32, false);
    for _ in 0..27 {
        let places = (low..end).rev();
        let order = places.map(|i| above.plus[i].cmp(&below.plus[i])).find(|order| order.is_ne());
        let is_in = order != Some(Ordering::Less);
        digits = digits << 1 | u32::from(is_in);
        is_rest = false;
        let (mut borrow, mut carry) = (false, 0);
        for i in low..end {
            let other = if is_in { below.plus[i] } else { 0 };
            let (difference, is_less) = above.plus[i].overflowing_sub(other);
            let (rest, is_less_still) = difference.overflowing_sub(u32::from(borrow));
            borrow = is_less || is_less_still;
            above.plus[i] = rest << 1 | carry;
            carry = rest >> 31;
            is_rest |= rest != 0;
        }
    }
    // 27 bits of which the first may be 0: 24 are kept, fewer of a subnormal number, and what is cut off decides.
    let exponent = above_bits as i32 - below_bits as i32 - (digits.leading_zeros() as i32 - 5);
    let cut = 8 - digits.leading_zeros() as i32 + (-126 - exponent).max(0);
    if cut > 28 {
        return 0.0;
    }
    let kept = digits >> cut;
    let half = 1 << (cut - 1);
    let part = digits & (2 * half - 1);
    let is_up = part > half || (part == half && (is_rest || kept & 1 == 1));
    // A carry out of the digits is one into the exponent.
    let bits = (((exponent + 126).clamp(0, 254) as u32) << 23) + kept + u32::from(is_up);
    f32::from_bits(bits.min(f32::MAX.to_bits()))
}

impl Sum {
    /// The number of bits of a magnitude.
    fn bit_length(&self) -> u32 {
        let last = (self.low..self.end).rev().find(|&i| self.plus[i] != 0);
        last.map_or(0, |i| 32 * (i as u32 + 1) - self.plus[i].leading_zeros())
    }

    /// A magnitude times 2^`by`.
    fn shifted_up(&self, by: u32) -> Self {
        let (places, bits) = ((by / 32) as usize, by % 32);
        let mut up = Self { low: self.low + places, end: (self.end + places + 1).min(WORDS), ..Self::new() };
        for i in up.low..up.end {
            let word = |i: usize| if i < self.end { self.plus[i] } else { 0 };
            let from = i - places;
            let lower = if from > self.low { word(from - 1) } else { 0 };
            up.plus[i] = word(from) << bits | (lower >> 1) >> (31 - bits);
        }
        up
    }
}

#[cfg(test)]
mod tests;
