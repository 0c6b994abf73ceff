//! Morph targets with their default weights, and skins in the rest pose of their joints.

mod skin;

use super::accessor::{Accessors, Component, Kind};
use super::budget::Budget;
use super::graph::Graph;
use super::json::{Attributes, Number, Primitive, Root};
use super::lost::Lost;
use super::notes::Notes;
use super::points::Points;
use super::{LoadError, at};
use glam::{DAffine3, DVec3};
use skin::Joints;
use std::cell::RefCell;
use std::collections::HashMap;

/// Types that positions and morph targets may have.
pub(super) const SMALL: [Component; 5] = [Component::F32, Component::I8, Component::U8, Component::I16, Component::U16];

/// The vertices that a pose moves.
pub(super) struct Vertices {
    pub(super) positions: Points,
    pub(super) normals: Option<Points>,
    /// For skinned vertices, which are in world space: whether their matrix mirrors.
    pub(super) mirrored: Option<Vec<bool>>,
}

/// What determines a pose: nodes with equal keys show a primitive with the same vertices.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct Key {
    skin: Option<usize>,
    /// The node whose own weights replace the mesh's.
    weights_of: Option<usize>,
    morphs: bool,
}

/// A primitive that is posed.
#[derive(Clone, Copy)]
pub(super) struct Posed<'a> {
    pub(super) json: &'a Primitive,
    pub(super) mesh_weights: Option<&'a Vec<Number>>,
    /// Its mesh and its place there.
    pub(super) key: (usize, usize),
    pub(super) path: &'a str,
}

/// Joints and weights of vertices, four per set.
pub(super) type Influences = Vec<(Vec<[u32; 4]>, Vec<[f64; 4]>)>;

/// Computes poses.
pub(super) struct Poser<'a, 'b> {
    pub(super) root: &'a Root<'b>,
    pub(super) accessors: &'a Accessors<'b>,
    pub(super) graph: &'a Graph,
    pub(super) budget: &'a Budget,
    pub(super) notes: &'a RefCell<Notes>,
    /// What has been subtracted from all of the graph's positions.
    pub(super) offset: DVec3,
    /// World from bind pose for each joint, by skin.
    pub(super) joints: RefCell<HashMap<usize, Result<Joints, LoadError>>>,
}

impl Poser<'_, '_> {
    /// The pose of `primitive` at `node`; `None` if it has none.
    pub(super) fn key(&self, node: usize, primitive: &Primitive, is_skinned: bool) -> Option<Key> {
        let json = self.root.nodes.elements().get(node)?.ok()?;
        let morphs = !primitive.targets.elements().is_empty();
        let weights_of = json.weights.ok().filter(|_| morphs).map(|_| node);
        let skin = json.skin.ok().filter(|_| is_skinned).map(|skin| skin.index());
        (morphs || skin.is_some()).then_some(Key { skin, weights_of, morphs })
    }

    /// A primitive's joints and weights; empty if it has none.
    pub(super) fn influences(&self, primitive: &Primitive, count: u64, path: &str) -> Result<Influences, LoadError> {
        let mut sets = Vec::new();
        let Some(attributes) = primitive.attributes.ok() else { return Ok(sets) };
        for n in 0_u32.. {
            let (joints, weights) = (format!("JOINTS_{n}"), format!("WEIGHTS_{n}"));
            let (Some(j), Some(w)) = (attributes.get(&joints), attributes.get(&weights)) else { break };
            let open = |name: &str, index: &super::json::Property<super::json::Int>| {
                let path = format!("{path}.attributes.{name}");
                self.accessors.open(*index.need(|| path.clone())?, &path)
            };
            let joints = open(&joints, j)?;
            joints.expect(&[Kind::Vec4], &[Component::U8, Component::U16], "VEC4 of U8 or U16")?;
            let weights = open(&weights, w)?;
            let floats = [Component::F32, Component::U8, Component::U16];
            weights.expect(&[Kind::Vec4], &floats, "VEC4 of F32 or of normalized U8 or U16")?;
            weights.expect_normalized()?;
            joints.expect_count(count)?;
            weights.expect_count(count)?;
            sets.push((joints.integers()?, weights.doubles()?));
        }
        Ok(sets)
    }

    /// The vertices of a pose. A skin or a target that cannot be read is left out.
    pub(super) fn pose(
        &self,
        key: Key,
        primitive: Posed<'_>,
        base: &Vertices,
        influences: &Influences,
    ) -> Result<Vertices, LoadError> {
        let copy = |points: &Points| {
            let mut copy = self.budget.vec(points.len() as u64, primitive.path)?;
            copy.extend(points.iter().map(|point| point.to_array()));
            Ok::<_, LoadError>(copy)
        };
        let mut positions = copy(&base.positions)?;
        let mut normals = base.normals.as_ref().map(copy).transpose()?;
        if key.morphs {
            self.morph(key, primitive, &mut positions, normals.as_mut());
        }
        let lost = |error| self.notes.borrow_mut().lost(Lost::Skin, primitive.key, error);
        let skinned = key.skin.and_then(|skin| {
            self.skin(skin, &positions, normals.as_deref(), influences, primitive.path).map_err(lost).ok()
        });
        Ok(skinned.unwrap_or_else(|| Vertices {
            positions: Points::Double(positions),
            normals: normals.map(Points::Double),
            mirrored: None,
        }))
    }

    /// Adds the targets' displacements times their weights.
    fn morph(
        &self,
        key: Key,
        primitive: Posed<'_>,
        positions: &mut Vec<[f64; 3]>,
        normals: Option<&mut Vec<[f64; 3]>>,
    ) {
        let node = key.weights_of.and_then(|node| self.root.nodes.elements().get(node)?.ok());
        let weights = node.and_then(|node| node.weights.ok()).or(primitive.mesh_weights);
        let targets = primitive.json.targets.elements();
        let mut parts = [("POSITION", Some(positions)), ("NORMAL", normals)];
        for (i, (target, weight)) in targets.iter().zip(weights.into_iter().flatten()).enumerate() {
            let path = format!("{}.targets[{i}]", primitive.path);
            for (name, to) in &mut parts {
                let Some(to) = to.as_deref_mut().filter(|_| weight.0 != 0.0) else { continue };
                let added = target.need(|| path.clone()).and_then(|target| self.add(target, name, weight.0, &path, to));
                if let Err(error) = added {
                    self.notes.borrow_mut().lost(Lost::Morph, primitive.key, error);
                }
            }
        }
    }

    /// Adds one attribute of a target, if it has it and all of it can be read.
    fn add(
        &self,
        target: &Attributes,
        name: &str,
        weight: f64,
        path: &str,
        to: &mut [[f64; 3]],
    ) -> Result<(), LoadError> {
        let path = format!("{path}.{name}");
        let Some(index) = target.get(name) else { return Ok(()) };
        let elements = self.accessors.open(*index.need(|| path.clone())?, &path)?;
        elements.expect(&[Kind::Vec3], &SMALL, "VEC3 of F32, or of 8 or 16-bit integers")?;
        elements.expect_count(to.len() as u64)?;
        let deltas = elements.doubles::<3>()?;
        if !weight.is_finite() || deltas.iter().flatten().any(|delta| !delta.is_finite()) {
            return Err(at(path, "or its weight has parts that are no numbers"));
        }
        for (to, delta) in to.iter_mut().flatten().zip(deltas.iter().flatten()) {
            *to += weight * delta;
        }
        Ok(())
    }

    /// World from what skinned vertices are in, for an instance of their node.
    pub(super) fn of_skinned(&self, instance: Option<&DAffine3>) -> DAffine3 {
        // The node's own transform does not move its skin. An instance's is about the world's origin.
        instance.map_or(DAffine3::IDENTITY, |instance| {
            DAffine3::from_translation(-self.offset) * *instance * DAffine3::from_translation(self.offset)
        })
    }
}
