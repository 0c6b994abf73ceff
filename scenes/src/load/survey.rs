//! What the picture shows: which primitives, how often, and of how many triangles. Nothing is decoded yet, except what
//! is compressed.

use super::accessor::Accessors;
use super::budget::Budget;
use super::buffers::Buffers;
use super::check::is_lack;
use super::draco;
use super::instances::Instances;
use super::json::{self, Int, Mesh, Root};
use super::lost::Lost;
use super::notes::Notes;
use super::{LoadError, at};
use gltf::json::mesh::Mode;
use std::cell::RefCell;
use std::collections::HashMap;

/// A mesh and the nodes that show it.
pub(super) struct Group<'a> {
    pub(super) index: usize,
    pub(super) mesh: &'a Mesh,
    pub(super) nodes: Vec<usize>,
}

/// A primitive with at least one triangle.
pub(super) struct Primitive<'a> {
    pub(super) group: &'a Group<'a>,
    pub(super) json: &'a json::Primitive,
    pub(super) attributes: &'a json::Attributes,
    pub(super) position: Int,
    pub(super) mode: Mode,
    pub(super) triangles: u64,
    pub(super) draco: Option<draco::Mesh>,
    /// Its mesh and its place there.
    pub(super) key: (usize, usize),
    pub(super) path: String,
}

/// Everything that is asked for here.
pub(super) struct Survey<'a> {
    pub(super) root: &'a Root<'a>,
    pub(super) buffers: &'a Buffers<'a>,
    pub(super) accessors: &'a Accessors<'a>,
    pub(super) budget: &'a Budget,
    pub(super) notes: &'a RefCell<Notes>,
}

impl<'a> Survey<'a> {
    /// The meshes of these nodes, in the order of first occurrence.
    pub(super) fn groups(&self, nodes: &[usize], instances: &Instances) -> Vec<Group<'a>> {
        let mut groups: Vec<Group<'a>> = Vec::new();
        let mut known: HashMap<usize, usize> = HashMap::new();
        for &i in nodes {
            let Some(node) = self.root.nodes.elements().get(i).and_then(|node| node.ok()) else { continue };
            if matches!(instances.get(&i), Some(None)) {
                continue;
            }
            let path = || format!("nodes[{i}].mesh");
            let found = node.mesh.get(path).and_then(|index| {
                let Some(index) = index else { return Ok(None) };
                Ok(Some((index.index(), self.root.meshes.at(*index, &path(), ("meshes", "mesh"))?)))
            });
            match found {
                Ok(None) => {}
                Ok(Some((index, mesh))) => match known.get(&index).and_then(|&k| groups.get_mut(k)) {
                    Some(group) => group.nodes.push(i),
                    None => {
                        known.insert(index, groups.len());
                        groups.push(Group { index, mesh, nodes: vec![i] });
                    }
                },
                Err(error) => self.notes.borrow_mut().lost(Lost::Mesh, (i, 0), error),
            }
        }
        groups
    }

    /// The primitives that have triangles.
    pub(super) fn primitives(&self, groups: &'a [Group<'a>]) -> Result<Vec<Primitive<'a>>, LoadError> {
        let mut primitives = Vec::new();
        let mut expected = 0;
        for group in groups {
            let path = format!("meshes[{}].primitives", group.index);
            if let Err(error) = group.mesh.primitives.get(|| path.clone()) {
                self.notes.borrow_mut().lost(Lost::Mesh, (usize::MAX, group.index), error);
            }
            for (k, json) in group.mesh.primitives.elements().iter().enumerate() {
                let (path, key) = (format!("{path}[{k}]"), (group.index, k));
                match json.need(|| path.clone()).and_then(|json| self.primitive(group, json, key, path)) {
                    Ok(None) => {}
                    Ok(Some(primitive)) => {
                        expected += 1;
                        primitives.push(primitive);
                    }
                    Err(error) if is_lack(&error) => return Err(error),
                    Err(error) => {
                        expected += 1;
                        self.notes.borrow_mut().lost(Lost::Primitive, key, error);
                    }
                }
            }
        }
        self.notes.borrow_mut().expect_primitives(expected);
        Ok(primitives)
    }

    /// A primitive, if it has triangles. Checks what determines their number.
    fn primitive(
        &self,
        group: &'a Group<'a>,
        json: &'a json::Primitive,
        key: (usize, usize),
        path: String,
    ) -> Result<Option<Primitive<'a>>, LoadError> {
        let mode = json.mode.known_or(Mode::Triangles, || format!("{path}.mode"), "0 to 6")?;
        if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            self.notes.borrow_mut().add("points and lines are omitted");
            return Ok(None);
        }
        let attributes = json.attributes.need(|| format!("{path}.attributes"))?;
        let position_path = format!("{path}.attributes.POSITION");
        let Some(position) = attributes.get("POSITION") else {
            self.notes.borrow_mut().add("primitives without positions are omitted");
            return Ok(None);
        };
        let position = *position.need(|| position_path.clone())?;
        let indices = json.indices.get(|| format!("{path}.indices"))?.copied();
        let draco = self.decompressed(json, position, indices, &path)?;
        let mode = if draco.is_some() { Mode::Triangles } else { mode };
        let counting = match (&draco, indices) {
            (Some(_), _) => None,
            (None, Some(indices)) => Some(self.accessors.open(indices, &format!("{path}.indices"))?),
            (None, None) => Some(self.accessors.open(position, &position_path)?),
        };
        let corners = match (&draco, &counting) {
            (Some(draco), _) => draco.indices.len() as u64,
            (None, counting) => counting.as_ref().map_or(0, |counting| counting.count),
        };
        let left_over = mode == Mode::Triangles && !corners.is_multiple_of(3);
        if let (true, Some(counting)) = (left_over, &counting) {
            let error = counting.wrong(format!("has {corners} corners; expected a multiple of 3"));
            if corners < 3 {
                return Err(error);
            }
            self.notes.borrow_mut().lost(Lost::Corners, key, error);
        }
        if let Err(error) = json.material.get(|| format!("{path}.material")) {
            self.notes.borrow_mut().lost(Lost::Material, (usize::MAX, key.1), error);
        }
        let triangles = if mode == Mode::Triangles { corners / 3 } else { corners.saturating_sub(2) };
        let primitive = Primitive { group, json, attributes, position, mode, triangles, draco, key, path };
        Ok((triangles > 0).then_some(primitive))
    }

    /// The decompressed primitive, if it is compressed and the file has no other bytes for it.
    fn decompressed(
        &self,
        json: &json::Primitive,
        position: Int,
        indices: Option<Int>,
        path: &str,
    ) -> Result<Option<draco::Mesh>, LoadError> {
        let path = format!("{path}.extensions.KHR_draco_mesh_compression");
        let Some(extensions) = json.extensions.ok() else { return Ok(None) };
        let Some(draco) = extensions.draco.get(|| path.clone())? else { return Ok(None) };
        let has_bytes = |index| self.accessors.has_bytes(index);
        if has_bytes(position) && indices.is_none_or(has_bytes) {
            return Ok(None);
        }
        let mesh = draco::decode(draco, self.buffers, self.budget, &path)?;
        if mesh.has("POSITION") || has_bytes(position) {
            return Ok(Some(mesh));
        }
        Err(at(format!("{path}.attributes"), "has no POSITION, and the file has no other positions"))
    }
}
