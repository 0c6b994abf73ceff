//! Twin of `wide_walk.wgsl`: one node of the compressed eight-wide BVH.

use super::bvh_walk::finite_inverse;
use super::constants::BOX_PADDING;
use super::wide_node::WideNode;
use crate::numbers::real::{Real, Vec3};

/// Words of a restart trail, eight levels each.
pub const TRAIL_WORDS: usize = 4;
/// The last level of a restart trail.
pub const MOST_LEVELS: u32 = 31;
/// Stands for none of a group's children.
pub const NO_CHILD: u32 = 8;

/// The child entered at a level, from the word of the trail that contains the level.
#[must_use]
pub fn trail_child(word: u32, level: u32) -> u32 {
    word >> (4 * (level % 8)) & 15
}

/// The word with a different child at the level.
#[must_use]
pub fn with_trail_child(word: u32, level: u32, child: u32) -> u32 {
    let shift = 4 * (level % 8);
    word & !(15 << shift) | child << shift
}

/// The variables of a ray's walk.
#[derive(Clone, Copy, Debug)]
pub struct WideRay<R> {
    origin: Vec3<R>,
    inverse: Vec3<R>,
    /// Bits 2, 1, 0: the direction is not negative along x, y, z.
    octant: u32,
    negative: [bool; 3],
    /// Whether boxes are grown by their distance.
    is_padded: bool,
}

/// Siblings that wait: `base` is the first child, and `bits` holds the hits (24-31, in the order of visits) and the
/// slots that are inner nodes (0-7).
#[derive(Clone, Copy, Debug, Default)]
pub struct WideGroup {
    /// First child.
    pub base: u32,
    /// Hits, and slots that are inner nodes.
    pub bits: u32,
}

/// The entries of a node's leaves.
#[derive(Clone, Copy, Debug)]
pub struct WideLeaves {
    base: u32,
    /// Entries whose boxes were met (0-23).
    pub bits: u32,
    all: u32,
}

impl WideLeaves {
    /// The entry for a hit on a leaf.
    #[must_use]
    pub fn entry(&self, bit: u32) -> u32 {
        self.base + (self.all & ((1 << bit) - 1)).count_ones()
    }
}

impl<R: Real> WideRay<R> {
    /// Prepares a ray for the walk, in which boxes are grown by their distance or not.
    pub fn new(origin: Vec3<R>, direction: Vec3<R>, is_padded: bool) -> Self {
        let inverse = finite_inverse(direction);
        let negative = inverse.map(|v| v < R::zero()).to_array();
        let octant = u32::from(!negative[0]) << 2 | u32::from(!negative[1]) << 1 | u32::from(!negative[2]);
        Self { origin, inverse, octant, negative, is_padded }
    }

    /// The node for a hit in a group.
    #[must_use]
    pub fn child(&self, group: WideGroup, bit: u32) -> u32 {
        let slot = (bit - 24) ^ self.octant;
        group.base + (group.bits & ((1 << slot) - 1) & 0xff).count_ones()
    }

    /// Tests the eight boxes of a node; returns the groups of its inner children and of its leaves.
    #[must_use]
    pub fn visit(&self, node: &WideNode, nearest_t: R) -> (WideGroup, WideLeaves) {
        // Compiled twice: together, the loop over slots is a third slower.
        if self.is_padded { self.visit_as::<true>(node, nearest_t) } else { self.visit_as::<false>(node, nearest_t) }
    }

    fn visit_as<const PADDED: bool>(&self, node: &WideNode, nearest_t: R) -> (WideGroup, WideLeaves) {
        let (mut enter, mut leave) = ([R::zero(); 8], [nearest_t; 8]);
        let (origin, inverse) = (self.origin.to_array(), self.inverse.to_array());
        let spacing = node.exponents.map(|exponent| R::from_f32(f32::from_bits(u32::from(exponent) << 23)));
        let low = [0, 1, 2].map(|axis| R::from_f32(node.origin[axis]) - origin[axis]);
        let padding = if PADDED {
            let far = [0, 1, 2].map(|axis| low[axis].abs() + R::from_f32(256.0) * spacing[axis]);
            R::from_f32(BOX_PADDING) * far[0].max(far[1]).max(far[2])
        } else {
            R::zero()
        };
        for axis in 0..3 {
            let scale = spacing[axis] * inverse[axis];
            let offset = low[axis] * inverse[axis];
            let (mut enter_at, mut leave_at) = (offset, offset);
            if PADDED {
                let padding = padding * inverse[axis].abs();
                (enter_at, leave_at) = (offset - padding, offset + padding);
            }
            // A ray that goes down along an axis meets the upper plane first.
            let near = usize::from(self.negative[axis]);
            let (nearer, farther) = (&node.planes[axis][near], &node.planes[axis][1 - near]);
            for slot in 0..8 {
                enter[slot] = enter[slot].max(R::from_i32(i32::from(nearer[slot])) * scale + enter_at);
                leave[slot] = leave[slot].min(R::from_i32(i32::from(farther[slot])) * scale + leave_at);
            }
        }
        // The sign decides, as on the GPU: it may be that of -0 if a box ends at the ray's origin.
        let hits = (0..8).fold(0, |hits, s| hits | u32::from(!(leave[s] - enter[s]).is_negative()) << s);
        let inner = node.contents >> 24;
        (
            WideGroup { base: node.child_base, bits: self.in_order(hits & inner) << 24 | inner },
            WideLeaves { base: node.triangle_base, bits: tripled(hits) & node.contents, all: node.contents },
        )
    }

    /// Moves bit s of eight to bit s ^ octant.
    fn in_order(&self, slots: u32) -> u32 {
        let mut bits = slots;
        if !self.negative[0] {
            bits = (bits & 0x0f) << 4 | bits >> 4;
        }
        if !self.negative[1] {
            bits = (bits & 0x33) << 2 | bits >> 2 & 0x33;
        }
        if !self.negative[2] {
            bits = (bits & 0x55) << 1 | bits >> 1 & 0x55;
        }
        bits
    }
}

/// Copies bit s of eight to bits 3s to 3s + 2.
fn tripled(slots: u32) -> u32 {
    let mut bits = (slots | slots << 8) & 0x00_f00f;
    bits = (bits | bits << 4) & 0x0c_30c3;
    bits = (bits | bits << 2) & 0x24_9249;
    bits * 7
}
