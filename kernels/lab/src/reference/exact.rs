//! Decides on which side of an edge a ray passes, in integers and thus without rounding.

use std::cmp::Ordering;

use num_bigint::{BigInt, Sign};

/// Whether the ray's line meets the triangle, edges and vertices included. A triangle that is exactly edge-on is not
/// met.
pub(super) fn hits(origin: [f32; 3], direction: [f32; 3], corners: [[f32; 3]; 3]) -> bool {
    let sides = sides(origin, direction, corners);
    let none = |unwanted: Sign| sides.iter().all(|&s| s != unwanted);
    sides.iter().any(|&s| s != Sign::NoSign) && (none(Sign::Minus) || none(Sign::Plus))
}

/// Whether a ray is parallel to the triangle's plane, or the triangle has no area.
pub(super) fn is_edge_on(direction: [f32; 3], corners: [[f32; 3]; 3]) -> bool {
    let d = direction.map(integer);
    let p = corners.map(|c| c.map(integer));
    let [ab, ac] = [1, 2].map(|k| [0, 1, 2].map(|a| &p[k][a] - &p[0][a]));
    let along = |i: usize, j: usize, k: usize| &d[i] * (&ab[j] * &ac[k] - &ab[k] * &ac[j]);
    (along(0, 1, 2) + along(1, 2, 0) + along(2, 0, 1)).sign() == Sign::NoSign
}

/// The sign of each edge function.
fn sides(origin: [f32; 3], direction: [f32; 3], corners: [[f32; 3]; 3]) -> [Sign; 3] {
    let o = origin.map(integer);
    let d = direction.map(integer);
    let p = corners.map(|c| {
        let c = c.map(integer);
        [&c[0] - &o[0], &c[1] - &o[1], &c[2] - &o[2]]
    });
    let side = |q: usize, r: usize| {
        let volume = &d[0] * (&p[q][1] * &p[r][2] - &p[q][2] * &p[r][1])
            + &d[1] * (&p[q][2] * &p[r][0] - &p[q][0] * &p[r][2])
            + &d[2] * (&p[q][0] * &p[r][1] - &p[q][1] * &p[r][0]);
        volume.sign()
    };
    [side(1, 2), side(2, 0), side(0, 1)]
}

/// `value * 2^149`, an integer for every finite f32.
pub(super) fn integer(value: f32) -> BigInt {
    let bits = value.to_bits();
    let (exponent, fraction) = ((bits >> 23) & 0xff, bits & 0x7f_ffff);
    let magnitude = match exponent.cmp(&0) {
        Ordering::Greater => BigInt::from(fraction | 0x80_0000) << (exponent - 1),
        _ => BigInt::from(fraction),
    };
    if bits >> 31 == 1 { -magnitude } else { magnitude }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_through_a_shared_edge_meets_both_triangles_and_one_beside_it_only_one() {
        let (a, b, c, d) = ([0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.0, 1.0, 1.0]);
        let through = |x: f32, y: f32, corners| hits([x, y, 0.0], [0.0, 0.0, 1.0], corners);
        assert!(through(0.5, 0.5, [a, b, c]) && through(0.5, 0.5, [a, c, d]));
        let above = f32::from_bits(0.5f32.to_bits() + 1);
        assert!(!through(0.5, above, [a, b, c]) && through(0.5, above, [a, c, d]));
    }

    #[test]
    fn only_a_ray_along_the_plane_sees_a_triangle_edge_on() {
        let corners = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.5], [1.0, 1.0, 2.0]];
        assert!(is_edge_on([1.0, 0.0, 0.5], corners));
        assert!(!is_edge_on([1.0, 0.0, 0.500_000_06], corners));
        assert!(is_edge_on([0.1, 0.2, 0.7], [corners[0], corners[0], corners[2]]), "no area");
    }
}
