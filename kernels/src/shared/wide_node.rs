//! A node of the wide BVH: eight boxes in 80 bytes.

use bytemuck::{Pod, Zeroable};

use crate::numbers::units::exp2;

/// A node of the compressed wide BVH of Ylitie, Karras and Laine (2017), with the planes of each axis side by side.
///
/// ```text
/// word  0..3    origin           f32
///       3       exponents x y z  bytes 0 1 2, 1 to 254; byte 3 is 0
///       4       first inner child: the n-th inner slot is node child_base + n
///       5       first triangle entry: the n-th bit of all leaves is entry triangle_base + n
///       6       contents         bit 24 + s: slot s is an inner child; bits 3s to 3s + 2: entries of a leaf
///       7       0
///       8..20   planes           8 bytes each: min x, max x, min y, max y, min z, max z
/// ```
///
/// Plane q of an axis is at `origin + q * 2^(exponent - 127)`, which is exact in f64. An empty slot has no bit in
/// `contents`, and the planes 255 and 0.
///
/// Seen from the node's centre, the child in slot s lies towards positive x, y and z if bits 2, 1 and 0 of s are set,
/// and towards negative if they are clear, as far as eight slots allow. So a ray enters children roughly by ascending
/// `s ^ octant`, where these bits of octant are set if its direction is negative; the walk stores the complement of
/// this octant, and takes the highest bit first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct WideNode {
    /// Plane 0 along x, y and z, traced units.
    pub origin: [f32; 3],
    /// Biased exponents of the planes' spacing along x, y and z.
    pub exponents: [u8; 3],
    /// Unused.
    pub unused: u8,
    /// First inner child.
    pub child_base: u32,
    /// First entry of the leaves.
    pub triangle_base: u32,
    /// What each slot holds.
    pub contents: u32,
    /// Unused.
    pub padding: u32,
    /// Along each axis, the lower and the upper plane of each slot.
    pub planes: [[[u8; 8]; 2]; 3],
}

/// The child in a slot of a [`WideNode`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WideChild {
    /// The slot, 0 to 7.
    pub slot: usize,
    /// Lower corner of its box, exact.
    pub min: [f64; 3],
    /// Upper corner of its box, exact.
    pub max: [f64; 3],
    /// What the box contains.
    pub content: WideContent,
}

/// A child of a [`WideNode`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WideContent {
    /// An inner node.
    Inner(u32),
    /// Entries of `packed_triangles`.
    Leaf {
        /// The first entry.
        first: u32,
        /// Number of entries, 1 to 3.
        count: u32,
    },
}

impl WideNode {
    /// The children by ascending slots; empty slots are left out.
    pub fn children(&self) -> impl Iterator<Item = WideChild> + '_ {
        (0..8usize).filter_map(|slot| {
            let content = self.content(slot)?;
            let plane = |side: usize| [0, 1, 2].map(|axis| self.plane(axis, self.planes[axis][side][slot]));
            Some(WideChild { slot, min: plane(0), max: plane(1), content })
        })
    }

    /// The child in a slot (0 to 7); `None` if it is empty.
    #[must_use]
    pub fn content(&self, slot: usize) -> Option<WideContent> {
        let entries = self.contents >> (3 * slot) & 7;
        if self.contents >> (24 + slot) & 1 == 1 {
            let before = self.contents >> 24 & ((1 << slot) - 1);
            return Some(WideContent::Inner(self.child_base.wrapping_add(before.count_ones())));
        }
        let before = self.contents & ((1 << (3 * slot)) - 1);
        let first = self.triangle_base.wrapping_add(before.count_ones());
        (entries != 0).then_some(WideContent::Leaf { first, count: entries.count_ones() })
    }

    /// Coordinate of plane `q` of an axis (0 to 2).
    #[must_use]
    pub fn plane(&self, axis: usize, q: u8) -> f64 {
        f64::from(self.origin[axis]) + f64::from(q) * spacing(self.exponents[axis])
    }
}

/// The spacing that a biased exponent stands for.
pub(crate) fn spacing(exponent: u8) -> f64 {
    exp2(i32::from(exponent) - 127)
}
