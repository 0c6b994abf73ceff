//! Twin of `direction.wgsl`: a random direction about a normal.

use crate::numbers::real::{Real, Vec3};
use crate::shared::vector::unit3;

/// Cosine and sine of so many turns, from 0 to 1: the polynomials of Moshier's Cephes (1989) between -1/8 and 1/8 turn. In
/// f32 both are within 1.2·10⁻⁷ of the exact values for every multiple of 2⁻²⁴, as a test of all of them shows.
pub(in crate::programs) fn on_circle<R: Real>(turns: R) -> [R; 2] {
    let f = R::from_f32;
    let quarter = (f(4.0) * turns + f(0.5)).floor();
    let angle = (f(4.0) * turns - quarter) * f(1.570_796_4);
    let square = angle * angle;
    let sine = angle + angle * square * ((f(-1.951_529_6e-4) * square + f(8.332_161e-3)) * square - f(0.166_666_55));
    let cosine = R::one() - f(0.5) * square
        + square * square * ((f(2.443_315_7e-5) * square - f(1.388_731_6e-3)) * square + f(4.166_664_6e-2));
    let quarter = quarter.to_i32();
    let at = if quarter & 1 == 1 { [-sine, cosine] } else { [cosine, sine] };
    if quarter & 2 == 2 { at.map(|v| -v) } else { at }
}

/// What is at right angles to a normal of length 1, with these coordinates along two axes there (Duff et al. 2017).
pub(in crate::programs) fn perpendicular<R: Real>(normal: Vec3<R>, [x, y]: [R; 2]) -> Vec3<R> {
    let one = R::one();
    let side = if normal.z >= R::zero() { one } else { -one };
    let a = -one / (side + normal.z);
    let b = normal.x * normal.y * a;
    let first = Vec3::new(one + side * normal.x * normal.x * a, side * b, -side * normal.x);
    let second = Vec3::new(b, side + normal.y * normal.y * a, -normal.y);
    first * x + second * y
}

/// A direction of length 1 about a normal of length 1, with a pdf of cosine / π, by two numbers from 0 to below 1.
pub(in crate::programs) fn cosine_weighted<R: Real>(normal: Vec3<R>, by: [R; 2]) -> Vec3<R> {
    let at = on_circle(by[1]).map(|v| v * by[0].sqrt());
    unit3(perpendicular(normal, at) + normal * (R::one() - by[0]).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_angle_is_exact_to_a_rounding() {
        let mut most = 0f64;
        for step in 0..1u32 << 24 {
            let turns = step as f32 * 5.960_464_5e-8;
            let (sine, cosine) = (f64::from(turns) * std::f64::consts::TAU).sin_cos();
            let found = on_circle(turns);
            most = most.max((f64::from(found[0]) - cosine).abs()).max((f64::from(found[1]) - sine).abs());
        }
        assert!(most < 1.2e-7, "{most:e}");
    }

    /// The mean of a cosine-weighted direction is 2/3 of the normal, and it never leads below.
    #[test]
    fn directions_are_weighted_by_their_cosine() {
        for normal in [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.6, -0.8, 0.0], [-0.48, 0.6, -0.64f32]] {
            let normal = unit3(Vec3::<f32>::from_f32(normal));
            let (mut sum, mut squares) = ([0.0; 3], 0.0);
            for i in 0..256 {
                for j in 0..256 {
                    let direction = cosine_weighted(normal, [(i as f32 + 0.5) / 256.0, (j as f32 + 0.5) / 256.0]);
                    let [x, y, z] = direction.to_f64();
                    let n = normal.to_f64();
                    let cosine = x * n[0] + y * n[1] + z * n[2];
                    assert!(cosine > 0.0 && (x * x + y * y + z * z - 1.0).abs() < 1e-6);
                    sum = [sum[0] + x, sum[1] + y, sum[2] + z];
                    squares += cosine * cosine;
                }
            }
            // The midpoint rule's error for these is below 1e-4.
            let n = normal.to_f64();
            assert!((0..3).all(|axis| (sum[axis] / 65_536.0 - n[axis] * 2.0 / 3.0).abs() < 1e-4), "{sum:?}");
            assert!((squares / 65_536.0 - 0.5).abs() < 1e-4, "{squares}");
        }
    }
}
