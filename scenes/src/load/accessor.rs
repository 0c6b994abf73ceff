//! The bounded accessor reader: checks offsets, strides and counts against the available bytes, in u64, before anything
//! is allocated or read.

mod elements;
mod types;

pub(super) use elements::Elements;
pub(super) use gltf::json::accessor::{ComponentType as Component, Type as Kind};

use super::budget::Budget;
use super::buffers::Buffers;
use super::json::{Accessor, Int, Property, Root, SparsePart};
use super::notes::Notes;
use super::{LoadError, at};
use elements::{Run, Sparse};
use gltf::json::accessor::GenericComponentType;
use std::cell::RefCell;

/// Everything that accessors may refer to.
#[derive(Clone, Copy)]
pub(super) struct Accessors<'a> {
    root: &'a Root<'a>,
    buffers: &'a Buffers<'a>,
    budget: &'a Budget,
    notes: &'a RefCell<Notes>,
}

impl<'a> Accessors<'a> {
    pub(super) fn new(
        root: &'a Root<'a>,
        buffers: &'a Buffers<'a>,
        budget: &'a Budget,
        notes: &'a RefCell<Notes>,
    ) -> Self {
        Self { root, buffers, budget, notes }
    }

    /// Whether the file has bytes of this accessor, and not only zeros.
    pub(super) fn has_bytes(&self, index: Int) -> bool {
        let accessor = self.root.accessors.elements().get(index.index()).and_then(|accessor| accessor.ok());
        accessor.is_some_and(|accessor| accessor.buffer_view.ok().is_some() || accessor.sparse.ok().is_some())
    }

    /// Checks the accessor that `path` refers to. Nothing is decoded or allocated yet.
    pub(super) fn open(&self, index: Int, path: &str) -> Result<Elements<'a>, LoadError> {
        let mut elements = self.without_bytes(index, path)?;
        let accessor = self.json(index, path)?;
        let path = elements.path.clone();
        let bytes = elements.element_bytes();
        // Zeros have no bytes to check against; decoding charges them to the budget like any others.
        if let Some(view) = accessor.buffer_view.get(|| format!("{path}.bufferView"))? {
            elements.dense = Some(self.run(*view, &accessor.byte_offset, elements.count, bytes, &path)?);
        }
        if let Some(sparse) = accessor.sparse.get(|| format!("{path}.sparse"))? {
            let place = |part: &str| format!("{path}.sparse.{part}");
            let count = sparse.count.need(|| place("count"))?.0;
            if count > elements.count {
                let problem = format!("sparse.count {count} is more than its {} elements", elements.count);
                return Err(at(path, problem));
            }
            let indices = sparse.indices.need(|| place("indices"))?;
            let component = component(&indices.component_type, || place("indices.componentType"))?;
            if !matches!(component, Component::U8 | Component::U16 | Component::U32) {
                return Err(at(place("indices.componentType"), "is not 5121, 5123 or 5125"));
            }
            let values = sparse.values.need(|| place("values"))?;
            let run = |part: &SparsePart, name: &str, bytes| {
                let view = part.buffer_view.need(|| place(&format!("{name}.bufferView")))?;
                self.run(*view, &part.byte_offset, count, bytes, &path)
            };
            elements.sparse = Some(Sparse {
                count,
                component,
                indices: run(indices, "indices", component.size())?,
                values: run(values, "values", bytes)?,
            });
        }
        Ok(elements)
    }

    /// What the JSON says of the accessor that `path` refers to; its elements are zeros.
    pub(super) fn without_bytes(&self, index: Int, path: &str) -> Result<Elements<'a>, LoadError> {
        let accessor = self.json(index, path)?;
        let path = format!("{path} (accessors[{index}])");
        let component = component(&accessor.component_type, || format!("{path}.componentType"))?;
        let kind = accessor.kind.need_known(|| format!("{path}.type"), "SCALAR, VEC2 to VEC4, MAT2 to MAT4")?;
        Ok(Elements {
            count: accessor.count.need(|| format!("{path}.count"))?.0,
            path,
            index: index.index(),
            bounds: [&accessor.min, &accessor.max].map(|bound| bound.ok().map(Vec::as_slice)),
            kind,
            component,
            normalized: accessor.normalized.ok() == Some(&true),
            dense: None,
            sparse: None,
            budget: self.budget,
            notes: self.notes,
        })
    }

    fn json(&self, index: Int, path: &str) -> Result<&'a Accessor, LoadError> {
        self.root.accessors.at(index, path, ("accessors", "accessor"))
    }

    /// The bytes of `count` elements in a view.
    fn run(
        &self,
        view: Int,
        offset: &Property<Int>,
        count: u64,
        element_bytes: usize,
        path: &str,
    ) -> Result<Run<'a>, LoadError> {
        let offset = offset.get(|| format!("{path}.byteOffset"))?.map_or(0, |offset| offset.0);
        let (bytes, stride) = self.buffers.view(view, path)?;
        let stride = stride.unwrap_or(element_bytes);
        if stride < element_bytes {
            let problem =
                format!("bufferViews[{view}].byteStride {stride} is less than the {element_bytes} bytes of an element");
            return Err(at(path, problem));
        }
        let end = match count.checked_sub(1) {
            None => Some(offset),
            Some(last) => (stride as u64)
                .checked_mul(last)
                .and_then(|start| start.checked_add(element_bytes as u64)?.checked_add(offset)),
        };
        if end.is_none_or(|end| end > bytes.len() as u64) {
            let problem = format!(
                "{count} elements of {element_bytes} bytes, {stride} apart, from byte {offset} on do not fit \
                 into the {} bytes of bufferViews[{view}]",
                bytes.len()
            );
            return Err(at(path, problem));
        }
        let bytes = usize::try_from(offset).ok().and_then(|offset| bytes.get(offset..)).unwrap_or_default();
        Ok(Run { bytes, stride })
    }
}

fn component(property: &Property<Int>, path: impl Fn() -> String) -> Result<Component, LoadError> {
    property.need(&path)?;
    let GenericComponentType(component) =
        property.known_or(GenericComponentType(Component::F32), path, "a componentType of 5120 to 5126 but 5124")?;
    Ok(component)
}
