//! Rays resolved, and rays resolved wrongly, over time, pass by pass.
//!
//! Two runs of each way: one whose passes are timed and nothing is read, and one that goes pass by pass and reads after
//! each which rays are resolved. Kernels are deterministic, so both have the same passes. A resolved ray's hit does not
//! change any more: each ray is judged once, at the end.

use std::ops::ControlFlow;
use std::time::Instant;

use raystep_kernels::reference::Verdict;
use raystep_kernels::state::{self, StateCounts};
use raystep_kernels::statistics::quantile;
use raystep_kernels::stream::STATE_TAG;
use raystep_kernels::{Accelerator, Numerics, Options, Pass, Renderer, ScheduleKind, Stream};

use super::judge::{Judge, is_error};
use super::page::{Part, number};
use super::table::{Row, Table};
use super::work::Work;
use crate::commands::plot::{Axis, Mark, Plot, Scale, Series, Stroke};
use crate::error::Error;
use crate::session::{MISSES_ALL, misses_all};

pub(super) const COLUMNS: &[&str] = &[
    "schema_version",
    "scene",
    "adapter",
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
];

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

/// Most tests of a run without an accelerator.
const MOST_TESTS: u64 = 1 << 28;

#[derive(Clone, Copy)]
struct Way {
    accelerator: Accelerator,
    schedule: ScheduleKind,
    numerics: Numerics,
}

/// Every way, and the paper's rules with its own faster schedule.
fn ways() -> Vec<Way> {
    use Accelerator::{Bvh, Grid, None};
    let mut ways = Vec::new();
    for accelerator in [Grid, Bvh, None] {
        for &schedule in ScheduleKind::ALL {
            // Without cells to walk through there are no turns to take, and second is first.
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
                part.notes.push(format!("{what}: {}", error.message()));
            }
        }
    }
    let rows = &mut table.rows[first..];
    // The paper's rules may be fast by missing everything.
    let robust = rows.iter().filter(|r| r.get("numerics") == "robust");
    let fastest = robust.filter_map(|r| r.number("run_ns")).fold(f64::INFINITY, f64::min);
    for row in rows.iter_mut() {
        let ratio = row.number("run_ns").map(|ns| ns / fastest);
        *row = row.clone().set("run_ratio", ratio);
    }
    let rows = &table.rows[first..];
    for accelerator in ["grid", "bvh", "none"] {
        part.figure(resolved_plot(accelerator, rows).svg()?, "");
    }
    let wrong = wrong_plot(rows);
    if rows.iter().any(|r| r.number("judged_wrong_rays").is_some_and(|n| n > 0.0)) {
        part.figure(wrong.svg()?, "");
    }
    part.table(rows.iter().filter(|r| r.get("is_last") == "true"), SHOWN);
    let robust = rows.iter().filter(|r| r.is(&[("is_last", "true"), ("numerics", "robust")]));
    let most_wrong = robust.max_by_key(|r| r.number("judged_wrong_rays").unwrap_or(0.0) as u64);
    if let Some(row) = most_wrong {
        part.prose.push(format!(
            "By robust rules at most {} of {} judged rays were resolved wrongly.",
            number(row.get("judged_wrong_rays")),
            number(row.get("judged_rays"))
        ));
    }
    part.prose.push(format!(
        "Times are of {}; ratios are to the fastest way by robust rules in this table.",
        work.clock_in_words()
    ));
    Ok(part)
}

/// The rows of a way, or why there are none.
fn one(work: &Work<'_>, way: Way, judge: &mut Judge, part: &mut Part) -> Result<Result<Vec<Row>, String>, Error> {
    let Way { accelerator, schedule, numerics } = way;
    let (triangles, rays) = (work.input.scene.triangles.len() as u64, u64::from(work.size.width * work.size.height));
    if accelerator == Accelerator::None && triangles.saturating_mul(rays) > MOST_TESTS {
        return Ok(Err(format!("{triangles} triangles for each of {rays} rays are too many tests")));
    }
    let options = Options {
        accelerator,
        schedule,
        numerics,
        // A fused kernel that need not shade makes its rays itself, and nobody could see them.
        shade: schedule == ScheduleKind::Fused,
        timings: true,
        ..Options::new(work.camera_rays())
    };
    let planned = work.plan(&options)?;
    let mut timed = work.start(&planned, &options)?.renderer;
    if misses_all(&work.input.scene, &options, timed.plan()) {
        part.notes.push(MISSES_ALL.into());
    }
    let Some((passes, times)) = timed_passes(work, &mut timed)? else {
        return Ok(Err("it was given up: too slow, or without an end".into()));
    };
    // Timers of passes cost several microseconds each; the time of a whole run is of runs without them.
    let run_ns = match work.chosen.gpu() {
        None => times.last().copied(),
        Some(_) => {
            let mut plain = work.start(&planned, &Options { timings: false, ..options })?.renderer;
            quantile(&work.time_in_turn(&mut [&mut plain], work.either(3, 5))?[0], 0.5)
        }
    };
    let read = read_back(work, &mut timed, &passes, judge)?;
    let judged = judge.judge(work, &timed)?;
    let last = read.len().saturating_sub(1);
    let row = |(i, r): (usize, &ReadBack)| {
        let resolved = judged.verdicts.iter().zip(&r.is_resolved).filter(|(_, is)| **is).map(|(v, _)| *v);
        let resolved: Vec<Verdict> = resolved.collect();
        let count = |is: fn(Verdict) -> bool| resolved.iter().filter(|v| is(**v)).count();
        work.row(COLUMNS)
            .set("accelerator", accelerator.name())
            .set("schedule", schedule.name())
            .set("numerics", numerics.name())
            .set("rays", timed.plan().rays)
            .set("judged_rays", judged.verdicts.len())
            .set("pass_index", r.pass)
            .set("kernel", passes[r.pass].kernel.name())
            .set("time_ns", times[r.pass])
            .set("resolved_rays", decided(&passes[r.pass].counts))
            .set("judged_resolved_rays", resolved.len())
            .set("judged_wrong_rays", count(is_error))
            .set("judged_undecided_rays", count(|v| v == Verdict::Tie))
            .set("is_last", i == last)
            .set("run_ns", run_ns)
            .set("clock", work.clock())
    };
    Ok(Ok(read.iter().enumerate().map(row).collect()))
}

/// Rays whose hit is decided.
fn decided(counts: &StateCounts) -> u32 {
    [state::SHADE, state::BACKGROUND, state::DONE].iter().map(|&tag| counts[tag as usize]).sum()
}

/// The passes of a run, and when each of them was over.
type Timed = (Vec<Pass>, Vec<f64>);

/// Of three runs the middle one; `None` where one was given up.
fn timed_passes(work: &Work<'_>, renderer: &mut Renderer) -> Result<Option<Timed>, Error> {
    let has_clock = work.chosen.timer().is_some();
    let mut runs: Vec<Timed> = Vec::new();
    for run in 0..4 {
        if work.run(renderer)?.is_none() {
            return Ok(None);
        }
        let mut sum = 0.0;
        let times = match has_clock {
            true => renderer.passes().iter().map(|p| p.duration_ns.unwrap_or(0) as f64).collect::<Vec<_>>(),
            false => by_wall_clock(work, renderer)?,
        };
        let ends = times.into_iter().map(|ns| {
            sum += ns;
            sum
        });
        // The first warms up.
        if run > 0 {
            runs.push((renderer.passes().to_vec(), ends.collect()));
        }
    }
    runs.sort_by(|a, b| a.1.last().unwrap_or(&0.0).total_cmp(b.1.last().unwrap_or(&0.0)));
    Ok(runs.into_iter().nth(1))
}

fn by_wall_clock(work: &Work<'_>, renderer: &mut Renderer) -> Result<Vec<f64>, Error> {
    renderer.restart();
    work.chosen.settle();
    let mut times = Vec::new();
    loop {
        let begin = Instant::now();
        if work.chosen.wait(renderer.step())?.is_none() {
            return Ok(times);
        }
        times.push(begin.elapsed().as_nanos() as f64);
    }
}

/// After a pass that resolved rays.
struct ReadBack {
    pass: usize,
    /// One a ray of the sample.
    is_resolved: Vec<bool>,
}

/// Which rays of the sample are resolved after each pass that resolves any.
fn read_back(
    work: &Work<'_>,
    renderer: &mut Renderer,
    passes: &[Pass],
    judge: &mut Judge,
) -> Result<Vec<ReadBack>, Error> {
    // The sample is chosen where truth is worked out; the run is over, so its streams are there.
    judge.judge(work, renderer)?;
    let mut read: Vec<ReadBack> = Vec::new();
    let mut before = 0;
    renderer.restart();
    for (index, pass) in passes.iter().enumerate() {
        let now = decided(&pass.counts);
        let is_last = index + 1 == passes.len();
        if now == before && !is_last {
            continue;
        }
        work.progress.part("reading back", index as u64, passes.len() as u64);
        work.chosen.wait(renderer.run_to(index + 1, |_| ControlFlow::Continue(())))?;
        if now != before || is_last {
            let tags = work.chosen.wait(renderer.values(Stream::State))?;
            let is_done =
                |&ray: &usize| matches!(tags.get(STATE_TAG, ray), state::SHADE | state::BACKGROUND | state::DONE);
            read.push(ReadBack { pass: index, is_resolved: judge.sample.iter().map(is_done).collect() });
        }
        before = now;
    }
    Ok(read)
}

fn curve(row: &[&Row], y: impl Fn(&Row) -> Option<f64>) -> Vec<(f64, f64)> {
    row.iter().filter_map(|r| Some((r.number("time_ns")? / 1e6, y(r)?))).collect()
}

/// Until the first pass that changes anything, there is nothing.
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
        // All at once: what it shades with afterwards does not matter.
        let points =
            if is_point { points.into_iter().filter(|p| p.1 > 0.0).take(1).collect() } else { from_zero(points) };
        let name = if numerics == "paper" { format!("{schedule}, paper's rules") } else { schedule.to_owned() };
        let mark = if is_point { Mark::Square } else { Mark::None };
        let stroke = if is_point { Stroke::None } else { Stroke::Steps };
        (!points.is_empty()).then(|| Series { name, points, whiskers: Vec::new(), color: i.min(4), mark, stroke })
    });
    Plot {
        title: format!("Resolved rays, {accelerator}"),
        x: Axis { label: "time since the run began, ms".into(), scale: Scale::Log },
        y: Axis { label: "resolved rays, %".into(), scale: Scale::Linear },
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
        x: Axis { label: "time since the run began, ms".into(), scale: Scale::Log },
        y: Axis { label: "wrong per million judged".into(), scale: Scale::LogWithZero },
        series,
        places: Vec::new(),
    }
}
