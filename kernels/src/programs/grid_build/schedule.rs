//! The order of the build's kernels: each runs once, except those of the sort.

use super::kernels::{COUNTED, MARKED, SORTED, STARTED, TALLIED};
use super::radix::digits_of;
use crate::program::Kernel;
use crate::program::schedule::{Schedule, Step};

/// The schedule for a grid with this many cells.
#[must_use]
pub fn of(cells: u32) -> Schedule {
    let digits = digits_of(cells) as usize;
    let mut kernels: Vec<Kernel> = COUNTED.into();
    for [count, scatter] in SORTED.into_iter().take(digits) {
        kernels.push(count);
        kernels.extend(TALLIED);
        kernels.push(scatter);
    }
    kernels.push(MARKED[digits % 2]);
    kernels.extend(STARTED);
    Schedule { steps: kernels.into_iter().map(Step::Run).collect() }
}
