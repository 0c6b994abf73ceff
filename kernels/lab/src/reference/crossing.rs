//! All triangles that a ray crosses, by rational arithmetic: with its origin moved by a number so small that whatever is not 0
//! without it keeps its sign.

use std::cmp::Ordering;

use num_bigint::{BigInt, Sign};

use super::Triangles;
use super::exact::integer;

/// Coordinates are multiples of 2⁻¹⁴⁹ times this power of two.
const SHIFT: u32 = 6000;

/// The origin is moved by 2⁻²⁰⁰⁰ along x, by the square of that along y, and by its cube along z. Differences of t are multiples
/// of 2⁻⁸⁹⁴ over a common denominator, and what moves them is below 2⁸⁰⁰ times that.
const MOVED: [u32; 3] = [2000, 4000, 6000];

/// t of a crossing: numerator, and denominator above 0.
type Share = [BigInt; 2];

fn wide(v: [f32; 3]) -> [BigInt; 3] {
    v.map(|v| integer(v) << SHIFT)
}

fn cross(a: &[BigInt; 3], b: &[BigInt; 3]) -> [BigInt; 3] {
    [(1, 2), (2, 0), (0, 1)].map(|(i, j)| &a[i] * &b[j] - &a[j] * &b[i])
}

fn dot(a: &[BigInt; 3], b: &[BigInt; 3]) -> BigInt {
    (0..3).map(|axis| &a[axis] * &b[axis]).sum()
}

/// Where the moved ray crosses a triangle.
fn crossing(origin: [f32; 3], direction: [f32; 3], corners: [[f32; 3]; 3]) -> Option<Share> {
    let (mut o, d) = (wide(origin), wide(direction));
    for (o, power) in o.iter_mut().zip(MOVED) {
        *o += BigInt::from(1) << (149 + SHIFT - power);
    }
    let [a, b, c] = corners.map(|corner| {
        let corner = wide(corner);
        [0, 1, 2].map(|axis| &corner[axis] - &o[axis])
    });
    let sides = [(&a, &b), (&b, &c), (&c, &a)].map(|(p, q)| dot(&d, &cross(p, q)));
    let sign = sides[0].sign();
    if sign == Sign::NoSign || sides.iter().any(|side| side.sign() != sign) {
        return None;
    }
    // The sides add up to d · n, and o is 0 here.
    let [along, off] = [sides.into_iter().sum(), dot(&a, &cross(&b, &c))];
    (off.sign() == sign).then(|| [off, along].map(|part: BigInt| BigInt::from(part.magnitude().clone())))
}

impl Triangles<'_> {
    /// The triangles that the ray crosses, in the order in which it does; of two in one plane, the one with the smaller id comes
    /// first.
    #[must_use]
    pub fn crossings(&self, origin: [f32; 3], direction: [f32; 3]) -> Vec<u32> {
        let mut found: Vec<(Share, u32)> = Vec::new();
        self.tree.visit(origin, direction, |triangle| {
            if let Some(t) = crossing(origin, direction, self.corners(triangle)) {
                found.push((t, triangle));
            }
        });
        let order = |([t, by], triangle): &(Share, u32),
                     ([other, other_by], other_triangle): &(Share, u32)|
         -> Ordering { (t * other_by).cmp(&(other * by)).then(triangle.cmp(other_triangle)) };
        found.sort_by(order);
        found.into_iter().map(|(_, triangle)| triangle).collect()
    }
}
