//! The node hierarchy: trees, and every node's world transform. Nothing here is recursive, since a file may nest its
//! nodes arbitrarily deep.

mod transform;

pub(super) use transform::{affine, scaled_rotated_moved};

use super::json::{Int, Property, Root};
use super::lost::Lost;
use super::notes::{Notes, Wrong};
use super::{LoadError, at};
use glam::{DAffine3, DQuat, DVec3};
use std::collections::HashSet;

/// The node hierarchy, mended where nodes do not form trees.
pub(super) struct Graph {
    parents: Vec<Option<usize>>,
    children: Vec<Vec<usize>>,
    /// Parents before children.
    order: Vec<usize>,
    /// Parent from node, or what is wrong with the node.
    local: Vec<Result<DAffine3, Box<LoadError>>>,
    /// World from node, if its parents' transforms are right, too. In f64, so that neither long chains nor large
    /// numbers that cancel each other lose precision.
    world: Vec<Option<DAffine3>>,
}

impl Graph {
    /// Reads the hierarchy, and ignores links that make it no tree.
    pub(super) fn new(root: &Root<'_>, notes: &mut Notes) -> Result<Self, LoadError> {
        root.nodes.get(|| "nodes".to_owned())?;
        let nodes = root.nodes.elements();
        let mut graph = Self {
            parents: vec![None; nodes.len()],
            children: Vec::with_capacity(nodes.len()),
            order: Vec::with_capacity(nodes.len()),
            local: Vec::with_capacity(nodes.len()),
            world: Vec::new(),
        };
        for (i, node) in nodes.iter().enumerate() {
            graph.local.push(transform::local(node, i).map_err(Box::new));
            let own = graph.own_children(root, i, notes);
            graph.children.push(own);
        }
        let mut is_reached = vec![false; nodes.len()];
        let roots: Vec<usize> = (0..nodes.len()).filter(|&i| graph.parents.get(i) == Some(&None)).collect();
        roots.into_iter().for_each(|root| graph.walk(root, &mut is_reached));
        // Each node has at most one parent, so a node that no root leads to is on a cycle, or below one.
        for i in 0..nodes.len() {
            if is_reached.get(i) == Some(&false) {
                let top = graph.cut_cycle(i);
                let problem = "is on a cycle of children, or below one; nodes must form trees";
                notes.lost(Lost::Link, (top, 0), at(format!("nodes[{top}]"), problem));
                graph.walk(top, &mut is_reached);
            }
        }
        graph.world = graph.worlds(DVec3::ZERO);
        Ok(graph)
    }

    /// The children of a node that have no other parent.
    fn own_children(&mut self, root: &Root<'_>, i: usize, notes: &mut Notes) -> Vec<usize> {
        let node = root.nodes.elements().get(i).and_then(|node| node.ok());
        let Some(listed) = node.map(|node| &node.children) else { return Vec::new() };
        if let Err(error) = listed.get(|| format!("nodes[{i}].children")) {
            notes.lost(Lost::Link, (i, 0), error);
        }
        let mut own = Vec::new();
        for (k, child) in listed.elements().iter().enumerate() {
            let path = || format!("nodes[{i}].children[{k}]");
            let linked = existing(root, child, path).and_then(|child| match self.parents.get_mut(child) {
                Some(Some(first)) => {
                    let problem = format!("node {child} is a child of node {first} already; a node has one parent");
                    Err(at(path(), problem))
                }
                parent => {
                    parent.into_iter().for_each(|parent| *parent = Some(i));
                    Ok(child)
                }
            });
            match linked {
                Ok(child) => own.push(child),
                Err(error) => notes.lost(Lost::Link, (i, k), error),
            }
        }
        own
    }

    /// Appends a node and all below it to the order.
    fn walk(&mut self, from: usize, is_reached: &mut [bool]) {
        let mut open = vec![from];
        while let Some(i) = open.pop() {
            if let Some(is_reached) = is_reached.get_mut(i) {
                *is_reached = true;
            }
            self.order.push(i);
            open.extend(self.children.get(i).into_iter().flatten());
        }
    }

    /// Makes a node of the cycle that node `i` is on or below a root, and returns it.
    fn cut_cycle(&mut self, i: usize) -> usize {
        let (mut top, mut passed) = (i, HashSet::new());
        while passed.insert(top) {
            top = self.parents.get(top).copied().flatten().unwrap_or(top);
        }
        let parent = self.parents.get_mut(top).and_then(Option::take);
        if let Some(children) = parent.and_then(|parent| self.children.get_mut(parent)) {
            children.retain(|&child| child != top);
        }
        top
    }

    /// The same hierarchy with `offset` subtracted from all positions, before anything is added to them.
    pub(super) fn shifted(self, offset: DVec3) -> Self {
        Self { world: self.worlds(offset), ..self }
    }

    fn worlds(&self, offset: DVec3) -> Vec<Option<DAffine3>> {
        let mut world = vec![None; self.order.len()];
        for &i in &self.order {
            let parent = match self.parents.get(i).copied().flatten() {
                None => Some(DAffine3::from_translation(DVec3::ZERO - offset)),
                Some(parent) => world.get(parent).copied().flatten(),
            };
            let own =
                parent.zip(self.local.get(i).and_then(|own| own.as_ref().ok())).map(|(parent, own)| parent * *own);
            if let Some(slot) = world.get_mut(i) {
                *slot = own;
            }
        }
        world
    }

    /// World from node `i`; the identity if it has none, which only nodes have that are not shown.
    pub(super) fn world(&self, i: usize) -> DAffine3 {
        self.try_world(i).unwrap_or(DAffine3::IDENTITY)
    }

    /// World from node `i`, if its transform and those above it are right.
    pub(super) fn try_world(&self, i: usize) -> Option<DAffine3> {
        self.world.get(i).copied().flatten()
    }

    /// The nodes of the scene to show, parents before children, siblings in the file's order.
    pub(super) fn nodes_of(
        &self,
        root: &Root<'_>,
        asked: Option<usize>,
        notes: &mut Notes,
    ) -> Result<Vec<usize>, LoadError> {
        let mut open = self.roots_of(root, asked, notes)?;
        open.reverse();
        let mut nodes = Vec::new();
        let mut is_shown = vec![false; self.parents.len()];
        while let Some(i) = open.pop() {
            match self.local.get(i) {
                Some(Err(error)) => notes.lost(Lost::Node, (i, 0), error.as_ref().clone()),
                Some(Ok(_)) if !is_shown.get_mut(i).is_none_or(|shown| std::mem::replace(shown, true)) => {
                    nodes.push(i);
                    open.extend(self.children.get(i).into_iter().flatten().rev());
                }
                _ => {}
            }
        }
        Ok(nodes)
    }

    /// Those of `nodes`, parents before children, that neither they nor a node above them hides.
    pub(super) fn visible(&self, root: &Root<'_>, nodes: &[usize], notes: &mut Notes) -> Vec<usize> {
        let mut is_hidden = vec![false; self.parents.len()];
        let mut visible = Vec::new();
        for &i in nodes {
            let node = root.nodes.elements().get(i).and_then(|node| node.ok());
            let own = node.and_then(|node| node.extensions.ok()?.visibility.ok()?.visible.ok());
            let above = self.parents.get(i).copied().flatten().and_then(|parent| is_hidden.get(parent).copied());
            notes.found(Wrong::Hidden, i, usize::from(own == Some(&false)));
            match is_hidden.get_mut(i) {
                Some(is_hidden) if own == Some(&false) || above == Some(true) => *is_hidden = true,
                _ => visible.push(i),
            }
        }
        visible
    }

    /// The nodes that the scene lists.
    fn roots_of(&self, root: &Root<'_>, asked: Option<usize>, notes: &mut Notes) -> Result<Vec<usize>, LoadError> {
        let count = root.scenes.elements().len();
        let index = match asked {
            Some(asked) if asked >= count => return Err(LoadError::NoSuchScene { asked, count }),
            Some(asked) => asked,
            None => default_scene(root, notes),
        };
        // A file without scenes is a library of nodes; show all of it.
        let Some(scene) = root.scenes.elements().get(index) else {
            return Ok((0..root.nodes.elements().len()).filter(|&i| self.parents.get(i) == Some(&None)).collect());
        };
        let scene = scene.need(|| format!("scenes[{index}]"))?;
        scene.nodes.get(|| format!("scenes[{index}].nodes"))?;
        let mut listed = vec![false; self.parents.len()];
        let mut nodes = Vec::new();
        for (k, node) in scene.nodes.elements().iter().enumerate() {
            let path = || format!("scenes[{index}].nodes[{k}]");
            let mut lost = |error| notes.lost(Lost::Link, (usize::MAX, k), error);
            let i = match existing(root, node, path) {
                Ok(i) => i,
                Err(error) => {
                    lost(error);
                    continue;
                }
            };
            if listed.get_mut(i).is_some_and(|listed| std::mem::replace(listed, true)) {
                lost(at(path(), format!("node {i} is listed twice; once would be right")));
                continue;
            }
            if let Some(Some(parent)) = self.parents.get(i) {
                lost(at(path(), format!("node {i} is a child of node {parent}; only root nodes may be listed")));
            }
            nodes.push(i);
        }
        Ok(nodes)
    }
}

/// The index of a node that is listed at `path`.
fn existing(root: &Root<'_>, node: &Property<Int>, path: impl Fn() -> String) -> Result<usize, LoadError> {
    let node = *node.need(&path)?;
    let count = root.nodes.elements().len();
    if node.index() < count {
        return Ok(node.index());
    }
    Err(at(path(), format!("refers to node {node}, but the file has {count} (counted from 0)")))
}

/// The index of the scene that the file says to show.
fn default_scene(root: &Root<'_>, notes: &mut Notes) -> usize {
    let found = root.scene.get(|| "scene".to_owned()).and_then(|scene| {
        let Some(scene) = scene else { return Ok(0) };
        root.scenes.at(*scene, "scene", ("scenes", "scene")).map(|_| scene.index())
    });
    found.unwrap_or_else(|error| {
        notes.lost(Lost::Scene, (0, 0), error);
        0
    })
}

/// Tolerance for a rotation's length; it covers four components rounded to three decimals each. A quaternion farther
/// from 1 was not meant to be a unit quaternion.
const UNIT_TOLERANCE: f64 = 1e-3;

/// Notes faults of these nodes' transforms, and what replaces them.
pub(super) fn check_transforms(root: &Root<'_>, nodes: &[usize], notes: &mut Notes) {
    for &i in nodes {
        let Some(node) = root.nodes.elements().get(i).and_then(|node| node.ok()) else { continue };
        if node.matrix.ok().is_some() {
            let is_split = [&node.translation, &node.rotation, &node.scale].iter().any(|part| part.ok().is_some());
            notes.found(Wrong::MatrixBesideParts, i, usize::from(is_split));
        } else if let Ok(Some(rotation)) = node.rotation.numbers(String::new) {
            let length = DQuat::from_array(rotation).length();
            let is_unit = (length - 1.0).abs() <= UNIT_TOLERANCE;
            notes.found(Wrong::RotationNotUnit, i, usize::from(!is_unit && length != 0.0));
            notes.found(Wrong::RotationZero, i, usize::from(length == 0.0));
        }
    }
}
