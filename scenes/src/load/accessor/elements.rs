//! The elements of an accessor: decodes them as numbers.

use super::types::{read, read_unsigned, scale};
use super::{Component, Kind};
use crate::load::budget::Budget;
use crate::load::json::Number;
use crate::load::notes::{Notes, Wrong};
use crate::load::points::Points;
use crate::load::{LoadError, at};
use std::cell::RefCell;

/// A sequence of elements that is known to be within its bytes.
#[derive(Clone, Copy)]
pub(super) struct Run<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) stride: usize,
}

impl<'a> Run<'a> {
    /// The bytes from element `i` on. Empty past the end, which has been excluded.
    fn element(&self, i: usize) -> &'a [u8] {
        i.checked_mul(self.stride).and_then(|start| self.bytes.get(start..)).unwrap_or_default()
    }
}

/// The elements that replace some of the run's.
#[derive(Clone, Copy)]
pub(super) struct Sparse<'a> {
    pub(super) count: u64,
    pub(super) component: Component,
    pub(super) indices: Run<'a>,
    pub(super) values: Run<'a>,
}

/// An accessor, checked and ready to be decoded.
pub(crate) struct Elements<'a> {
    /// Its index and where it is used, for messages.
    pub(super) path: String,
    pub(super) index: usize,
    /// The declared minimum and maximum components, not normalised.
    pub(super) bounds: [Option<&'a [Number]>; 2],
    /// The number of elements.
    pub(crate) count: u64,
    pub(super) kind: Kind,
    pub(super) component: Component,
    pub(super) normalized: bool,
    /// `None` if all elements are initially zero.
    pub(super) dense: Option<Run<'a>>,
    pub(super) sparse: Option<Sparse<'a>>,
    pub(super) budget: &'a Budget,
    pub(super) notes: &'a RefCell<Notes>,
}

impl<'a> Elements<'a> {
    /// An error about this accessor.
    pub(crate) fn wrong(&self, problem: impl Into<String>) -> LoadError {
        at(self.path.clone(), problem)
    }

    /// The bytes of an element.
    pub(super) fn element_bytes(&self) -> usize {
        self.component.size() * self.kind.multiplicity()
    }

    /// The same elements with these values, which were decompressed: one after the other, of this type.
    pub(crate) fn with_bytes(mut self, bytes: &'a [u8], component: Component) -> Self {
        self.component = component;
        let stride = self.element_bytes();
        self.count = (bytes.len() / stride) as u64;
        self.dense = Some(Run { bytes, stride });
        self
    }

    /// The type of the elements.
    pub(crate) fn kind(&self) -> Kind {
        self.kind
    }

    /// Whether the accessor has one of `kinds` and one of `components`; otherwise an error with the expected ones.
    pub(crate) fn expect(&self, kinds: &[Kind], components: &[Component], right: &str) -> Result<(), LoadError> {
        if kinds.contains(&self.kind) && components.contains(&self.component) {
            return Ok(());
        }
        Err(self.wrong(format!("is {:?} of {:?}; expected {right}", self.kind, self.component)))
    }

    /// Whether the accessor has elements of this kind.
    pub(crate) fn expect_kind(&self, kind: Kind, right: &str) -> Result<(), LoadError> {
        if self.kind == kind { Ok(()) } else { Err(self.wrong(format!("is {:?}; expected {right}", self.kind))) }
    }

    /// Rejects integers that are not normalised in places where only normalised ones are meaningful.
    pub(crate) fn expect_normalized(&self) -> Result<(), LoadError> {
        if self.component == Component::F32 || self.normalized {
            return Ok(());
        }
        Err(self.wrong("has integers that are not normalized; expected \"normalized\": true"))
    }

    /// Checks that there is one element per vertex.
    pub(crate) fn expect_count(&self, vertices: u64) -> Result<(), LoadError> {
        if self.count == vertices {
            return Ok(());
        }
        Err(self.wrong(format!("has {} elements, but POSITION has {vertices}", self.count)))
    }

    /// Counts what is wrong with this accessor's elements.
    pub(crate) fn found(&self, what: Wrong, count: usize) {
        self.notes.borrow_mut().found(what, self.index, count);
    }

    /// Positions or normals, as exact as they are in the file.
    pub(crate) fn points(&self) -> Result<Points, LoadError> {
        if self.component != Component::F32 {
            return Ok(Points::Double(self.doubles()?));
        }
        let points = self.singles::<3>()?;
        self.check_lattice(&points);
        Ok(Points::Single(points))
    }

    /// The first `N` components of every element as 32-bit numbers, normalised if the accessor says so.
    pub(crate) fn singles<const N: usize>(&self) -> Result<Vec<[f32; N]>, LoadError> {
        let elements = if self.component == Component::F32 {
            self.collect([0.0; N], |bytes| {
                let mut element = [0.0; N];
                for (component, word) in element.iter_mut().zip(bytes.as_chunks::<4>().0) {
                    *component = f32::from_le_bytes(*word);
                }
                element
            })?
        } else {
            self.collect([0.0; N], |bytes| self.decode(bytes).map(|component| component as f32))?
        };
        self.check_bounds(&elements, |bound| self.normalize(bound) as f32);
        Ok(elements)
    }

    /// The first `N` components of every element as 64-bit numbers, normalised if the accessor says so.
    pub(crate) fn doubles<const N: usize>(&self) -> Result<Vec<[f64; N]>, LoadError> {
        let elements = self.collect([0.0; N], |bytes| self.decode(bytes))?;
        self.check_bounds(&elements, |bound| self.normalize(bound));
        Ok(elements)
    }

    /// The first `N` components of every element as unsigned integers.
    pub(crate) fn integers<const N: usize>(&self) -> Result<Vec<[u32; N]>, LoadError> {
        let elements = self.collect([0; N], |bytes| {
            let mut components = bytes.chunks(self.component.size()).map(|b| read_unsigned(self.component, b));
            std::array::from_fn(|_| components.next().unwrap_or_default())
        })?;
        // Negative or too large bounds are clamped to the range of an index.
        self.check_bounds(&elements, |bound| bound as u32);
        Ok(elements)
    }

    fn decode<const N: usize>(&self, bytes: &[u8]) -> [f64; N] {
        let mut components = bytes.chunks(self.component.size()).map(|b| self.normalize(read(self.component, b)));
        std::array::from_fn(|_| components.next().unwrap_or_default())
    }

    /// The specification's conversion of integers, in f64, so that one more rounding to f32 gives the nearest.
    fn normalize(&self, value: f64) -> f64 {
        match (self.component, self.normalized) {
            (Component::F32, _) | (_, false) => value,
            // Without clamping, the smallest signed value would be below -1.
            (component, true) => (value / scale(component)).max(-1.0),
        }
    }

    /// Notes elements outside the declared bounds. NaN is noted elsewhere.
    fn check_bounds<T: PartialOrd + Copy, const N: usize>(&self, elements: &[[T; N]], as_decoded: impl Fn(f64) -> T) {
        let [min, max] = self.bounds;
        if min.is_none() && max.is_none() {
            return;
        }
        let bound = |bounds: Option<&[Number]>, part: usize| Some(as_decoded(bounds?.get(part)?.0));
        let holds = (0..N.min(self.kind.multiplicity())).all(|part| {
            let (min, max) = (bound(min, part), bound(max, part));
            let mut values = elements.iter().filter_map(|element| element.get(part));
            !values.any(|value| min.is_some_and(|min| *value < min) || max.is_some_and(|max| *value > max))
        });
        self.found(Wrong::Bounds, usize::from(!holds));
    }

    /// Notes positions that lie so far from the origin that the steps between 32-bit numbers are coarse beside their
    /// extent. Whatever wrote them has then rounded their shape, and no transform brings it back.
    fn check_lattice(&self, points: &[[f32; 3]]) {
        /// Steps per extent from which on nobody sees them.
        const ENOUGH: f32 = 4096.0;
        let (mut min, mut max) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for point in points {
            for ((part, min), max) in point.iter().zip(&mut min).zip(&mut max) {
                *min = min.min(*part);
                *max = max.max(*part);
            }
        }
        let parts = || min.iter().zip(&max);
        let extent = parts().map(|(min, max)| max - min).fold(0.0, f32::max);
        let step = parts().map(|(min, max)| min.abs().max(max.abs())).fold(0.0, f32::max) * f32::EPSILON / 2.0;
        let is_coarse = step.is_finite() && step * ENOUGH > extent;
        self.found(Wrong::Lattice, usize::from(is_coarse));
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
            let index = read_unsigned(sparse.component, sparse.indices.element(i));
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
