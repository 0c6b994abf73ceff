//! Skins: vertices follow their joints.

use super::{Influences, Poser, Vertices};
use crate::load::accessor::{Component, Kind};
use crate::load::graph::affine;
use crate::load::place::Placement;
use crate::load::points::Points;
use crate::load::{LoadError, at};
use glam::{DAffine3, DMat3, DVec3};
use std::rc::Rc;

/// World from bind pose for each joint.
pub(super) type Joints = Rc<Vec<DAffine3>>;

impl Poser<'_, '_> {
    /// World from bind pose for each joint of a skin. The node of a skinned mesh does not affect it.
    fn joints(&self, skin: usize) -> Result<Joints, LoadError> {
        if let Some(known) = self.joints.borrow().get(&skin) {
            return known.clone();
        }
        let joints = self.read_joints(skin);
        self.joints.borrow_mut().insert(skin, joints.clone());
        joints
    }

    fn read_joints(&self, skin: usize) -> Result<Joints, LoadError> {
        let path = format!("skins[{skin}]");
        let count = self.root.skins.elements().len();
        let Some(json) = self.root.skins.elements().get(skin) else {
            return Err(at("skin", format!("refers to skin {skin}, but the file has {count} (counted from 0)")));
        };
        let json = json.need(|| path.clone())?;
        let joints = json.joints.need(|| format!("{path}.joints"))?;
        let inverse_bind = match json.inverse_bind_matrices.get(|| format!("{path}.inverseBindMatrices"))? {
            None => Vec::new(),
            Some(index) => {
                let elements = self.accessors.open(*index, &format!("{path}.inverseBindMatrices"))?;
                elements.expect(&[Kind::Mat4], &[Component::F32], "MAT4 of F32")?;
                if elements.count < joints.len() as u64 {
                    return Err(elements.wrong(format!("has {} matrices for {} joints", elements.count, joints.len())));
                }
                elements.doubles::<16>()?
            }
        };
        let mut matrices = self.budget.vec(joints.len() as u64, &path)?;
        for (k, joint) in joints.iter().enumerate() {
            let path = || format!("{path}.joints[{k}]");
            let joint = joint.need(path)?;
            let world = self.graph.try_world(joint.index());
            let world = world.ok_or_else(|| at(path(), format!("node {joint} has no transform")))?;
            matrices.push(world * inverse_bind.get(k).map_or(DAffine3::IDENTITY, |matrix| affine(*matrix)));
        }
        Ok(Rc::new(matrices))
    }

    /// Vertices in the world, moved by the weighted mean of their joints' matrices.
    pub(super) fn skin(
        &self,
        skin: usize,
        positions: &[[f64; 3]],
        normals: Option<&[[f64; 3]]>,
        influences: &Influences,
        path: &str,
    ) -> Result<Vertices, LoadError> {
        let matrices = self.joints(skin)?;
        let count = positions.len() as u64;
        let mut moved = self.budget.vec(count, path)?;
        let mut turned = normals.map(|_| self.budget.vec(count, path)).transpose()?;
        let mut mirrored = self.budget.vec(count, path)?;
        for (v, position) in positions.iter().enumerate() {
            let placement = Placement::new(self.blend(&matrices, influences, v, path)?);
            let to = placement.position(DVec3::from_array(*position));
            if !to.is_finite() && position.iter().all(|part| part.is_finite()) {
                return Err(at(path, format!("its skin moves vertex {v} to no place")));
            }
            moved.push(to.to_array());
            if let (Some(turned), Some(normal)) = (&mut turned, normals.and_then(|normals| normals.get(v))) {
                turned.push(placement.normal(DVec3::from_array(*normal)).map(f64::from));
            }
            mirrored.push(placement.mirrors);
        }
        Ok(Vertices { positions: Points::Double(moved), normals: turned.map(Points::Double), mirrored: Some(mirrored) })
    }

    /// The weighted mean of the matrices of a vertex's joints.
    fn blend(
        &self,
        matrices: &[DAffine3],
        influences: &Influences,
        v: usize,
        path: &str,
    ) -> Result<DAffine3, LoadError> {
        let mut blend = DAffine3::from_mat3_translation(DMat3::ZERO, DVec3::ZERO);
        let mut sum = 0.0;
        for (n, (joints, weights)) in influences.iter().enumerate() {
            let (joints, weights) = (joints.get(v).into_iter().flatten(), weights.get(v).into_iter().flatten());
            for (&joint, &weight) in joints.zip(weights).filter(|(_, weight)| **weight != 0.0) {
                let Some(matrix) = matrices.get(joint as usize) else {
                    let problem = format!("vertex {v} names joint {joint}, but the skin has {}", matrices.len());
                    return Err(at(format!("{path}.attributes.JOINTS_{n}"), problem));
                };
                blend.matrix3 += matrix.matrix3 * weight;
                blend.translation += matrix.translation * weight;
                sum += weight;
            }
        }
        // Weights should add up to 1, but are rounded; a vertex without weights stays where it is.
        Ok(if sum == 0.0 {
            DAffine3::from_translation(DVec3::ZERO - self.offset)
        } else {
            DAffine3::from_mat3_translation(blend.matrix3 * sum.recip(), blend.translation / sum)
        })
    }
}
