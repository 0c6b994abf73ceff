//! Twin of `packed_triangles.wgsl`: triangles in the fused kernel's format.

use crate::numbers::real::{Real, Vec3};

/// Three corners, each followed by a word: the triangle's id, and 0.
pub type PackedTriangle = [u32; 12];

/// A triangle, of nine floats each.
pub(crate) fn pack(vertices: &[f32], triangle: u32) -> PackedTriangle {
    let first = 9 * triangle as usize;
    let v = |at: usize| vertices[first + at].to_bits();
    [v(0), v(1), v(2), triangle, v(3), v(4), v(5), 0, v(6), v(7), v(8), 0]
}

/// The corners and the id.
#[inline(always)]
pub(crate) fn unpack<R: Real>(packed: &PackedTriangle) -> ([Vec3<R>; 3], u32) {
    let corner = |at: usize| Vec3::from_f32([0, 1, 2].map(|axis| f32::from_bits(packed[at + axis])));
    ([corner(0), corner(4), corner(8)], packed[3])
}
