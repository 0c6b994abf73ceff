//! The node hierarchy: one parent each, no cycles, and every node's world matrix. Nothing here is recursive, since a
//! file may nest its nodes arbitrarily deep.

use super::check;
use super::notes::{Notes, Wrong};
use super::{LoadError, at};
use glam::{DAffine3, DMat3, DQuat, DVec3};
use gltf::json::{Index, Node, Root};

/// The node hierarchy, checked.
pub(super) struct Graph {
    /// World from node, in f64 so that long chains do not lose precision.
    world: Vec<DAffine3>,
    parents: Vec<Option<usize>>,
    children: Vec<Vec<usize>>,
}

impl Graph {
    /// Checks the hierarchy and computes all world matrices.
    pub(super) fn new(root: &Root) -> Result<Self, LoadError> {
        let mut parents: Vec<Option<usize>> = vec![None; root.nodes.len()];
        let mut children = Vec::with_capacity(root.nodes.len());
        for (i, node) in root.nodes.iter().enumerate() {
            let own = node.children.as_deref().unwrap_or_default();
            for (k, &child) in own.iter().enumerate() {
                let path = || format!("nodes[{i}].children[{k}]");
                let Some(parent) = parents.get_mut(child.value()) else {
                    check::get(&root.nodes, child, &path(), "node")?;
                    continue;
                };
                if let Some(first) = parent.replace(i) {
                    let problem = format!("node {child} is a child of node {first} already; a node has one parent");
                    return Err(at(path(), problem));
                }
            }
            children.push(own.iter().map(Index::value).collect::<Vec<_>>());
        }

        let mut world = vec![None; root.nodes.len()];
        let roots = parents.iter().enumerate().filter(|(_, parent)| parent.is_none());
        let mut open: Vec<(usize, DAffine3)> = roots.map(|(i, _)| (i, DAffine3::IDENTITY)).collect();
        while let Some((i, parent)) = open.pop() {
            let (Some(node), Some(slot)) = (root.nodes.get(i), world.get_mut(i)) else { continue };
            let own = parent * local(node, i)?;
            *slot = Some(own);
            open.extend(children.get(i).into_iter().flatten().map(|&child| (child, own)));
        }
        // Each node has at most one parent, so a node not reached from a root is part of a cycle, or below one.
        if let Some(i) = world.iter().position(Option::is_none) {
            return Err(at(format!("nodes[{i}]"), "is on a cycle of children, or below one; nodes must form trees"));
        }
        Ok(Self { world: world.into_iter().flatten().collect(), parents, children })
    }

    /// World from node `i`.
    pub(super) fn world(&self, i: usize) -> DAffine3 {
        self.world.get(i).copied().unwrap_or(DAffine3::IDENTITY)
    }

    /// The nodes of the scene to show, parents before children, siblings in the file's order.
    pub(super) fn nodes_of(&self, root: &Root, asked: Option<usize>) -> Result<Vec<usize>, LoadError> {
        let count = root.scenes.len();
        let index = match (asked, root.scene) {
            (Some(asked), _) if asked >= count => return Err(LoadError::NoSuchScene { asked, count }),
            (Some(asked), _) => Some(asked),
            (None, Some(default)) => {
                check::get(&root.scenes, default, "scene", "scene")?;
                Some(default.value())
            }
            (None, None) => None,
        };
        let index = index.unwrap_or(0);
        let mut open = Vec::new();
        match root.scenes.get(index) {
            // A file without scenes is a library of nodes; show all of it.
            None => open.extend((0..root.nodes.len()).filter(|&i| self.parents.get(i) == Some(&None))),
            Some(scene) => {
                let mut listed = vec![false; root.nodes.len()];
                for (k, &node) in scene.nodes.iter().enumerate() {
                    let path = || format!("scenes[{index}].nodes[{k}]");
                    check::get(&root.nodes, node, &path(), "node")?;
                    if let Some(Some(parent)) = self.parents.get(node.value()) {
                        let problem = format!("node {node} is a child of node {parent}; only root nodes may be listed");
                        return Err(at(path(), problem));
                    }
                    if listed.get_mut(node.value()).is_some_and(|listed| std::mem::replace(listed, true)) {
                        return Err(at(path(), format!("node {node} is listed twice; once would be right")));
                    }
                    open.push(node.value());
                }
            }
        }
        open.reverse();
        let mut nodes = Vec::new();
        while let Some(i) = open.pop() {
            nodes.push(i);
            open.extend(self.children.get(i).into_iter().flatten().rev());
        }
        Ok(nodes)
    }
}

/// Tolerance for a rotation's length; it covers four components rounded to three decimals each. A quaternion farther
/// from 1 was not meant to be a unit quaternion.
const UNIT_TOLERANCE: f64 = 1e-3;

/// Notes faults of these nodes' transforms, and what replaces them.
pub(super) fn check_transforms(root: &Root, nodes: &[usize], notes: &mut Notes) {
    for &i in nodes {
        let Some(node) = root.nodes.get(i) else { continue };
        let is_split = node.translation.is_some() || node.rotation.is_some() || node.scale.is_some();
        if node.matrix.is_some() {
            notes.found(Wrong::MatrixBesideParts, i, usize::from(is_split));
        } else if let Some(rotation) = node.rotation {
            let [x, y, z, w] = rotation.0.map(f64::from);
            let is_unit = (DQuat::from_xyzw(x, y, z, w).length() - 1.0).abs() <= UNIT_TOLERANCE;
            notes.found(Wrong::RotationNotUnit, i, usize::from(!is_unit));
        }
    }
}

/// Parent from node.
fn local(node: &Node, i: usize) -> Result<DAffine3, LoadError> {
    let path = |field: &str| format!("nodes[{i}].{field}");
    if let Some(matrix) = node.matrix {
        let m = check::finite(matrix, &path("matrix"))?.map(f64::from);
        let [x0, x1, x2, x3, y0, y1, y2, y3, z0, z1, z2, z3, t0, t1, t2, t3] = m;
        let last_row = [x3, y3, z3, t3 - 1.0];
        // Exporters that multiply matrices leave small rounding errors here.
        if last_row.iter().any(|v| v.abs() > 1e-4) {
            return Err(at(path("matrix"), "has a last row that is not 0 0 0 1; only affine transforms are allowed"));
        }
        let axes = DMat3::from_cols(DVec3::new(x0, x1, x2), DVec3::new(y0, y1, y2), DVec3::new(z0, z1, z2));
        return Ok(DAffine3::from_mat3_translation(axes, DVec3::new(t0, t1, t2)));
    }
    let translation = check::finite(node.translation.unwrap_or([0.0; 3]), &path("translation"))?;
    let scale = check::finite(node.scale.unwrap_or([1.0; 3]), &path("scale"))?;
    let rotation = match node.rotation {
        None => DQuat::IDENTITY,
        Some(rotation) => {
            let [x, y, z, w] = check::finite(rotation.0, &path("rotation"))?.map(f64::from);
            let length = DQuat::from_xyzw(x, y, z, w).length();
            if length == 0.0 {
                return Err(at(path("rotation"), "is 0 0 0 0; a unit quaternion would be right"));
            }
            DQuat::from_xyzw(x / length, y / length, z / length, w / length)
        }
    };
    let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    Ok(DAffine3::from_scale_rotation_translation(vector(scale), rotation, vector(translation)))
}
