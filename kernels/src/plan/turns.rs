//! How many loop turns one thread may take in one dispatch, and which runs need several dispatches for them.
//!
//! Some adapters end a shader's loops after a number of turns, without a word: Mesa's software Vulkan after 65,535 of
//! all loops of a thread, or of the threads beside it in a vector, together. Others take the GPU away from a dispatch
//! that lasts too long. So no thread takes more turns than [`Limits::turns`] and a step. Where the bounds here say that
//! none can need as many, nothing of this is compiled.

use super::limits::{Limits, TURNS_WITHOUT_LIMIT};
use crate::options::features::Features;
use crate::scene_data::SceneData;
use crate::shared::constants::{NODES_A_STEP, TURNS_A_TEST};

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
    pub(super) fn of(features: &Features, data: &SceneData, is_fused: bool, lights: u64, limits: &Limits) -> Self {
        let most = u64::from(limits.turns);
        let walk = if is_fused && features.bvh && limits.turns >= TURNS_WITHOUT_LIMIT {
            whole_walk(features, data) / BUDGETS_OF_A_TREE
        } else if is_fused {
            whole_walk(features, data)
        } else if features.many_steps {
            one_pass(features, data)
        } else {
            0
        };
        let counts_repeated = features.counters && features.grid && !is_fused && !features.many_steps;
        Self { walk: walk > most, scan: counts_repeated && longest_search(data) > most, light: lights > most }
    }
}

/// Most cells on a ray's way through the grid.
fn cells_on_a_walk(features: &Features, data: &SceneData) -> u64 {
    let sum: u64 = data.grid.cells.iter().map(|&n| n as u64).sum();
    // As `fused` bounds the paper's rules, which may run over a face again and again.
    if features.in_cell { 4 * sum + 64 } else { sum + 2 }
}

/// The longest list of a cell or leaf.
fn longest_list(features: &Features, data: &SceneData) -> u64 {
    let longest = if features.grid {
        data.grid_cells.windows(2).map(|w| w[1] - w[0]).max()
    } else {
        data.bvh_nodes.iter().map(|node| node.count()).max()
    };
    u64::from(longest.unwrap_or(0))
}

/// Turns of a ray's whole way.
pub(super) fn whole_walk(features: &Features, data: &SceneData) -> u64 {
    let test = u64::from(TURNS_A_TEST);
    if features.grid {
        let cells = cells_on_a_walk(features, data);
        let tests = cells.saturating_mul(longest_list(features, data));
        // A ray of robust numerics is in no cell twice.
        let tests = if features.robust { tests.min(data.grid_items.len() as u64) } else { tests };
        return cells + test * tests;
    }
    if features.bvh {
        // A node's leaves lie in its loop, and a wait's way down is as long as the tree is deep.
        return data.wide_nodes.len() as u64 + test * data.packed_triangles.len() as u64 + u64::from(data.wide_depth);
    }
    test * u64::from(data.info.triangles)
}

/// Turns of a pass of several steps.
fn one_pass(features: &Features, data: &SceneData) -> u64 {
    let (test, steps) = (u64::from(TURNS_A_TEST), u64::from(data.info.steps));
    if features.grid {
        steps.min(cells_on_a_walk(features, data)) * (1 + test * longest_list(features, data))
    } else if features.bvh {
        let nodes = (steps * u64::from(NODES_A_STEP)).min(2 * data.bvh_nodes.len() as u64);
        nodes * (1 + test * longest_list(features, data))
    } else {
        test * steps.min(u64::from(data.info.triangles))
    }
}

/// Turns of one search for a triangle in the lists of the cells before.
pub(super) fn longest_search(data: &SceneData) -> u64 {
    let cells: u64 = data.grid.cells.iter().map(|&n| n as u64).sum::<u64>() + 2;
    let longest = data.grid_cells.windows(2).map(|w| w[1] - w[0]).max().unwrap_or(0);
    cells * u64::from(1 + 32 - longest.leading_zeros())
}
