//! The number types that a twin can run in: f32, as on the GPU, and f64, as the reference.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// A floating point type; every twin is generic over it. Operations round as specified by IEEE 754.
pub trait Real:
    Copy
    + Debug
    + Default
    + PartialEq
    + PartialOrd
    + Add<Output = Self>
    + AddAssign
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Send
    + Sync
    + 'static
{
    /// An unsigned integer as wide as the float: what one texel of a twin's stream holds.
    type Bits: Copy + Debug + Default + Eq + Send + Sync + 'static;

    /// Half the distance from 1 to the next larger number: 2⁻²⁴ for f32.
    const UNIT_ROUNDOFF: f64;

    /// Exact: every f32 is a `Real`.
    fn from_f32(value: f32) -> Self;
    /// Rounds to nearest.
    fn from_f64(value: f64) -> Self;
    /// Exact.
    fn to_f64(self) -> f64;
    /// WGSL's `f32(i)`: rounds to nearest.
    fn from_i32(value: i32) -> Self;
    /// WGSL's `i32(x)`: truncates, and clamps to the range of i32; 0 for NaN.
    fn to_i32(self) -> i32;
    /// Largest integer that is not greater.
    fn floor(self) -> Self;
    /// Magnitude.
    fn abs(self) -> Self;
    /// Square root, correctly rounded.
    fn sqrt(self) -> Self;
    /// WGSL's `min`. Do not rely on the result if either operand is NaN.
    fn min(self, other: Self) -> Self;
    /// WGSL's `max`.
    fn max(self, other: Self) -> Self;
    /// `self * factor + summand`, rounded once.
    fn fused(self, factor: Self, summand: Self) -> Self;
    /// `a b - c d` for two products that round to the same number: the difference that rounding removed, or 0 if they
    /// are too small to be rounded alike.
    fn below_rounding(ab: [Self; 2], cd: [Self; 2]) -> Self;
    /// A number from 0 to 2²³ rounded down, but an odd integer may become the one before it, and numbers below 1/4 become
    /// -1. Some integer for other numbers.
    fn rounded_down(self) -> i32;
    /// Whether it has a minus sign, as -0 has.
    fn is_negative(self) -> bool;
    /// Bit pattern.
    fn to_bits(self) -> Self::Bits;
    /// From a bit pattern.
    fn from_bits(bits: Self::Bits) -> Self;
    /// An integer component as a texel.
    fn bits_from_u32(value: u32) -> Self::Bits;
    /// The integer component in a texel.
    fn bits_to_u32(bits: Self::Bits) -> u32;

    /// 0
    fn zero() -> Self {
        Self::from_f32(0.0)
    }
    /// 1
    fn one() -> Self {
        Self::from_f32(1.0)
    }
}

macro_rules! real {
    ($float:ty, $bits:ty, $unit_roundoff:expr, $integers_from:expr) => {
        impl Real for $float {
            type Bits = $bits;
            const UNIT_ROUNDOFF: f64 = $unit_roundoff;
            fn from_f32(value: f32) -> Self {
                value as $float
            }
            fn from_f64(value: f64) -> Self {
                value as $float
            }
            fn to_f64(self) -> f64 {
                self as f64
            }
            fn from_i32(value: i32) -> Self {
                value as $float
            }
            fn to_i32(self) -> i32 {
                self as i32
            }
            fn floor(self) -> Self {
                <$float>::floor(self)
            }
            fn abs(self) -> Self {
                <$float>::abs(self)
            }
            fn sqrt(self) -> Self {
                <$float>::sqrt(self)
            }
            fn min(self, other: Self) -> Self {
                if other < self { other } else { self }
            }
            fn max(self, other: Self) -> Self {
                if self < other { other } else { self }
            }
            fn fused(self, factor: Self, summand: Self) -> Self {
                self.mul_add(factor, summand)
            }
            fn below_rounding([a, b]: [Self; 2], [c, d]: [Self; 2]) -> Self {
                let product = a * b;
                if product.abs() < <$float>::MIN_POSITIVE || [a, b, c, d].iter().any(|x| x.is_subnormal()) {
                    return 0.0;
                }
                // Both are exact, and have the same exponent or nearly so.
                a.mul_add(b, -product) - c.mul_add(d, -product)
            }
            fn rounded_down(self) -> i32 {
                // From here on, floats are a unit apart, so the last digits are an integer.
                const FROM: $float = $integers_from;
                (self + (FROM - 0.5)).to_bits().wrapping_sub(FROM.to_bits()) as i32
            }
            fn is_negative(self) -> bool {
                self.is_sign_negative()
            }
            fn to_bits(self) -> $bits {
                <$float>::to_bits(self)
            }
            fn from_bits(bits: $bits) -> Self {
                <$float>::from_bits(bits)
            }
            fn bits_from_u32(value: u32) -> $bits {
                value as $bits
            }
            fn bits_to_u32(bits: $bits) -> u32 {
                bits as u32
            }
        }
    };
}
real!(f32, u32, 1.0 / (1u64 << 24) as f64, (1u64 << 23) as f32);
real!(f64, u64, 1.0 / (1u64 << 53) as f64, (1u64 << 52) as f64);

/// Distance of two f32, given as bits, in units in the last place; 0 for equal numbers and for two NaNs.
#[must_use]
pub fn ulps(a: u32, b: u32) -> u64 {
    let (x, y) = (f32::from_bits(a), f32::from_bits(b));
    if x == y || (x.is_nan() && y.is_nan()) {
        return 0;
    }
    if x.is_nan() || y.is_nan() {
        return u64::MAX;
    }
    let ordered = |bits: u32| {
        let magnitude = i64::from(bits & 0x7fff_ffff);
        if bits >> 31 == 1 { -magnitude } else { magnitude }
    };
    ordered(a).abs_diff(ordered(b))
}

/// WGSL's `vec3f`, over any [`Real`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vec3<R> {
    /// First component.
    pub x: R,
    /// Second component.
    pub y: R,
    /// Third component.
    pub z: R,
}

impl<R: Real> Vec3<R> {
    /// From three components.
    pub fn new(x: R, y: R, z: R) -> Self {
        Self { x, y, z }
    }
    /// The same component three times.
    pub fn splat(v: R) -> Self {
        Self { x: v, y: v, z: v }
    }
    /// Exact.
    pub fn from_f32(v: [f32; 3]) -> Self {
        Self { x: R::from_f32(v[0]), y: R::from_f32(v[1]), z: R::from_f32(v[2]) }
    }
    /// Component-wise magnitude.
    pub fn abs(self) -> Self {
        self.map(R::abs)
    }
    /// Applies `f` to each component.
    pub fn map<T>(self, f: impl Fn(R) -> T) -> Vec3<T> {
        Vec3 { x: f(self.x), y: f(self.y), z: f(self.z) }
    }
    /// Rounds each component to f64.
    pub fn to_f64(self) -> [f64; 3] {
        [self.x.to_f64(), self.y.to_f64(), self.z.to_f64()]
    }
}

impl<T: Copy> Vec3<T> {
    /// As an array.
    pub fn to_array(self) -> [T; 3] {
        [self.x, self.y, self.z]
    }
}

impl<T> From<[T; 3]> for Vec3<T> {
    fn from([x, y, z]: [T; 3]) -> Self {
        Self { x, y, z }
    }
}

impl<R: Real> Add for Vec3<R> {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self { x: self.x + o.x, y: self.y + o.y, z: self.z + o.z }
    }
}

impl<R: Real> Sub for Vec3<R> {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self { x: self.x - o.x, y: self.y - o.y, z: self.z - o.z }
    }
}

/// Component-wise, as in WGSL.
impl<R: Real> Mul for Vec3<R> {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Self { x: self.x * o.x, y: self.y * o.y, z: self.z * o.z }
    }
}

impl<R: Real> Mul<R> for Vec3<R> {
    type Output = Self;
    fn mul(self, s: R) -> Self {
        Self { x: self.x * s, y: self.y * s, z: self.z * s }
    }
}

impl<R: Real> Neg for Vec3<R> {
    type Output = Self;
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For products that f32 cannot tell apart, the result agrees with f64, in which they are exact.
    #[test]
    fn what_rounding_took_from_two_equal_products_is_known() {
        let mut random = fastrand::Rng::with_seed(1);
        let mut seen = [0; 3];
        for i in 0..200_000 {
            let mut number = || ((random.f64() - 0.5) * 2f64.powi(i % 80 - 40)) as f32;
            let (a, b) = (number(), number());
            // The same product from other factors, changed by a unit in the last place or two.
            let c = f32::from_bits(a.to_bits() ^ (1 << (i % 5))) * if i % 2 == 0 { 1.0 } else { -1.0 };
            let d = a * b / c;
            if a * b != c * d || (a * b).abs() < f32::MIN_POSITIVE {
                continue;
            }
            let exact = f64::from(a) * f64::from(b) - f64::from(c) * f64::from(d);
            let found = <f32 as Real>::below_rounding([a, b], [c, d]);
            // Below 2^-149 nothing is left in f32; above 2^-126 there is one rounding.
            let tolerance = exact.abs() / f64::from(1 << 24) + 2f64.powi(-148);
            assert!((f64::from(found) - exact).abs() <= tolerance, "{a:e} {b:e} {c:e} {d:e}: {found:e}, {exact:e}");
            seen[match exact.total_cmp(&0.0) {
                std::cmp::Ordering::Less => 0,
                std::cmp::Ordering::Equal => 1,
                std::cmp::Ordering::Greater => 2,
            }] += 1;
        }
        assert!(seen[0] > 10_000 && seen[2] > 10_000, "{seen:?}");
    }

    #[test]
    fn numbers_round_down() {
        for (number, integer) in
            [(0.0, -1), (0.2, -1), (0.25, 0), (0.999, 0), (1.5, 1), (2.0, 2), (65_535.5, 65_535), (4.0e6, 4_000_000)]
        {
            assert_eq!((number as f32).rounded_down(), integer, "{number}");
            assert_eq!(number.rounded_down(), integer, "{number}");
        }
        // The sum is half-way between two floats, and becomes the even one.
        assert_eq!((1f32.rounded_down(), 2f32.rounded_down(), 3f32.rounded_down()), (0, 2, 2));
        let nearly_3 = f32::from_bits(3f32.to_bits() - 1);
        assert_eq!(nearly_3.rounded_down(), 2);
        assert!((-1.0f32).rounded_down() < 0 && (-1000.0f32).rounded_down() < 0);
    }

    #[test]
    fn in_f64_too() {
        let e = f64::EPSILON;
        assert_eq!(<f64 as Real>::below_rounding([1.0 + e, 1.0 + e], [1.0 + 2.0 * e, 1.0]), e * e);
        assert_eq!(<f64 as Real>::below_rounding([1e-300, 1e-300], [2e-300, 1e-300]), 0.0, "both are flushed");
    }
}
