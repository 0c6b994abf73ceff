//! Twin of `vector.wgsl`.

use crate::numbers::real::{Real, Vec3};

/// Dot product, summed from x to z.
pub fn dot3<R: Real>(a: Vec3<R>, b: Vec3<R>) -> R {
    a.x * b.x + a.y * b.y + a.z * b.z
}

/// Cross product.
pub fn cross3<R: Real>(a: Vec3<R>, b: Vec3<R>) -> Vec3<R> {
    Vec3::new(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
}

/// Largest component.
pub fn largest3<R: Real>(a: Vec3<R>) -> R {
    a.x.max(a.y).max(a.z)
}

/// The vector of length 1 along `a`, or 0 if `a` is too short to have a direction.
pub fn unit3<R: Real>(a: Vec3<R>) -> Vec3<R> {
    let size = largest3(a.abs());
    #[allow(clippy::neg_cmp_op_on_partial_ord, reason = "as the WGSL has it: NaN has no direction")]
    if !(size > R::from_f32(1e-37)) {
        return Vec3::splat(R::zero());
    }
    let scaled = a * (R::one() / size);
    scaled * (R::one() / dot3(scaled, scaled).sqrt())
}

/// Smallest component.
pub fn smallest3<R: Real>(a: Vec3<R>) -> R {
    a.x.min(a.y).min(a.z)
}
