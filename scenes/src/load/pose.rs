//! Morph targets with their default weights, and skins in the rest pose of their joints.

use super::accessor::{Accessors, Elements};
use super::budget::Budget;
use super::graph::Graph;
use super::place::Placement;
use super::{LoadError, at, check};
use glam::{DAffine3, DMat3, DVec3};
use gltf::json::accessor::{ComponentType as C, Type};
use gltf::json::mesh::{MorphTarget, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Index, Root};
use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;

/// The vertices that a pose moves.
pub(super) struct Vertices {
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) normals: Option<Vec<[f32; 3]>>,
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

impl Key {
    pub(super) fn is_skinned(&self) -> bool {
        self.skin.is_some()
    }
}

/// Joints and weights of vertices, four per set.
pub(super) type Influences = Vec<(Vec<[u32; 4]>, Vec<[f32; 4]>)>;

/// Computes poses.
pub(super) struct Poser<'a> {
    root: &'a Root,
    accessors: &'a Accessors<'a>,
    graph: &'a Graph,
    budget: &'a Budget,
    /// World from bind pose for each joint, by skin.
    joints: RefCell<HashMap<usize, Rc<Vec<DAffine3>>>>,
}

impl<'a> Poser<'a> {
    pub(super) fn new(root: &'a Root, accessors: &'a Accessors<'a>, graph: &'a Graph, budget: &'a Budget) -> Self {
        Self { root, accessors, graph, budget, joints: RefCell::default() }
    }

    /// The pose of `primitive` at `node`; `None` if it has none.
    pub(super) fn key(&self, node: usize, primitive: &Primitive, is_skinned: bool) -> Option<Key> {
        let json = self.root.nodes.get(node)?;
        let morphs = primitive.targets.as_ref().is_some_and(|targets| !targets.is_empty());
        let weights_of = json.weights.as_ref().filter(|_| morphs).map(|_| node);
        let skin = json.skin.filter(|_| is_skinned).map(|skin| skin.value());
        (morphs || skin.is_some()).then_some(Key { skin, weights_of, morphs })
    }

    /// A primitive's joints and weights; empty if it has none.
    pub(super) fn influences(&self, primitive: &Primitive, count: u64, path: &str) -> Result<Influences, LoadError> {
        let mut sets = Vec::new();
        let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
        for n in 0_u32.. {
            let (Some(joints), Some(weights)) = (attribute(Semantic::Joints(n)), attribute(Semantic::Weights(n)))
            else {
                break;
            };
            let joints = self.accessors.open(joints, &format!("{path}.attributes.JOINTS_{n}"))?;
            joints.expect(&[Type::Vec4], &[C::U8, C::U16], "VEC4 of U8 or U16")?;
            let weights = self.accessors.open(weights, &format!("{path}.attributes.WEIGHTS_{n}"))?;
            weights.expect(&[Type::Vec4], &[C::F32, C::U8, C::U16], "VEC4 of F32 or of normalized U8 or U16")?;
            weights.expect_normalized()?;
            for elements in [&joints, &weights] {
                expect_count(elements, count)?;
            }
            sets.push((joints.integers()?, weights.vectors()?));
        }
        Ok(sets)
    }

    /// The vertices of a pose.
    pub(super) fn pose(
        &self,
        key: Key,
        mesh_weights: Option<&[f32]>,
        primitive: &Primitive,
        base: &Vertices,
        influences: &Influences,
        path: &str,
    ) -> Result<Vertices, LoadError> {
        let count = base.positions.len() as u64;
        let mut positions = self.budget.vec(count, path)?;
        positions.extend_from_slice(&base.positions);
        let normals = match &base.normals {
            None => None,
            Some(base) => {
                let mut normals = self.budget.vec(count, path)?;
                normals.extend_from_slice(base);
                Some(normals)
            }
        };
        let mut vertices = Vertices { positions, normals, mirrored: None };
        if key.morphs {
            let own = key.weights_of.and_then(|node| self.root.nodes.get(node)?.weights.as_deref());
            let targets = primitive.targets.as_deref().unwrap_or_default();
            let weights = own.or(mesh_weights).unwrap_or_default();
            self.morph(&mut vertices, targets, weights, path)?;
        }
        if let Some(skin) = key.skin {
            let matrices = self.joint_matrices(skin)?;
            self.skin(&mut vertices, &matrices, influences, path)?;
        }
        Ok(vertices)
    }

    /// Adds the targets' displacements times their weights.
    fn morph(&self, to: &mut Vertices, targets: &[MorphTarget], weights: &[f32], path: &str) -> Result<(), LoadError> {
        for (i, (target, &weight)) in targets.iter().zip(weights).enumerate() {
            if weight == 0.0 {
                continue;
            }
            let parts = [
                ("POSITION", target.positions, Some(&mut to.positions)),
                ("NORMAL", target.normals, to.normals.as_mut()),
            ];
            for (name, index, to) in parts {
                let (Some(index), Some(to)) = (index, to) else { continue };
                let elements = self.accessors.open(index, &format!("{path}.targets[{i}].{name}"))?;
                let components = [C::F32, C::I8, C::U8, C::I16, C::U16];
                elements.expect(&[Type::Vec3], &components, "VEC3 of F32, or of 8 or 16-bit integers")?;
                expect_count(&elements, to.len() as u64)?;
                for (to, delta) in to.iter_mut().zip(elements.vectors::<3>()?) {
                    for (to, delta) in to.iter_mut().zip(delta) {
                        *to += weight * delta;
                    }
                }
            }
        }
        Ok(())
    }

    /// World from bind pose for each joint. The node of a skinned mesh does not affect it.
    fn joint_matrices(&self, skin: usize) -> Result<Rc<Vec<DAffine3>>, LoadError> {
        if let Some(known) = self.joints.borrow().get(&skin) {
            return Ok(known.clone());
        }
        let path = format!("skins[{skin}]");
        let json = check::get(&self.root.skins, Index::<()>::new(skin as u32), &path, "skin")?;
        let inverse_bind = match json.inverse_bind_matrices {
            None => Vec::new(),
            Some(index) => {
                let path = format!("{path}.inverseBindMatrices");
                let elements = self.accessors.open(index, &path)?;
                elements.expect(&[Type::Mat4], &[C::F32], "MAT4 of F32")?;
                let needed = json.joints.len();
                if elements.count < needed as u64 {
                    return Err(elements.wrong(format!("has {} matrices for {needed} joints", elements.count)));
                }
                elements.vectors::<16>()?
            }
        };
        let mut matrices = self.budget.vec(json.joints.len() as u64, &path)?;
        for (k, &joint) in json.joints.iter().enumerate() {
            check::get(&self.root.nodes, joint, &format!("{path}.joints[{k}]"), "node")?;
            let bind = inverse_bind.get(k).map_or(DAffine3::IDENTITY, |m| {
                let [x0, x1, x2, _, y0, y1, y2, _, z0, z1, z2, _, t0, t1, t2, _] = m.map(f64::from);
                let axes = DMat3::from_cols(DVec3::new(x0, x1, x2), DVec3::new(y0, y1, y2), DVec3::new(z0, z1, z2));
                DAffine3::from_mat3_translation(axes, DVec3::new(t0, t1, t2))
            });
            matrices.push(self.graph.world(joint.value()) * bind);
        }
        let matrices = Rc::new(matrices);
        self.joints.borrow_mut().insert(skin, matrices.clone());
        Ok(matrices)
    }

    /// Transforms vertices to the world by the weighted mean of their joints' matrices.
    fn skin(
        &self,
        to: &mut Vertices,
        matrices: &[DAffine3],
        influences: &Influences,
        path: &str,
    ) -> Result<(), LoadError> {
        let mut mirrored = self.budget.vec(to.positions.len() as u64, path)?;
        for (v, position) in to.positions.iter_mut().enumerate() {
            let mut blend = DAffine3::from_mat3_translation(DMat3::ZERO, DVec3::ZERO);
            let mut sum = 0.0;
            for (n, (joints, weights)) in influences.iter().enumerate() {
                let (joints, weights) = (joints.get(v).into_iter().flatten(), weights.get(v).into_iter().flatten());
                for (&joint, &weight) in joints.zip(weights).filter(|(_, weight)| **weight != 0.0) {
                    let Some(matrix) = matrices.get(joint as usize) else {
                        let problem = format!("vertex {v} names joint {joint}, but the skin has {}", matrices.len());
                        return Err(at(format!("{path}.attributes.JOINTS_{n}"), problem));
                    };
                    let weight = f64::from(weight);
                    blend.matrix3 += matrix.matrix3 * weight;
                    blend.translation += matrix.translation * weight;
                    sum += weight;
                }
            }
            // Weights should add up to 1, but are rounded; a vertex without weights stays where it is.
            let blend = if sum == 0.0 {
                DAffine3::IDENTITY
            } else {
                DAffine3::from_mat3_translation(blend.matrix3 * sum.recip(), blend.translation / sum)
            };
            let placement = Placement::new(blend);
            *position = placement.position(*position);
            if let Some(normal) = to.normals.as_mut().and_then(|normals| normals.get_mut(v)) {
                *normal = placement.normal(*normal);
            }
            mirrored.push(placement.mirrors);
        }
        to.mirrored = Some(mirrored);
        Ok(())
    }
}

/// Checks that an attribute has one element per vertex.
pub(super) fn expect_count(elements: &Elements<'_>, vertices: u64) -> Result<(), LoadError> {
    if elements.count == vertices {
        return Ok(());
    }
    Err(elements.wrong(format!("has {} elements, but POSITION has {vertices}", elements.count)))
}
