//! Checks the guarantees of a built BVH from its buffers alone.

use super::binary::{BvhData, order};
use super::padding::{Padding, extent};
use super::polygon::covered;
use super::references::{Bounds, corners};
use super::wide::WideBvhData;
use crate::shared::bvh_walk::EMPTY;
use crate::shared::constants::{NO_NODE, WIDE_MAX_DEPTH};
use crate::shared::wide_node::WideContent;

/// A guarantee that a BVH violates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BvhFault {
    /// A node refers to nodes or items that do not exist, or that belong to another node as well.
    #[error("node {0} links to what is not there, or to what another node links to")]
    Link(u32),
    /// A node has the wrong parent.
    #[error("node {0} names the wrong parent")]
    Parent(u32),
    /// The children of a node are not in order along its axis.
    #[error("the children of node {0} are not ordered along its axis")]
    Order(u32),
    /// The depth is not the stated one, or exceeds the limit.
    #[error("the tree is {0} levels deep, not what it says or more than is allowed")]
    Depth(u32),
    /// Corners in a leaf are not those of the triangle it names.
    #[error("entry {0} does not have the corners of its triangle")]
    Corners(u32),
    /// A triangle is in no leaf.
    #[error("no leaf lists triangle {0}")]
    Missing(u32),
    /// Part of a triangle is outside the boxes that lead to it.
    #[error("the boxes that lead to triangle {0} do not contain it")]
    Uncovered(u32),
}

/// A triangle in a leaf, and the intersection of the boxes on the path to it.
struct Listing {
    triangle: u32,
    bounds: [[f64; 3]; 2],
}

const EVERYWHERE: [[f64; 3]; 2] = [[f64::NEG_INFINITY; 3], [f64::INFINITY; 3]];

fn meet(a: [[f64; 3]; 2], b: [[f64; 3]; 2]) -> [[f64; 3]; 2] {
    [[0, 1, 2].map(|i| a[0][i].max(b[0][i])), [0, 1, 2].map(|i| a[1][i].min(b[1][i]))]
}

/// Checks that every triangle is listed. The grown box of a triangle that is listed once must lie inside all boxes on
/// the path to it; one that is listed several times must be covered by the boxes that lead to it, shrunk by the growth.
fn contained(vertices: &[f32], padding: Padding, mut listings: Vec<Listing>) -> Result<(), BvhFault> {
    listings.sort_by_key(|l| l.triangle);
    let mut next = 0;
    for same in listings.chunk_by(|a, b| a.triangle == b.triangle) {
        let triangle = same[0].triangle;
        if triangle != next {
            return Err(BvhFault::Missing(next));
        }
        next += 1;
        let corners = corners(vertices, triangle);
        let [a, b, c] = corners;
        let bounds = Bounds { min: a.min(b).min(c).to_array(), max: a.max(b).max(c).to_array() };
        let first = 9 * triangle as usize;
        let extent = f64::from(extent(&vertices[first..first + 9]));
        let [min, max] = bounds.grown(padding.of_triangle(extent, false));
        let inside = |l: &Listing| (0..3).all(|i| l.bounds[0][i] <= min[i] && max[i] <= l.bounds[1][i]);
        if same.iter().any(inside) {
            continue;
        }
        // The rounding error of f64 where planes cut the triangle.
        let largest = min.iter().chain(&max).fold(0.0f64, |m, v| m.max(v.abs()));
        let shrink = padding.of_triangle(extent, true) - largest * 2.0f64.powi(-40);
        let shrunk = same.iter().map(|l| [l.bounds[0].map(|v| v + shrink), l.bounds[1].map(|v| v - shrink)]);
        if same.len() == 1 || !covered(corners, shrunk) {
            return Err(BvhFault::Uncovered(triangle));
        }
    }
    let triangles = (vertices.len() / 9) as u32;
    if next < triangles { Err(BvhFault::Missing(next)) } else { Ok(()) }
}

impl BvhData {
    /// Checks the BVH over `vertices`: links, order, depth, and boxes in f64.
    ///
    /// # Errors
    /// The first violation.
    pub fn check(&self, vertices: &[f32]) -> Result<(), BvhFault> {
        let triangles = (vertices.len() / 9) as u32;
        let mut seen = vec![false; self.nodes.len()];
        let (mut listed, mut depth) = (0, 0);
        let mut listings = Vec::with_capacity(self.items.len());
        let mut waiting = vec![(0u32, NO_NODE, 1u32, EVERYWHERE)];
        while let Some((i, parent, level, outer)) = waiting.pop() {
            let Some(node) = self.nodes.get(i as usize).filter(|_| !std::mem::replace(&mut seen[i as usize], true))
            else {
                return Err(BvhFault::Link(parent));
            };
            if self.parents.get(i as usize) != Some(&parent) {
                return Err(BvhFault::Parent(i));
            }
            depth = depth.max(level);
            let inner = meet(outer, [node.min.map(f64::from), node.max.map(f64::from)]);
            if node.link == EMPTY && i == 0 {
                continue;
            }
            if node.is_inner() {
                // The walk recognises the first of two siblings by its odd index.
                let last =
                    node.first.checked_add(1).filter(|&last| last % 2 == 0 && (last as usize) < self.nodes.len());
                let last = last.ok_or(BvhFault::Link(i))?;
                let (axis, swapped) = order(&self.nodes[node.first as usize], &self.nodes[last as usize]);
                if swapped || axis != node.axis() {
                    return Err(BvhFault::Order(i));
                }
                waiting.extend([(last, i, level + 1, inner), (node.first, i, level + 1, inner)]);
            } else {
                let range = node.first as usize..node.first as usize + node.count() as usize;
                let items = self.items.get(range).ok_or(BvhFault::Link(i))?;
                if items.iter().any(|&triangle| triangle >= triangles) {
                    return Err(BvhFault::Link(i));
                }
                listed += items.len();
                listings.extend(items.iter().map(|&triangle| Listing { triangle, bounds: inner }));
            }
        }
        if depth != self.depth {
            return Err(BvhFault::Depth(depth));
        }
        if let Some(unused) = seen.iter().position(|seen| !seen) {
            return Err(BvhFault::Link(unused as u32));
        }
        // More entries than there are mean that leaves share ranges.
        if listed > self.items.len() {
            return Err(BvhFault::Link(0));
        }
        contained(vertices, self.padding, listings)
    }
}

impl WideBvhData {
    /// Checks the BVH over `vertices`: links, depth, entries, and boxes in f64.
    ///
    /// # Errors
    /// The first violation.
    pub fn check(&self, vertices: &[f32]) -> Result<(), BvhFault> {
        let triangles = (vertices.len() / 9) as u32;
        let mut seen = vec![false; self.nodes.len()];
        let mut listed = vec![false; self.triangles.len()];
        let mut depth = 0;
        let mut listings = Vec::with_capacity(self.triangles.len());
        let mut waiting = vec![(0u32, 0u32, 1u32, EVERYWHERE)];
        while let Some((i, parent, level, outer)) = waiting.pop() {
            let node = self.nodes.get(i as usize).ok_or(BvhFault::Link(parent))?;
            if std::mem::replace(&mut seen[i as usize], true) {
                return Err(BvhFault::Link(parent));
            }
            depth = depth.max(level);
            for child in node.children() {
                let inner = meet(outer, [child.min, child.max]);
                let (first, count) = match child.content {
                    WideContent::Inner(node) => {
                        waiting.push((node, i, level + 1, inner));
                        continue;
                    }
                    WideContent::Leaf { first, count } => (first, count),
                };
                for at in first..first.saturating_add(count) {
                    let entry = self.triangles.get(at as usize).filter(|entry| entry[3] < triangles);
                    let entry = entry.ok_or(BvhFault::Link(i))?;
                    if std::mem::replace(&mut listed[at as usize], true) {
                        return Err(BvhFault::Link(i));
                    }
                    let corner = |c: usize| [0, 1, 2].map(|a| f32::from_bits(entry[4 * c + a]));
                    if [0, 1, 2].map(corner) != corners(vertices, entry[3]).map(|c| c.to_array()) {
                        return Err(BvhFault::Corners(at));
                    }
                    listings.push(Listing { triangle: entry[3], bounds: inner });
                }
            }
        }
        if depth != self.depth || depth > WIDE_MAX_DEPTH {
            return Err(BvhFault::Depth(depth));
        }
        if let Some(unused) = seen.iter().position(|seen| !seen) {
            return Err(BvhFault::Link(unused as u32));
        }
        contained(vertices, self.padding, listings)
    }
}
