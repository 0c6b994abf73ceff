//! Builds a tree from the leaves up: clusters in Morton order, each joined with the neighbour with which it makes the
//! smallest box, as in *Parallel Locally-Ordered Clustering* (Meister and Bittner 2018).
//!
//! Two clusters are joined if each is the other's best partner. With nested boxes that is one pair per round, which
//! takes n rounds; a round that joins less than an eighth joins all neighbours instead, so the number of rounds, and
//! with it the depth, grows with log n.

use glam::DVec3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::ploc::morton::morton_encode_u64_unorm;

use crate::numbers::parallel::{for_chunks, map_ranges};

const CHUNK: usize = 1 << 12;

/// This few clusters may continue with one pair per round.
const FEW: usize = 32;

/// Nodes of a tree over the boxes: the root first, children in pairs after their parents; a leaf refers to one box.
pub(super) fn cluster(boxes: &[Aabb], search: usize) -> Vec<Bvh2Node> {
    let mut clusters: Vec<Bvh2Node> =
        morton_order(boxes).iter().map(|&i| Bvh2Node::new(boxes[i as usize], 1, i)).collect();
    if clusters.len() < 2 {
        return clusters;
    }
    let mut nodes = vec![Bvh2Node::default(); 2 * clusters.len() - 1];
    // Filled from the end, so that the nodes joined last, which have the largest boxes, come first.
    let mut free = nodes.len();
    let mut best = vec![0u32; clusters.len()];
    while clusters.len() > 1 {
        let count = clusters.len();
        let best = &mut best[..count];
        for_chunks(best, CHUNK, |first, piece| {
            for (i, best) in piece.iter_mut().enumerate() {
                *best = best_partner(&clusters, first + i, search) as u32;
            }
        });
        let pairs = (0..count).filter(|&i| best[i] as usize > i && best[best[i] as usize] as usize == i).count();
        if count > FEW && pairs < count / 8 {
            best.iter_mut().enumerate().for_each(|(i, best)| *best = (i ^ 1).min(count - 1) as u32);
        }
        let mut kept = 0;
        for i in 0..count {
            let partner = best[i] as usize;
            if partner == i || best[partner] as usize != i {
                clusters[kept] = clusters[i];
                kept += 1;
            } else if partner < i {
                continue;
            } else {
                // In the place of the first of the two, which keeps the Morton order.
                let (left, right) = (clusters[i], clusters[partner]);
                free -= 2;
                nodes[free] = left;
                nodes[free + 1] = right;
                clusters[kept] = Bvh2Node::new(left.aabb().union(right.aabb()), 0, free as u32);
                kept += 1;
            }
        }
        clusters.truncate(kept);
    }
    nodes[0] = clusters[0];
    nodes
}

/// The cluster within `search` places with which `i` has the smallest box. Among equals, its neighbour in the pairs 0
/// 1, 2 3, … and then the first: so each round halves the number of identical boxes.
fn best_partner(clusters: &[Bvh2Node], i: usize, search: usize) -> usize {
    let own = clusters[i].aabb();
    let area = |j: usize| own.union(clusters[j].aabb()).half_area();
    let mut best = if i ^ 1 < clusters.len() { i ^ 1 } else { i - 1 };
    let mut smallest = area(best);
    let (first, end) = (i.saturating_sub(search), (i + search + 1).min(clusters.len()));
    for j in (first..i).chain(i + 1..end) {
        let area = area(j);
        if area < smallest {
            (best, smallest) = (j, area);
        }
    }
    best
}

/// Indices of the boxes, sorted by the Morton code of their centres, in cubes, then by index.
fn morton_order(boxes: &[Aabb]) -> Vec<u32> {
    let center = |b: &Aabb| b.min.as_dvec3() * 0.5 + b.max.as_dvec3() * 0.5;
    let parts = map_ranges(boxes.len(), 1 << 16, |range| {
        boxes[range]
            .iter()
            .map(center)
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), c| (low.min(c), high.max(c)))
    });
    let (low, high) = parts
        .into_iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), part| (low.min(part.0), high.max(part.1)));
    let extent = (high - low).max_element();
    // Just below 1: the code cannot represent 1 itself.
    let scale = if extent > 0.0 { (1.0 - 1e-9) / extent } else { 0.0 };
    let mut keys = vec![(0u64, 0u32); boxes.len()];
    for_chunks(&mut keys, 1 << 14, |first, piece| {
        for (i, key) in piece.iter_mut().enumerate() {
            let at = (center(&boxes[first + i]) - low) * scale;
            *key = (morton_encode_u64_unorm(at), (first + i) as u32);
        }
    });
    sort(&mut keys);
    keys.into_iter().map(|(_, i)| i).collect()
}

fn sort(keys: &mut [(u64, u32)]) {
    #[cfg(feature = "parallel")]
    rayon::slice::ParallelSliceMut::par_sort_unstable(keys);
    #[cfg(not(feature = "parallel"))]
    keys.sort_unstable();
}
