//! The light tree of the selected pixel in the 3D view: its rays up to the current pass.

use raystep_kernels::export::light_tree::LightTree;
use raystep_kernels::export::trace::Trace;

use super::super::walked::Walked;
use crate::session::Model;
use crate::session::request::Opened;
use crate::walk::{Aabb, Branch, branches};

/// The rays of the tree.
#[derive(Default)]
pub(super) struct Lit {
    /// The version of the walk that they are of.
    version: Option<u64>,
    pub(super) branches: Vec<Branch>,
    /// They in words; empty without any.
    pub(super) told: String,
}

/// The tree of a history's first rows.
fn tree(history: &Trace, rows: usize, opened: &Opened) -> Option<LightTree> {
    LightTree::of(history.rows.get(..rows)?, opened.plan.program, &opened.data)
}

impl Lit {
    /// Takes over the walk. Returns whether the rays are others.
    pub(super) fn update(&mut self, walked: &Walked, model: &Model, scene: &Aabb) -> bool {
        if self.version.replace(walked.version) == Some(walked.version) {
            return false;
        }
        let all = walked.history.as_ref().zip(walked.row).zip(model.opened.as_ref());
        let found = all.and_then(|((history, row), opened)| Some((history, tree(history, row + 1, opened)?)));
        (self.branches, self.told) = match found {
            Some((history, tree)) => {
                let sample = tree.vertices.last().map_or(0, |last| last.sample);
                (branches(&tree, history, scene), format!("light tree: {}", tree.sentence(sample)))
            }
            None => (Vec::new(), String::new()),
        };
        true
    }
}

/// What a picture of the whole tree contains: a light that is far from the scene only by its direction.
pub(super) fn extent(history: &Trace, opened: &Opened, scene: &Aabb) -> Vec<glam::DVec3> {
    let whole = tree(history, history.rows.len(), opened);
    let lines = whole.map_or_else(Vec::new, |tree| branches(&tree, history, scene));
    let most = 2.0 * scene.radius();
    let ends = |line: &Branch| {
        let way = line.beyond.unwrap_or(line.to) - line.from;
        [line.from, line.from + way * (most / way.length()).min(1.0)]
    };
    lines.iter().filter(|line| line.light.is_some()).flat_map(ends).filter(|point| point.is_finite()).collect()
}
