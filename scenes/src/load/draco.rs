//! Decompresses the primitives of KHR_draco_mesh_compression.

use super::accessor::{Component, Kind};
use super::budget::Budget;
use super::buffers::Buffers;
use super::json::Draco;
use super::{LoadError, at};
use draco_core::{DataType, DecodeLimits, DecoderBuffer, MeshDecoder, PointAttribute, PointIndex};
use std::collections::BTreeMap;

/// A decompressed primitive, a list of triangles.
pub(super) struct Mesh {
    pub(super) indices: Vec<[u32; 1]>,
    /// What is wrong with one costs no other.
    attributes: BTreeMap<String, Result<Attribute, LoadError>>,
}

/// The values of an attribute, one element per vertex.
pub(super) struct Attribute {
    pub(super) component: Component,
    components: usize,
    pub(super) bytes: Vec<u8>,
}

impl Mesh {
    /// The attribute with this name, if it was compressed; an error if it has not as many components as `kind`.
    pub(super) fn attribute(&self, name: &str, kind: Kind, path: &str) -> Result<Option<&Attribute>, LoadError> {
        let Some(attribute) = self.attributes.get(name) else { return Ok(None) };
        let attribute = attribute.as_ref().map_err(Clone::clone)?;
        if attribute.components == kind.multiplicity() {
            return Ok(Some(attribute));
        }
        let problem = format!("has {} compressed components; expected {}", attribute.components, kind.multiplicity());
        Err(at(path, problem))
    }

    /// Whether an attribute was compressed.
    pub(super) fn has(&self, name: &str) -> bool {
        self.attributes.contains_key(name)
    }
}

/// Memory that the decoder needs for a face, at most: corners, their opposites and vertices, and traversal state.
const BYTES_PER_FACE: u64 = 256;

/// Decompresses what `json`, at `path`, says.
pub(super) fn decode(json: &Draco, buffers: &Buffers<'_>, budget: &Budget, path: &str) -> Result<Mesh, LoadError> {
    let view = json.buffer_view.need(|| format!("{path}.bufferView"))?;
    let (bytes, _) = buffers.view(*view, &format!("{path}.bufferView"))?;
    let left = budget.left();
    let limits = DecodeLimits::permissive()
        .with_max_points(left / BYTES_PER_FACE)
        .with_max_faces(left / BYTES_PER_FACE)
        .with_max_decoded_bytes(left / 4);
    let mut mesh = draco_core::Mesh::new();
    MeshDecoder::new()
        .decode(&mut DecoderBuffer::new(bytes).with_limits(limits), &mut mesh)
        .map_err(|error| at(path, format!("cannot be decompressed: {error}")))?;

    let mut indices = budget.vec(mesh.num_faces() as u64 * 3, path)?;
    indices.extend(mesh.faces().iter().flatten().map(|point| [point.0]));
    let mut attributes = BTreeMap::new();
    for (name, id) in json.attributes.need(|| format!("{path}.attributes"))? {
        let path = format!("{path}.attributes.{name}");
        let attribute = id.need(|| path.clone()).and_then(|id| {
            let found = u32::try_from(id.0).ok().and_then(|id| mesh.attribute_by_unique_id(id));
            let found = found.ok_or_else(|| at(&path, format!("{id} is not the id of a compressed attribute")))?;
            read(found, mesh.num_points(), budget, &path)
        });
        attributes.insert(name.clone(), attribute);
    }
    Ok(Mesh { indices, attributes })
}

/// Copies an attribute's values, one per vertex.
fn read(attribute: &PointAttribute, vertices: usize, budget: &Budget, path: &str) -> Result<Attribute, LoadError> {
    let component = match attribute.data_type() {
        DataType::Int8 => Component::I8,
        DataType::Uint8 => Component::U8,
        DataType::Int16 => Component::I16,
        DataType::Uint16 => Component::U16,
        DataType::Uint32 => Component::U32,
        DataType::Float32 => Component::F32,
        other => return Err(at(path, format!("has components of {other:?}, which no accessor has"))),
    };
    let components = usize::from(attribute.num_components());
    let element = component.size() * components;
    let (data, stride) = (attribute.buffer().data(), usize::try_from(attribute.byte_stride()).unwrap_or_default());
    let mut bytes = budget.vec((vertices as u64).saturating_mul(element as u64), path)?;
    for vertex in 0..vertices {
        let value = attribute.mapped_index(PointIndex(vertex as u32)).0 as usize;
        let start = value.checked_mul(stride);
        let found = start.and_then(|start| data.get(start..)?.get(..element));
        bytes.extend_from_slice(found.ok_or_else(|| at(path, format!("has no value for vertex {vertex}")))?);
    }
    Ok(Attribute { component, components, bytes })
}
