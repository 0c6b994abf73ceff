//! Rays resolved, and rays resolved wrongly, over time and per pass.
//!
//! Every configuration runs twice: with timed passes and no read-back, and pass by pass, reading after each pass which
//! rays are resolved. Kernels are deterministic, so both runs have the same passes. The hit of a resolved ray does not
//! change any more, so each ray is judged once, at the end.
//!
//! A row is a pass, with the time at which it ended by the clock of passes; timing passes costs some microseconds each.
//! Which configuration is fastest is the matter of the section `choices`, with whole runs in turn.

mod plots;

use std::ops::ControlFlow;
use std::time::Instant;

use raystep_kernels::tables::stream::STATE_TAG;
use raystep_kernels::{Accelerator, Numerics, Options, Pass, Renderer, ScheduleKind};

use super::judge::Judge;
use super::page::{Part, number};
use super::work::{Work, id, in_words};
use crate::Error;
use crate::configuration::{Configuration, numerics_of};
use crate::meter::Ended;
use crate::outside::{ALL_MISS, misses_all};
use crate::reference::Verdict;
use crate::structures::STRUCTURES;
use crate::tidy::fill::per_million;
use crate::tidy::{KEYS, Row, Table, count, joined};

const GROUPS: &[&[&str]] = &[
    KEYS,
    columns![
        accelerator schedule numerics rays judged_rays pass_index kernel pass_end_ns resolved_rays
        resolved_judged_rays resolved_wrong_rays resolved_wrong_per_million resolved_undecided_rays is_last
        clock
    ],
];

pub(super) const COLUMNS: &[&str] = &joined::<{ count(GROUPS) }>(GROUPS);

/// Maximum number of tests in a run without an accelerator.
const MOST_TESTS: u64 = 1 << 28;

/// Every configuration, and the paper's numerics with its own faster schedule; in a quick report, without the schedules
/// between the paper's and the fused one.
fn configurations(is_quick: bool) -> Vec<Configuration> {
    use Accelerator::{Bvh, Grid, Irregular, None};
    let mut all = Vec::new();
    for accelerator in [Grid, Irregular, Bvh, None] {
        for &schedule in ScheduleKind::ALL {
            // Without a grid or BVH, `second` is the same as `first`.
            let is_same = accelerator == None && schedule == ScheduleKind::Second;
            let is_papers = matches!(schedule, ScheduleKind::First | ScheduleKind::Second);
            if !(is_same || is_quick && is_papers) {
                all.push(Configuration::usual(accelerator, schedule));
            }
        }
        let schedule = if accelerator == None { ScheduleKind::First } else { ScheduleKind::Second };
        if numerics_of(accelerator).contains(&Numerics::Paper) {
            all.push(Configuration::usual(accelerator, schedule).paper());
        }
    }
    all
}

pub(super) fn run(work: &Work<'_>, table: &mut Table) -> Result<Part, Error> {
    let mut part = Part::default();
    part.is_folded = true;
    let first = table.rows.len();
    let mut judge = Judge::default();
    let mut left_out = Vec::new();
    let is_wanted = |one: &Configuration| work.only.has(one.accelerator) && work.only.has_schedule(one.schedule);
    for configuration in configurations(work.is_quick).into_iter().filter(is_wanted) {
        let what = in_words(&configuration);
        if work.is_past(1.0) {
            left_out.push(what);
            continue;
        }
        work.stage(&format!("rays over time, {what}"));
        let found = one(work, configuration, &mut judge, &mut part);
        match work.noted(&mut part, &what, found)? {
            Some(Err(reason)) => part.notes.push(format!("{what}: {reason}")),
            found => table.rows.extend(found.and_then(Result::ok).into_iter().flatten()),
        }
    }
    part.notes.extend(work.left_out(&left_out));
    let rows = &table.rows[first..];
    for (accelerator, _) in STRUCTURES {
        part.figure(accelerator, plots::resolved(accelerator, rows), plots::resolved_caption(accelerator, rows));
    }
    if rows.iter().any(|r| r.number("resolved_wrong_rays").is_some_and(|n| n > 0.0)) {
        part.figure("wrong", plots::wrong(rows), plots::wrong_caption(rows));
    }
    let last = || rows.iter().filter(|r| r.get("is_last") == "true");
    part.table(last());
    let wrong = |row: &&Row| row.number("resolved_wrong_rays").unwrap_or(0.0) as u64;
    for (numerics, name) in [("robust", "robust rules"), ("paper", "the paper's rules")] {
        if let Some(row) = last().filter(|r| r.get("numerics") == numerics).max_by_key(wrong) {
            let (wrong, judged) = (number("resolved_wrong_rays", row), number("judged_rays", row));
            part.prose.push(match row.get("resolved_wrong_rays") {
                "0" => format!("With {name}, no ray was wrong ({judged} judged)."),
                _ => format!("With {name}, at most {wrong} of {judged} judged rays were wrong."),
            });
        }
    }
    part.prose.push(format!(
        "Times are those at which passes ended, {}. Do not rank schedules by these times: timing every pass slows them. \
         Section Choices compares whole runs.",
        work.clock_in_words()
    ));
    Ok(part)
}

/// The rows of a configuration, or why there are none.
fn one(
    work: &Work<'_>,
    configuration: Configuration,
    judge: &mut Judge,
    part: &mut Part,
) -> Result<Result<Vec<Row>, String>, Error> {
    let (triangles, rays) = (work.subject.scene.triangles.len() as u64, u64::from(work.size.width * work.size.height));
    if configuration.accelerator == Accelerator::None && triangles.saturating_mul(rays) > MOST_TESTS {
        return Ok(Err(format!("testing {triangles} triangles for each of {rays} rays takes too long")));
    }
    let options = configuration.of(&Options {
        // A fused kernel that does not shade generates its rays itself, so they could not be read.
        shade: configuration.schedule == ScheduleKind::Fused,
        timings: true,
        ..Options::new(work.camera_rays())
    });
    let mut timed = work.wait(work.build(&options))?.renderer;
    if misses_all(&work.subject.scene, &options, timed.plan()) {
        part.notes.push(ALL_MISS.into());
    }
    let Some((passes, ends_ns)) = timed_passes(work, &mut timed)? else {
        return Ok(Err("stopped: too slow, or endless".into()));
    };
    if ends_ns.contains(&None) {
        part.notes.push(format!("{}: some passes have no valid time", in_words(&configuration)));
    }
    let read = read_back(work, &mut timed, &passes, judge)?;
    let judged = work.wait(judge.judge(work, &timed))?;
    let last = read.len().saturating_sub(1);
    let row = |(i, r): (usize, &ReadBack)| {
        let resolved = judged.verdicts.iter().zip(&r.is_resolved).filter(|(_, is)| **is);
        let resolved: Vec<Verdict> = resolved.filter_map(|(verdict, _)| *verdict).collect();
        let count = |is: fn(Verdict) -> bool| resolved.iter().filter(|v| is(**v)).count();
        let (wrong, judged_rays) = (count(Verdict::is_error), judged.counts.rays());
        work.row(COLUMNS)
            .set("configuration", id(work, &configuration))
            .configured(&configuration)
            .set("rays", timed.plan().rays)
            .set("judged_rays", judged_rays)
            .set("pass_index", r.pass)
            .set("kernel", passes[r.pass].kernel.name())
            .set("pass_end_ns", ends_ns[r.pass])
            .set("resolved_rays", passes[r.pass].kernel.program().states.decided(&passes[r.pass].counts))
            .set("resolved_judged_rays", resolved.len())
            .set("resolved_wrong_rays", wrong)
            .set("resolved_wrong_per_million", per_million(wrong as u64, judged_rays))
            .set("resolved_undecided_rays", count(|v| v == Verdict::Tie))
            .set("is_last", i == last)
            .set("clock", work.clock())
    };
    Ok(Ok(read.iter().enumerate().map(row).collect()))
}

/// Passes, and when each ended, in nanoseconds from the start of the first; `None` if unknown.
type Timed = (Vec<Pass>, Vec<Option<f64>>);

/// Of three runs, the one with the median time of the last pass; `None` if one was stopped.
fn timed_passes(work: &Work<'_>, renderer: &mut Renderer) -> Result<Option<Timed>, Error> {
    let has_clock = work.machine().timer().times_passes();
    let mut runs: Vec<Timed> = Vec::new();
    // The first run warms up.
    for run in 0..4 {
        if work.wait(work.run(renderer))? == Ended::GivenUp {
            return Ok(None);
        }
        let ends = if has_clock { ends_of(renderer.passes()) } else { by_wall_clock(work, renderer)? };
        if run > 0 {
            runs.push((renderer.passes().to_vec(), ends));
        }
    }
    let last = |run: &Timed| run.1.last().copied().flatten().unwrap_or(f64::INFINITY);
    runs.sort_by(|a, b| last(a).total_cmp(&last(b)));
    Ok(runs.into_iter().nth(1))
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
    work.wait(work.machine().settle());
    let mut ends = Vec::new();
    let begin = Instant::now();
    while work.wait(renderer.step())?.is_some() {
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
    work.wait(judge.judge(work, renderer))?;
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
        work.wait(renderer.run_to(index + 1, |_| ControlFlow::Continue(())))?;
        if now != before || is_last {
            let tags = work.wait(renderer.values(renderer.results()?.t.stream))?;
            let is_done = |&ray: &usize| renderer.plan().program.states.is_decided(tags.get(STATE_TAG, ray));
            read.push(ReadBack { pass: index, is_resolved: judge.sample().iter().map(is_done).collect() });
        }
        before = now;
    }
    Ok(read)
}

#[cfg(test)]
mod tests {
    use raystep_kernels::programs::closest_hit::kernels;

    use super::*;

    #[test]
    fn passes_end_since_the_first_began_and_times_that_are_not_known_are_not_0() {
        let pass = |begin_ns, duration_ns| Pass { begin_ns, duration_ns, ..Pass::of(kernels::SETUP) };
        // The third has no time; the fourth is from a clock that was set back.
        let times =
            [(Some(100), Some(10)), (Some(150), Some(10)), (None, None), (Some(20), Some(5)), (Some(170), Some(1))];
        let passes = times.map(|(begin, duration)| pass(begin, duration));
        assert_eq!(ends_of(&passes), [Some(10.0), Some(60.0), None, None, Some(71.0)]);
        assert_eq!(ends_of(&[pass(None, Some(3))]), [None]);
    }
}
