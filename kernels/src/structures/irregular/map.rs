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

/// Writes the entry of a tree, and the blocks below it: those of nodes that begin one, parents first, then in the order
/// of children.
fn place(entries: &mut Vec<u32>, at: usize, tree: &Tree, first: u32) {
    match tree {
        Tree::Leaf(cell) => entries[at] = cell_entry(first + cell),
        Tree::Node(_) => {
            let block = Block { start: entries.len(), levels: depth_of(tree) };
            entries[at] = block_entry(block.start as u32, block.levels);
            entries.resize(block.start + (1 << (3 * block.levels)), 0);
            block.fill(entries, block.levels, [0; 3], tree, first);
        }
    }
}

/// A block of entries.
#[derive(Clone, Copy)]
struct Block {
    start: usize,
    levels: u32,
}

impl Block {
    /// Writes the entries of a tree in this block, so many levels above its entries, at a place in units of its size.
    fn fill(self, entries: &mut Vec<u32>, above: u32, place_of: [usize; 3], tree: &Tree, first: u32) {
        let index = |[x, y, z]: [usize; 3]| self.start + x + ((y + (z << self.levels)) << self.levels);
        match tree {
            Tree::Leaf(cell) => {
                let each = 0..1usize << above;
                let [x, y, z] = place_of.map(|v| v << above);
                for (k, j) in each.clone().flat_map(|k| each.clone().map(move |j| (k, j))) {
                    let row = index([x, y + j, z + k]);
                    entries[row..row + each.end].fill(cell_entry(first + cell));
                }
            }
            Tree::Node(_) if above == 0 => place(entries, index(place_of), tree, first),
            Tree::Node(children) => {
                for (i, child) in children.iter().enumerate() {
                    let half = [0, 1, 2].map(|a| 2 * place_of[a] + (i >> a & 1));
                    self.fill(entries, above - 1, half, child, first);
                }
            }
        }
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
