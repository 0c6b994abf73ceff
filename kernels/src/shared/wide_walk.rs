//! Twin of `wide_walk.wgsl`: one node of the compressed eight-wide tree.

use super::bvh_walk::finite_inverse;
use crate::bvh::WideNode;
use crate::real::{Real, Vec3};

/// What a ray's walk keeps.
#[derive(Clone, Copy, Debug)]
pub struct WideRay<R> {
    origin: Vec3<R>,
    inverse: Vec3<R>,
    /// Bits 2, 1, 0: the direction goes up along x, y, z.
    octant: u32,
    negative: [bool; 3],
}

/// Siblings that wait: of an inner group, `base` is the first child, and `bits` the hits (24-31, in the
/// order of visits) and which slots are inner nodes (0-7); of a leaf group, the first entry and its hits.
#[derive(Clone, Copy, Debug, Default)]
pub struct WideGroup {
    /// First child or entry.
    pub base: u32,
    /// What was hit.
    pub bits: u32,
}

impl<R: Real> WideRay<R> {
    /// Prepares a ray.
    pub fn new(origin: Vec3<R>, direction: Vec3<R>) -> Self {
        let inverse = finite_inverse(direction);
        let negative = inverse.map(|v| v < R::zero()).to_array();
        let octant = u32::from(!negative[0]) << 2 | u32::from(!negative[1]) << 1 | u32::from(!negative[2]);
        Self { origin, inverse, octant, negative }
    }

    /// The node of a group's hit.
    #[must_use]
    pub fn child(&self, group: WideGroup, bit: u32) -> u32 {
        let slot = (bit - 24) ^ self.octant;
        group.base + (group.bits & ((1 << slot) - 1) & 0xff).count_ones()
    }

    /// Tests the eight boxes of a node: the groups of its inner children and of its leaves.
    #[must_use]
    pub fn visit(&self, node: &WideNode, nearest_t: R) -> (WideGroup, WideGroup) {
        let (mut enter, mut leave) = ([R::zero(); 8], [nearest_t; 8]);
        let (origin, inverse) = (self.origin.to_array(), self.inverse.to_array());
        for axis in 0..3 {
            let scale = R::from_f32(f32::from_bits(u32::from(node.exponents[axis]) << 23)) * inverse[axis];
            let offset = (R::from_f32(node.origin[axis]) - origin[axis]) * inverse[axis];
            // A ray that goes down an axis meets the upper plane first.
            let near = usize::from(self.negative[axis]);
            let (near, far) = (&node.planes[axis][near], &node.planes[axis][1 - near]);
            for slot in 0..8 {
                enter[slot] = enter[slot].max(R::from_i32(i32::from(near[slot])) * scale + offset);
                leave[slot] = leave[slot].min(R::from_i32(i32::from(far[slot])) * scale + offset);
            }
        }
        let mut hits = 0u32;
        for slot in 0..8 {
            if enter[slot] <= leave[slot] {
                let meta = u32::from(node.meta[slot]);
                // Inner children are marked in the order in which this ray visits them.
                let is_inner = meta & (meta << 1) & 0x10 != 0;
                let place = (meta ^ if is_inner { self.octant } else { 0 }) & 0x1f;
                hits |= (meta >> 5) << place;
            }
        }
        (
            WideGroup { base: node.child_base, bits: hits & 0xff00_0000 | u32::from(node.imask) },
            WideGroup { base: node.triangle_base, bits: hits & 0x00ff_ffff },
        )
    }
}
