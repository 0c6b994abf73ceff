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
        let mut needed = streams.map(|(stream, _)| stream.info().elements).chain([kernel.instance().over]);
        needed.find_map(|elements| self.root(plan.program, elements))
    }

    /// The set that must be counted before this one has a size.
    fn root(&self, program: &'static Program, elements: &Elements) -> Option<Unknown> {
        let index = program.elements.iter().position(|set| set.name == elements.name)?;
        if self.known[index].is_some() {
            return None;
        }
        match elements.count {
            Count::Found { in_stream } => program.stream(in_stream).map(|stream| Unknown { index, stream }),
            Count::Per { of, .. } => self.root(program, program.elements(of)?),
            Count::Image | Count::Given => None,
        }
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
