//! The parts of the passes of a batch, and which timestamps and statistics are theirs.

use std::ops::Range;

use crate::executor::gpu::timers::Times;
use crate::executor::{DrawTime, Drawing};

/// What was read back after a batch.
#[derive(Default)]
pub(super) struct Read {
    /// Pairs of timestamps.
    pub(super) times: Times,
    /// Fragments run.
    pub(super) fragments: Vec<u64>,
}

impl Read {
    /// From the first begin to the last end.
    pub(super) fn span(&self) -> Option<u64> {
        let (first, last) = (self.times.first()?, self.times.last()?);
        (last.0? + last.1?).checked_sub(first.0?)
    }
}

/// A part of a pass.
struct Part {
    what: Drawing,
    /// Its pair of timestamps.
    pair: Option<usize>,
    statistic: Option<usize>,
}

/// The parts of the passes of a batch.
pub(super) struct Parts {
    /// Whether each part is timed, or only the batch; `None` without a clock.
    each: Option<bool>,
    pairs: usize,
    statistics: usize,
    parts: Vec<Part>,
    passes: Vec<Range<usize>>,
}

/// The indices of a begin and an end in a set of timestamps.
type Stamps = [Option<u32>; 2];

impl Parts {
    pub(super) fn new(each: Option<bool>) -> Self {
        Self { each, pairs: 0, statistics: 0, parts: Vec::new(), passes: Vec::new() }
    }

    /// Number of timestamps.
    pub(super) fn stamps(&self) -> u32 {
        2 * self.pairs as u32
    }

    /// Number of statistics.
    pub(super) fn statistics(&self) -> u32 {
        self.statistics as u32
    }

    /// What follows is of the next pass.
    pub(super) fn begin_pass(&mut self) {
        self.passes.push(self.parts.len()..self.parts.len());
    }

    /// The timestamps at the begin of a pass that copies, and of any batch; `None` if no timestamps are needed there.
    pub(super) fn begin_copies(&mut self, copies: bool) -> Option<Stamps> {
        if copies {
            self.push(Drawing::Copies, None);
        }
        match self.each? {
            true if copies => {
                let stamps = self.next_pair();
                if let Some(part) = self.parts.last_mut() {
                    part.pair = Some(self.pairs - 1);
                }
                Some(stamps)
            }
            false if self.pairs == 0 => Some([self.next_pair()[0], None]),
            _ => None,
        }
    }

    /// The timestamps of a draw; `is_end`: it is the batch's last.
    pub(super) fn begin_draw(&mut self, what: Drawing, is_end: bool) -> Stamps {
        match self.each {
            Some(true) => {
                self.push(what, Some(self.pairs));
                self.next_pair()
            }
            each => {
                self.push(what, None);
                // The other half of the pair that the batch began with.
                [None, (each.is_some() && is_end).then_some(1)]
            }
        }
    }

    /// The index of a statistic for the latest part.
    pub(super) fn next_statistic(&mut self) -> u32 {
        let index = self.statistics;
        self.statistics += 1;
        if let Some(part) = self.parts.last_mut() {
            part.statistic = Some(index);
        }
        index as u32
    }

    fn push(&mut self, what: Drawing, pair: Option<usize>) {
        self.parts.push(Part { what, pair, statistic: None });
        if let Some(pass) = self.passes.last_mut() {
            pass.end = self.parts.len();
        }
    }

    fn next_pair(&mut self) -> Stamps {
        let first = 2 * self.pairs as u32;
        self.pairs += 1;
        [Some(first), Some(first + 1)]
    }

    /// The parts of a pass.
    pub(super) fn of_pass(&self, pass: usize, read: &Read) -> Vec<DrawTime> {
        let parts = &self.parts[self.passes[pass].clone()];
        let time = |part: &Part| part.pair.and_then(|pair| read.times.get(pair)).copied().unwrap_or_default();
        let mut draws: Vec<DrawTime> = parts
            .iter()
            .map(|part| {
                let (begin_ns, duration_ns) = time(part);
                let fragments = part.statistic.and_then(|index| read.fragments.get(index)).copied();
                DrawTime { what: part.what, begin_ns, duration_ns, fragments }
            })
            .collect();
        // Copies last until the first draw: the pair around the empty pass only tells their begin.
        let next = draws.get(1).and_then(|draw| draw.begin_ns);
        if let Some(copies) = draws.first_mut().filter(|draw| draw.what == Drawing::Copies) {
            let begin = copies.begin_ns.zip(copies.duration_ns).map(|(begin, duration)| begin + duration);
            copies.begin_ns = begin;
            copies.duration_ns = begin.zip(next).and_then(|(begin, next)| next.checked_sub(begin));
        }
        draws
    }
}

/// Begin and duration of a pass, from its first part to the end of its last.
pub(super) fn time_of(draws: &[DrawTime]) -> (Option<u64>, Option<u64>) {
    let (Some(first), Some(last)) = (draws.first(), draws.last()) else { return (None, None) };
    let end = last.begin_ns.zip(last.duration_ns).map(|(begin, duration)| begin + duration);
    (first.begin_ns, first.begin_ns.zip(end).and_then(|(begin, end)| end.checked_sub(begin)))
}
