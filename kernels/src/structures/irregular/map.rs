//! The voxel map: from a virtual cell to the cell that it belongs to.

use super::layout::Layout;
use crate::shared::grid_walk::Grid;
use crate::shared::irregular_walk::{block_entry, cell_entry, find};

/// An octree below a top-level cell: leaves are indices of cells, counted from the tree's first.
pub(super) enum Tree {
    Leaf(u32),
    Node(Box<[Tree; 8]>),
}

/// The map while it is built.
pub(super) struct Map {
    pub(super) entries: Vec<u32>,
    pub(super) grid: Grid,
}

/// Most levels that one block of entries covers.
const MOST_AT_ONCE: u32 = 3;

impl Map {
    /// The map of one octree per top-level cell, each with the number of its first leaf.
    pub(super) fn new(layout: &Layout, trees: &[(u32, Tree)]) -> Self {
        let mut entries = vec![0; trees.len()];
        for (at, (first, tree)) in trees.iter().enumerate() {
            place(&mut entries, at, tree, *first);
        }
        Self { entries, grid: layout.grid }
    }

    /// The cell of a virtual cell.
    pub(super) fn find(&self, voxel: [i32; 3]) -> u32 {
        find(&self.grid, &self.entries, voxel)
    }

    /// Replaces every cell by another one.
    pub(super) fn rename(&mut self, name: impl Fn(u32) -> u32) {
        // Leaves have a depth of 0.
        for entry in self.entries.iter_mut().filter(|entry| **entry & 3 == 0) {
            *entry = cell_entry(name(*entry >> 2));
        }
    }
}

fn place(entries: &mut Vec<u32>, at: usize, tree: &Tree, first: u32) {
    let depth = depth_of(tree);
    if depth == 0 {
        if let Tree::Leaf(cell) = tree {
            entries[at] = cell_entry(first + cell);
        }
        return;
    }
    let block = entries.len();
    entries[at] = block_entry(block as u32, depth);
    entries.resize(block + (1 << (3 * depth)), 0);
    for i in 0..1usize << (3 * depth) {
        let mask = (1 << depth) - 1;
        let voxel = [i & mask, i >> depth & mask, i >> (2 * depth) & mask];
        let mut below = tree;
        for level in (0..depth).rev() {
            let Tree::Node(children) = below else { break };
            below = &children[(0..3).map(|a| (voxel[a] >> level & 1) << a).sum::<usize>()];
        }
        place(entries, block + i, below, first);
    }
}

/// Levels of the block below a tree: as many as are divided in at least a sixteenth of its volume. Large blocks take
/// memory, and save every step a load that waits for the one before.
fn depth_of(tree: &Tree) -> u32 {
    let Tree::Node(_) = tree else { return 0 };
    let mut divided = vec![tree];
    for depth in 1..MOST_AT_ONCE {
        let below = |tree: &&'_ Tree| matches!(tree, Tree::Node(_));
        let next: Vec<&Tree> = divided
            .iter()
            .flat_map(|tree| match tree {
                Tree::Node(children) => children.iter().collect(),
                Tree::Leaf(_) => Vec::new(),
            })
            .filter(below)
            .collect();
        if 16 * next.len() < 1 << (3 * depth) {
            return depth;
        }
        divided = next;
    }
    MOST_AT_ONCE
}
