//! Twin of `exact.wgsl`: whether a ray meets a triangle, and which of two it meets first, in integers.

pub mod values;

use std::cmp::Ordering;

use super::constants::INF;
pub use super::narrow::Point;
use super::narrow::{Share, Units, common_sign, meets_narrowly};

/// 32-bit words of a sum of products of three f32, in units of 2⁻⁴⁴⁷.
const WORDS: usize = 27;

/// A sum of products: those that are added, and those that are subtracted. All words below `low` are 0, and those from
/// `end` on.
#[derive(Clone, Copy)]
pub(super) struct Sum {
    plus: [u32; WORDS],
    minus: [u32; WORDS],
    low: usize,
    end: usize,
}

impl Sum {
    pub(super) fn new() -> Self {
        Self { plus: [0; WORDS], minus: [0; WORDS], low: WORDS, end: 0 }
    }

    fn add_product(&mut self, factors: Point, is_negative: bool) {
        let bits = factors.map(f32::to_bits);
        let parts = bits.map(|bits| {
            let (exponent, fraction) = ((bits >> 23) & 0xff, bits & 0x7f_ffff);
            (exponent.max(1), u128::from(if exponent == 0 { fraction } else { fraction | 0x80_0000 }))
        });
        let product = parts.iter().map(|(_, digits)| digits).product::<u128>();
        if product == 0 {
            return;
        }
        let at = parts.iter().map(|(exponent, _)| exponent).sum::<u32>() - 3;
        let mut shifted = product << (at % 32);
        let first = (at / 32) as usize;
        let is_minus = ((bits[0] ^ bits[1] ^ bits[2]) >> 31 == 1) != is_negative;
        let words = if is_minus { &mut self.minus } else { &mut self.plus };
        let (mut place, mut carry) = (first, 0);
        for word in 0.. {
            if word >= 4 && carry == 0 {
                break;
            }
            let all = u64::from(words[place]) + (shifted as u32 as u64) + carry;
            words[place] = all as u32;
            (carry, shifted) = (all >> 32, shifted >> 32);
            place += 1;
        }
        self.low = self.low.min(first);
        self.end = self.end.max(place);
    }

    /// x · ((q − p) × (r − p)) = x · (p × q + q × r + r × p)
    pub(super) fn add_volume(&mut self, x: Point, [p, q, r]: [Point; 3], is_negative: bool) {
        for [tail, head] in [[p, q], [q, r], [r, p]] {
            for (axis, along) in x.into_iter().enumerate() {
                let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
                self.add_product([along, tail[next], head[last]], is_negative);
                self.add_product([along, tail[last], head[next]], !is_negative);
            }
        }
    }

    /// Leaves the magnitude in `plus`, and returns the sign.
    pub(super) fn settle(&mut self) -> Ordering {
        let words = || (self.low..self.end).rev();
        let sign =
            words().map(|i| self.plus[i].cmp(&self.minus[i])).find(|order| order.is_ne()).unwrap_or(Ordering::Equal);
        let mut borrow = false;
        for i in self.low..self.end {
            let (plus, minus) = (self.plus[i], self.minus[i]);
            let (larger, smaller) = if sign.is_gt() { (plus, minus) } else { (minus, plus) };
            let (difference, is_less) = larger.overflowing_sub(smaller);
            let (rest, is_less_still) = difference.overflowing_sub(u32::from(borrow));
            (self.plus[i], borrow) = (rest, is_less || is_less_still);
        }
        sign
    }

    fn magnitude(mut self) -> Self {
        self.settle();
        self
    }
}

/// (a − o) · n, of which t is the share of d · n.
pub(super) fn distance(origin: Point, corners: [Point; 3]) -> Sum {
    let [a, b, c] = corners;
    let mut sum = Sum::new();
    sum.add_volume(a, [b, c, [0.0; 3]], false);
    sum.add_volume(origin, corners, true);
    sum
}

/// x · n; with an edge and the ray's origin as the corners, which side of the edge the ray passes on.
pub(super) fn volume(x: Point, corners: [Point; 3]) -> Sum {
    let mut sum = Sum::new();
    sum.add_volume(x, corners, false);
    sum
}

/// Whether the ray meets the triangle at t > 0, its edges and corners included. A triangle that is seen edge-on is not met.
#[must_use]
pub fn meets_exactly(origin: Point, direction: Point, corners: [Point; 3]) -> bool {
    let [a, b, c] = corners;
    if let Some(units) = Units::of(&[origin, a, b, c], direction) {
        return meets_narrowly(units, origin, direction, corners);
    }
    meets_widely(origin, direction, corners)
}

fn meets_widely(origin: Point, direction: Point, corners: [Point; 3]) -> bool {
    let [a, b, c] = corners;
    let sides = [[a, b], [b, c], [c, a]].map(|[tail, head]| volume(direction, [tail, head, origin]).settle());
    // The sides add up to d · n.
    Some(distance(origin, corners).settle()) == common_sign(sides)
}

/// Compares the t of two triangles that the ray meets.
#[must_use]
pub fn compare_exactly(origin: Point, direction: Point, corners: [Point; 3], others: [Point; 3]) -> Ordering {
    let ([a, b, c], [e, f, g]) = (corners, others);
    let told = Units::of(&[origin, a, b, c, e, f, g], direction).and_then(|units| {
        let share = |corners| Share::of(units, origin, direction, corners);
        share(corners).compare(share(others))
    });
    told.unwrap_or_else(|| compare_widely(origin, direction, corners, others))
}

fn compare_widely(origin: Point, direction: Point, corners: [Point; 3], others: [Point; 3]) -> Ordering {
    let [[distance, along], [other_distance, other_along]] =
        [corners, others].map(|corners| [distance(origin, corners), volume(direction, corners)].map(Sum::magnitude));
    products(&distance, &other_along).cmp(&products(&other_distance, &along))
}

/// Whether the t of a triangle that the ray meets, rounded to the nearest f32, lies between two numbers; it is never rounded
/// to 0.
#[must_use]
pub fn rounds_between([begin, end]: [f32; 2], origin: Point, direction: Point, corners: [Point; 3]) -> bool {
    let [above, below] = [distance(origin, corners), volume(direction, corners)].map(Sum::magnitude);
    if begin > 0.0 && !rounds_above(begin.to_bits(), &above, &below) {
        return false;
    }
    // Either the number before the end is reached or the end is not.
    end >= INF || (end > f32::from_bits(1) && !rounds_above(end.to_bits() - 1, &above, &below))
}

/// Whether a quotient of magnitudes is rounded to an f32 above that of these bits: whether it is above the middle between
/// this and the next one, or at it, if this one is odd.
fn rounds_above(bits: u32, above: &Sum, below: &Sum) -> bool {
    let exponent = bits >> 23;
    let digits = bits & 0x7f_ffff | if exponent == 0 { 0 } else { 0x80_0000 };
    // In units of 2^-151.
    let middle = shifted_number(2 * digits + 1, exponent.max(1));
    let order = products(above, &shifted_number(1, 151)).cmp(&products(below, &middle));
    order.is_gt() || (order.is_eq() && bits & 1 == 1)
}

fn shifted_number(number: u32, by: u32) -> Sum {
    let mut sum = Sum { low: (by / 32) as usize, end: (by / 32) as usize + 2, ..Sum::new() };
    let wide = u64::from(number) << (by % 32);
    (sum.plus[sum.low], sum.plus[sum.low + 1]) = (wide as u32, (wide >> 32) as u32);
    sum
}

/// The product of two magnitudes, its highest word first.
pub(super) fn products(a: &Sum, b: &Sum) -> [u32; 2 * WORDS] {
    let mut product = [0; 2 * WORDS];
    for i in a.low..a.end {
        let mut carry = 0;
        for j in b.low..b.end {
            let at = &mut product[2 * WORDS - 1 - i - j];
            let all = u64::from(a.plus[i]) * u64::from(b.plus[j]) + u64::from(*at) + carry;
            (*at, carry) = (all as u32, all >> 32);
        }
        product[2 * WORDS - 1 - i - b.end.max(b.low)] = carry as u32;
    }
    product
}

#[cfg(test)]
pub(crate) mod tests;
