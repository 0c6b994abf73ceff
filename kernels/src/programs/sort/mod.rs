//! Sorts keys by Batcher's bitonic sort (1968): a network of comparisons that does not depend on the keys, so every pass is
//! known ahead. n keys take k (k + 1) / 2 passes, where k is the base-2 logarithm of n, rounded up.
//!
//! It is the smallest program here, and an example of how to write one: a set of elements, a stream, a kernel, and a
//! schedule whose inner loop grows with the outer one.

pub mod exchange;

use std::borrow::Cow;

use crate::options::reasons::{Because, Reason, Run};
use crate::program::breaks::{Break, as_it_is};
use crate::program::schedule::{Count as Counted, Schedule, Step};
use crate::program::{Instance, Kernel, KernelInfo, Program};
use crate::shared;
use crate::tables::elements::{Count, Elements};
use crate::tables::state::States;
use crate::tables::stream::{Meaning, Stream, streams};

/// Most keys: a schedule of 253 passes.
pub const MOST_KEYS: u32 = 1 << 22;

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

const EXCHANGES: KernelInfo = KernelInfo::once(
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
};

/// Compares and exchanges.
pub const EXCHANGE: Kernel = Kernel::at(&PROGRAM, 0);

/// The schedule for this many keys: stage s has s + 1 steps, counted from 0. The kernel's parameter is 32 s + step.
#[must_use]
pub fn schedule(keys: u32) -> Schedule {
    let stages = keys.max(1).next_power_of_two().trailing_zeros();
    let step = Step::RunBy(EXCHANGE, Counted { first: 0, by: &[1, 32] });
    let stage = Step::Repeat(Counted { first: 1, by: &[1] }, vec![step]);
    Schedule { steps: vec![Step::Repeat(Counted::always(stages), vec![stage])] }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::schedule::Cursor;
    use crate::tables::state::Population;

    fn passes(keys: u32) -> Vec<(u32, Vec<u32>)> {
        let (schedule, mut cursor) = (schedule(keys), Cursor::start());
        let population = Population::default();
        let next = || cursor.next(&schedule, &population).map(|_| (cursor.parameter, cursor.loops()));
        std::iter::from_fn(next).collect()
    }

    #[test]
    fn a_sort_takes_as_many_passes_as_batchers_network_has_levels() {
        for (keys, levels) in [(0, 0), (1, 0), (2, 1), (3, 3), (8, 6), (9, 10), (65_536, 136), (1 << 22, 253)] {
            assert_eq!(passes(keys).len(), levels, "{keys} keys");
            assert_eq!(schedule(keys).passes_expected(), levels as u64, "{keys} keys");
        }
        let expected = [(0, [0, 0]), (32, [1, 0]), (33, [1, 1]), (64, [2, 0]), (65, [2, 1]), (66, [2, 2])];
        assert_eq!(passes(8), expected.map(|(parameter, loops)| (parameter, loops.to_vec())));
    }

    /// By the 0-1 principle (Knuth, The Art of Computer Programming 3, 5.3.4), a network sorts all keys if it sorts all
    /// sequences of zeros and ones.
    #[test]
    fn the_network_sorts_any_keys_of_any_number() {
        for keys in 0..=13usize {
            let passes = passes(keys as u32);
            for bits in 0..1u32 << keys {
                let mut sorted: Vec<u32> = (0..keys).map(|i| bits >> i & 1).collect();
                for (parameter, _) in &passes {
                    for i in 0..keys {
                        let j = exchange::partner(i, *parameter);
                        if i < j && j < keys && sorted[j] < sorted[i] {
                            sorted.swap(i, j);
                        }
                    }
                }
                assert!(sorted.is_sorted(), "{bits:b} of {keys}");
            }
        }
    }
}
