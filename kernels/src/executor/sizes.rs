//! How many elements each set of a program has in a run: known from the plan, or found on the way.

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

/// A set that is still to be counted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Unknown {
    index: usize,
    /// Where the number is: in the first texel of this stream.
    pub(crate) stream: Stream,
}

impl Sizes {
    /// What is known before the first pass.
    pub(crate) fn new(plan: &Plan) -> Self {
        let known = plan.sets.iter().map(|set| set.size).collect();
        Self { known, side: plan.image_side, most: plan.most_elements }
    }

    /// How many elements a set has.
    pub(crate) fn of(&self, program: &Program, elements: &Elements) -> Option<Size> {
        self.known.get(program.elements.iter().position(|set| set.name == elements.name)?).copied()?
    }

    /// The first set that has no size yet, and that this kernel is launched over or binds a stream of.
    pub(crate) fn unknown(&self, plan: &Plan, kernel: Kernel) -> Option<Unknown> {
        let streams = plan.variant(kernel).into_iter().flat_map(|variant| variant.streams());
        let mut needed = streams.map(|(stream, _)| stream.info().elements).chain([kernel.instance().over]);
        needed.find_map(|elements| self.root(plan.program, elements))
    }

    /// The set that must be counted for this one to have a size.
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

    /// A set was counted: it has a size from now on, and so have those that follow from it.
    pub(crate) fn found(&mut self, program: &Program, unknown: Unknown, count: u32) -> Result<(), TooMany> {
        let elements = program.elements[unknown.index].name;
        let size = Size::folded(count.into(), self.side).filter(|_| u64::from(count) <= self.most);
        let most = self.most.min(u64::from(self.side).pow(2));
        self.known[unknown.index] = Some(size.ok_or(TooMany { elements, count: count.into(), most })?);
        derive(program, &mut self.known, self.side)
    }
}
