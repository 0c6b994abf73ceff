//! How many loop turns one thread may take in one dispatch, and which runs need several dispatches for them.
//!
//! Some adapters end a shader's loops after a number of turns, without a word: Mesa's software Vulkan after 65,535 of
//! all loops of a thread, or of the threads beside it in a vector, together. Others take the GPU away from a dispatch
//! that lasts too long. So no thread takes more turns than [`Limits::turns`] and a step. Where the bounds here say that
//! none can need as many, nothing of this is compiled.

use super::limits::{Limits, TURNS_WITHOUT_LIMIT};
use crate::options::features::Features;
use crate::shared::constants::{NODES_A_STEP, TURNS_A_TEST};
use crate::structures::Structure;

/// How many budgets a tree's turns may be where the adapter ends no loop. Only a ray made for it meets all boxes of a
/// tree; it costs time there and nothing else, and code that can wait costs every ray 15% of `fused` on an H200.
const BUDGETS_OF_A_TREE: u64 = 16;

/// What may take too many turns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Resumes {
    /// A walk: a pass of `walk`, or all of `fused`.
    pub(super) walk: bool,
    /// The search for repeated tests.
    pub(super) scan: bool,
    /// The sum over the lights.
    pub(super) light: bool,
}

impl Resumes {
    /// What exceeds the limits of one dispatch. `steps`: of a ray in one pass, as far as the schedule takes several;
    /// `lights`: how many are summed.
    pub(super) fn of(walk: &Walk<'_>, is_fused: bool, steps: u32, lights: u64, limits: &Limits) -> Self {
        let (most, features) = (u64::from(limits.turns), walk.features);
        let turns = if is_fused && features.bvh && limits.turns >= TURNS_WITHOUT_LIMIT {
            walk.turns() / BUDGETS_OF_A_TREE
        } else if is_fused {
            walk.turns()
        } else if features.many_steps {
            walk.turns_of_a_pass(steps)
        } else {
            0
        };
        let counts_repeated = features.counters && features.grid && !is_fused && !features.many_steps;
        Self { walk: turns > most, scan: counts_repeated && walk.turns_of_a_search() > most, light: lights > most }
    }
}

/// What bounds a ray's way: the structure that it goes through, and how.
pub(super) struct Walk<'a> {
    /// The options of the kernels.
    pub(super) features: &'a Features,
    /// What it goes through.
    pub(super) structure: &'a Structure,
    /// All triangles, which it goes through without a structure.
    pub(super) triangles: u64,
}

impl Walk<'_> {
    /// Most cells on a ray's way through the grid.
    fn cells(&self) -> u64 {
        let sum = self.structure.cells_along_axes();
        // As `fused` bounds the paper's rules, which may run over a face again and again.
        if self.features.in_cell { 4 * sum + 64 } else { sum + 2 }
    }

    fn longest_list(&self) -> u64 {
        u64::from(self.structure.longest_list())
    }

    /// Turns of a ray's whole way.
    fn turns(&self) -> u64 {
        let test = u64::from(TURNS_A_TEST);
        match self.structure {
            Structure::Grid { data, .. } => {
                let cells = self.cells();
                let tests = cells.saturating_mul(self.longest_list());
                // A ray of robust numerics is in no cell twice.
                let tests = if self.features.robust { tests.min(data.items.len() as u64) } else { tests };
                cells + test * tests
            }
            // A node's leaves lie in its loop, and a wait's way down is as long as the tree is deep.
            Structure::Wide(tree) => {
                tree.nodes.len() as u64 + test * tree.triangles.len() as u64 + u64::from(tree.depth)
            }
            // No kernel goes through all of a binary tree at once.
            Structure::Bvh(_) => 0,
            Structure::None => test * self.triangles,
        }
    }

    /// Turns of a pass of several steps.
    fn turns_of_a_pass(&self, steps: u32) -> u64 {
        let (test, steps) = (u64::from(TURNS_A_TEST), u64::from(steps));
        match self.structure {
            Structure::Grid { .. } => steps.min(self.cells()) * (1 + test * self.longest_list()),
            Structure::Bvh(tree) => {
                let nodes = (steps * u64::from(NODES_A_STEP)).min(2 * tree.nodes.len() as u64);
                nodes * (1 + test * self.longest_list())
            }
            // Rays step through no wide tree.
            Structure::Wide(_) => 0,
            Structure::None => test * steps.min(self.triangles),
        }
    }

    /// Turns of one search for a triangle in the lists of the cells before.
    fn turns_of_a_search(&self) -> u64 {
        let cells = self.structure.cells_along_axes() + 2;
        let longest = match self.structure {
            Structure::Grid { .. } => self.structure.longest_list(),
            _ => 0,
        };
        cells * u64::from(1 + 32 - longest.leading_zeros())
    }

    /// Most passes that a sample of all pixels can take before it must be over: every ray visits at most nx + ny + nz + 2
    /// cells and tests no list more than once. The paper's numerics can exceed it, see `docs`.
    pub(super) fn most_passes(&self, is_fused: bool) -> u64 {
        let walk = match self.structure {
            Structure::Grid { .. } => self.structure.cells_along_axes().saturating_add(2) * (self.longest_list() + 2),
            // A ray's whole way is bounded, and every pass takes a part of it.
            _ if self.features.resumes && is_fused => self.turns() / u64::from(self.features.turns) + 1,
            // A node is entered once, and come back to once.
            Structure::Bvh(tree) => 2 * tree.nodes.len() as u64 + 2 * tree.items.len() as u64,
            Structure::Wide(_) => 0,
            Structure::None => self.triangles + 1,
        };
        // A search for repeated tests may take several passes a test.
        let passes_a_test =
            if self.features.resumes_scan { self.turns_of_a_search() / u64::from(self.features.turns) + 2 } else { 1 };
        (2 * walk).saturating_mul(passes_a_test) + 16
    }
}
