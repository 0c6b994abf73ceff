//! Rays resolved, and rays resolved wrongly, over time and per pass.
//!
//! Every configuration runs twice: once with timed passes and no read-back, and once pass by pass, reading after each
//! pass which rays are resolved. Kernels are deterministic, so both runs have the same passes. The hit of a resolved
//! ray does not change any more, so each ray is judged once, at the end.

use std::ops::ControlFlow;
use std::time::Instant;

use raystep_kernels::tables::stream::STATE_TAG;
use raystep_kernels::{Accelerator, Numerics, Options, Pass, Renderer, ScheduleKind};

use super::judge::Judge;
use super::page::{Part, number};
use super::work::{TESTS_PER_PASS, Work};
use crate::Error;
use crate::meter::Ended;
use crate::plots::{Axis, Mark, Plot, Scale, Series, Stroke};
use crate::reference::Verdict;
use crate::statistics::median;
use crate::tidy::{KEYS, Row, Table, count, joined};
use crate::ways::{MISSES_ALL, misses_all};

const GROUPS: &[&[&str]] = &[
    KEYS,
    &[
        "accelerator",
        "schedule",
        "numerics",
        "rays",
        "judged_rays",
        "pass_index",
        "kernel",
        "time_ns",
        "resolved_rays",
        "judged_resolved_rays",
        "judged_wrong_rays",
        "judged_undecided_rays",
        "is_last",
        "run_ns",
        "run_ratio",
        "clock",
    ],
];

pub(super) const COLUMNS: &[&str] = &joined::<{ count(GROUPS) }>(GROUPS);

const SHOWN: &[&str] = &[
    "accelerator",
    "schedule",
    "numerics",
    "pass_index",
    "time_ns",
    "run_ns",
    "run_ratio",
    "rays",
    "resolved_rays",
    "judged_rays",
    "judged_wrong_rays",
    "judged_undecided_rays",
];

/// Maximum number of tests in a run without an accelerator.
const MOST_TESTS: u64 = 1 << 28;

#[derive(Clone, Copy)]
struct Way {
    accelerator: Accelerator,
    schedule: ScheduleKind,
    numerics: Numerics,
}

/// Every configuration, and the paper's numerics with its own faster schedule.
fn ways() -> Vec<Way> {
    use Accelerator::{Bvh, Grid, None};
    let mut ways = Vec::new();
    for accelerator in [Grid, Bvh, None] {
        for &schedule in ScheduleKind::ALL {
            // Without a grid or BVH, `second` is the same as `first`.
            if accelerator != None || schedule != ScheduleKind::Second {
                ways.push(Way { accelerator, schedule, numerics: Numerics::Robust });
            }
        }
        let schedule = if accelerator == None { ScheduleKind::First } else { ScheduleKind::Second };
        ways.push(Way { accelerator, schedule, numerics: Numerics::Paper });
    }
    ways
}

pub(super) fn run(work: &Work<'_>, table: &mut Table) -> Result<Part, Error> {
    let mut part = Part::default();
    let first = table.rows.len();
    let mut judge = Judge::default();
    for way in ways() {
        let what = format!("{} {} {}", way.accelerator, way.schedule, way.numerics);
        work.stage(&format!("resolution of rays, {what}"));
        match one(work, way, &mut judge, &mut part) {
            Ok(Ok(rows)) => table.rows.extend(rows),
            Ok(Err(reason)) => part.notes.push(format!("{what}: {reason}")),
            Err(error) => {
                work.can_go_on()?;
                part.notes.push(format!("{what}: {}", work.explain(&error)));
            }
        }
    }
    let rows = &mut table.rows[first..];
    // Only robust numerics: the paper's may be fast by missing everything.
    let robust = rows.iter().filter(|r| r.get("numerics") == "robust");
    let fastest = robust.filter_map(|r| r.number("run_ns")).fold(f64::INFINITY, f64::min);
    for row in rows.iter_mut() {
        let ratio = row.number("run_ns").filter(|_| fastest.is_finite()).map(|ns| ns / fastest);
        *row = row.clone().set("run_ratio", ratio);
    }
    let rows = &table.rows[first..];
    for accelerator in ["grid", "bvh", "none"] {
        part.figure(accelerator, resolved_plot(accelerator, rows).svg()?, "");
    }
    let wrong = wrong_plot(rows);
    if rows.iter().any(|r| r.number("judged_wrong_rays").is_some_and(|n| n > 0.0)) {
        part.figure("wrong", wrong.svg()?, "");
    }
    part.table(rows.iter().filter(|r| r.get("is_last") == "true"), SHOWN);
    let robust = rows.iter().filter(|r| r.is(&[("is_last", "true"), ("numerics", "robust")]));
    let most_wrong = robust.max_by_key(|r| r.number("judged_wrong_rays").unwrap_or(0.0) as u64);
    if let Some(row) = most_wrong {
        part.prose.push(format!(
            "With robust numerics, at most {} of {} judged rays were resolved wrongly.",
            number("judged_wrong_rays", row),
            number("judged_rays", row)
        ));
    }
    part.prose.push(format!(
        "Times are {}; ratios are relative to the fastest configuration with robust numerics in this table.",
        work.clock_in_words()
    ));
    Ok(part)
}

/// The rows of a configuration, or why there are none.
fn one(work: &Work<'_>, way: Way, judge: &mut Judge, part: &mut Part) -> Result<Result<Vec<Row>, String>, Error> {
    let Way { accelerator, schedule, numerics } = way;
    let (triangles, rays) = (work.subject.scene.triangles.len() as u64, u64::from(work.size.width * work.size.height));
    if accelerator == Accelerator::None && triangles.saturating_mul(rays) > MOST_TESTS {
        return Ok(Err(format!("testing {triangles} triangles for each of {rays} rays takes too long")));
    }
    let options = Options {
        accelerator,
        schedule,
        numerics,
        // A fused kernel that does not shade generates its rays itself, so they could not be read.
        shade: schedule == ScheduleKind::Fused,
        timings: true,
        ..Options::new(work.camera_rays())
    };
    let options = match accelerator {
        Accelerator::None => Options { steps_per_pass: TESTS_PER_PASS, ..options },
        _ => options,
    };
    let planned = work.plan(&options)?;
    let mut timed = work.start(&planned, &options)?.renderer;
    if misses_all(&work.subject.scene, &options, timed.plan()) {
        part.notes.push(MISSES_ALL.into());
    }
    let given_up = || Ok(Err("stopped: too slow, or endless".into()));
    let Some(Timed { passes, ends_ns, run_ns }) = timed_passes(work, &mut timed)? else { return given_up() };
    if ends_ns.contains(&None) {
        part.notes.push(format!("{accelerator} {schedule} {numerics}: some passes have no valid time"));
    }
    // Timing passes costs several microseconds each, so the total comes from runs without it.
    let run_ns = match work.machine().gpu() {
        None => run_ns,
        Some(_) => {
            let mut plain = work.start(&planned, &Options { timings: false, ..options })?.renderer;
            let name = work.configuration(&[accelerator.name(), schedule.name(), numerics.name()]);
            let times = work.time_in_turn(&[name], &mut [&mut plain], work.either(3, 5))?;
            if times[0].is_given_up {
                return given_up();
            }
            times[0].median()
        }
    };
    let read = read_back(work, &mut timed, &passes, judge)?;
    let judged = judge.judge(work, &timed)?;
    let last = read.len().saturating_sub(1);
    let row = |(i, r): (usize, &ReadBack)| {
        let resolved = judged.verdicts.iter().zip(&r.is_resolved).filter(|(_, is)| **is);
        let resolved: Vec<Verdict> = resolved.filter_map(|(verdict, _)| *verdict).collect();
        let count = |is: fn(Verdict) -> bool| resolved.iter().filter(|v| is(**v)).count();
        work.row(COLUMNS)
            .set("configuration", work.configuration(&[accelerator.name(), schedule.name(), numerics.name()]))
            .set("accelerator", accelerator.name())
            .set("schedule", schedule.name())
            .set("numerics", numerics.name())
            .set("rays", timed.plan().rays)
            .set("judged_rays", judged.counts.rays())
            .set("pass_index", r.pass)
            .set("kernel", passes[r.pass].kernel.name())
            .set("time_ns", ends_ns[r.pass])
            .set("resolved_rays", passes[r.pass].kernel.program().states.decided(&passes[r.pass].counts))
            .set("judged_resolved_rays", resolved.len())
            .set("judged_wrong_rays", count(Verdict::is_error))
            .set("judged_undecided_rays", count(|v| v == Verdict::Tie))
            .set("is_last", i == last)
            .set("run_ns", run_ns)
            .set("clock", work.clock())
    };
    Ok(Ok(read.iter().enumerate().map(row).collect()))
}

/// A run with timed passes.
struct Timed {
    passes: Vec<Pass>,
    /// When each pass ended, in nanoseconds from the start of the first; `None` if unknown.
    ends_ns: Vec<Option<f64>>,
    /// The median of all runs.
    run_ns: Option<f64>,
}

/// Of three runs, the one with the median time of the last pass; `None` if one was stopped.
fn timed_passes(work: &Work<'_>, renderer: &mut Renderer) -> Result<Option<Timed>, Error> {
    let has_clock = work.machine().timer().times_passes();
    let mut runs: Vec<(Vec<Pass>, Vec<Option<f64>>)> = Vec::new();
    let mut run_ns = Vec::new();
    for run in 0..4 {
        let Ended::Done(time) = work.run(renderer)? else { return Ok(None) };
        let ends = if has_clock { ends_of(renderer.passes()) } else { by_wall_clock(work, renderer)? };
        // The first run warms up.
        if run > 0 {
            run_ns.extend(work.ns(time));
            runs.push((renderer.passes().to_vec(), ends));
        }
    }
    let last = |run: &(Vec<Pass>, Vec<Option<f64>>)| run.1.last().copied().flatten().unwrap_or(f64::INFINITY);
    runs.sort_by(|a, b| last(a).total_cmp(&last(b)));
    let run_ns = median(&run_ns);
    Ok(runs.into_iter().nth(1).map(|(passes, ends_ns)| Timed { passes, ends_ns, run_ns }))
}

/// When each pass ended, from the start of the first. Some clocks are set back between two submissions: passes have no
/// time from then on until the clock has caught up.
fn ends_of(passes: &[Pass]) -> Vec<Option<f64>> {
    let first = passes.first().and_then(|pass| pass.begin_ns);
    let mut latest = 0;
    let end = |pass: &Pass| {
        let since = (pass.begin_ns? + pass.duration_ns?).checked_sub(first?)?;
        let is_later = since >= latest;
        latest = latest.max(since);
        is_later.then_some(since as f64)
    };
    passes.iter().map(end).collect()
}

/// The same for devices without a reliable clock: waits for each pass.
fn by_wall_clock(work: &Work<'_>, renderer: &mut Renderer) -> Result<Vec<Option<f64>>, Error> {
    renderer.restart();
    work.machine().settle();
    let mut ends = Vec::new();
    let begin = Instant::now();
    while work.machine().wait(renderer.step())?.is_some() {
        ends.push(Some(begin.elapsed().as_nanos() as f64));
    }
    Ok(ends)
}

/// State of the sample after a pass that resolved rays.
struct ReadBack {
    pass: usize,
    /// One per ray of the sample.
    is_resolved: Vec<bool>,
}

/// Which rays of the sample are resolved, after each pass that resolves any.
fn read_back(
    work: &Work<'_>,
    renderer: &mut Renderer,
    passes: &[Pass],
    judge: &mut Judge,
) -> Result<Vec<ReadBack>, Error> {
    // Judging chooses the sample; it needs the streams of a finished run.
    judge.judge(work, renderer)?;
    let mut read: Vec<ReadBack> = Vec::new();
    let mut before = 0;
    renderer.restart();
    for (index, pass) in passes.iter().enumerate() {
        let now = pass.kernel.program().states.decided(&pass.counts);
        let is_last = index + 1 == passes.len();
        if now == before && !is_last {
            continue;
        }
        work.reporter.part("reading back", index as u64, passes.len() as u64);
        work.machine().wait(renderer.run_to(index + 1, |_| ControlFlow::Continue(())))?;
        if now != before || is_last {
            let tags = work.machine().wait(renderer.values(renderer.results()?.t.stream))?;
            let is_done = |&ray: &usize| renderer.plan().program.states.is_decided(tags.get(STATE_TAG, ray));
            read.push(ReadBack { pass: index, is_resolved: judge.sample().iter().map(is_done).collect() });
        }
        before = now;
    }
    Ok(read)
}

fn curve(row: &[&Row], y: impl Fn(&Row) -> Option<f64>) -> Vec<(f64, f64)> {
    row.iter().filter_map(|r| Some((r.number("time_ns")? / 1e6, y(r)?))).collect()
}

/// Starts the curve at zero, up to the first pass that changes it.
fn from_zero(points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let begin = points.first().map(|p| (p.0, 0.0));
    begin.into_iter().chain(points).collect()
}

fn rows_of<'a>(rows: &'a [Row], wanted: &[(&str, &str)]) -> Vec<&'a Row> {
    rows.iter().filter(|r| r.is(wanted)).collect()
}

fn resolved_plot(accelerator: &str, rows: &[Row]) -> Plot {
    let share = |r: &Row| Some(100.0 * r.number("resolved_rays")? / r.number("rays").filter(|&n| n > 0.0)?);
    let ways = [("first", "robust"), ("second", "robust"), ("compact", "robust"), ("fused", "robust")];
    let paper = [("first", "paper"), ("second", "paper")];
    let series = ways.iter().chain(&paper).enumerate().filter_map(|(i, &(schedule, numerics))| {
        let of_way = [("accelerator", accelerator), ("schedule", schedule), ("numerics", numerics)];
        let is_point = schedule == "fused";
        let points = curve(&rows_of(rows, &of_way), share);
        // `fused` resolves all rays in one pass; it does not matter that it shades them afterwards.
        let points =
            if is_point { points.into_iter().filter(|p| p.1 > 0.0).take(1).collect() } else { from_zero(points) };
        let name = if numerics == "paper" { format!("{schedule}, paper's rules") } else { schedule.to_owned() };
        let mark = if is_point { Mark::Square } else { Mark::None };
        let stroke = if is_point { Stroke::None } else { Stroke::Steps };
        (!points.is_empty()).then(|| Series { name, points, whiskers: Vec::new(), color: i.min(4), mark, stroke })
    });
    Plot {
        title: format!("Resolved rays, {accelerator}"),
        x: Axis::new("time since the start, ms", Scale::Log),
        y: Axis::new("resolved rays, %", Scale::Linear),
        series: series.collect(),
        places: Vec::new(),
    }
}

fn wrong_plot(rows: &[Row]) -> Plot {
    let wrong = |r: &Row| {
        let (wrong, judged) = (r.number("judged_wrong_rays")?, r.number("judged_rays").filter(|&n| n > 0.0)?);
        Some(1e6 * wrong / judged)
    };
    let mut series = Vec::new();
    for (color, accelerator) in ["grid", "bvh", "none"].into_iter().enumerate() {
        for (numerics, schedules, stroke) in
            [("paper", &["first", "second"][..], Stroke::Steps), ("robust", &["compact"], Stroke::Dashed)]
        {
            for schedule in schedules {
                let of_way = [("accelerator", accelerator), ("schedule", schedule), ("numerics", numerics)];
                let points = from_zero(curve(&rows_of(rows, &of_way), wrong));
                let name = format!("{accelerator} {schedule}, {numerics}");
                if !points.is_empty() {
                    series.push(Series { name, points, whiskers: Vec::new(), color, mark: Mark::None, stroke });
                }
            }
        }
    }
    Plot {
        title: "Rays resolved wrongly".into(),
        x: Axis::new("time since the start, ms", Scale::Log),
        y: Axis::new("wrong per million judged", Scale::LogWithZero),
        series,
        places: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use raystep_kernels::programs::closest_hit::kernels;
    use raystep_kernels::tables::state;

    use super::*;

    #[test]
    fn passes_end_since_the_first_began_and_times_that_are_not_known_are_not_0() {
        let pass = |begin_ns, duration_ns| Pass {
            index: 0,
            iteration: 0,
            kernel: kernels::SETUP,
            rays_in: 0,
            counts: state::StateCounts::default(),
            threads_launched: 0,
            begin_ns,
            duration_ns,
        };
        // The third has no time; the fourth is from a clock that was set back.
        let times =
            [(Some(100), Some(10)), (Some(150), Some(10)), (None, None), (Some(20), Some(5)), (Some(170), Some(1))];
        let passes = times.map(|(begin, duration)| pass(begin, duration));
        assert_eq!(ends_of(&passes), [Some(10.0), Some(60.0), None, None, Some(71.0)]);
        assert_eq!(ends_of(&[pass(None, Some(3))]), [None]);
    }
}
