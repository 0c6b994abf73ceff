//! EXT_mesh_gpu_instancing: a node's mesh is shown many times, each time with a transform of its own below the node's.

use super::accessor::{Accessors, Kind};
use super::check::is_lack;
use super::graph::scaled_rotated_moved;
use super::json::{Int, Property, Root};
use super::lost::Lost;
use super::notes::{Notes, Wrong};
use super::{LoadError, budget::Budget};
use glam::DAffine3;
use std::cell::RefCell;
use std::collections::HashMap;

/// The instances of nodes that have some, or `None` if they cannot be read.
pub(super) type Instances = HashMap<usize, Option<Vec<DAffine3>>>;

/// Reads the instances of these nodes.
pub(super) fn read(
    root: &Root<'_>,
    nodes: &[usize],
    accessors: &Accessors<'_>,
    budget: &Budget,
    notes: &RefCell<Notes>,
) -> Result<Instances, LoadError> {
    let mut instances = Instances::new();
    for &i in nodes {
        match of_node(root, i, accessors, budget, notes) {
            Ok(None) => {}
            Ok(Some(own)) => drop(instances.insert(i, Some(own))),
            Err(error) if is_lack(&error) => return Err(error),
            Err(error) => {
                notes.borrow_mut().lost(Lost::Mesh, (i, 0), error);
                instances.insert(i, None);
            }
        }
    }
    Ok(instances)
}

/// Node from instance, for each instance of node `i`.
fn of_node(
    root: &Root<'_>,
    i: usize,
    accessors: &Accessors<'_>,
    budget: &Budget,
    notes: &RefCell<Notes>,
) -> Result<Option<Vec<DAffine3>>, LoadError> {
    let path = format!("nodes[{i}].extensions");
    let node = root.nodes.elements().get(i).and_then(|node| node.ok());
    let Some(node) = node.filter(|node| node.mesh.ok().is_some()) else { return Ok(None) };
    // What is wrong with all extensions together does not say that there are instances.
    let Some(json) = node.extensions.ok().map(|extensions| &extensions.instancing) else { return Ok(None) };
    let path = format!("{path}.EXT_mesh_gpu_instancing");
    let Some(json) = json.get(|| path.clone())? else { return Ok(None) };
    let path = format!("{path}.attributes");
    let Some(json) = json.attributes.get(|| path.clone())? else { return Ok(None) };

    let open = |index: &Property<Int>, name: &str, kind, right: &str| {
        let path = format!("{path}.{name}");
        let Some(index) = index.get(|| path.clone())? else { return Ok(None) };
        let elements = accessors.open(*index, &path)?;
        elements.expect_kind(kind, right)?;
        Ok::<_, LoadError>(Some(elements))
    };
    let translations = open(&json.translation, "TRANSLATION", Kind::Vec3, "VEC3")?;
    let rotations = open(&json.rotation, "ROTATION", Kind::Vec4, "VEC4")?;
    let scales = open(&json.scale, "SCALE", Kind::Vec3, "VEC3")?;
    let counts = || [&translations, &rotations, &scales].into_iter().flatten().map(|elements| elements.count);
    let Some(count) = counts().min() else { return Ok(None) };
    notes.borrow_mut().found(Wrong::InstanceCounts, i, usize::from(counts().any(|other| other != count)));

    let translations = translations.map(|elements| elements.doubles::<3>()).transpose()?;
    let rotations = rotations.map(|elements| elements.doubles::<4>()).transpose()?;
    let scales = scales.map(|elements| elements.doubles::<3>()).transpose()?;
    let mut instances = budget.vec(count, &path)?;
    let (mut wrong, mut unrotated) = (0, 0);
    for k in 0..usize::try_from(count).unwrap_or_default() {
        let translation = part(&translations, k, [0.0; 3]);
        let rotation = part(&rotations, k, [0.0, 0.0, 0.0, 1.0]);
        let scale = part(&scales, k, [1.0; 3]);
        let parts = [&translation[..], &rotation, &scale].concat();
        if parts.iter().all(|part| part.is_finite()) {
            unrotated += usize::from(rotation == [0.0; 4]);
            instances.push(scaled_rotated_moved(scale, rotation, translation));
        } else {
            wrong += 1;
        }
    }
    notes.borrow_mut().found(Wrong::Instances, i, wrong);
    // A node's own rotation is counted at its own index.
    notes.borrow_mut().found(Wrong::RotationZero, root.nodes.elements().len() + i, unrotated);
    Ok(Some(instances))
}

fn part<const N: usize>(list: &Option<Vec<[f64; N]>>, k: usize, default: [f64; N]) -> [f64; N] {
    list.as_ref().and_then(|list| list.get(k)).copied().unwrap_or(default)
}
