//! Sorts keys by Batcher's bitonic sort (1968): a network of comparisons that does not depend on the keys, so every pass is
//! known ahead. n keys take k (k + 1) / 2 passes, where k is the base-2 logarithm of n, rounded up.
//!
//! It is the smallest program here, and an example of how to write one: a set of elements, a stream, a kernel, and a
//! schedule whose inner loop grows with the outer one.

pub mod exchange;
mod plan;

use std::borrow::Cow;

use super::{Alone, Registered};
use crate::options::reasons::{Because, Reason, Run};
use crate::options::{Integrator, Options, ProgramName};
use crate::program::breaks::{Break, as_it_is};
use crate::program::schedule::{Count as Counted, Schedule, Step};
use crate::program::{Instance, Kernel, KernelInfo, Program};
use crate::shared;
use crate::tables::elements::{Count, Elements};
use crate::tables::state::States;
use crate::tables::stream::{Meaning, Stream, StreamData, streams};

/// Keys with what they belong to.
pub static KEYS: Elements = Elements { name: "keys", count: Count::Given };

fn never(_: &Run<'_>) -> Reason {
    (Because::Options, "every sort needs it")
}

streams! {
    /// A key, and the element that it came from.
    KEY of KEYS: "key" U32 &["key", "from"], meaning: &[Meaning::Count, Meaning::Id], unit: "key, element",
        unwritten: &[0; 2], why_absent: never;
}

pub(super) const EXCHANGES: KernelInfo = KernelInfo::once(
    ("exchange", include_str!("exchange.wgsl")),
    exchange::exchange,
    [66, 124, 200],
    "puts the smaller of two keys first",
    never,
    &[Break::new(as_it_is, "there.x < here.x ||", "there.x > here.x ||")],
);

/// The program.
pub static PROGRAM: Program = Program {
    name: "sort",
    summary: "keys in ascending order, by Batcher's bitonic sort",
    elements: &[&KEYS],
    streams: &STREAMS,
    states: States(&[]),
    courses: &[],
    rays: None,
    results: None,
    buffers: &[],
    lists: &[],
    kernels: &[Instance::of(EXCHANGES, &KEYS)],
    modules: |_| shared::MODULES.iter().map(|&(name, source)| (name, Cow::Borrowed(source))).collect(),
    files: &[],
};

pub(super) const REGISTERED: Registered = Registered {
    name: ProgramName::Sort,
    integrators: Integrator::ALL,
    program: || &PROGRAM,
    plan: plan::plan,
    alone: Some(Alone { results: KEY, are_right: is_sorted }),
};

/// Compares and exchanges.
pub const EXCHANGE: Kernel = Kernel::at(&PROGRAM, 0);

/// The schedule for this many keys: stage s has s + 1 steps, counted from 0. The kernel's parameter is 32 s + step. A single
/// key is looked at once, so that it is in a stream.
#[must_use]
pub fn schedule(keys: u32) -> Schedule {
    let stages = keys.max(2).next_power_of_two().trailing_zeros();
    let step = Step::RunBy(EXCHANGE, Counted { first: 0, by: &[1, 32] });
    let stage = Step::Repeat("step", Counted { first: 1, by: &[1] }, vec![step]);
    Schedule { steps: vec![Step::Repeat("stage", Counted::always(stages), vec![stage])] }
}

/// Keys to sort: numbers below 2³², the same for the same seed (the hash `pcg`; Jarzynski and Olano 2020).
#[must_use]
pub fn random_keys(keys: u32, seed: u32) -> Vec<u32> {
    let hash = |v: u32| {
        let state = v.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
        (word >> 22) ^ word
    };
    (0..keys).map(|i| hash(i ^ hash(seed))).collect()
}

/// Whether these are the keys of a run with these options, as the host sorts them.
fn is_sorted(options: &Options, sorted: &StreamData) -> bool {
    let mut expected: Vec<_> = random_keys(options.elements, options.samples.seed).into_iter().zip(0..).collect();
    expected.sort_unstable();
    let found = sorted.layer(0).iter().copied().zip(sorted.layer(1).iter().copied());
    found.take(expected.len()).eq(expected)
}

#[cfg(test)]
mod tests;
