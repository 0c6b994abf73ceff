//! Sizes of sets of elements that follow from other sets.

use super::Program;
use crate::tables::elements::{Count, Size};

/// A set has more elements than fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{count} {elements} are too many: at most {most} fit here")]
pub struct TooMany {
    /// Name of the set.
    pub elements: &'static str,
    /// Number found; `u32::MAX` also stands for more.
    pub count: u64,
    /// Most that fit.
    pub most: u64,
}

/// Sets the sizes of sets that follow from other sets.
pub(crate) fn derive(program: &Program, known: &mut [Option<Size>], side: u32) -> Result<(), TooMany> {
    // As many rounds as there are sets: each may follow from a later one.
    for _ in 0..program.elements.len() {
        for (index, elements) in program.elements.iter().enumerate() {
            let Count::Per { of, per, each } = elements.count else { continue };
            let base = program.elements.iter().position(|set| set.name == of).and_then(|base| known[base]);
            let Some(base) = base.filter(|_| known[index].is_none()) else { continue };
            let count = u64::from(base.count.div_ceil(per).max(1)) * u64::from(each);
            let most = u64::from(side).pow(2);
            let size = Size::folded(count, side).ok_or(TooMany { elements: elements.name, count, most })?;
            known[index] = Some(size);
        }
    }
    Ok(())
}
