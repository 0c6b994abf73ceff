//! What putting back an omitted item costs, and all of them together: bytes, and on an adapter start and run times,
//! interleaved with those of the plan as it is.

use std::time::{Duration, Instant};

use raystep_kernels::plan::{Because, Bytes, Plan};
use raystep_kernels::{Item, Keep, Options, RayHit, Renderer};

use super::super::record::RUN_COLUMNS;
use super::super::times::Times;
use super::super::work::{Planned, Work};
use crate::Error;
use crate::meter::{Ended, Run, Time, Turns, in_turn};
use crate::statistics::Compared;
use crate::statistics::interval::{self, Interval};

/// Bytes of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sizes {
    /// Bytes of streams.
    pub streams: u64,
    /// Bytes of buffers.
    pub buffers: u64,
}

/// Something that a plan omits because the scene does not need it, and what putting it back costs.
#[derive(Clone, Debug)]
pub struct Cost {
    /// The item; `None` for all of them together.
    pub item: Option<Item>,
    /// What made it unnecessary.
    pub because: Because,
    /// The reason.
    pub reason: String,
    /// Whether any kernel or buffer of this run changes with it. If not, no time is measured.
    pub is_changed: bool,
    /// Rays of a run.
    pub rays: u64,
    /// Without and with it.
    pub bytes: [Sizes; 2],
    /// On an adapter, if there was time.
    pub times: Option<Measured>,
}

/// A median ratio of with to without, with its interval if there are enough pairs.
pub type Ratio = (f64, Option<Interval>);

/// Times without and with an item.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Seconds for allocating, uploading and compiling for the first time, which the driver may have cached earlier.
    pub first_start_s: [f64; 2],
    /// Median of later starts, whose kernels the driver may have cached; `None` if there was time for one only.
    pub start_s: [Option<f64>; 2],
    /// Ratio of later starts.
    pub start_ratio: Option<Ratio>,
    /// Median time of a run, in nanoseconds.
    pub run_ns: [Option<f64>; 2],
    /// Counted pairs of runs.
    pub runs: usize,
    /// Ratio of runs.
    pub time_ratio: Option<Ratio>,
    /// Id of the configuration without it.
    pub without: String,
    /// Rays whose hits differ in any bit.
    pub differing: Vec<usize>,
}

/// All costs of a configuration.
#[derive(Clone, Debug, Default)]
pub struct Costs {
    /// Everything together first, then by what is saved: most time first, then most bytes, then what changes nothing.
    pub costs: Vec<Cost>,
    /// Items whose plans there was no time for, as building the structure takes long.
    pub unplanned: Vec<Item>,
}

/// Most starts of each, and most pairs of runs.
const STARTS: usize = 7;
const RUNS: usize = 20;

/// Most configurations to interleave with the plan as it is, and bytes of all that are kept at the same time.
const AT_ONCE: usize = 4;
const MOST_BYTES: u64 = 1 << 30;

impl Sizes {
    fn of(plan: &Plan) -> Self {
        let streams = plan.streams.iter().map(|s| s.bytes).sum();
        Self { streams, buffers: plan.bytes() - streams }
    }

    /// The sum.
    #[must_use]
    pub fn total(self) -> u64 {
        self.streams + self.buffers
    }
}

impl Cost {
    /// Its name in tables.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.item.map_or("all", Item::name)
    }

    /// What putting it back costs: the time with it divided by that without, memory, and start-up. Empty where nothing
    /// was measured.
    #[must_use]
    pub fn in_words(&self) -> [String; 3] {
        if !self.is_changed {
            return ["no effect in this run".into(), String::new(), String::new()];
        }
        let [without, with] = self.bytes.map(Sizes::total);
        let memory = match with.checked_sub(without) {
            Some(0) => "same".into(),
            Some(more) => format!("+{}", Bytes(more)),
            None => format!("-{}", Bytes(without - with)),
        };
        let Some(times) = &self.times else { return [String::new(), memory, String::new()] };
        let time = match times.time_ratio {
            Some((ratio, Some(i))) => {
                let words = Compared::of_interval(Some(i)).words();
                format!("{ratio:.3} [{:.3}, {:.3}] {words}", i.low, i.high)
            }
            Some((ratio, None)) => format!("{ratio:.3} {}", Compared::Unknown.words()),
            None => "no valid times".into(),
        };
        let interval = times.start_ratio.and_then(|(_, interval)| interval);
        let start = match (Compared::of_interval(interval), times.start_s) {
            (Compared::Faster | Compared::Slower, [Some(without), Some(with)]) => {
                format!("{:+.1} ms", 1e3 * (with - without))
            }
            (Compared::Unknown, _) => "too few starts to compare".into(),
            (other, _) => other.words().into(),
        };
        [time, memory, start]
    }

    /// Median ratio of run times, for sorting: unknown ones are no difference.
    fn saved(&self) -> f64 {
        self.times.as_ref().and_then(|times| times.time_ratio).map_or(1.0, |(median, _)| median)
    }

    fn added_bytes(&self) -> i128 {
        i128::from(self.bytes[1].total()) - i128::from(self.bytes[0].total())
    }
}

/// Measures every item that the scene does not need, and all of them together. Each is measured at least as often as an
/// interval requires; after `time`, no other is, and if plans take long, none is planned.
///
/// # Errors
/// If one cannot be planned or run, or a run takes too long.
pub(super) fn costs(work: &Work<'_>, options: &Options, time: Duration) -> Result<Costs, Error> {
    let begin = Instant::now();
    let lean = work.plan(options)?;
    let items = Item::ALL.iter().filter(|&&item| !lean.plan.features.has(item));
    let keeps: Vec<Option<Item>> = std::iter::once(None).chain(items.map(|&item| Some(item))).collect();
    let count = keeps.len();
    let mut all = Costs::default();
    if count == 1 {
        return Ok(all);
    }
    let at_once = (MOST_BYTES / lean.plan.bytes().max(1)).clamp(1, AT_ONCE as u64) as usize;
    let is_slow = lean.build_s * count as f64 > time.as_secs_f64();
    for (group, keeps) in keeps.chunks(at_once).enumerate() {
        let is_over = group > 0 && begin.elapsed() > time;
        if is_over && is_slow {
            all.unplanned.extend(keeps.iter().flatten());
            continue;
        }
        let mut planned = Vec::new();
        for &item in keeps {
            let keep = item.map_or(Keep::ALL, Keep::only);
            let options = Options { keep, ..options.clone() };
            let with = work.plan(&options)?;
            let is_changed = is_changed(&lean.plan, &with.plan);
            let (because, reason) = reason(&lean.plan, item, is_changed);
            let bytes = [&lean, &with].map(|planned| Sizes::of(&planned.plan));
            let rays = lean.plan.rays;
            all.costs.push(Cost { item, because, reason, is_changed, rays, bytes, times: None });
            if work.machine().gpu().is_some() && is_changed && !is_over {
                planned.push((all.costs.len() - 1, options, with));
            }
        }
        if planned.is_empty() {
            continue;
        }
        let without = match group {
            0 => "omitted".to_owned(),
            _ => format!("omitted-{}", group + 1),
        };
        let first = Started { place: None, name: name(work, options, &without), options, planned: &lean, last: None };
        let others = planned.iter().map(|(place, options, planned)| {
            let name = name(work, options, all.costs[*place].name());
            Started { place: Some(*place), name, options, planned, last: None }
        });
        let mut started: Vec<Started<'_>> = std::iter::once(first).chain(others).collect();
        let share = time.mul_f64(keeps.len() as f64 / count as f64);
        for (place, times) in measure(work, &mut started, share)? {
            all.costs[place].times = Some(times);
        }
    }
    let rank = |cost: &Cost| (cost.item.is_some(), !cost.is_changed);
    all.costs.sort_by(|a, b| {
        let by_size = || b.added_bytes().cmp(&a.added_bytes());
        rank(a).cmp(&rank(b)).then(b.saved().total_cmp(&a.saved())).then_with(by_size)
    });
    Ok(all)
}

/// Why an item is omitted.
fn reason(plan: &Plan, item: Option<Item>, is_changed: bool) -> (Because, String) {
    let Some(item) = item else { return (Because::Scene, "all items together".into()) };
    match plan.left_out.iter().find(|left| left.item == Some(item)) {
        Some(left) => (left.because, left.reason.into()),
        None if is_changed => (Because::Scene, "the scene does not need it".into()),
        None => (Because::Options, "no kernel of this run has code for it".into()),
    }
}

/// Whether two plans compile or allocate anything else.
fn is_changed(a: &Plan, b: &Plan) -> bool {
    let sources = |plan: &Plan| plan.variants.iter().map(|v| (v.kernel, v.source.clone())).collect::<Vec<_>>();
    sources(a) != sources(b) || a.streams != b.streams || a.buffers != b.buffers
}

/// The id of a configuration.
fn name(work: &Work<'_>, options: &Options, what: &str) -> String {
    work.configuration(&[options.accelerator.name(), options.schedule.name(), what])
}

/// A configuration, started again and again.
struct Started<'a> {
    /// Index of its cost; `None` for the plan as it is.
    place: Option<usize>,
    name: String,
    options: &'a Options,
    planned: &'a Planned,
    /// The last renderer.
    last: Option<Renderer>,
}

/// Compares each with the first: about half of the time is for starts, the rest for runs.
fn measure(work: &Work<'_>, all: &mut [Started<'_>], time: Duration) -> Result<Vec<(usize, Measured)>, Error> {
    let turns = Turns {
        warmups: 0,
        repeats: STARTS,
        fewest: 2,
        all: Some(time.mul_f64(0.4)),
        each: None,
        seed: u64::from(work.seed()),
    };
    let (mut done, of) = (0, (STARTS * all.len()) as u64);
    let starts = in_turn(all, turns, |one| -> Result<Ended, Error> {
        work.reporter.part("starting", done, of);
        done += 1;
        // The memory of the old one is free before the new one takes its own.
        one.last = None;
        let built = work.wait(work.start(one.planned, one.options))?;
        one.last = Some(built.renderer);
        Ok(Ended::Done(Time { wall_ns: (built.start_s * 1e9) as u64, device_ns: None }))
    })?;
    for (one, times) in all.iter().zip(&starts) {
        record_starts(work, &one.name, &times.runs);
    }
    let names: Vec<String> = all.iter().map(|one| one.name.clone()).collect();
    let mut renderers: Vec<&mut Renderer> = all.iter_mut().filter_map(|one| one.last.as_mut()).collect();
    let Some(first) = renderers.first_mut() else { return Err(Error::NothingBuilt) };
    let begin = Instant::now();
    if work.wait(work.run(first))? == Ended::GivenUp {
        return Err(Error::GivenUp);
    }
    let round = begin.elapsed().mul_f64(renderers.len() as f64).max(Duration::from_nanos(1));
    let repeats = ((0.5 * time.as_secs_f64() / round.as_secs_f64()) as usize).clamp(interval::FEWEST, RUNS);
    let runs = work.wait(work.time_in_turn(&names, &mut renderers, repeats))?;
    if runs.iter().any(|times| times.is_given_up() || times.is_missing()) {
        return Err(Error::GivenUp);
    }
    let hits = renderers.iter().map(|renderer| work.wait(renderer.hits())).collect::<Result<Vec<_>, _>>()?;
    let seconds = |i: usize| -> Vec<f64> { starts[i].wall_ns().iter().map(|ns| ns / 1e9).collect() };
    let later = |i: usize| Times::of(seconds(i).into_iter().skip(1).map(Some).collect());
    let mut measured = Vec::new();
    for (i, place) in all.iter().enumerate().filter_map(|(i, one)| Some((i, one.place?))) {
        let times = Measured {
            first_start_s: [0, i].map(|i| seconds(i).first().copied().unwrap_or(f64::NAN)),
            start_s: [0, i].map(|i| later(i).median()),
            start_ratio: later(i).ratio(&later(0), work.seed()),
            run_ns: [0, i].map(|i| runs[i].median()),
            runs: runs[i].pairs(&runs[0]).count(),
            time_ratio: runs[i].ratio(&runs[0], work.seed()),
            without: names[0].clone(),
            differing: differing(&hits[0], &hits[i]),
        };
        measured.push((place, times));
    }
    Ok(measured)
}

/// Adds starts to the timed runs, as configurations of their own.
fn record_starts(work: &Work<'_>, name: &str, starts: &[Run]) {
    work.record.add_runs(starts.iter().map(|start| {
        work.row(RUN_COLUMNS)
            .set("section", work.section)
            .set("configuration", format!("{name}/start"))
            .set("round", start.round)
            .set("place", start.place)
            .set("time_ns", start.time.wall_ns)
            .set("wall_ns", start.time.wall_ns)
            .set("clock", "host")
    }));
}

/// Rays whose hits differ in any bit.
fn differing(a: &[Option<RayHit>], b: &[Option<RayHit>]) -> Vec<usize> {
    let bits = |hit: &Option<RayHit>| hit.map(|h| (h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.triangle));
    a.iter().zip(b).enumerate().filter(|(_, (a, b))| bits(a) != bits(b)).map(|(i, _)| i).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::interval::Method;

    #[test]
    fn a_hit_differs_by_a_bit() {
        let hit = RayHit { t: 1.0, u: 0.0, v: 0.5, triangle: 3 };
        let a = [Some(hit), None, Some(hit), Some(hit)];
        let b = [Some(RayHit { u: -0.0, ..hit }), None, None, Some(hit)];
        assert_eq!(differing(&a, &b), [0, 2]);
    }

    #[test]
    fn a_cost_says_what_cannot_be_distinguished() {
        let sizes = |buffers| Sizes { streams: 0, buffers };
        let interval = |low, high| Some(Interval { median: 1.04, low, high, level: 0.95, method: Method::Bootstrap });
        let times = |time: Option<Interval>, start: Option<Interval>| Measured {
            first_start_s: [0.2, 0.3],
            start_s: [Some(0.1), Some(0.18)],
            start_ratio: Some((1.8, start)),
            run_ns: [Some(1e6), Some(1.04e6)],
            runs: 20,
            time_ratio: Some((1.04, time)),
            without: String::new(),
            differing: Vec::new(),
        };
        let cost = |is_changed, bytes: [Sizes; 2], times| {
            let (because, reason) = (Because::Scene, "no spot light".to_owned());
            Cost { item: Some(Item::SpotLights), because, reason, is_changed, rays: 1, bytes, times }.in_words()
        };
        let (same, more) = ([sizes(2048); 2], [sizes(2048), sizes(14336)]);
        let sure = times(interval(1.02, 1.06), interval(1.7, 1.9));
        assert_eq!(cost(true, more, Some(sure.clone())), ["1.040 [1.020, 1.060] slower", "+12.0 KiB", "+80.0 ms"]);
        let unsure = times(interval(0.98, 1.06), interval(0.9, 1.9));
        let line = ["1.040 [0.980, 1.060] not distinguishable", "-12.0 KiB", "not distinguishable"];
        assert_eq!(cost(true, [more[1], more[0]], Some(unsure)), line);
        let few = Measured { runs: 4, ..times(None, None) };
        let line = ["1.040 too few runs to compare", "same", "too few starts to compare"];
        assert_eq!(cost(true, same, Some(few)), line);
        assert_eq!(cost(true, more, None), ["", "+12.0 KiB", ""]);
        assert_eq!(cost(false, same, None), ["no effect in this run", "", ""]);
    }
}
