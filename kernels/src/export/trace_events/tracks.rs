//! Where the slices of passes are: on a common axis of time, and on tracks where they do not overlap.

use crate::renderer::Pass;

/// A pass with a possible time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Timed {
    /// Its place among the passes.
    pub(super) index: usize,
    /// Its begin on the device's clock.
    pub(super) clock_ns: u64,
    /// Its begin since the first pass began.
    pub(super) begin_ns: u64,
    pub(super) duration_ns: u64,
}

impl Timed {
    pub(super) fn end_ns(&self) -> u64 {
        self.begin_ns.saturating_add(self.duration_ns)
    }
}

/// The passes with possible times, and how often the clock was set back between them.
///
/// A single pass whose begin does not lie between those of its neighbours has no possible time. If later passes follow
/// it there, the clock was set back, and how long that took is not known: the pass then begins where the last one ended.
pub(super) fn timed(passes: &[Pass]) -> (Vec<Timed>, usize) {
    let told = passes.iter().enumerate().filter_map(|(index, pass)| {
        let (begin, duration) = pass.begin_ns.zip(pass.duration_ns)?;
        begin.checked_add(duration).map(|_| (index, begin, duration))
    });
    let told: Vec<(usize, u64, u64)> = told.collect();
    let mut placed: Vec<Timed> = Vec::with_capacity(told.len());
    // The clock's value at a place of the axis.
    let (mut from_ns, mut at_ns) = (told.first().map_or(0, |first| first.1), 0);
    let (mut latest_end, mut set_back) = (0, 0);
    for (i, &(index, clock_ns, duration_ns)) in told.iter().enumerate() {
        if let Some(before) = placed.last().map(|pass| pass.clock_ns) {
            let next = told.get(i + 1).map(|next| next.1).filter(|&next| next >= before);
            if next.is_some_and(|next| clock_ns < before || clock_ns > next) {
                continue;
            }
            if clock_ns < before {
                (from_ns, at_ns) = (clock_ns, latest_end);
                set_back += 1;
            }
        }
        let begin_ns = (clock_ns - from_ns).saturating_add(at_ns);
        let pass = Timed { index, clock_ns, begin_ns, duration_ns };
        latest_end = latest_end.max(pass.end_ns());
        placed.push(pass);
    }
    (placed, set_back)
}

/// Tracks for slices that may overlap, each named after the first: the format allows slices of one track only inside
/// each other, and a pass is no part of another one.
#[derive(Debug)]
pub(super) struct Tracks {
    /// The first track.
    first: u32,
    name: &'static str,
    /// The end of the last slice on each of them.
    ends: Vec<u64>,
}

/// Distance between the numbers of one group's tracks, so that those of two groups differ.
const BETWEEN: u32 = 10;

impl Tracks {
    pub(super) fn new(first: u32, name: &'static str) -> Self {
        Self { first, name, ends: Vec::new() }
    }

    fn track(&self, index: usize) -> u32 {
        self.first + index as u32 * BETWEEN
    }

    /// The first track that is free for a slice; slices come in order of their begins.
    pub(super) fn place(&mut self, begin_ns: u64, end_ns: u64) -> u32 {
        let free = self.ends.iter().position(|&end| end <= begin_ns);
        let index = free.unwrap_or_else(|| {
            self.ends.push(0);
            self.ends.len() - 1
        });
        self.ends[index] = end_ns;
        self.track(index)
    }

    /// Number and name of every track: the first, and those for slices that overlap with others.
    pub(super) fn names(&self) -> impl Iterator<Item = (u32, String)> + '_ {
        (0..self.ends.len().max(1)).map(|index| {
            let name = if index == 0 { self.name.to_owned() } else { format!("{}, overlapping {index}", self.name) };
            (self.track(index), name)
        })
    }
}
