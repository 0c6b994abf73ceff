//! The light tree of the selected pixel in the 3D view: its rays up to the current pass.

use glam::DVec3;
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

/// What a picture of the whole tree contains.
#[derive(Default)]
pub(super) struct Extent {
    /// The ends of its rays to lights; a light that is far from the scene counts only by its direction.
    pub(super) ends: Vec<DVec3>,
    /// Those that lie in the scene.
    pub(super) inside: Vec<DVec3>,
}

impl Extent {
    /// Of a pixel's history.
    pub(super) fn of(history: &Trace, opened: &Opened, scene: &Aabb) -> Self {
        let whole = tree(history, history.rows.len(), opened);
        let lines = whole.map_or_else(Vec::new, |tree| branches(&tree, history, scene));
        let lines: Vec<&Branch> = lines.iter().filter(|line| line.light.is_some()).collect();
        let most = 2.0 * scene.radius();
        let end = |line: &&Branch| {
            let way = line.beyond.unwrap_or(line.to) - line.from;
            line.from + way * (most / way.length()).min(1.0)
        };
        let ends = lines.iter().map(end).filter(|point| point.is_finite()).collect();
        let is_inside = |point: &DVec3| point.cmpge(scene.min).all() && point.cmple(scene.max).all();
        let inside = lines.iter().flat_map(|line| [line.from, line.to]).filter(is_inside).collect();
        Self { ends, inside }
    }
}
