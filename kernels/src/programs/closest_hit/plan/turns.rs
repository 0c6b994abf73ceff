//! How many loop iterations a thread may run in one dispatch, and which runs need several dispatches for that.
//!
//! Some adapters end a shader's loops after a number of iterations without an error: Mesa's software Vulkan after
//! 65,535, counted over all loops of a thread, or of the threads that share a vector with it. Others reset the GPU when
//! a dispatch takes too long. So no thread runs more than [`Limits::turns`] iterations and one step. If the bounds here
//! show that none can need as many, nothing of this is compiled.

use crate::options::features::{Features, StructureKind};
use crate::plan::limits::{Limits, TURNS_WITHOUT_LIMIT};
use crate::shared::constants::{NODES_A_STEP, TURNS_A_TEST, TURNS_TO_CROSS, TURNS_TO_DECIDE};
use crate::structures::Structure;

/// If the adapter ends no loop, walks through a BVH or an irregular grid can wait for the next dispatch only if they may
/// take more than this many times [`Limits::turns`]. Only a ray made for the purpose meets all boxes of a BVH, or the
/// longest lists of an irregular grid, and it costs only time; code that can wait makes `fused` 15% slower for every ray
/// on an H200.
const BUDGETS_OF_A_WALK: u64 = 16;

/// The loops that may take too many iterations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Resumes {
    /// A walk: a pass of `walk`, or the whole of `fused`.
    pub(super) walk: bool,
    /// The walk of a ray for which integers decide.
    pub(super) exact: bool,
    /// The search for repeated tests.
    pub(super) scan: bool,
    /// The sum over the lights.
    pub(super) light: bool,
}

impl Resumes {
    /// The loops that exceed the limits of one dispatch. `steps`: of a ray in one pass, if the schedule takes several;
    /// `lights`: how many are summed.
    pub(super) fn of(walk: &Walk<'_>, is_fused: bool, steps: u32, lights: u64, limits: &Limits) -> Self {
        let (most, features) = (u64::from(limits.turns), walk.features);
        let is_bounded_loosely = matches!(features.structure(), StructureKind::Bvh | StructureKind::Irregular);
        let turns = if is_fused && is_bounded_loosely && limits.turns >= TURNS_WITHOUT_LIMIT {
            walk.turns() / BUDGETS_OF_A_WALK
        } else if is_fused {
            walk.turns()
        } else if features.many_steps {
            walk.turns_of_a_pass(steps)
        } else {
            0
        };
        let counts_repeated = features.counters && features.grid && !is_fused && !features.many_steps;
        // Where the adapter ends loops, every test may be one that integers decide.
        let exact =
            if limits.turns >= TURNS_WITHOUT_LIMIT { walk.turns() / BUDGETS_OF_A_WALK } else { walk.turns_exact() };
        let exact = features.exact_order && exact > most;
        Self {
            walk: turns > most,
            exact,
            scan: counts_repeated && walk.turns_of_a_search() > most,
            light: lights > most,
        }
    }
}

/// What the length of a walk depends on: the structure, and the options of the kernels.
pub(super) struct Walk<'a> {
    /// The options of the kernels.
    pub(super) features: &'a Features,
    /// The acceleration structure.
    pub(super) structure: &'a Structure,
    /// All triangles; without a structure, every one is tested.
    pub(super) triangles: u64,
}

impl Walk<'_> {
    /// Most cells that a ray visits in the grid.
    fn cells(&self) -> u64 {
        let sum = self.structure.cells_along_axes();
        // As in `fused`: with the paper's rules, a ray may wrap over a face of the grid again and again.
        if self.features.in_cell { 4 * sum + 64 } else { sum + 2 }
    }

    /// Iterations to step to a cell of an irregular grid: one, and one per level of the map at most.
    fn turns_of_a_cell(&self) -> u64 {
        match self.structure {
            Structure::Irregular(data) => 1 + u64::from(data.grid.levels),
            _ => 1,
        }
    }

    fn longest_list(&self) -> u64 {
        u64::from(self.structure.longest_list())
    }

    /// Most iterations of a whole walk.
    fn turns(&self) -> u64 {
        let test = u64::from(TURNS_A_TEST);
        match self.structure {
            Structure::Grid { data, .. } => {
                let cells = self.cells();
                let tests = cells.saturating_mul(self.longest_list());
                // With robust numerics, a ray visits no cell twice.
                let tests = if self.features.robust { tests.min(data.items.len() as u64) } else { tests };
                cells + test * tests
            }
            // With robust numerics, a ray visits no cell twice; to find one takes an iteration per level at most.
            Structure::Irregular(data) => data.most_visited * self.turns_of_a_cell() + test * data.items.len() as u64,
            // A node's leaves are tested in its loop; resuming takes at most as many iterations as the tree is deep.
            Structure::Wide(tree) => {
                tree.nodes.len() as u64 + test * tree.triangles.len() as u64 + u64::from(tree.depth)
            }
            // A node is entered once, and returned to once.
            Structure::Bvh(tree) => 2 * tree.nodes.len() as u64 + test * tree.items.len() as u64,
            Structure::None => test * self.triangles,
        }
    }

    /// The same if integers decide every test.
    fn turns_exact(&self) -> u64 {
        let to_decide = if self.features.all_hits { TURNS_TO_CROSS } else { TURNS_TO_DECIDE };
        self.turns().saturating_mul(1 + u64::from(to_decide / TURNS_A_TEST))
    }

    /// Whether so many walks fit into one dispatch, each of which does. Without a limit of the adapter's, the bounds are too
    /// loose to be multiplied.
    pub(super) fn fits(&self, walks: u64, limits: &Limits) -> bool {
        limits.turns >= TURNS_WITHOUT_LIMIT || walks.saturating_mul(self.turns()) <= u64::from(limits.turns)
    }

    /// Most iterations of a pass of several steps.
    fn turns_of_a_pass(&self, steps: u32) -> u64 {
        let (test, steps) = (u64::from(TURNS_A_TEST), u64::from(steps));
        match self.structure {
            Structure::Grid { .. } => steps.min(self.cells()) * (1 + test * self.longest_list()),
            Structure::Irregular(data) => {
                steps.min(data.most_visited) * (self.turns_of_a_cell() + test * self.longest_list())
            }
            Structure::Bvh(tree) => {
                let nodes = (steps * u64::from(NODES_A_STEP)).min(2 * tree.nodes.len() as u64);
                nodes * (1 + test * self.longest_list())
            }
            // No kernel steps through a wide BVH.
            Structure::Wide(_) => 0,
            Structure::None => test * steps.min(self.triangles),
        }
    }

    /// Most iterations of one search for a triangle in the lists of earlier cells.
    fn turns_of_a_search(&self) -> u64 {
        let cells = self.structure.cells_along_axes() + 2;
        let longest = match self.structure {
            Structure::Grid { .. } => self.structure.longest_list(),
            _ => 0,
        };
        cells * u64::from(1 + 32 - longest.leading_zeros())
    }

    /// Most passes that a sample of all pixels can take: every ray visits at most nx + ny + nz + 2 cells and tests no
    /// list more than once. The paper's numerics can exceed it, see `docs`.
    pub(super) fn most_passes(&self, is_fused: bool) -> u64 {
        let walk = match self.structure {
            Structure::Grid { .. } => self.structure.cells_along_axes().saturating_add(2) * (self.longest_list() + 2),
            Structure::Irregular(data) => data.most_visited.saturating_add(2) * (self.longest_list() + 2),
            // The whole walk is bounded, and every pass takes a part of it.
            _ if self.features.resumes && is_fused => self.turns() / u64::from(self.features.turns) + 1,
            // A node is entered once, and returned to once.
            Structure::Bvh(tree) => 2 * tree.nodes.len() as u64 + 2 * tree.items.len() as u64,
            Structure::Wide(_) => 0,
            Structure::None => self.triangles + 1,
        };
        // A search for repeated tests may take several passes per test.
        let passes_a_test =
            if self.features.resumes_scan { self.turns_of_a_search() / u64::from(self.features.turns) + 2 } else { 1 };
        // Where integers decide, each test may take a dispatch.
        let exact =
            if self.features.resumes_exact { self.turns_exact() / u64::from(self.features.turns) + 1 } else { 0 };
        (2 * walk).saturating_mul(passes_a_test).saturating_add(exact) + 16
    }
}
