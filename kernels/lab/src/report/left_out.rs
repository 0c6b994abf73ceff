//! What the plan saves by omitting unneeded work: traces the same rays with the plan as it is and with everything put
//! back, interleaved.

use raystep_kernels::plan::Plan;
use raystep_kernels::{Accelerator, Keep, Options, RayHit, Renderer, ScheduleKind};

use super::page::{Part, number};
use super::work::Work;
use crate::Error;
use crate::plots::{Axis, Mark, Plot, Scale, Series, Stroke};
use crate::statistics::quantile;
use crate::tidy::{Row, Table};

pub(super) const COLUMNS: &[&str] = &[
    "schema_version",
    "run_id",
    "scene",
    "scene_hash",
    "adapter",
    "configuration",
    "accelerator",
    "schedule",
    "rays",
    "left_out",
    "put_back",
    "stream_bytes",
    "kept_stream_bytes",
    "buffer_bytes",
    "kept_buffer_bytes",
    "bytes_ratio",
    "started_first",
    "first_start_s",
    "kept_first_start_s",
    "start_s",
    "kept_start_s",
    "start_ratio",
    "runs",
    "median_ns",
    "kept_median_ns",
    "time_ratio",
    "time_ratio_low",
    "time_ratio_high",
    "differing_hits",
    "first_differing_rays",
    "clock",
];

const SHOWN: &[&str] = &[
    "accelerator",
    "schedule",
    "left_out",
    "put_back",
    "stream_bytes",
    "kept_stream_bytes",
    "buffer_bytes",
    "kept_buffer_bytes",
    "started_first",
    "first_start_s",
    "kept_first_start_s",
    "start_s",
    "kept_start_s",
    "start_ratio",
    "time_ratio",
    "time_ratio_low",
    "time_ratio_high",
    "differing_hits",
];

pub(super) fn run(work: &Work<'_>, table: &mut Table) -> Result<Part, Error> {
    let mut part = Part::default();
    let first = table.rows.len();
    let mut rows_so_far = 0;
    for accelerator in [Accelerator::Grid, Accelerator::Bvh] {
        for schedule in [ScheduleKind::Second, ScheduleKind::Compact, ScheduleKind::Fused] {
            work.stage(&format!("omitted work, {accelerator} {schedule}"));
            let is_kept_first = rows_so_far % 2 == 1;
            rows_so_far += 1;
            match one(work, accelerator, schedule, is_kept_first, &mut part) {
                Ok(row) => table.rows.push(row),
                Err(error) => {
                    work.can_go_on()?;
                    part.notes.push(format!("{accelerator} {schedule}: {}", work.explain(&error)));
                }
            }
        }
    }
    let rows = &table.rows[first..];
    part.figure("time", plot(rows).svg()?, "");
    part.table(rows, SHOWN);
    let differing = rows.iter().max_by_key(|r| r.number("differing_hits").unwrap_or(0.0) as u64);
    if let Some(row) = differing {
        part.prose.push(format!(
            "A ratio above 1 is the saving from omitting. Hits that differ in bits: at most {}. Times are {}.",
            number("differing_hits", row),
            work.clock_in_words()
        ));
        part.prose.push(
            "A start allocates, uploads and compiles, excluding planning. The first start of each variant is listed \
             separately, as the driver caches kernels for later ones; but it may already have compiled them for an \
             earlier section or report, and the variant that starts second benefits from kernels that both share. \
             Every other row starts with everything restored."
                .into(),
        );
    }
    if work.machine().gpu().is_none() {
        part.notes.push("kernels for the CPU are compiled in advance: there are no start times".into());
    }
    Ok(part)
}

fn one(
    work: &Work<'_>,
    accelerator: Accelerator,
    schedule: ScheduleKind,
    is_kept_first: bool,
    part: &mut Part,
) -> Result<Row, Error> {
    let options = Options { accelerator, schedule, ..Options::new(work.camera_rays()) };
    let kept = Options { keep: Keep::ALL, ..options.clone() };
    // Starts are interleaved, too, so that a driver's cache serves both. The last of each is run.
    let mut starts: [Vec<f64>; 2] = Default::default();
    let mut last: [Option<Renderer>; 2] = Default::default();
    let planned = [work.plan(&options)?, work.plan(&kept)?];
    for _ in 0..work.either(2, 5) {
        for i in if is_kept_first { [1, 0] } else { [0, 1] } {
            let built = work.start(&planned[i], [&options, &kept][i])?;
            starts[i].push(built.start_s);
            last[i] = Some(built.renderer);
        }
    }
    let [Some(mut without), Some(mut with)] = last else {
        return Err(Error::NothingBuilt);
    };
    let name = |what| work.configuration(&[accelerator.name(), schedule.name(), what]);
    let names = [name("left-out"), name("put-back")];
    let times = work.time_in_turn(&names, &mut [&mut without, &mut with], work.either(6, 20))?;
    if times.iter().any(|times| times.is_given_up) {
        return Err(Error::GivenUp);
    }
    let ratio = times[1].ratio(&times[0], work.seed());
    let interval = ratio.and_then(|(_, interval)| interval);
    let (hits, kept_hits) = (work.machine().wait(without.hits())?, work.machine().wait(with.hits())?);
    let differing = differing(&hits, &kept_hits);
    if !differing.is_empty() {
        part.notes.push(format!(
            "{accelerator} {schedule}: {} hits differ in their bits, the first of them of rays {}",
            differing.len(),
            first_of(&differing)
        ));
    }
    let is_compiled = work.machine().gpu().is_some();
    let first_start = |i: usize| starts[i].first().copied().filter(|_| is_compiled);
    let start = |i: usize| quantile(&starts[i][1..], 0.5).filter(|_| is_compiled);
    let bytes = |plan: &Plan| {
        let streams: u64 = plan.streams.iter().map(|s| s.bytes).sum();
        [streams, plan.bytes() - streams]
    };
    let ([streams, buffers], [kept_streams, kept_buffers]) = (bytes(without.plan()), bytes(with.plan()));
    let put_back = put_back(without.plan(), with.plan());
    Ok(work
        .row(COLUMNS)
        .set("configuration", name("left-out"))
        .set("accelerator", accelerator.name())
        .set("schedule", schedule.name())
        .set("rays", without.plan().rays)
        .set("left_out", without.plan().left_out.len())
        .set("put_back", put_back.join("; "))
        .set("stream_bytes", streams)
        .set("kept_stream_bytes", kept_streams)
        .set("buffer_bytes", buffers)
        .set("kept_buffer_bytes", kept_buffers)
        .set("bytes_ratio", (kept_streams + kept_buffers) as f64 / (streams + buffers).max(1) as f64)
        .set("started_first", is_compiled.then_some(if is_kept_first { "put back" } else { "left out" }))
        .set("first_start_s", first_start(0))
        .set("kept_first_start_s", first_start(1))
        .set("start_s", start(0))
        .set("kept_start_s", start(1))
        .set("start_ratio", start(1).zip(start(0)).map(|(kept, s)| kept / s))
        .set("runs", times[0].runs())
        .set("median_ns", times[0].median())
        .set("kept_median_ns", times[1].median())
        .set("time_ratio", ratio.map(|(median, _)| median))
        .set("time_ratio_low", interval.map(|i| i.low))
        .set("time_ratio_high", interval.map(|i| i.high))
        .set("differing_hits", differing.len())
        .set("first_differing_rays", first_of(&differing))
        .set("clock", work.clock()))
}

/// What one plan omits and the other does not.
fn put_back(without: &Plan, with: &Plan) -> Vec<String> {
    let is_back = |what: &String| !with.left_out.iter().any(|left| left.what == *what);
    without.left_out.iter().map(|left| left.what.clone()).filter(is_back).collect()
}

/// Rays whose hits differ in any bit.
fn differing(a: &[Option<RayHit>], b: &[Option<RayHit>]) -> Vec<usize> {
    let bits = |hit: &Option<RayHit>| hit.map(|h| (h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.triangle));
    a.iter().zip(b).enumerate().filter(|(_, (a, b))| bits(a) != bits(b)).map(|(i, _)| i).collect()
}

/// The first few of many rays.
fn first_of(rays: &[usize]) -> String {
    rays.iter().take(16).map(usize::to_string).collect::<Vec<_>>().join(" ")
}

fn plot(rows: &[Row]) -> Plot {
    let mut series = Vec::new();
    for (color, accelerator, mark) in [(0, "grid", Mark::Dot), (1, "bvh", Mark::Triangle)] {
        let of: Vec<(usize, &Row)> = rows.iter().filter(|r| r.get("accelerator") == accelerator).enumerate().collect();
        // Offset the two series so that they do not overlap.
        let x = |i: usize| i as f64 + 1.0 + if color == 0 { -0.06 } else { 0.06 };
        let points = of.iter().filter_map(|(i, r)| Some((x(*i), r.number("time_ratio")?))).collect();
        let ends = |r: &Row| Some((r.number("time_ratio_low")?, r.number("time_ratio_high")?));
        let whiskers = of.iter().filter_map(|(_, r)| ends(r)).collect();
        let name = accelerator.to_owned();
        series.push(Series { name, points, whiskers, color, mark, stroke: Stroke::None });
    }
    series.push(Series::dashed("no difference", 6, vec![(0.5, 1.0), (3.5, 1.0)]));
    Plot {
        title: "Time with everything restored, relative to time without".into(),
        x: Axis::new("schedule", Scale::Names(&["second", "compact", "fused"])),
        y: Axis::new("ratio of times", Scale::Linear),
        series,
        places: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hit_differs_by_a_bit() {
        let hit = RayHit { t: 1.0, u: 0.0, v: 0.5, triangle: 3 };
        let a = [Some(hit), None, Some(hit), Some(hit)];
        let b = [Some(RayHit { u: -0.0, ..hit }), None, None, Some(hit)];
        assert_eq!(differing(&a, &b), [0, 2]);
        assert_eq!(first_of(&differing(&a, &b)), "0 2");
    }
}
