//! A node of the wide tree: eight boxes in 80 bytes.

use bytemuck::{Pod, Zeroable};

use crate::units::exp2;

/// A node of the compressed wide tree of Ylitie, Karras and Laine 2017, with the planes of each axis side by side.
///
/// ```text
/// word  0..3    origin           f32
///       3       exponents x y z  bytes 0 1 2, 1 to 254; inner slots: byte 3, one bit each
///       4       first inner child: the n-th inner slot is node child_base + n
///       5       first triangle entry of the leaves
///       6, 7    meta             a byte a slot
///       8..20   planes           8 bytes each: min x, max x, min y, max y, min z, max z
/// ```
///
/// Plane q of an axis lies at `origin + q * 2^(exponent - 127)`, which is exact in f64. A meta byte is 0 for an
/// empty slot, whose planes are 255 and 0; `0b001_11sss` for an inner child in slot s; and for a leaf its offset
/// from `triangle_base` (0 to 23) in the low five bits and as many of the upper three, from the lowest on, as
/// it has entries (1 to 3).
///
/// Seen from the node's centre, the child in slot s lies towards positive x, y and z where bits 2, 1 and 0 of s are
/// set and towards negative ones where they are clear, as far as eight slots allow. So a ray enters children
/// roughly by ascending `s ^ octant`, with these bits of octant set where its direction is negative.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct WideNode {
    /// Traced units.
    pub origin: [f32; 3],
    /// Biased exponents of the planes' spacing along x, y and z.
    pub exponents: [u8; 3],
    /// Bit s: slot s holds an inner node.
    pub imask: u8,
    /// First inner child.
    pub child_base: u32,
    /// First entry of the leaves.
    pub triangle_base: u32,
    /// What each slot holds.
    pub meta: [u8; 8],
    /// Along each axis, the lower and the upper plane of each slot.
    pub planes: [[[u8; 8]; 2]; 3],
}

/// What a slot of a [`WideNode`] holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WideChild {
    /// 0 to 7.
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
    /// A node.
    Inner(u32),
    /// Entries of `wide_triangles`.
    Leaf {
        /// The first.
        first: u32,
        /// How many: 1 to 3.
        count: u32,
    },
}

impl WideNode {
    /// The children in ascending slots; empty slots are left out.
    pub fn children(&self) -> impl Iterator<Item = WideChild> + '_ {
        (0..8).filter_map(|slot| {
            let content = self.content(slot)?;
            let plane = |side: usize| [0, 1, 2].map(|axis| self.plane(axis, self.planes[axis][side][slot]));
            Some(WideChild { slot, min: plane(0), max: plane(1), content })
        })
    }

    /// What a slot (0 to 7) holds; `None` where it is empty.
    #[must_use]
    pub fn content(&self, slot: usize) -> Option<WideContent> {
        let meta = *self.meta.get(slot).filter(|&&meta| meta != 0)?;
        Some(if self.imask >> slot & 1 == 1 {
            let before = u32::from(self.imask) & ((1 << slot) - 1);
            WideContent::Inner(self.child_base.wrapping_add(before.count_ones()))
        } else {
            let first = self.triangle_base.wrapping_add(u32::from(meta & 31));
            WideContent::Leaf { first, count: (meta >> 5).count_ones() }
        })
    }

    /// Where plane `q` of an axis (0 to 2) lies.
    #[must_use]
    pub fn plane(&self, axis: usize, q: u8) -> f64 {
        f64::from(self.origin[axis]) + f64::from(q) * spacing(self.exponents[axis])
    }
}

/// What a biased exponent stands for.
pub(super) fn spacing(exponent: u8) -> f64 {
    exp2(i32::from(exponent) - 127)
}
