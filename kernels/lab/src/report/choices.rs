//! The answer of a report: every structure, schedule and set of rules on the same rays, time against wrong rays.
//!
//! The rays are a random sample of what the camera sees, so that shares of wrong rays have exact bounds. Runs are
//! interleaved. Recommended is the fastest of the robust choices that are accurate. It is found in half of the rounds and
//! compared with the others in the other half, so that luck which made it the fastest does not enter the comparison; with
//! fewer than twelve rounds, all of them serve both.

mod figure;
mod strata;
mod table;
mod words;

use std::fmt;

use raystep_kernels::export::structure::structure_bytes;
use raystep_kernels::plan::Plan;
use raystep_kernels::{Accelerator, Numerics, Options, Ray, RaySource, Renderer, ScheduleKind};
use strata::{ALL, Strata};

use super::judge::{Judge, Judged};
use super::methods::Method;
use super::page::Part;
use super::times::{self, First, Times};
use super::work::{Built, Only, TESTS_PER_PASS, Work};
use crate::Error;
use crate::html::escaped;
use crate::human;
use crate::portions::Portions;
use crate::rays::view;
use crate::statistics::interval;
use crate::statistics::proportion::at_most;
use crate::tidy::fill::{self, Drawn};
use crate::tidy::{KEYS, RATIO, Row, TIMES, Table, VERDICTS, count, joined};
use crate::ways::{MISSES_OUTSIDE, numerics_of, share_outside};

const GROUPS: &[&[&str]] = &[
    KEYS,
    &[
        "method",
        "accelerator",
        "schedule",
        "numerics",
        "stratum",
        "rays",
        "ns_per_ray",
        "ns_per_ray_low",
        "ns_per_ray_high",
    ],
    TIMES,
    RATIO,
    &["is_recommended", "is_fastest", "is_front", "most_wrong_per_million", "is_accurate"],
    VERDICTS,
    &["undecided_per_million", "passes", "cells_per_ray", "tests_per_ray", "structure_bytes", "build_s"],
    &["witness_rays", "witness_error_by_bound", "witness_reference_error_by_bound"],
];

pub(super) const COLUMNS: &[&str] = &joined::<{ count(GROUPS) }>(GROUPS);

const SHOWN: &[&str] = &[
    "accelerator",
    "schedule",
    "numerics",
    "runs",
    "ns_per_ray",
    "ns_per_ray_low",
    "ns_per_ray_high",
    "time_ratio",
    "time_ratio_low",
    "time_ratio_high",
    "judged_rays",
    "wrong_rays",
    "missed",
    "false_hits",
    "wrong_hits",
    "undecided",
    "wrong_per_million_low",
    "wrong_per_million_high",
    "at_bound",
    "passes",
    "cells_per_ray",
    "tests_per_ray",
    "structure_bytes",
    "build_s",
    "witness_rays",
    "witness_error_by_bound",
    "witness_reference_error_by_bound",
];

const SHOWN_STRATA: &[&str] = &[
    "accelerator",
    "schedule",
    "numerics",
    "stratum",
    "judged_rays",
    "wrong_rays",
    "undecided",
    "wrong_per_million_low",
    "wrong_per_million_high",
];

/// Maximum number of tests in a run without an accelerator, in a quick report and in a full one.
const MOST_TESTS: [u64; 2] = [1 << 26, 1 << 28];

/// Most bytes of all choices together: they are timed in turn. A browser's module has 4 GiB for everything.
const MOST_BYTES: u64 = if cfg!(target_pointer_width = "32") { 1 << 30 } else { 4 << 30 };

/// Share of wrong rays, per million, up to which a choice is called accurate.
pub(super) const MOST_WRONG: f64 = 100.0;

/// Hits whose t is compared with rational arithmetic.
const WITNESSED: usize = 256;

/// A choice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Way {
    accelerator: Accelerator,
    schedule: ScheduleKind,
    numerics: Numerics,
}

impl Way {
    fn options(self, rays: &[Ray]) -> Options {
        let Self { accelerator, schedule, numerics } = self;
        let base = Options::new(RaySource::Given(rays.to_vec()));
        let steps = if accelerator == Accelerator::None { TESTS_PER_PASS } else { base.steps_per_pass };
        Options { accelerator, schedule, numerics, steps_per_pass: steps, shade: false, ..base }
    }

    fn id(self, work: &Work<'_>) -> String {
        work.configuration(&[self.accelerator.name(), self.schedule.name(), self.numerics.name()])
    }
}

impl fmt::Display for Way {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {} {}", self.accelerator, self.schedule, self.numerics)
    }
}

/// Every structure with every schedule, by robust and by the paper's rules, but for what is not wanted.
fn ways(is_quick: bool, only: &Only) -> Vec<Way> {
    use Accelerator::{Bvh, Grid, Irregular, None};
    let mut ways = Vec::new();
    for accelerator in [Grid, Irregular, Bvh, None].into_iter().filter(|&accelerator| only.has(accelerator)) {
        for &numerics in numerics_of(accelerator) {
            for &schedule in ScheduleKind::ALL.iter().filter(|&&schedule| only.has_schedule(schedule)) {
                // Without a grid or BVH, `second` is the same as `first`; with them, `first` is the slower of the two.
                let unlike = if accelerator == None { ScheduleKind::Second } else { ScheduleKind::First };
                let is_slow = matches!(schedule, ScheduleKind::First | ScheduleKind::Second);
                let is_named = only.schedules.contains(&schedule);
                if schedule != unlike && (is_named || !(is_quick && is_slow && accelerator != Grid)) {
                    ways.push(Way { accelerator, schedule, numerics });
                }
            }
        }
    }
    // If there is no room or time for all of them, the slowest are missing: by schedule, then by how long they take to
    // build or run.
    let by_schedule = |way: &Way| match way.schedule {
        ScheduleKind::Fused => 0,
        ScheduleKind::Compact => 1,
        ScheduleKind::First | ScheduleKind::Second => 2,
    };
    let by_structure = |way: &Way| [Bvh, Grid, Irregular, None].iter().position(|a| *a == way.accelerator);
    ways.sort_by_key(|way| (by_schedule(way), by_structure(way)));
    ways
}

/// A choice that was built and timed.
struct Measured {
    way: Way,
    built: Built,
    times: Times,
    judged: Judged,
}

pub(super) async fn run(work: &Work<'_>, table: &mut Table) -> Result<Part, Error> {
    let mut part = Part::default();
    if work.subject.scene.triangles.is_empty() {
        let name = escaped(&work.subject.scene.name);
        part.lead.push(format!("{name}: the scene has no triangles, so there is nothing to compare."));
        return Ok(part);
    }
    let begin = table.rows.len();
    let rays = match work.rays {
        Some(file) => file.in_scene(&work.subject.scene),
        None => view(&work.subject.camera, work.size.width, work.size.height, work.seed()),
    };
    let strata = Strata::new(work);
    let mut ready = first_runs(work, &rays, &mut part).await?;
    let of_paper = |one: &&Ready| (one.way.accelerator, one.way.numerics) == (Accelerator::Grid, Numerics::Paper);
    let outside = ready.iter().find(of_paper).and_then(|one| share_outside(&rays, one.built.renderer.data()));
    part.notes.extend(outside.map(|share| format!("{MISSES_OUTSIDE}; here {share} rays do")));
    work.stage("timing choices");
    let names: Vec<String> = ready.iter().map(|one| one.way.id(work)).collect();
    let firsts: Vec<First> = ready.iter().map(|one| one.first).collect();
    let mut renderers: Vec<&mut Renderer> = ready.iter_mut().map(|one| &mut one.built.renderer).collect();
    let repeats = work.either(12, 24);
    let times = work.time_after(&firsts, &names, &mut renderers, interval::FEWEST, repeats).await?;
    part.notes.extend(times::notes(work, ready.iter().map(|one| one.way.to_string()).zip(&times)));
    work.stage("judging choices");
    let mut judge = Judge::default();
    let mut measured = Vec::new();
    for (Ready { way, built, .. }, times) in ready.into_iter().zip(times) {
        let judged = judge.judge(work, &built.renderer).await?;
        part.notes.extend(times.is_given_up().then(|| format!("{way}: {}", judged.given_up())));
        judge.record(work, &built.renderer, &judged, &way.id(work), |ray| strata.of(ray));
        measured.push(Measured { way, built, times, judged });
    }
    let limit = limit(&measured);
    table.rows.extend(all_rows(work, &rays, &judge, &measured, limit).await);
    let scene = &work.subject.scene.name;
    let own = work.methods.iter().filter(|m| m.scene.is_empty() || m.scene == *scene);
    table.rows.extend(own.map(|method| own_row(work, method, limit)));
    compare_own(&mut table.rows[begin..]);
    mark(&mut table.rows[begin..]);
    let last = table.rows.len();
    for m in &measured {
        table.rows.extend(strata.rows(work, &judge, m));
    }
    let (rows, of_strata) = (&table.rows[begin..last], &table.rows[last..]);
    words::say(work, rows, outside, &mut part);
    let is_file = work.rays.is_some();
    part.lead_figure("precision", figure::of(rows, is_file), figure::caption(rows, is_file));
    table::add(rows, is_halved(&measured), &mut part);
    part.table(rows, SHOWN);
    part.table(of_strata, SHOWN_STRATA);
    Ok(part)
}

/// A choice that has run once.
struct Ready {
    way: Way,
    built: Built,
    first: First,
}

/// Shows the choices so far, with the time of one run each.
fn show(work: &Work<'_>, ready: &[Ready]) {
    let row = |one: &Ready| {
        let rays = one.built.renderer.plan().rays.max(1) as f64;
        let time = match one.first.time().and_then(|time| work.ns(time)) {
            Some(ns) => human::time(ns / rays),
            None => "stopped".into(),
        };
        vec![one.way.to_string(), time]
    };
    work.reporter.rows(&["choice", "time per ray, one run"], &ready.iter().map(row).collect::<Vec<_>>());
}

/// Builds and runs every choice once, as long as there is time.
async fn first_runs(work: &Work<'_>, rays: &[Ray], part: &mut Part) -> Result<Vec<Ready>, Error> {
    let (mut ready, mut left_out): (Vec<Ready>, Vec<String>) = (Vec::new(), Vec::new());
    let ways = ways(work.is_quick, work.only);
    for (done, &way) in (0..).zip(&ways) {
        if work.is_past(times::FOR_FIRST_RUNS) {
            left_out.push(way.to_string());
            continue;
        }
        work.stage(&format!("building {way}"));
        work.reporter.part("choices built and run", done, ways.len() as u64);
        match build(work, way, rays, &ready, part).await {
            Ok(Some(mut built)) => {
                let first = work.first_run(&mut built.renderer).await?;
                if first.is_missing() {
                    left_out.push(way.to_string());
                } else {
                    ready.push(Ready { way, built, first });
                    show(work, &ready);
                }
            }
            Ok(None) => {}
            Err(error) => {
                work.can_go_on()?;
                part.notes.push(format!("{way}: {}", work.explain(&error)));
            }
        }
    }
    part.notes.extend(work.left_out(&left_out));
    Ok(ready)
}

/// Builds a choice, unless it would take too long or too much memory beside those that are already `built`.
async fn build(
    work: &Work<'_>,
    way: Way,
    rays: &[Ray],
    built: &[Ready],
    part: &mut Part,
) -> Result<Option<Built>, Error> {
    let mut note = |text: String| {
        if !part.notes.contains(&text) {
            part.notes.push(text);
        }
    };
    let tests = work.subject.scene.triangles.len().saturating_mul(rays.len()) as u64;
    if way.accelerator == Accelerator::None && tests > work.either(MOST_TESTS[0], MOST_TESTS[1]) {
        note(format!("none, left out: testing every triangle for each of {} rays takes too long", rays.len()));
        return Ok(None);
    }
    let options = way.options(rays);
    let planned = work.plan(&options)?;
    let bytes = |plan: &Plan| plan.bytes() + size_of_val(rays) as u64;
    let before: u64 = built.iter().map(|one| bytes(one.built.renderer.plan())).sum();
    if before + bytes(&planned.plan) > MOST_BYTES && !built.is_empty() {
        note(format!("{way}: the choices together would take more than {} GiB", MOST_BYTES >> 30));
        return Ok(None);
    }
    Ok(Some(work.start(&planned, &options).await?))
}

/// The share of wrong rays up to which a choice is called accurate: [`MOST_WRONG`], or what the judged rays can show.
fn limit(measured: &[Measured]) -> f64 {
    // A run that was stopped has fewer judged rays, and is not accurate in any case.
    let is_over = |m: &&Measured| m.judged.at_bound == 0;
    let shown = |m: &Measured| at_most(0, m.judged.counts.rays()).map(|high| 1e6 * high);
    measured.iter().filter(is_over).filter_map(shown).fold(MOST_WRONG, f64::max)
}

/// Fewest rounds of which one half chooses the fastest and the other compares: both have an interval.
const FEWEST_TO_HALVE: usize = 2 * interval::FEWEST;

/// Two of four rounds, of which one is the reverse of the other: the fastest choice is found in these.
fn is_for_choosing(round: usize) -> bool {
    round % 4 < 2
}

/// Whether there are enough rounds to find the fastest in one half and compare in the other.
fn is_halved(measured: &[Measured]) -> bool {
    measured.iter().all(|m| !m.times.is_timed() || m.times.rounds() >= FEWEST_TO_HALVE)
}

/// The rows, with their comparisons.
async fn all_rows(work: &Work<'_>, rays: &[Ray], judge: &Judge, measured: &[Measured], limit: f64) -> Vec<Row> {
    let mut rows = Vec::new();
    for m in measured {
        rows.push(row(work, rays, judge, m, limit).await);
    }
    // With fewer rounds, all of them serve both.
    let has_halves = is_halved(measured);
    let choosing = |m: &Measured| m.times.in_rounds(|round| !has_halves || is_for_choosing(round));
    let chosen_by = |i: usize| choosing(&measured[i]).median().filter(|_| measured[i].times.is_timed());
    let can_be = |i: usize| words::is_robust(&rows[i]) && words::is_accurate(&rows[i]);
    let times = (0..rows.len()).filter(|&i| can_be(i)).filter_map(|i| Some((i, chosen_by(i)?)));
    let best = times.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i);
    if let Some(best) = best {
        let name = measured[best].way.id(work);
        let rest = |m: &Measured| m.times.in_rounds(|round| !has_halves || !is_for_choosing(round));
        let to = rest(&measured[best]);
        let mut portions = Portions::new();
        for (i, row) in rows.iter_mut().enumerate() {
            portions.rest().await;
            if measured[i].times.is_timed() {
                *row = rest(&measured[i]).fill_ratio(&to, &name, row.clone(), work.seed());
            }
            *row = row.clone().set("is_recommended", i == best);
        }
    }
    rows
}

/// The row of a method of another program.
fn own_row(work: &Work<'_>, method: &Method, limit: f64) -> Row {
    let row = work
        .row(COLUMNS)
        .set("configuration", work.configuration(&["own", &method.method]))
        .set("method", &*method.method)
        .set("stratum", ALL)
        .set("ns_per_ray", method.ns_per_ray)
        .set("ns_per_ray_low", method.ns_per_ray_low)
        .set("ns_per_ray_high", method.ns_per_ray_high)
        .set("undecided", method.undecided)
        .set("undecided_per_million", fill::per_million(method.undecided, method.judged_rays))
        .set("most_wrong_per_million", limit)
        .set("is_recommended", false);
    let row = fill::shares(row, method.wrong_rays, method.judged_rays, Drawn::AtRandom);
    let is_accurate = is_within_limit(&row);
    row.set("is_accurate", is_accurate)
}

/// Whether the upper bound of wrong rays is at most the limit: both as they are written, with the same digits.
fn is_within_limit(row: &Row) -> bool {
    let ends = row.number("wrong_per_million_high").zip(row.number("most_wrong_per_million"));
    ends.is_some_and(|(high, most)| high <= most)
}

/// Fills the ratios of other programs' methods to the recommended choice. Their runs have no pairs: the ratio is that of
/// the times, and its interval what both intervals allow.
fn compare_own(rows: &mut [Row]) {
    const TIMES: [&str; 3] = ["ns_per_ray", "ns_per_ray_low", "ns_per_ray_high"];
    let Some(best) = rows.iter().find(|row| row.get("is_recommended") == "true").cloned() else { return };
    let of_best = TIMES.map(|column| best.number(column).filter(|ns| *ns > 0.0));
    for row in rows.iter_mut().filter(|row| words::is_own(row)) {
        let of_own = TIMES.map(|column| row.number(column));
        let ratio = |own: usize, ours: usize| Some(of_own[own]? / of_best[ours]?);
        // An interval needs all four ends.
        let ends = ratio(1, 2).zip(ratio(2, 1));
        *row = row
            .clone()
            .set("ratio_to", best.get("configuration"))
            .set("time_ratio", ratio(0, 0))
            .set("time_ratio_low", ends.map(|(low, _)| low))
            .set("time_ratio_high", ends.map(|(_, high)| high));
    }
}

/// Marks the fastest of all accurate choices, and the front.
fn mark(rows: &mut [Row]) {
    let front = front(rows);
    let fastest = words::quickest(rows, &[("is_accurate", "true")]).map(|row| row.get("configuration").to_owned());
    for (row, is_front) in rows.iter_mut().zip(front) {
        let is_fastest = fastest.as_deref() == Some(row.get("configuration"));
        *row = row.clone().set("is_front", is_front).set("is_fastest", is_fastest);
    }
}

/// Whether no other choice is faster and not more often wrong, or as fast and less often wrong.
fn front(rows: &[Row]) -> Vec<bool> {
    let at = |row: &Row| Some((row.number("ns_per_ray")?, row.number("wrong_per_million")?));
    let is_front = |row: &Row| {
        at(row).is_some_and(|(ns, wrong)| {
            !rows.iter().filter_map(at).any(|(n, w)| n <= ns && w <= wrong && (n < ns || w < wrong))
        })
    };
    rows.iter().map(is_front).collect()
}

async fn row(work: &Work<'_>, rays: &[Ray], judge: &Judge, m: &Measured, limit: f64) -> Row {
    let Measured { way, built, times, judged } = m;
    let plan = built.renderer.plan();
    let sums = work.machine().counts(&work.subject.scene, &way.options(rays)).await;
    let per_ray = |sum: u64| (plan.rays > 0).then(|| sum as f64 / plan.rays as f64);
    let row = work
        .row(COLUMNS)
        .set("configuration", way.id(work))
        .set("accelerator", way.accelerator.name())
        .set("schedule", way.schedule.name())
        .set("numerics", way.numerics.name())
        .set("stratum", ALL)
        .set("rays", plan.rays)
        .set("clock", work.clock())
        .set("passes", built.renderer.pass_count())
        .set("cells_per_ray", sums.as_ref().and_then(|sums| per_ray(sums.cells_visited)))
        .set("tests_per_ray", sums.as_ref().and_then(|sums| per_ray(sums.triangles_tested)))
        .set("structure_bytes", structure_bytes(plan))
        .set("build_s", built.build_s)
        .set("most_wrong_per_million", limit);
    let row = judged.fill(times.fill(row, work.seed()), Drawn::AtRandom);
    let undecided = fill::per_million(judged.counts.ties, judged.counts.rays());
    let of_ray = |column: &str| row.number(column).filter(|_| plan.rays > 0).map(|ns| ns / plan.rays as f64);
    let (ns, low, high) = (of_ray("median_ns"), of_ray("low_ns"), of_ray("high_ns"));
    let is_accurate = judged.at_bound == 0 && is_within_limit(&row);
    let witness = judge.witness(judged, &built.renderer, WITNESSED).await;
    row.set("ns_per_ray", ns)
        .set("ns_per_ray_low", low)
        .set("ns_per_ray_high", high)
        .set("undecided_per_million", undecided)
        .set("is_accurate", is_accurate)
        .set("witness_rays", witness.rays)
        .set("witness_error_by_bound", witness.error_by_bound)
        .set("witness_reference_error_by_bound", witness.reference_error_by_bound)
}
