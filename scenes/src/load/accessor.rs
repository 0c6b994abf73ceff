//! The bounded accessor reader: checks offsets, strides and counts against the available bytes, in u64, before anything
//! is allocated or read.

use super::budget::Budget;
use super::buffers::Buffers;
use super::check;
use super::notes::{Notes, Wrong};
use super::{LoadError, at};
use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::{Index, Root, buffer::View};
use serde_json::Value;
use std::cell::RefCell;

/// Number of zeros that a file may declare beyond its own size, see [`Accessors::open`].
const FREE_ZEROS: u64 = 1 << 16;

/// Everything that accessors may refer to.
#[derive(Clone, Copy)]
pub(super) struct Accessors<'a> {
    root: &'a Root,
    buffers: &'a Buffers<'a>,
    budget: &'a Budget,
    notes: &'a RefCell<Notes>,
}

/// A sequence of elements that is known to be within its bytes.
#[derive(Clone, Copy)]
struct Run<'a> {
    bytes: &'a [u8],
    stride: usize,
}

impl<'a> Run<'a> {
    /// The bytes from element `i` on. Empty past the end, which [`Accessors::run`] has excluded.
    fn element(&self, i: usize) -> &'a [u8] {
        i.checked_mul(self.stride).and_then(|start| self.bytes.get(start..)).unwrap_or_default()
    }
}

/// The elements that replace some of the run's.
#[derive(Clone, Copy)]
struct Sparse<'a> {
    count: u64,
    index_type: ComponentType,
    indices: Run<'a>,
    values: Run<'a>,
}

/// An accessor, checked and ready to be decoded.
pub(super) struct Elements<'a> {
    /// Its index and where it is used, for messages.
    path: String,
    index: usize,
    /// The declared minimum and maximum components, not normalised.
    bounds: [Option<&'a Value>; 2],
    /// The number of elements.
    pub(super) count: u64,
    kind: Type,
    component: ComponentType,
    normalized: bool,
    /// `None` if all elements are initially zero.
    dense: Option<Run<'a>>,
    sparse: Option<Sparse<'a>>,
    budget: &'a Budget,
    notes: &'a RefCell<Notes>,
}

impl<'a> Accessors<'a> {
    pub(super) fn new(root: &'a Root, buffers: &'a Buffers<'a>, budget: &'a Budget, notes: &'a RefCell<Notes>) -> Self {
        Self { root, buffers, budget, notes }
    }

    /// Checks the accessor that `path` refers to. Nothing is decoded or allocated yet.
    pub(super) fn open(&self, index: Index<Accessor>, path: &str) -> Result<Elements<'a>, LoadError> {
        let accessor = check::get(&self.root.accessors, index, path, "accessor")?;
        let path = format!("{path} (accessors[{index}])");
        let component = check::known(&accessor.component_type, &path, "a componentType of 5120 to 5126 but 5124")?.0;
        let kind = check::known(&accessor.type_, &path, "a type of SCALAR, VEC2 to VEC4, MAT2 to MAT4")?;
        let (count, element_bytes) = (accessor.count.0, component.size() * kind.multiplicity());
        let dense = match accessor.buffer_view {
            Some(view) => {
                let offset = accessor.byte_offset.unwrap_or_default().0;
                Some(self.run(view, offset, count, element_bytes, &path)?)
            }
            // Zeros have no bytes to check against. Whatever they are used with (a mesh that they displace, indices)
            // has at least one byte per element, so the file's size bounds them.
            None if count > FREE_ZEROS && count - FREE_ZEROS > self.buffers.total_bytes() => {
                let problem = format!("claims {count} zeros without a bufferView, far more than the file has bytes");
                return Err(at(path, problem));
            }
            None => None,
        };
        let sparse = match &accessor.sparse {
            None => None,
            Some(sparse) => {
                let index_type = check::known(
                    &sparse.indices.component_type,
                    &format!("{path}.sparse.indices.componentType"),
                    "5121, 5123 or 5125",
                )?
                .0;
                let changed = sparse.count.0;
                if changed > count {
                    return Err(at(path, format!("sparse.count {changed} is more than its {count} elements")));
                }
                let (indices, values) = (&sparse.indices, &sparse.values);
                Some(Sparse {
                    count: changed,
                    index_type,
                    indices: self.run(indices.buffer_view, indices.byte_offset.0, changed, index_type.size(), &path)?,
                    values: self.run(values.buffer_view, values.byte_offset.0, changed, element_bytes, &path)?,
                })
            }
        };
        let normalized = accessor.normalized;
        let bounds = [accessor.min.as_ref(), accessor.max.as_ref()];
        let (index, Self { budget, notes, .. }) = (index.value(), *self);
        Ok(Elements { path, index, bounds, count, kind, component, normalized, dense, sparse, budget, notes })
    }

    /// The bytes of `count` elements in a view.
    fn run(
        &self,
        view: Index<View>,
        offset: u64,
        count: u64,
        element_bytes: usize,
        path: &str,
    ) -> Result<Run<'a>, LoadError> {
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

impl Elements<'_> {
    /// An error about this accessor.
    pub(super) fn wrong(&self, problem: impl Into<String>) -> LoadError {
        at(self.path.clone(), problem)
    }

    /// Whether the accessor has one of `kinds` and one of `components`; otherwise an error with the expected ones.
    pub(super) fn expect(&self, kinds: &[Type], components: &[ComponentType], right: &str) -> Result<(), LoadError> {
        if kinds.contains(&self.kind) && components.contains(&self.component) {
            return Ok(());
        }
        Err(self.wrong(format!("is {:?} of {:?}; expected {right}", self.kind, self.component)))
    }

    /// Rejects integers that are not normalised in places where only normalised ones are meaningful.
    pub(super) fn expect_normalized(&self) -> Result<(), LoadError> {
        if self.component == ComponentType::F32 || self.normalized {
            return Ok(());
        }
        Err(self.wrong("has integers that are not normalized; expected \"normalized\": true"))
    }

    /// The first `N` components of every element as numbers, normalised if the accessor says so.
    pub(super) fn vectors<const N: usize>(&self) -> Result<Vec<[f32; N]>, LoadError> {
        let decode: fn(&[u8]) -> f32 = match (self.component, self.normalized) {
            (ComponentType::F32, _) => |b| f32::from_le_bytes(word(b)),
            // The specification's conversions; without clamping, the smallest signed value would be below -1.
            (ComponentType::I8, true) => |b| (f32::from(i8::from_le_bytes(word(b))) / 127.0).max(-1.0),
            (ComponentType::U8, true) => |b| f32::from(u8::from_le_bytes(word(b))) / 255.0,
            (ComponentType::I16, true) => |b| (f32::from(i16::from_le_bytes(word(b))) / 32767.0).max(-1.0),
            (ComponentType::U16, true) => |b| f32::from(u16::from_le_bytes(word(b))) / 65535.0,
            (ComponentType::U32, true) => |b| (f64::from(u32::from_le_bytes(word(b))) / f64::from(u32::MAX)) as f32,
            (ComponentType::I8, false) => |b| f32::from(i8::from_le_bytes(word(b))),
            (ComponentType::U8, false) => |b| f32::from(u8::from_le_bytes(word(b))),
            (ComponentType::I16, false) => |b| f32::from(i16::from_le_bytes(word(b))),
            (ComponentType::U16, false) => |b| f32::from(u16::from_le_bytes(word(b))),
            (ComponentType::U32, false) => |b| u32::from_le_bytes(word(b)) as f32,
        };
        let elements = self.collect([0.0; N], |bytes| {
            let mut components = bytes.chunks(self.component.size()).map(decode);
            std::array::from_fn(|_| components.next().unwrap_or_default())
        })?;
        // Normalised numbers have the same order as their integers.
        let scale = match (self.component, self.normalized) {
            (ComponentType::F32, _) | (_, false) => 1.0,
            (ComponentType::I8, true) => 127.0,
            (ComponentType::U8, true) => 255.0,
            (ComponentType::I16, true) => 32767.0,
            (ComponentType::U16, true) => 65535.0,
            (ComponentType::U32, true) => f64::from(u32::MAX),
        };
        let is_signed = matches!(self.component, ComponentType::I8 | ComponentType::I16) && self.normalized;
        let as_decoded = |bound: f64| {
            let bound = (bound / scale) as f32;
            if is_signed { bound.max(-1.0) } else { bound }
        };
        self.check_bounds(&elements, as_decoded);
        Ok(elements)
    }

    /// Notes elements outside the declared bounds. NaN is noted elsewhere.
    fn check_bounds<T: PartialOrd + Copy, const N: usize>(&self, elements: &[[T; N]], as_decoded: impl Fn(f64) -> T) {
        let parts = N.min(self.kind.multiplicity());
        let bound = |value: Option<&Value>, part: usize| Some(as_decoded(value?.get(part)?.as_f64()?));
        let [min, max] = self.bounds;
        let holds = (0..parts).all(|part| {
            let (min, max) = (bound(min, part), bound(max, part));
            let mut values = elements.iter().filter_map(|element| element.get(part));
            min.is_none() && max.is_none()
                || !values.any(|value| min.is_some_and(|min| *value < min) || max.is_some_and(|max| *value > max))
        });
        self.found(Wrong::Bounds, usize::from(!holds));
    }

    /// Counts what is wrong with this accessor's elements.
    pub(super) fn found(&self, what: Wrong, count: usize) {
        self.notes.borrow_mut().found(what, self.index, count);
    }

    /// The first `N` components of every element as unsigned integers.
    pub(super) fn integers<const N: usize>(&self) -> Result<Vec<[u32; N]>, LoadError> {
        let elements = self.collect([0; N], |bytes| {
            let mut components = bytes.chunks(self.component.size()).map(|b| unsigned(self.component, b));
            std::array::from_fn(|_| components.next().unwrap_or_default())
        })?;
        // Negative or too large bounds are clamped to the range of an index.
        self.check_bounds(&elements, |bound| bound as u32);
        Ok(elements)
    }

    /// Decodes all elements: the dense run, or zeros, replaced by sparse ones.
    fn collect<T: Copy>(&self, zero: T, decode: impl Fn(&[u8]) -> T) -> Result<Vec<T>, LoadError> {
        let mut out = self.budget.vec(self.count, &self.path)?;
        // `vec` succeeded, so the count fits a usize.
        let count = usize::try_from(self.count).unwrap_or_default();
        match self.dense {
            Some(run) => out.extend((0..count).map(|i| decode(run.element(i)))),
            None => out.resize(count, zero),
        }
        let Some(sparse) = self.sparse else { return Ok(out) };
        let mut previous = None;
        for i in 0..usize::try_from(sparse.count).unwrap_or_default() {
            let index = unsigned(sparse.index_type, sparse.indices.element(i));
            if previous.is_some_and(|previous| index <= previous) {
                return Err(self.wrong(format!("sparse index {i} is {index}; they must strictly increase")));
            }
            previous = Some(index);
            match out.get_mut(index as usize) {
                Some(element) => *element = decode(sparse.values.element(i)),
                None => {
                    let problem = format!("sparse index {i} is {index}, but there are {count} elements");
                    return Err(self.wrong(problem));
                }
            }
        }
        Ok(out)
    }
}

/// An unsigned integer of 1, 2 or 4 bytes.
fn unsigned(component: ComponentType, bytes: &[u8]) -> u32 {
    match component.size() {
        1 => u32::from(u8::from_le_bytes(word(bytes))),
        2 => u32::from(u16::from_le_bytes(word(bytes))),
        _ => u32::from_le_bytes(word(bytes)),
    }
}

/// The first `N` bytes; zeros past the end, which [`Accessors::run`] has excluded.
fn word<const N: usize>(bytes: &[u8]) -> [u8; N] {
    bytes.first_chunk().copied().unwrap_or([0; N])
}
