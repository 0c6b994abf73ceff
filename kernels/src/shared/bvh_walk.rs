//! Twin of `bvh_walk.wgsl`: one step through the binary BVH, without a stack.

use bytemuck::{Pod, Zeroable};

use super::constants::{BOX_PADDING, NO_NODE, PARALLEL};
use crate::numbers::real::{Real, Vec3};

/// A node: its box, and its children or triangles.
///
/// `link` has the number of triangles in bits 0 to 29. If it is 0, the node's children are nodes `first` and
/// `first + 1`, ordered by their centres along the axis in bits 30 and 31 (0 to 2), the one along which they differ
/// most: a ray that does not go down along that axis enters `first` first. Otherwise the node is a leaf with items
/// `first .. first + count`, at most [`MAX_LEAF`](crate::structures::bvh::MAX_LEAF).
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct BvhNode {
    /// Lower corner, traced units.
    pub min: [f32; 3],
    /// First child or first item.
    pub first: u32,
    /// Upper corner, traced units.
    pub max: [f32; 3],
    /// Axis and count.
    pub link: u32,
}

/// `link` of the root of a BVH without triangles: axis 3, count 0. Its box is the single point (`f32::MAX`, `f32::MAX`,
/// `f32::MAX`), which a ray whose direction is shorter than 2^27 does not reach at any t up to 2^100.
pub const EMPTY: u32 = 3 << 30;

impl BvhNode {
    /// Number of triangles in a leaf; 0 for an inner node and for the root of an empty BVH.
    #[must_use]
    pub fn count(&self) -> u32 {
        self.link & 0x3fff_ffff
    }

    /// Axis along which the children of an inner node are ordered.
    #[must_use]
    pub fn axis(&self) -> usize {
        (self.link >> 30) as usize
    }

    /// Whether it has children.
    #[must_use]
    pub fn is_inner(&self) -> bool {
        self.count() == 0 && self.link != EMPTY
    }
}

/// A ray's position in the BVH.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Visit {
    /// The node; [`NO_NODE`] for a ray that has finished.
    pub node: u32,
    /// The previous node; the node itself for a leaf whose triangles have been tested.
    pub previous: u32,
    /// Whether the ray is in a leaf whose box it meets.
    pub in_leaf: bool,
}

/// 1 / direction, kept finite: a component too small to matter inside the scene is replaced by one whose inverse cannot
/// overflow.
pub fn finite_inverse<R: Real>(direction: Vec3<R>) -> Vec3<R> {
    let least = R::from_f32(PARALLEL);
    direction.map(|d| {
        let d = if d.abs() < least { if d < R::zero() { -least } else { least } } else { d };
        R::one() / d
    })
}

/// A box's growth for a ray: [`BOX_PADDING`] times the largest distance along an axis from the ray's origin to the box,
/// given the differences between its lower and upper corner and the origin.
pub fn ray_padding<R: Real>(low: Vec3<R>, high: Vec3<R>) -> R {
    let far = |low: R, high: R| low.abs().max(high.abs());
    R::from_f32(BOX_PADDING) * far(low.x, high.x).max(far(low.y, high.y)).max(far(low.z, high.z))
}

/// A ray, and the values that each of its steps needs.
#[derive(Clone, Copy, Debug)]
pub struct TreeRay<R> {
    origin: Vec3<R>,
    direction: Vec3<R>,
    inverse: Vec3<R>,
    /// Whether boxes are grown by [`ray_padding`].
    is_padded: bool,
}

impl<R: Real> TreeRay<R> {
    /// Prepares a ray for the walk, in which boxes are grown by [`ray_padding`] or not.
    pub fn new(origin: Vec3<R>, direction: Vec3<R>, is_padded: bool) -> Self {
        Self { origin, direction, inverse: finite_inverse(direction), is_padded }
    }
}

/// Whether the ray is inside the node's box anywhere between 0 and `nearest_t`.
pub fn hits_box<R: Real>(node: &BvhNode, ray: &TreeRay<R>, nearest_t: R) -> bool {
    let mut low = Vec3::from_f32(node.min) - ray.origin;
    let mut high = Vec3::from_f32(node.max) - ray.origin;
    if ray.is_padded {
        let padding = ray_padding(low, high);
        (low, high) = (low.map(|v| v - padding), high.map(|v| v + padding));
    }
    let (t0, t1) = (low * ray.inverse, high * ray.inverse);
    let t_enter = t0.x.min(t1.x).max(t0.y.min(t1.y)).max(t0.z.min(t1.z).max(R::zero()));
    let t_leave = t0.x.max(t1.x).min(t0.y.max(t1.y)).min(t0.z.max(t1.z).min(nearest_t));
    t_enter <= t_leave
}

/// Whether the ray goes down along an axis (0 to 2).
fn goes_down<R: Real>(axis: u32, direction: Vec3<R>) -> bool {
    let along = match axis {
        0 => direction.x,
        1 => direction.y,
        _ => direction.z,
    };
    along < R::zero()
}

/// An entry of `bvh_parents`: the parent, with the axis of its link in bits 30 and 31, or [`NO_NODE`].
#[must_use]
pub fn link_above(nodes: &[BvhNode], parent: u32) -> u32 {
    nodes.get(parent as usize).map_or(NO_NODE, |above| parent | above.link >> 30 << 30)
}

/// The node in an entry of `bvh_parents`.
#[must_use]
pub fn parent_of(above: u32) -> u32 {
    if above == NO_NODE { NO_NODE } else { above & 0x3fff_ffff }
}

/// One step (after Hapala and others, 2011).
pub fn next_node<R: Real>(nodes: &[BvhNode], parents: &[u32], at: Visit, ray: &TreeRay<R>, nearest_t: R) -> Visit {
    let above = parents[at.node as usize];
    let parent = parent_of(above);
    if at.previous == parent {
        let node = &nodes[at.node as usize];
        if hits_box(node, ray, nearest_t) {
            if node.count() != 0 {
                return Visit { node: at.node, previous: at.node, in_leaf: true };
            }
            let nearer = node.first + u32::from(goes_down(node.link >> 30, ray.direction));
            return Visit { node: nearer, previous: at.node, in_leaf: false };
        }
    }
    // Finished with this node: continue with the sibling if this was the nearer child, else with the parent.
    if parent == NO_NODE {
        return Visit { node: NO_NODE, previous: at.node, in_leaf: false };
    }
    // The first of two siblings has an odd index.
    let is_first = at.node & 1 == 1;
    if is_first != goes_down(above >> 30, ray.direction) {
        return Visit { node: ((at.node - 1) ^ 1) + 1, previous: parent, in_leaf: false };
    }
    Visit { node: parent, previous: at.node, in_leaf: false }
}
