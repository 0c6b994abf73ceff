//! Twins of the kernels that make the voxel map.

use std::cmp::Ordering;

use super::pass::{Pass, View, high_of, low_of};
use crate::scene_data::SceneData;
use crate::shared::build::Build;
use crate::shared::irregular_walk::{block_entry, cell_entry};
use crate::tables::texels::Columns;

/// Bit 0 of a child tells whether it is a node; else it is a leaf.
const NODE: u32 = 1;

/// Where a leaf lies in its octree: `leaf_level.wgsl`.
struct Place {
    level: u32,
    corner: [u32; 3],
    /// Number of nodes that have this leaf as their first.
    opens: u32,
}

impl Place {
    fn of(build: &Build, extent: [u32; 3]) -> Self {
        let width = high_of(extent[0]).wrapping_sub(low_of(extent[0]));
        let level = build.levels.saturating_sub(width.trailing_zeros());
        let corner = extent.map(low_of);
        let joined = corner.iter().fold(0, |joined, low| joined | low >> (build.levels - level));
        Self { level, corner, opens: level.min(joined.trailing_zeros()) }
    }
}

/// The index of the top-level cell that a virtual cell is in.
fn top_of(build: &Build, voxel: [u32; 3]) -> u32 {
    let [x, y, z] = voxel.map(|v| v >> build.levels);
    x + build.cells[0] * (y + build.cells[1] * z)
}

/// Which child of a node, so many levels above the finest, holds a virtual cell.
fn octant_of(voxel: [u32; 3], shift: u32) -> u32 {
    let bit = |a: usize| voxel[a].checked_shr(shift).unwrap_or(0) & 1;
    bit(0) | bit(1) << 1 | bit(2) << 2
}

pub(crate) fn open_nodes(columns: &mut dyn Columns, data: &SceneData) {
    let mut pass = Pass::new(columns, &data.build);
    let [space, opened, cell_of] = ["space", "opened", "cell_of"].map(|name| pass.of(name));
    for i in 0..pass.len(space) {
        let place = Place::of(&data.build, pass.all(space, i));
        pass.set(opened, 0, i, place.opens);
        pass.set(cell_of, 0, i, i);
    }
}

/// The order of virtual cells: by their top-level cells, then along the Z-order curve (Morton, 1966).
fn order(build: &Build, a: [u32; 3], b: [u32; 3]) -> Ordering {
    let by_top = top_of(build, a).cmp(&top_of(build, b));
    let along_the_curve = || {
        // The axis with the highest bit that differs decides, the last one if several have it.
        let axis = (0..3).max_by_key(|&axis| ((a[axis] ^ b[axis]).checked_ilog2(), axis)).unwrap_or(0);
        a[axis].cmp(&b[axis])
    };
    by_top.then_with(along_the_curve)
}

pub(crate) fn link_nodes(columns: &mut dyn Columns, data: &SceneData) {
    let build = &data.build;
    let mut pass = Pass::new(columns, build);
    let [space, opened, sums] = ["space", "opened", "opened_of_block"].map(|name| pass.of(name));
    let [node, tree, tree_top] = ["node", "tree", "tree_top"].map(|name| pass.of(name));
    for i in 0..pass.len(space) {
        let Place { level, corner, opens } = Place::of(build, pass.all(space, i));
        let first = pass.sum_before(opened, sums, 0, i);
        let mut below = i << 1;
        for k in (0..opens).rev() {
            let index = first + k;
            pass.set_all(node, index, [i, level - opens + k]);
            pass.set(tree, 0, 8 * index, below);
            below = index << 1 | NODE;
        }
        let top_level = level - opens;
        if top_level == 0 {
            pass.set(tree_top, 0, top_of(build, corner), below);
            continue;
        }
        let shift = build.levels - top_level;
        // The parent's first leaf is the last one before this one whose corner does not come after the parent's.
        let parent_corner = corner.map(|v| v >> (shift + 1) << (shift + 1));
        let (mut low, mut high) = (0, i);
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            let its_corner = pass.all::<3>(space, middle).map(low_of);
            if order(build, parent_corner, its_corner) == Ordering::Less { high = middle } else { low = middle }
        }
        let its = Place::of(build, pass.all(space, low));
        let parent = (pass.sum_before(opened, sums, 0, low) + top_level - 1 + its.opens).wrapping_sub(its.level);
        pass.set(tree, 0, parent.wrapping_mul(8).wrapping_add(octant_of(corner, shift)), below);
    }
}

fn children(pass: &Pass<'_>, tree: View, node: u32) -> [u32; 8] {
    std::array::from_fn(|octant| pass.get(tree, 0, node.wrapping_mul(8).wrapping_add(octant as u32)))
}

/// Levels of the block below a node.
fn levels_below(pass: &Pass<'_>, tree: View, node: u32) -> u32 {
    let nodes = |node: u32| children(pass, tree, node).into_iter().filter(|below| below & NODE != 0);
    let divided: Vec<u32> = nodes(node).map(|below| below >> 1).collect();
    match divided.iter().map(|&node| nodes(node).count()).sum::<usize>() {
        _ if divided.is_empty() => 1,
        0..4 => 2,
        _ => 3,
    }
}

pub(crate) fn size_blocks(columns: &mut dyn Columns, data: &SceneData) {
    let build = &data.build;
    let mut pass = Pass::new(columns, build);
    let [space, node, tree, tree_top] = ["space", "node", "tree", "tree_top"].map(|name| pass.of(name));
    let [first_entry, block_levels] = ["first_entry", "block_levels"].map(|name| pass.of(name));
    for i in 0..pass.len(node) {
        let [leaf, own_level] = pass.all(node, i);
        let voxel = pass.all::<3>(space, leaf).map(low_of);
        let mut root = pass.get(tree_top, 0, top_of(build, voxel)) >> 1;
        let (mut level, mut levels) = (0, levels_below(&pass, tree, root));
        while level + levels <= own_level {
            for _ in 0..levels {
                let octant = octant_of(voxel, build.levels.wrapping_sub(level + 1));
                root = pass.get(tree, 0, root.wrapping_mul(8).wrapping_add(octant)) >> 1;
                level += 1;
            }
            levels = levels_below(&pass, tree, root);
        }
        let begins = level == own_level;
        pass.set(first_entry, 0, i, if begins { 1 << (3 * levels) } else { 0 });
        pass.set(block_levels, 0, i, if begins { levels } else { 0 });
    }
}

/// The entry of the voxel map for a leaf, or for a node with which a block begins.
fn entry_of(pass: &Pass<'_>, [first_entry, block_levels]: [View; 2], below: u32) -> u32 {
    let index = below >> 1;
    if below & NODE == 0 {
        return cell_entry(index);
    }
    block_entry(pass.top_cells() + pass.get(first_entry, 0, index), pass.get(block_levels, 0, index))
}

pub(crate) fn map_top_level(columns: &mut dyn Columns, data: &SceneData) {
    let mut pass = Pass::new(columns, &data.build);
    let [tree_top, map_top] = ["tree_top", "map_top"].map(|name| pass.of(name));
    let blocks = ["first_entry", "block_levels"].map(|name| pass.of(name));
    for i in 0..pass.len(tree_top) {
        let entry = entry_of(&pass, blocks, pass.get(tree_top, 0, i));
        pass.set(map_top, 0, i, entry);
    }
}

pub(crate) fn map_blocks(columns: &mut dyn Columns, data: &SceneData) {
    let mut pass = Pass::new(columns, &data.build);
    let [tree, map_below] = ["tree", "map_below"].map(|name| pass.of(name));
    let blocks @ [first_entry, block_levels] = ["first_entry", "block_levels"].map(|name| pass.of(name));
    let nodes = pass.len(first_entry);
    for i in 0..pass.len(map_below) {
        // Nodes without entries begin where the next ones do.
        let (mut low, mut high) = (0, nodes);
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            if pass.get(first_entry, 0, middle) <= i { low = middle } else { high = middle }
        }
        let levels = pass.get(block_levels, 0, low).min(3);
        let place = i.wrapping_sub(pass.get(first_entry, 0, low));
        let voxel = [0, levels, 2 * levels].map(|shift| place >> shift & ((1 << levels) - 1));
        let mut below = low << 1 | NODE;
        for k in (0..levels).rev() {
            if below & NODE != 0 {
                below = children(&pass, tree, below >> 1)[octant_of(voxel, k) as usize];
            }
        }
        let entry = entry_of(&pass, blocks, below);
        pass.set(map_below, 0, i, entry);
    }
}

/// The voxel map: `voxel_map.wgsl`.
pub(super) struct VoxelMap {
    top: View,
    below: View,
}

impl VoxelMap {
    pub(super) fn new(pass: &Pass<'_>) -> Self {
        let [top, below] = ["map_top", "map_below"].map(|name| pass.of(name));
        Self { top, below }
    }

    /// The leaf of the octrees, or at the end the cell, to which a virtual cell belongs.
    pub(super) fn find(&self, pass: &Pass<'_>, voxel: [u32; 3]) -> u32 {
        let mut shift = pass.build.levels;
        let mut entry = pass.get(self.top, 0, top_of(pass.build, voxel));
        while entry & 3 != 0 && shift > 0 {
            let depth = entry & 3;
            shift -= depth.min(shift);
            let [x, y, z] = voxel.map(|v| v >> shift & ((1 << depth) - 1));
            let place = (entry >> 2).wrapping_sub(pass.top_cells()).wrapping_add(x + ((y + (z << depth)) << depth));
            entry = pass.get(self.below, 0, place);
        }
        entry >> 2
    }
}
