//! Which triangles a ray may meet at all: a hierarchy of boxes that never leaves out one that testing every triangle
//! would accept.
//!
//! Every triangle has a bounding sphere. A triangle is tested only if the ray's *line* passes the sphere's centre c,
//! seen from the origin, within `reach = radius + 64u (|c| + radius)`; the second term covers f32's errors, which grow
//! with the distance. The boxes of the hierarchy enclose the spheres, and each is widened for each ray by 66u times the
//! distance (in the sum of its components) of the box's farthest corner. As the whole sphere lies in the box, that
//! distance is at least |c| + radius, so a line that passes within reach of the centre meets the widened box. The
//! remaining 2u are far more than what f64 rounds, which is of the order of 2⁻⁵⁰; sums of coordinates are rounded
//! relative to their own size, by which boxes are grown when they are built.
//!
//! Whether a line meets a box is decided by the three axes that are perpendicular to the line and to an edge of the box:
//! without a division, so that directions along an axis, or of length 0, are no special cases. What is not a number is
//! never left out. Lines, not rays, are tested: a hit's t may be off by its bound, and what lies behind the origin is
//! left to the exact test.

use glam::DVec3;

use super::{U, wide};

/// Most triangles of a leaf.
const LEAF: usize = 4;

/// More than the depth of a hierarchy of 2³² triangles: each half has at most one more than half of them.
const DEEPEST: usize = 64;

/// What sums and halves of coordinates are rounded by, relative to their size, and more.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// A bounding sphere.
#[derive(Clone, Copy, Debug)]
struct Sphere {
    center: DVec3,
    radius: f64,
}

impl Sphere {
    /// Around a triangle of nine floats.
    fn new(v: &[f32]) -> Self {
        let p = [0, 3, 6].map(|c| wide([v[c], v[c + 1], v[c + 2]]));
        let center = (p[0] + p[1] + p[2]) / 3.0;
        let radius = p.iter().map(|q| (*q - center).length()).fold(0.0, f64::max);
        Self { center, radius }
    }

    /// Whether the triangle may be hit.
    fn may_be_met(&self, ray: &Line) -> bool {
        let c = self.center - ray.origin;
        let off = c.cross(ray.direction);
        let reach = self.radius + 64.0 * U * (c.length() + self.radius);
        let is_passed = off.dot(off) > reach * reach * ray.length_squared * (1.0 + 1e-9);
        !is_passed
    }

    /// The box around it; everything if it is not finite.
    fn bounds(&self) -> [DVec3; 2] {
        if !self.radius.is_finite() || !self.center.is_finite() {
            return [DVec3::NEG_INFINITY, DVec3::INFINITY];
        }
        let reach = DVec3::splat(self.radius) + (self.center.abs() + self.radius) * ROUNDING;
        [self.center - reach, self.center + reach]
    }
}

/// A ray's line, with what every test needs of it.
struct Line {
    origin: DVec3,
    direction: DVec3,
    size: DVec3,
    length_squared: f64,
}

/// A box with what is in it.
#[derive(Clone, Debug)]
struct Node {
    center: DVec3,
    half: DVec3,
    /// Of a leaf, the first of its triangles in `Tree::order`; else the second child: the first one follows its parent.
    next: u32,
    /// Triangles of a leaf; 0 if it is none.
    count: u32,
}

impl Node {
    fn new([low, high]: [DVec3; 2], next: usize, count: usize) -> Self {
        let grown = (low.abs() + high.abs()) * ROUNDING;
        Self { center: 0.5 * (low + high), half: 0.5 * (high - low) + grown, next: next as u32, count: count as u32 }
    }

    fn may_be_met(&self, ray: &Line) -> bool {
        let c = self.center - ray.origin;
        let h = self.half + 66.0 * U * (c.abs() + self.half).element_sum();
        let (off, d) = (c.cross(ray.direction).abs(), ray.size);
        let is_passed = off.x > h.y * d.z + h.z * d.y || off.y > h.z * d.x + h.x * d.z || off.z > h.x * d.y + h.y * d.x;
        !is_passed
    }
}

/// The hierarchy. It is for the triangles that it was made of only.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    spheres: Vec<Sphere>,
    nodes: Vec<Node>,
    /// Triangles in the order of the leaves.
    order: Vec<u32>,
}

impl Tree {
    /// Of triangles of nine floats each.
    pub(super) fn new(vertices: &[f32]) -> Self {
        let spheres: Vec<Sphere> = vertices.chunks_exact(9).map(Sphere::new).collect();
        let order = (0..spheres.len() as u32).collect();
        let mut tree = Self { spheres, nodes: Vec::new(), order };
        if !tree.order.is_empty() {
            tree.add(0, tree.order.len());
        }
        tree
    }

    /// Adds the node of a range of the order, and those below it: halves along the axis on which its centres are
    /// spread farthest.
    fn add(&mut self, begin: usize, end: usize) {
        let none = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let join = |[low, high]: [DVec3; 2], [l, h]: [DVec3; 2]| [low.min(l), high.max(h)];
        let spheres = self.order[begin..end].iter().map(|&triangle| &self.spheres[triangle as usize]);
        let bounds = spheres.clone().map(Sphere::bounds).fold(none, join);
        if end - begin <= LEAF {
            self.nodes.push(Node::new(bounds, begin, end - begin));
            return;
        }
        let [low, high] = spheres.map(|s| [s.center; 2]).fold(none, join);
        let axis = (high - low).max_position();
        let middle = (end - begin) / 2;
        let Self { spheres, order, .. } = self;
        let along = |triangle: u32| spheres[triangle as usize].center[axis];
        order[begin..end].select_nth_unstable_by(middle, |&a, &b| along(a).total_cmp(&along(b)));
        let node = self.nodes.len();
        self.nodes.push(Node::new(bounds, 0, 0));
        self.add(begin, begin + middle);
        self.nodes[node].next = self.nodes.len() as u32;
        self.add(begin + middle, end);
    }

    /// Calls `visit` with every triangle that the ray may meet, in any order. Returns the number of boxes and spheres
    /// that were looked at.
    pub(super) fn visit(&self, origin: [f32; 3], direction: [f32; 3], mut visit: impl FnMut(u32)) -> usize {
        let ray = Line::new(origin, direction);
        let (mut stack, mut height, mut looked) = ([0_u32; DEEPEST], usize::from(!self.nodes.is_empty()), 0);
        while height > 0 {
            height -= 1;
            let at = stack[height];
            let node = &self.nodes[at as usize];
            looked += 1;
            if !node.may_be_met(&ray) {
                continue;
            }
            if node.count == 0 {
                stack[height] = node.next;
                stack[height + 1] = at + 1;
                height += 2;
                continue;
            }
            let leaf = &self.order[node.next as usize..][..node.count as usize];
            looked += leaf.len();
            leaf.iter().filter(|&&t| self.spheres[t as usize].may_be_met(&ray)).for_each(|&t| visit(t));
        }
        looked
    }

    /// The same, by looking at every triangle, in order.
    pub(super) fn visit_all(&self, origin: [f32; 3], direction: [f32; 3], visit: impl FnMut(u32)) {
        let ray = Line::new(origin, direction);
        let met = (0..).zip(&self.spheres).filter(|(_, sphere)| sphere.may_be_met(&ray));
        met.map(|(triangle, _)| triangle).for_each(visit);
    }
}

impl Line {
    fn new(origin: [f32; 3], direction: [f32; 3]) -> Self {
        let (origin, direction) = (wide(origin), wide(direction));
        Self { origin, direction, size: direction.abs(), length_squared: direction.dot(direction) }
    }
}

#[cfg(test)]
mod tests;
