//! Long work cut into portions, between which other tasks of the same thread run: a browser's worker draws its window
//! and serves its events there.

use std::ops::Range;
use std::time::Duration;

use raystep_kernels::let_others_run;
use raystep_kernels::numbers::parallel::map_ranges;
use web_time::Instant;

/// How long work goes on before others run: with one more piece of it, not much longer than half of a frame.
pub(crate) const PORTION: Duration = Duration::from_millis(5);

/// Lets others run once a portion's time is over.
pub(crate) struct Portions {
    begin: Instant,
}

impl Portions {
    pub(crate) fn new() -> Self {
        Self { begin: Instant::now() }
    }

    /// Seconds that are left.
    fn left(&self) -> f64 {
        PORTION.saturating_sub(self.begin.elapsed()).as_secs_f64()
    }

    /// To be called between small pieces of work.
    pub(crate) async fn rest(&mut self) {
        if self.begin.elapsed() >= PORTION {
            let_others_run().await;
            self.begin = Instant::now();
        }
    }
}

/// Maps `0..len` on all cores, in order. Between two rests, each core does as many items as fit into a portion's time by
/// the time of those before.
pub(crate) async fn map_in_portions<T: Send>(len: usize, f: impl Fn(usize) -> T + Sync) -> Vec<T> {
    /// Items of a core at a time, so that none waits long for another.
    const CHUNK: usize = 16;
    /// How many times as many items a portion has as the one before, at most: the first ones may be the fast ones.
    const GROWTH: f64 = 4.0;
    // One in a browser, which has no threads.
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let map = |range: Range<usize>| range.map(&f).collect::<Vec<T>>();
    let mut all = Vec::with_capacity(len);
    let (mut portions, mut a_core) = (Portions::new(), 1.0);
    while all.len() < len {
        let (first, begin) = (all.len(), Instant::now());
        let count = (a_core as usize).saturating_mul(cores).min(len - first);
        let part = |range: Range<usize>| map(first + range.start..first + range.end);
        map_ranges(count, CHUNK.min(count.div_ceil(cores)), part).into_iter().for_each(|part| all.extend(part));
        let an_item = begin.elapsed().as_secs_f64().max(1e-9) / f64::floor(a_core);
        if portions.left() < an_item {
            let_others_run().await;
            portions = Portions::new();
        }
        a_core = (portions.left() / an_item).clamp(1.0, GROWTH * a_core);
    }
    all
}

#[cfg(test)]
mod tests {
    use std::pin::pin;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::task::{Context, Waker};

    use super::*;

    #[test]
    fn everything_is_mapped_once_and_in_order() {
        for len in [0, 1, 1000, 100_000] {
            let all = pollster::block_on(map_in_portions(len, |i| i));
            assert!(all.iter().copied().eq(0..len), "{len} items");
        }
    }

    #[test]
    fn others_run_between_portions() {
        const MS: u64 = 1;
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let (len, done) = (32 * cores, AtomicUsize::new(0));
        let mut mapped = pin!(map_in_portions(len, |_| {
            std::thread::sleep(Duration::from_millis(MS));
            done.fetch_add(1, Ordering::Relaxed);
        }));
        let mut before = 0;
        while mapped.as_mut().poll(&mut Context::from_waker(Waker::noop())).is_pending() {
            // Each takes longer on a busy machine, never shorter.
            let most = cores * (PORTION.as_millis() as usize / MS as usize + 1);
            let now = done.load(Ordering::Relaxed);
            assert!(now - before <= most, "{} at once", now - before);
            before = now;
        }
        assert!(before > 0 && done.load(Ordering::Relaxed) == len, "nobody else has run");
    }
}
