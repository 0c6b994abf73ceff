//! The condition under which the fused kernel runs without bounds checks: a proof, from only the bytes that are bound,
//! that every index it computes from them is in bounds.
//!
//! Nothing is assumed about how the structures were built. Depth and shape of the BVH are derived from its nodes, and
//! the bits of a node are read as the shader reads them. The work is linear in the size of the data; the only
//! allocation is one byte per node, and if it fails, so does the proof.

use super::SceneData;
use crate::options::features::{Features, StructureKind};
use crate::shared::constants::{LAST_ITEM, NO_LIST, wide_stack};
use crate::shared::wide_node::WideNode;

/// Whether the shader can count the buffer's words or vectors in u32, as `stride * index + rest`.
pub(super) fn is_counted_in_u32(entries: usize, stride: usize) -> bool {
    entries.checked_mul(stride).is_some_and(|all| u32::try_from(all).is_ok())
}

impl SceneData {
    /// Whether every index that the fused kernel, compiled with `features`, follows is in bounds: a shader without
    /// bounds checks relies on this.
    ///
    /// - With a grid: there is an offset for every cell and one more, offsets do not decrease, and the last one is
    ///   within the items; items are triangles; there is a byte of distance for every cell, 0 if the cell has a list.
    /// - With an irregular grid: every entry of the voxel map leads to a cell within the grid's levels; boxes lie in the
    ///   grid; a list starts at an item, items are triangles, and the last one is marked as the end of a list.
    /// - With a BVH: each node but the root is the child of exactly one node, which comes before it, so there are
    ///   neither cycles nor shared children; the entries of its leaves exist; a path from the root has at most one node
    ///   more than the kernel's stack has entries.
    /// - With neither, there are as many triangles as the kernel counts.
    #[must_use]
    pub fn indices_hold(&self, features: &Features) -> bool {
        let entries = self.packed_triangles.len();
        // Three vectors each. The host and other kernels use the ids for lookups.
        let triangles_hold = is_counted_in_u32(entries, 3)
            && (self.info.triangles == 0 || self.packed_triangles.iter().all(|entry| entry[3] < self.info.triangles));
        triangles_hold
            && match features.structure() {
                StructureKind::None => self.info.triangles as usize <= entries,
                StructureKind::Grid => self.grid_holds(features.skip),
                StructureKind::Irregular => self.irregular_holds(),
                StructureKind::Bvh => {
                    wide_depth(&self.wide_nodes, entries).is_some_and(|depth| depth <= wide_stack(features.stack) + 1)
                }
            }
    }

    /// Whether every virtual cell leads to a cell whose box lies in the grid, and every list ends and has only triangles.
    fn irregular_holds(&self) -> bool {
        let (grid, map, cells) = (&self.grid, &self.irregular_map, &self.irregular_cells);
        let entries = self.packed_triangles.len();
        let items = &self.irregular_items;
        let is_counted = grid.cells.iter().all(|&n| n > 0 && n <= 1 << 15) && grid.levels <= 15;
        if !is_counted || !is_counted_in_u32(map.len(), 1) || !is_counted_in_u32(items.len(), 1) {
            return false;
        }
        let top = grid.cells.map(|n| (n >> grid.levels) as usize);
        let lists_hold = items.iter().all(|item| ((item & !LAST_ITEM) as usize) < entries.max(1))
            && items.last().is_some_and(|item| item & LAST_ITEM != 0)
            && cells.iter().all(|cell| cell.first == NO_LIST || (cell.first as usize) < items.len());
        let boxes_hold = cells
            .iter()
            .all(|cell| (0..3).all(|a| cell.low[a] < cell.high[a] && i32::from(cell.high[a]) <= grid.cells[a]));
        let count = top[0] * top[1] * top[2];
        lists_hold && boxes_hold && map_holds(map, count, grid.levels, cells.len())
    }

    fn grid_holds(&self, leaps: bool) -> bool {
        // The shader multiplies these as i32.
        let product = self.grid.cells.iter().try_fold(1i32, |all, &n| all.checked_mul(n).filter(|_| n > 0));
        let Some(cells) = product.map(|n| n as usize) else { return false };
        let entries = self.packed_triangles.len();
        self.grid_cells.len() == cells + 1
            && self.grid_cells.is_sorted()
            && self.grid_cells.last().is_some_and(|&end| end as usize <= self.grid_items.len())
            && self.grid_items.iter().all(|&item| (item as usize) < entries)
            && (!leaps || self.distances_hold(cells))
    }

    fn distances_hold(&self, cells: usize) -> bool {
        let lists = self.grid_cells.windows(2).map(|list| list[0] < list[1]);
        let bytes = self.grid_distances.iter().flat_map(|word| word.to_le_bytes());
        self.grid_distances.len() == cells.div_ceil(4)
            && lists.zip(bytes).all(|(has_list, distance)| !has_list || distance == 0)
    }
}

/// Whether each of the first `top` entries of a voxel map leads to cells only, over at most `levels` levels, and every
/// block belongs to one entry, which comes before it.
fn map_holds(map: &[u32], top: usize, levels: u32, cells: usize) -> bool {
    const NOBODYS: u8 = u8::MAX;
    // Levels that are left below each entry.
    let mut left: Vec<u8> = Vec::new();
    if top > map.len() || left.try_reserve_exact(map.len()).is_err() {
        return false;
    }
    left.resize(top, levels as u8);
    left.resize(map.len(), NOBODYS);
    (0..map.len()).all(|entry| {
        let (depth, start) = (map[entry] & 3, (map[entry] >> 2) as usize);
        if depth == 0 {
            return left[entry] != NOBODYS && start < cells;
        }
        let below = u32::from(left[entry]).checked_sub(depth).filter(|_| left[entry] != NOBODYS && start > entry);
        let block = start.checked_add(1 << (3 * depth)).and_then(|end| left.get_mut(start..end));
        match (below, block) {
            (Some(below), Some(block)) if block.iter().all(|&left| left == NOBODYS) => {
                block.fill(below as u8);
                true
            }
            _ => false,
        }
    })
}

/// Nodes on the longest path from the root, both ends included. `None` if the nodes do not form one tree whose parents
/// come before their children, or refer to something that does not exist.
fn wide_depth(nodes: &[WideNode], entries: usize) -> Option<u32> {
    // Five vectors per node.
    if nodes.is_empty() || !is_counted_in_u32(nodes.len(), 5) {
        return None;
    }
    // 0 for a node that no node refers to yet. More levels than a byte holds are more than any stack holds.
    let mut levels: Vec<u8> = Vec::new();
    levels.try_reserve_exact(nodes.len()).ok()?;
    levels.resize(nodes.len(), 0);
    levels[0] = 1;
    for (i, node) in nodes.iter().enumerate() {
        // Without a reference from an earlier node, it is no node's child, or the child of a later one.
        let below = levels[i].checked_add(1).filter(|&below| below > 1)?;
        // From all 24 bits, whether their slots are leaves or not: the shader does not check.
        let of_leaves = (node.contents & 0x00ff_ffff).count_ones() as usize;
        if of_leaves > 0 && entries.checked_sub(of_leaves)? < node.triangle_base as usize {
            return None;
        }
        let inner = (node.contents >> 24).count_ones() as usize;
        if inner > 0 {
            let first = node.child_base as usize;
            let children = levels.get_mut(first..first.checked_add(inner)?)?;
            // An earlier node, even the root, has a level already: so has every node on the path to this one.
            if children.iter().any(|&level| level != 0) {
                return None;
            }
            children.fill(below);
        }
    }
    levels.iter().max().map(|&deepest| u32::from(deepest))
}

#[cfg(test)]
mod tests {
    use raystep_scenes::{Camera, generate};

    use super::*;
    use crate::options::{Accelerator, Options, RaySource, ScheduleKind, Skip};
    use crate::plan::{Limits, Plan};

    fn fused(accelerator: Accelerator, triangles: usize) -> (Features, SceneData) {
        let scene = generate::soup(triangles as u64, 1).expect("soup");
        let rays = RaySource::Camera { camera: Camera::framing(&scene.bounds()), width: 8, height: 8 };
        let options = Options { accelerator, schedule: ScheduleKind::Fused, skip: Skip::On, ..Options::new(rays) };
        let (plan, data) = Plan::new(&scene, &options, &Limits::CPU).expect("a plan");
        (plan.features, data)
    }

    fn refused(what: &str, (features, data): &(Features, SceneData), change: impl FnOnce(&mut SceneData)) {
        let mut changed = data.clone();
        change(&mut changed);
        assert!(!changed.indices_hold(features), "not seen: {what}");
    }

    /// An inner node with a leaf and at least two inner nodes among its children.
    fn mixed(data: &SceneData) -> usize {
        let is_mixed = |n: &WideNode| n.contents >> 24 != 0 && n.contents & 0xff_ffff != 0 && n.contents >> 24 != 0x80;
        let found = data.wide_nodes.iter().rposition(|n| is_mixed(n) && (n.contents >> 24).count_ones() >= 2);
        found.expect("such a node in a large tree")
    }

    #[test]
    fn what_a_u32_cannot_count_is_not_indexed() {
        // 3 * 1431655765 = 2^32 - 1
        for (entries, stride, holds) in
            [(0, 3, true), (1_431_655_765, 3, true), (1_431_655_766, 3, false), (usize::MAX, 5, false)]
        {
            assert_eq!(is_counted_in_u32(entries, stride), holds, "{entries} of {stride}");
        }
    }

    #[test]
    fn what_is_built_holds() {
        for accelerator in [Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh, Accelerator::None] {
            for triangles in [1, 7, 2000] {
                let (features, data) = fused(accelerator, triangles);
                assert!(data.indices_hold(&features), "{accelerator}, {triangles} triangles");
            }
        }
    }

    #[test]
    fn a_wrong_index_of_the_grid_is_seen() {
        let built = fused(Accelerator::Grid, 2000);
        assert!(built.0.skip && built.0.grid);
        // Without skipping, no distance hides a wrong offset.
        let stepped = (Features { skip: false, ..built.0 }, built.1.clone());
        assert!(stepped.1.indices_hold(&stepped.0));
        let cells = built.1.grid_cells.len() - 1;
        let items = built.1.grid_items.len() as u32;
        refused("an item that is no triangle", &built, |d| d.grid_items[5] = 2000);
        refused("the largest item", &built, |d| *d.grid_items.last_mut().expect("items") = u32::MAX);
        refused("an offset that falls", &stepped, |d| d.grid_cells[cells / 2] = items + 1);
        refused("a last offset beyond the items", &stepped, |d| d.grid_cells[cells] = items + 1);
        refused("fewer items than the offsets say", &built, |d| d.grid_items.truncate(1));
        refused("an offset too few", &built, |d| d.grid_cells.truncate(1));
        refused("an offset too many", &built, |d| d.grid_cells.push(items));
        refused("a cell more along an axis", &built, |d| d.grid.cells[1] += 1);
        refused("no cell along an axis", &stepped, |d| (d.grid.cells[2], d.grid_cells) = (0, vec![0]));
        refused("axes whose signs cancel", &stepped, |d| d.grid.cells[..2].iter_mut().for_each(|n| *n = -*n));
        refused("axes whose product wraps to the right number", &stepped, |d| {
            // 2^16 * 2^16 is 0 in 32 bits.
            (d.grid.cells, d.grid_cells) = ([1 << 16, 1 << 16, 1], vec![0]);
        });
        refused("too few distances", &built, |d| d.grid_distances.truncate(1));
        let full = built.1.grid_cells.windows(2).position(|w| w[0] < w[1]).expect("a list");
        refused("a leap from a cell with a list", &built, |d| d.grid_distances[full / 4] |= 2 << (8 * (full % 4)));
        refused("fewer triangles than are listed", &built, |d| d.packed_triangles.truncate(1));
        refused("an id that is no triangle", &built, |d| d.packed_triangles[3][3] = 2000);
    }

    #[test]
    fn a_wrong_index_of_the_irregular_grid_is_seen() {
        let built = fused(Accelerator::Irregular, 2000);
        let (cells, items) = (built.1.irregular_cells.len() as u32, built.1.irregular_items.len());
        let map = &built.1.irregular_map;
        let block = map.iter().rposition(|entry| entry & 3 != 0).expect("a block");
        let leaf = map.iter().position(|entry| entry & 3 == 0).expect("a cell");
        refused("a cell that does not exist", &built, |d| d.irregular_map[leaf] = cells << 2);
        refused("a block beyond the map", &built, |d| d.irregular_map[block] = u32::MAX - 2);
        refused("a block before its entry", &built, |d| d.irregular_map[block] &= 3);
        refused("more levels than the grid has", &built, |d| d.grid.levels = 0);
        refused("a block of two entries", &built, |d| d.irregular_map[leaf] = d.irregular_map[block]);
        refused("a map that is cut off", &built, |d| d.irregular_map.truncate(map.len() - 1));
        refused("an entry that belongs to no block", &built, |d| d.irregular_map.push(0));
        refused("an item that is no triangle", &built, |d| d.irregular_items[5] = 2000);
        refused("a last list without an end", &built, |d| d.irregular_items[items - 1] &= !LAST_ITEM);
        refused("a list beyond the items", &built, |d| d.irregular_cells[3].first = items as u32);
        refused("a box that ends outside of the grid", &built, |d| d.irregular_cells[3].high[1] = u16::MAX);
        refused("a box without an extent", &built, |d| d.irregular_cells[3].low = d.irregular_cells[3].high);
        refused("fewer triangles than are listed", &built, |d| d.packed_triangles.truncate(1));
    }

    #[test]
    fn a_wrong_index_of_the_tree_is_seen() {
        let built = fused(Accelerator::Bvh, 2000);
        let (nodes, entries) = (built.1.wide_nodes.len() as u32, built.1.packed_triangles.len() as u32);
        let at = mixed(&built.1);
        refused("no node", &built, |d| d.wide_nodes.clear());
        refused("children beyond the nodes", &built, |d| d.wide_nodes[at].child_base = nodes - 1);
        refused("children whose place wraps", &built, |d| d.wide_nodes[at].child_base = u32::MAX);
        refused("entries beyond the triangles", &built, |d| d.wide_nodes[at].triangle_base = entries);
        refused("entries whose place wraps", &built, |d| d.wide_nodes[at].triangle_base = u32::MAX);
        refused("a last node that is missing", &built, |d| d.wide_nodes.truncate(1));
        refused("a last entry that is missing", &built, |d| d.packed_triangles.truncate(1));
        refused("an id that is no triangle", &built, |d| d.packed_triangles[7][3] = 2000);
        // The shader reads such bits as entries of a leaf.
        refused("entries of an inner child", &built, |d| {
            let slot = (d.wide_nodes[at].contents >> 24).trailing_zeros();
            d.wide_nodes[at].triangle_base = entries - (d.wide_nodes[at].contents & 0xff_ffff).count_ones();
            d.wide_nodes[at].contents |= 7 << (3 * slot);
        });
    }

    #[test]
    fn a_graph_that_is_no_tree_is_seen() {
        let built = fused(Accelerator::Bvh, 2000);
        let at = mixed(&built.1);
        let child = built.1.wide_nodes[at].child_base;
        refused("a node that is its own child", &built, |d| d.wide_nodes[at].child_base = at as u32);
        refused("a cycle through the root", &built, |d| d.wide_nodes[at].child_base = 0);
        refused("a cycle of two", &built, |d| {
            let below = &mut d.wide_nodes[child as usize];
            (below.child_base, below.contents) = (at as u32, 1 << 24);
        });
        refused("a child that another node has too", &built, |d| {
            let other = (1..at).rev().find(|&i| d.wide_nodes[i].contents >> 24 != 0).expect("another inner node");
            d.wide_nodes[other].child_base = child;
        });
        refused("a node that nobody names", &built, |d| d.wide_nodes.push(WideNode::default()));
        refused("a child that is not named any more", &built, |d| {
            let slot = 31 - d.wide_nodes[at].contents.leading_zeros();
            d.wide_nodes[at].contents &= !(1 << slot);
        });
        refused("siblings that overlap by one", &built, |d| d.wide_nodes[at].child_base += 1);
    }

    /// Nothing but the fault is wrong with these: every node is referred to, and every index is in bounds.
    #[test]
    fn of_small_graphs_only_trees_hold() {
        // For each node, its first child and the number of children.
        let graph = |nodes: &[(u32, u32)]| -> Vec<WideNode> {
            let node = |&(child_base, inner): &(u32, u32)| {
                let contents = if inner == 0 { 1 } else { ((1 << inner) - 1) << 24 };
                WideNode { child_base, contents, ..WideNode::default() }
            };
            nodes.iter().map(node).collect()
        };
        for (what, nodes, depth) in [
            ("a root alone", &[(0, 0)][..], Some(1)),
            ("a tree", &[(1, 2), (3, 1), (4, 1), (0, 0), (0, 0)], Some(3)),
            ("one whose first children come last", &[(1, 2), (4, 1), (3, 1), (0, 0), (0, 0)], Some(3)),
            ("a child of two", &[(1, 2), (3, 1), (3, 1), (0, 0)], None),
            ("siblings of which one is another's", &[(1, 2), (2, 2), (0, 0), (0, 0)], None),
            ("a root that is its own child", &[(0, 1)], None),
            ("a node that is its own child", &[(1, 1), (1, 1)], None),
            ("a cycle of two", &[(1, 1), (2, 1), (1, 1)], None),
            ("a cycle through the root", &[(1, 1), (2, 1), (0, 1)], None),
            ("a cycle that no way leads to", &[(0, 0), (2, 1), (1, 1)], None),
            ("a node that nobody names", &[(0, 0), (0, 0)], None),
            ("a child before its parent", &[(2, 1), (0, 0), (1, 1)], None),
            ("a child that is not there", &[(1, 1)], None),
        ] {
            assert_eq!(wide_depth(&graph(nodes), 1), depth, "{what}");
        }
        assert_eq!(wide_depth(&graph(&[(0, 0)]), 0), None, "a leaf without its entry");
    }

    #[test]
    fn a_tree_that_is_deeper_than_the_stack_is_seen_whatever_it_says_of_itself() {
        // One child per node: no group ever waits, but the stack's size must suffice for the worst ray.
        let chain = |depth: u32| {
            let inner = |i| WideNode { child_base: i + 1, contents: 1 << 24, ..WideNode::default() };
            let mut nodes: Vec<WideNode> = (0..depth - 1).map(inner).collect();
            nodes.push(WideNode { contents: 1, ..WideNode::default() });
            nodes
        };
        let (mut features, mut data) = fused(Accelerator::Bvh, 2000);
        let built = data.wide_depth;
        assert_eq!(wide_depth(&data.wide_nodes, data.packed_triangles.len()), Some(built), "as it was built");
        features.stack = built - 2;
        data.wide_depth = 1;
        assert!(!data.indices_hold(&features), "not seen: a stack too low by one, under a depth that is not true");
        features.stack = built - 1;
        assert!(data.indices_hold(&features));
        for (depth, stack, holds) in [(1, 0, true), (2, 0, true), (3, 0, false), (3, 1, false), (3, 2, true)]
            .into_iter()
            // The shader's stack has at most 32 entries, whatever is requested.
            .chain([(33, 32, true), (34, 33, false), (34, u32::MAX, false), (300, 299, false), (257, 256, false)])
        {
            (data.wide_nodes, features.stack) = (chain(depth), stack);
            assert_eq!(data.indices_hold(&features), holds, "{depth} levels with a stack of {stack}");
        }
    }

    #[test]
    fn without_a_structure_the_count_of_triangles_is_seen() {
        let built = fused(Accelerator::None, 40);
        refused("more triangles than there are", &built, |d| d.info.triangles = 41);
        refused("a triangle too few", &built, |d| d.packed_triangles.truncate(1));
        refused("an id that is no triangle", &built, |d| d.packed_triangles[39][3] = 40);
    }

    /// A plan and data of different runs: the proof must be about the features that the shader was compiled for.
    #[test]
    fn data_of_another_structure_is_seen() {
        let [grid, bvh, none] =
            [Accelerator::Grid, Accelerator::Bvh, Accelerator::None].map(|accelerator| fused(accelerator, 300));
        assert!(!grid.1.indices_hold(&bvh.0) && !bvh.1.indices_hold(&grid.0));
        assert!(!none.1.indices_hold(&grid.0) && !none.1.indices_hold(&bvh.0));
    }
}
