//! Sizes of a program's sets of elements in a run: known from the plan, or found during the run.

use crate::plan::Plan;
use crate::program::sizes::derive;
use crate::program::{Kernel, Program};
use crate::tables::elements::{Count, Elements, Size};
use crate::tables::stream::Stream;

pub use crate::program::sizes::TooMany;

/// The sizes of a program's sets.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Sizes {
    known: Vec<Option<Size>>,
    side: u32,
    most: u64,
}

/// A set that has not been counted yet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Unknown {
    index: usize,
    /// The stream whose first texel holds the number.
    pub(crate) stream: Stream,
    /// The layer.
    pub(crate) layer: usize,
}

impl Sizes {
    /// The sizes known before the first pass.
    pub(crate) fn new(plan: &Plan) -> Self {
        let known = plan.sets.iter().map(|set| set.size).collect();
        Self { known, side: plan.image_side, most: plan.most_elements }
    }

    /// The size of a set.
    pub(crate) fn of(&self, program: &Program, elements: &Elements) -> Option<Size> {
        self.known.get(program.elements.iter().position(|set| set.name == elements.name)?).copied()?
    }

    /// The first set without a size that this kernel is launched over or binds a stream of.
    pub(crate) fn unknown(&self, plan: &Plan, kernel: Kernel) -> Option<Unknown> {
        let streams = plan.variant(kernel).into_iter().flat_map(|variant| variant.streams());
        let instance = kernel.instance();
        let renewed = instance.renews.iter().copied();
        let mut needed = streams.map(|(stream, _)| stream.info().elements).chain([instance.over]).chain(renewed);
        needed.find_map(|elements| self.root(plan.program, elements))
    }

    /// The set that must be counted before this one has a size.
    fn root(&self, program: &'static Program, elements: &Elements) -> Option<Unknown> {
        let index = program.elements.iter().position(|set| set.name == elements.name)?;
        if self.known[index].is_some() {
            return None;
        }
        match elements.count {
            Count::Found { in_stream, layer } => {
                program.stream(in_stream).map(|stream| Unknown { index, stream, layer })
            }
            Count::Per { of, .. } => self.root(program, program.elements(of)?),
            Count::Image | Count::Given => None,
        }
    }

    /// Forgets the sizes of the sets that a kernel renews, and of those whose sizes follow from them.
    pub(crate) fn renew(&mut self, program: &Program, kernel: Kernel) {
        self.forget(program, kernel.instance().renews.iter().copied());
    }

    /// Resizes the sets of the streams that a kernel [adopts](crate::program::Instance::adopts). Returns the pairs of
    /// streams; none if the sets of those that are adopted have no size.
    pub(crate) fn adopt(&mut self, program: &Program, kernel: Kernel) -> Result<Vec<(Stream, Stream)>, TooMany> {
        let size_of = |stream: Stream| self.of(program, stream.info().elements);
        let adopted = kernel.instance().adopts.iter().filter_map(|&(to, from)| Some((to, from, size_of(from)?)));
        let adopted: Vec<_> = adopted.collect();
        if adopted.is_empty() {
            return Ok(Vec::new());
        }
        let sets = adopted.iter().flat_map(|(to, from, _)| [to.info().elements, from.info().elements]);
        self.forget(program, sets);
        for (to, _, size) in &adopted {
            if let Some(index) = program.elements.iter().position(|set| set.name == to.info().elements.name) {
                self.known[index] = Some(*size);
            }
        }
        derive(program, &mut self.known, self.side)?;
        Ok(adopted.into_iter().map(|(to, from, _)| (to, from)).collect())
    }

    fn forget<'a>(&mut self, program: &Program, sets: impl Iterator<Item = &'a Elements>) {
        let mut forgotten: Vec<&str> = sets.map(|elements| elements.name).collect();
        while let Some(name) = forgotten.pop() {
            for (elements, known) in program.elements.iter().zip(&mut self.known) {
                if elements.name == name {
                    *known = None;
                }
            }
            let follows = |elements: &&&Elements| matches!(elements.count, Count::Per { of, .. } if of == name);
            forgotten.extend(program.elements.iter().filter(follows).map(|elements| elements.name));
        }
    }

    /// The number of elements in each set; 0 while it is unknown.
    pub(crate) fn counts(&self) -> Vec<u32> {
        self.known.iter().map(|size| size.map_or(0, |size| size.count)).collect()
    }

    /// Sets the size of a counted set, and of those whose sizes follow from it.
    pub(crate) fn found(&mut self, program: &Program, unknown: Unknown, count: u32) -> Result<(), TooMany> {
        let elements = program.elements[unknown.index].name;
        let size = Size::folded(count.into(), self.side).filter(|_| u64::from(count) <= self.most);
        let most = self.most.min(u64::from(self.side).pow(2));
        self.known[unknown.index] = Some(size.ok_or(TooMany { elements, count: count.into(), most })?);
        derive(program, &mut self.known, self.side)
    }
}
