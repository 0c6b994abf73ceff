//! A run's passes as Chrome trace events, which Perfetto and `chrome://tracing` open.
//!
//! Google, "Trace Event Format", 2016: complete events (`ph` X) are the passes on one thread, and the gaps between them
//! on a second; on a third, if passes are drawn, their copies and draws; counter events (C) are the rays in each state after a pass; metadata events (M) name them all. `ts` and
//! `dur` are microseconds from the beginning of the first pass.
//!
//! A pass without a valid time, or too short to tell by a coarse clock, is left out, and so is one that begins before the
//! previous one: its time is counted as part of the gap, and `passes_without_times` counts it. On a device that overlaps
//! passes, the time that two of them share is counted as an overlap, not a gap, so that always
//!
//! `whole_us` = `passes_us` + `gaps_us` − `overlaps_us`.
//!
//! If passes have no times but the run has one from the host, there is one slice (`cat` run) on a track of its own, as
//! long as the run, and no event about rays.
//!
//! In a gap the device counts rays and copies the counts, waits for the host, runs passes that were submitted ahead for
//! rays that have already left, or repeats a pass to time it: then `runs` says how often it ran, and `error_us` is the
//! standard error of its time.

use std::collections::BTreeMap;

use serde::Serialize;

use super::csv::{DrawnPart, RunContext, rays_out};
use crate::executor::Drawing;
use crate::renderer::Pass;
use crate::tables::state::{COUNT, StateCounts};

/// A run is one process.
const PROCESS: u32 = 1;
/// The track of passes.
const PASSES: u32 = 1;
/// The track of gaps between passes.
const GAPS: u32 = 2;
/// The track of a run that only the host has timed.
const HOST: u32 = 3;
/// The track of the parts of passes that are drawn.
const DRAWS: u32 = 4;

/// The file: the part that Perfetto reads and, in `otherData`, the part that it ignores.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct TraceEvents {
    /// In order of time.
    pub trace_events: Vec<Event>,
    /// Shows times in nanoseconds.
    pub display_time_unit: &'static str,
    /// Description of the run, and sums of its times.
    pub other_data: About,
}

/// What was run, and what its slices add up to.
#[derive(Clone, Debug, Serialize)]
pub struct About {
    /// raystep's version.
    pub raystep_version: &'static str,
    /// As in `passes.csv`; `clock` is `null` if passes were not timed.
    #[serde(flatten)]
    pub run: RunContext,
    /// From the beginning of the first pass to the end of the last.
    pub whole_us: f64,
    /// Sum of the passes.
    pub passes_us: f64,
    /// Sum of the gaps between passes.
    pub gaps_us: f64,
    /// Sum of the time that passes share with those before them.
    pub overlaps_us: f64,
    /// Passes left out because their times are unknown, not valid or too short to tell.
    pub passes_without_times: usize,
}

/// One event.
#[derive(Clone, Debug, Serialize)]
pub struct Event {
    /// What is shown.
    pub name: String,
    /// `pass`, `draw`, `gap`, `run`, `rays` or `__metadata`.
    pub cat: &'static str,
    /// `X`, `C` or `M`.
    pub ph: char,
    /// Begin, microseconds.
    pub ts: f64,
    /// Length, microseconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dur: Option<f64>,
    /// Process.
    pub pid: u32,
    /// Thread.
    pub tid: u32,
    /// Details.
    pub args: BTreeMap<&'static str, serde_json::Value>,
}

/// Sums of a run's times, nanoseconds: `whole = passes + gaps - overlaps`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Sums {
    passes: u64,
    gaps: u64,
    overlaps: u64,
}

/// Trace events for a run's passes, which must be in order. `parts`: those of each pass that is drawn, in the same order.
#[must_use]
pub fn trace_events(run: &RunContext, passes: &[Pass], parts: &[Vec<DrawnPart>]) -> TraceEvents {
    let timed = timed(passes);
    let name = format!("raystep: {}, {} {}, {}", run.scene, run.accelerator, run.schedule, run.adapter);
    let mut events = vec![
        named("process_name", PASSES, name),
        named("thread_name", PASSES, "passes".into()),
        named("thread_name", GAPS, "between passes".into()),
    ];
    if !parts.is_empty() {
        events.push(named("thread_name", DRAWS, "copies and draws".into()));
    }
    if let Some(host_ns) = run.host_run_ns.filter(|_| run.timer.is_some_and(|timer| !timer.times_passes())) {
        events.push(named("thread_name", HOST, "host's clock".into()));
        let args = [("passes", passes.len().into())];
        events.push(slice("run".into(), "run", HOST, 0, host_ns, args.into()));
    }
    let start = timed.first().map_or(0, |&(_, begin, _)| begin);
    let (mut sums, mut latest_end) = (Sums::default(), start);
    let mut shown: StateCounts = [0; COUNT];
    for &(index, begin, duration) in &timed {
        let pass = &passes[index];
        let (begin, end) = (begin - start, begin - start + duration);
        let latest = latest_end - start;
        if begin > latest {
            events.push(slice("gap".into(), "gap", GAPS, latest, begin - latest, BTreeMap::new()));
            sums.gaps += begin - latest;
        }
        sums.overlaps += latest.min(end).saturating_sub(begin);
        sums.passes += duration;
        latest_end = start + latest.max(end);
        let mut args = BTreeMap::from([
            ("pass", pass.index.into()),
            ("iteration", pass.iteration.into()),
            ("rays_in", pass.rays_in.into()),
            ("rays_out", rays_out(pass).into()),
            ("threads_launched", pass.threads_launched.into()),
        ]);
        if let Some(rounding) = pass.rounding {
            args.extend([("runs", rounding.runs.into()), ("error_us", us(rounding.error_ns).into())]);
        }
        events.push(slice(pass.kernel.name().into(), "pass", PASSES, begin, duration, args));
        events.extend(parts.get(index).into_iter().flatten().filter_map(|part| draw(part, start)));
        for (tag, &rays) in pass.counts.iter().enumerate() {
            // A counter keeps its value until the next event.
            if rays != std::mem::replace(&mut shown[tag], rays) {
                let args = BTreeMap::from([("rays", rays.into())]);
                let name = format!("rays in {}", pass.kernel.program().states.name(tag as u32));
                events.push(Event { ph: 'C', dur: None, ..slice(name, "rays", PASSES, end, 0, args) });
            }
        }
    }
    TraceEvents {
        trace_events: events,
        display_time_unit: "ns",
        other_data: About {
            raystep_version: env!("CARGO_PKG_VERSION"),
            run: run.clone(),
            whole_us: us(latest_end - start),
            passes_us: us(sums.passes),
            gaps_us: us(sums.gaps),
            overlaps_us: us(sums.overlaps),
            passes_without_times: passes.len() - timed.len(),
        },
    }
}

/// The slice of a part of a pass; `None` if it was not timed.
fn draw(part: &DrawnPart, start: u64) -> Option<Event> {
    let (begin, duration) = part.time.begin_ns.zip(part.time.duration_ns)?;
    let begin = begin.checked_sub(start)?;
    let mut args = BTreeMap::from([("targets", part.targets.clone().into())]);
    match part.time.what {
        Drawing::Copies => args.insert("bytes_copied", part.bytes_copied.into()),
        Drawing::Depths | Drawing::Draw(_) => args.insert("fragments_drawn", part.fragments_drawn.into()),
    };
    args.extend(part.time.fragments.map(|fragments| ("fragments_run", fragments.into())));
    Some(slice(part.name(), "draw", DRAWS, begin, duration, args))
}

/// The passes with possible times: index, begin and duration.
fn timed(passes: &[Pass]) -> Vec<(usize, u64, u64)> {
    let mut before = 0;
    let valid = passes.iter().enumerate().filter_map(|(index, pass)| {
        let (begin, duration) = pass.begin_ns.zip(pass.duration_ns)?;
        begin.checked_add(duration).filter(|_| begin >= before)?;
        before = begin;
        Some((index, begin, duration))
    });
    valid.collect()
}

fn us(ns: u64) -> f64 {
    ns as f64 / 1000.0
}

fn slice(
    name: String,
    cat: &'static str,
    tid: u32,
    begin_ns: u64,
    duration_ns: u64,
    args: BTreeMap<&'static str, serde_json::Value>,
) -> Event {
    Event { name, cat, ph: 'X', ts: us(begin_ns), dur: Some(us(duration_ns)), pid: PROCESS, tid, args }
}

fn named(what: &str, tid: u32, name: String) -> Event {
    let args = BTreeMap::from([("name", name.into())]);
    Event { ph: 'M', dur: None, ..slice(what.into(), "__metadata", tid, 0, 0, args) }
}

#[cfg(test)]
mod tests {
    use crate::programs::closest_hit::{kernels, states};
    use serde_json::Value;

    use super::*;
    use crate::executor::Rounding;

    fn pass(index: usize, time: Option<(u64, u64)>, shaded: u32) -> Pass {
        let mut counts = [0; COUNT];
        counts[states::SHADE as usize] = shaded;
        counts[states::TRAV as usize] = 10 - shaded;
        Pass {
            index,
            iteration: 1,
            kernel: kernels::INTERSECT,
            rays_in: 10,
            counts,
            threads_launched: 64,
            begin_ns: time.map(|(begin, _)| begin),
            duration_ns: time.map(|(_, duration)| duration),
            rounding: None,
        }
    }

    fn run() -> RunContext {
        RunContext {
            run_id: "1".into(),
            configuration: "0".into(),
            scene: "a \"b\"".into(),
            accelerator: "grid",
            schedule: "second",
            numerics: "robust",
            traversal: "amanatides-woo",
            mapping: "compute".into(),
            adapter: "cpu".into(),
            width_px: 5,
            height_px: 2,
            repeat: 0,
            is_warmup: false,
            timer: Some(super::super::csv::Timer::GpuTimestamp { resolution_ns: 1.0 }),
            host_run_ns: None,
        }
    }

    fn file(times: &[Option<(u64, u64)>]) -> Value {
        let passes: Vec<_> = times.iter().enumerate().map(|(i, &time)| pass(i, time, i as u32 / 2)).collect();
        let text = serde_json::to_string(&trace_events(&run(), &passes, &[])).expect("JSON");
        let file: Value = serde_json::from_str(&text).expect("JSON");
        for event in file["traceEvents"].as_array().expect("events") {
            check(event);
        }
        file
    }

    /// Checks what the format's specification requires of each kind of event.
    fn check(event: &Value) {
        let names: Vec<_> = event.as_object().expect("an object").keys().map(String::as_str).collect();
        let is_complete = event["ph"] == "X";
        let all = ["args", "cat", "dur", "name", "ph", "pid", "tid", "ts"];
        assert_eq!(names, all.into_iter().filter(|&n| is_complete || n != "dur").collect::<Vec<_>>(), "{event}");
        assert!(event["ts"].as_f64().is_some_and(|ts| ts >= 0.0), "{event}");
        assert_eq!(event["pid"], 1);
        match event["ph"].as_str() {
            Some("X") => assert!(event["dur"].as_f64().is_some_and(|dur| dur >= 0.0)),
            Some("C") => assert!(event["args"].as_object().is_some_and(|a| a.values().all(Value::is_u64))),
            Some("M") => assert!(event["args"]["name"].is_string()),
            _ => panic!("{event}"),
        }
    }

    fn sum(file: &Value, category: &str) -> f64 {
        let events = file["traceEvents"].as_array().expect("events");
        events.iter().filter(|e| e["cat"] == category).filter_map(|e| e["dur"].as_f64()).sum()
    }

    fn adds_up(file: &Value) {
        let about = |name: &str| file["otherData"][name].as_f64().expect(name);
        assert_eq!(sum(file, "pass"), about("passes_us"));
        assert_eq!(sum(file, "gap"), about("gaps_us"));
        let whole = about("passes_us") + about("gaps_us") - about("overlaps_us");
        assert!((whole - about("whole_us")).abs() < 1e-9, "{file}");
    }

    #[test]
    fn passes_and_gaps_add_up_to_the_whole() {
        let late = 1 << 60;
        let file = file(&[Some((late, 500)), Some((late + 700, 250)), Some((late + 950, 0)), Some((late + 2000, 3))]);
        adds_up(&file);
        let about = &file["otherData"];
        assert_eq!((&about["whole_us"], &about["gaps_us"]), (&2.003.into(), &1.25.into()));
        assert_eq!((&about["overlaps_us"], &about["passes_without_times"]), (&0.0.into(), &0.into()));
        let events = file["traceEvents"].as_array().expect("events");
        let second = events.iter().find(|e| e["args"]["pass"] == 1).expect("the second pass");
        assert_eq!((&second["ts"], &second["dur"]), (&0.7.into(), &0.25.into()));
        assert_eq!((&second["name"], &second["args"]["rays_in"]), (&"intersect".into(), &10.into()));
        assert_eq!((&second["args"]["iteration"], &second["args"]["rays_out"]), (&1.into(), &10.into()));
        assert_eq!(second["args"]["threads_launched"], 64);
    }

    #[test]
    fn a_repeated_pass_says_how_often_it_ran_and_one_too_short_is_left_out() {
        let rounding = Some(Rounding { runs: 40, error_ns: 7906, below_ns: 120_000 });
        let told = Pass { rounding, ..pass(0, Some((0, 80_000)), 0) };
        let short = Pass { duration_ns: None, ..Pass { rounding, ..pass(1, Some((200_000, 0)), 0) } };
        let events = trace_events(&run(), &[told, short], &[]);
        let slices: Vec<_> = events.trace_events.iter().filter(|event| event.cat == "pass").collect();
        assert_eq!((slices.len(), events.other_data.passes_without_times), (1, 1));
        assert_eq!((&slices[0].args["runs"], &slices[0].args["error_us"]), (&40.into(), &7.906.into()));
    }

    #[test]
    fn a_counter_says_when_it_changes() {
        let file = file(&[Some((0, 10)), Some((20, 10)), Some((40, 10)), Some((60, 10))]);
        let counters: Vec<_> =
            file["traceEvents"].as_array().expect("events").iter().filter(|e| e["ph"] == "C").collect();
        let rows: Vec<_> = counters
            .iter()
            .map(|e| {
                (e["name"].as_str().expect("a name"), e["ts"].as_f64().expect("a time"), e["args"]["rays"].as_u64())
            })
            .collect();
        let expected =
            [("rays in TRAV", 0.01, Some(10)), ("rays in TRAV", 0.05, Some(9)), ("rays in SHADE", 0.05, Some(1))];
        assert_eq!(rows, expected);
    }

    #[test]
    fn overlaps_and_missing_times_are_said() {
        let overlapping = file(&[Some((100, 100)), Some((150, 20)), Some((190, 60)), Some((240, 10)), Some((260, 5))]);
        adds_up(&overlapping);
        let about = &overlapping["otherData"];
        assert_eq!((&about["whole_us"], &about["gaps_us"]), (&0.165.into(), &0.01.into()));
        // 20 within the first; 10 shared by the third and the first; 10 shared by the fourth and the third.
        assert_eq!(about["overlaps_us"], 0.04);

        let holes = file(&[Some((100, 10)), None, Some((50, 10)), Some((u64::MAX, 10)), Some((120, 10))]);
        adds_up(&holes);
        let about = &holes["otherData"];
        assert_eq!((&about["passes_without_times"], &about["whole_us"]), (&3.into(), &0.03.into()));

        let none = file(&[None, None]);
        adds_up(&none);
        assert_eq!(
            (&none["otherData"]["whole_us"], none["traceEvents"].as_array().map(Vec::len)),
            (&0.0.into(), Some(3))
        );
    }
}
