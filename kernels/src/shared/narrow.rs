//! Twin of `narrow.wgsl`: what `exact` decides, for coordinates that 60 bits hold in one unit.

use std::cmp::Ordering;

/// A corner, an origin or a direction.
pub type Point = [f32; 3];

/// Powers of 2, above 2⁻¹⁴⁹: all places are multiples of the first, and the direction is one of the second.
#[derive(Clone, Copy, Debug)]
pub(super) struct Units {
    place: u32,
    direction: u32,
}

/// A signed number of 192 bits, the lower 64 bits first.
type Volume = (u64, i128);

/// Bits of an f32 above 2⁻¹⁴⁹: its digits, and where they begin.
fn digits(value: f32) -> (u32, u32) {
    let (exponent, fraction) = (value.to_bits() >> 23 & 0xff, value.to_bits() & 0x7f_ffff);
    (if exponent == 0 { fraction } else { fraction | 0x80_0000 }, exponent.max(1) - 1)
}

/// The lowest bit of all numbers, and the one above their highest: those that are 0 have none.
fn range(values: impl IntoIterator<Item = f32>) -> (u32, u32) {
    let digits = values.into_iter().map(digits).filter(|(digits, _)| *digits != 0);
    digits.fold((1000, 0), |(low, end), (digits, at)| {
        (low.min(at + digits.trailing_zeros()), end.max(at + 32 - digits.leading_zeros()))
    })
}

impl Units {
    /// Those of places and a direction, if the multiples are small enough.
    pub(super) fn of(places: &[Point], direction: Point) -> Option<Self> {
        let (place, end) = range(places.iter().flatten().copied());
        let (step, last) = range(direction);
        (end.saturating_sub(place) <= 60 && last.saturating_sub(step) <= 61).then_some(Self { place, direction: step })
    }
}

/// Multiples of a unit.
fn multiples(v: Point, unit: u32) -> [i64; 3] {
    v.map(|value| {
        let (digits, at) = digits(value);
        // Digits below the unit are 0, and 0 has any.
        let whole = match at >= unit {
            true => i64::from(digits).wrapping_shl(at - unit),
            false => i64::from(digits).wrapping_shr(unit - at),
        };
        if value.is_sign_negative() { -whole } else { whole }
    })
}

fn difference(v: Point, from: Point, unit: u32) -> [i64; 3] {
    let (to, from) = (multiples(v, unit), multiples(from, unit));
    [0, 1, 2].map(|axis| to[axis] - from[axis])
}

fn cross_of(a: [i64; 3], b: [i64; 3]) -> [i128; 3] {
    let product = |i: usize, j: usize| i128::from(a[i]) * i128::from(b[j]);
    [(1, 2), (2, 0), (0, 1)].map(|(i, j)| product(i, j) - product(j, i))
}

/// a · n
fn volume_of(a: [i64; 3], n: [i128; 3]) -> Volume {
    let low: i128 = (0..3).map(|axis| i128::from(n[axis] as u64) * i128::from(a[axis])).sum();
    let high: i128 = (0..3).map(|axis| (n[axis] >> 64) * i128::from(a[axis])).sum();
    (low as u64, high + (low >> 64))
}

fn sign_of((low, high): Volume) -> Ordering {
    high.cmp(&0).then(low.cmp(&0))
}

/// The sign of those sides that are not 0, if they have one in common.
pub(super) fn common_sign(sides: [Ordering; 3]) -> Option<Ordering> {
    match (sides.contains(&Ordering::Less), sides.contains(&Ordering::Greater)) {
        (true, false) => Some(Ordering::Less),
        (false, true) => Some(Ordering::Greater),
        _ => None,
    }
}

/// See `meets_exactly`.
pub(super) fn meets_narrowly(units: Units, origin: Point, direction: Point, corners: [Point; 3]) -> bool {
    let along = multiples(direction, units.direction);
    let [a, b, c] = corners.map(|corner| difference(corner, origin, units.place));
    let normals = [[a, b], [b, c], [c, a]].map(|[tail, head]| cross_of(tail, head));
    let sides = normals.map(|n| sign_of(volume_of(along, n)));
    // The sides add up to d · n.
    Some(sign_of(volume_of(a, normals[1]))) == common_sign(sides)
}

/// How many bits a number's magnitude has, and the first 32 of them. 0 has none.
fn leading((low, high): Volume) -> (u32, u32) {
    let (low, high) = if high < 0 { (low.wrapping_neg(), !high + i128::from(low == 0)) } else { (low, high) };
    let words = [low, high as u64, (high >> 64) as u64];
    let Some(place) = (0..3).rev().find(|&place| words[place] != 0) else { return (0, 0) };
    let next = if place > 0 { words[place - 1] } else { 0 };
    let shift = words[place].leading_zeros();
    (64 * (place as u32 + 1) - shift, ((words[place] << shift | next >> 1 >> (63 - shift)) >> 32) as u32)
}

/// (a − o) · n and d · n, of which t is the quotient in these units, as [`leading`] tells them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Share {
    above: (u32, u32),
    below: (u32, u32),
}

impl Share {
    pub(super) fn of(units: Units, origin: Point, direction: Point, [a, b, c]: [Point; 3]) -> Self {
        let n = cross_of(difference(b, a, units.place), difference(c, a, units.place));
        let distance = volume_of(difference(a, origin, units.place), n);
        let along = volume_of(multiples(direction, units.direction), n);
        Self { above: leading(distance), below: leading(along) }
    }

    /// Compares two quotients, unless the first bits do not tell.
    pub(super) fn compare(self, other: Self) -> Option<Ordering> {
        if self.above.0 == 0 || other.above.0 == 0 {
            return Some(self.above.0.min(1).cmp(&other.above.0.min(1))).filter(|order| order.is_ne());
        }
        let bits = (self.above.0 + other.below.0).cmp(&(other.above.0 + self.below.0));
        if (self.above.0 + other.below.0).abs_diff(other.above.0 + self.below.0) > 1 {
            return Some(bits);
        }
        // Each product has 63 or 64 bits, and its first 32 are too small by less than 3.
        let product = |a: u32, b: u32, is_half: bool| (u64::from(a) * u64::from(b)) >> (32 + u32::from(is_half));
        let left = product(self.above.1, other.below.1, bits.is_lt());
        let right = product(other.above.1, self.below.1, bits.is_gt());
        (left.abs_diff(right) > 2).then(|| left.cmp(&right))
    }
}
