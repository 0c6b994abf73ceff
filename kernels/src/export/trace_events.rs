//! A run's passes as Chrome trace events, which Perfetto and `chrome://tracing` open.
//!
//! Google, "Trace Event Format", 2016: complete events (`ph` X) are the passes on one thread, and the gaps between them
//! on a second; on a third, if passes are drawn, their copies and draws; counter events (C) are the rays in each state
//! after a pass; metadata events (M) name them all. `ts` and `dur` are microseconds from the beginning of the first pass.
//!
//! Slices of one track lie beside each other: passes or draws that a device overlaps are on further tracks. The time that
//! a pass shares with those before it is counted as an overlap, not a gap, so that always
//!
//! `whole_us` = `passes_us` + `gaps_us` − `overlaps_us`.
//!
//! A pass without a valid time, or too short to tell by a coarse clock, is left out, and so is a single one that does not
//! begin between its neighbours: its time is counted as part of the gap, and `passes_without_times` counts it. If the
//! device's clock was set back between two passes, the second begins where the first ended, since how long the gap was is
//! not known; `clock_set_back` counts that.
//!
//! If passes have no times but the run has one from the host, there is one slice (`cat` run) on a track of its own, as
//! long as the run, and no event about rays.
//!
//! In a gap the device counts rays and copies the counts, waits for the host, runs passes that were submitted ahead for
//! rays that have already left, or repeats a pass to time it: then `runs` says how often it ran, and `error_us` is the
//! standard error of its time.

mod tracks;

use std::collections::BTreeMap;

use serde::Serialize;

use super::csv::{DrawnPart, RunContext, rays_out};
use crate::executor::Drawing;
use crate::options::Choices;
use crate::renderer::Pass;
use tracks::{Timed, Tracks, timed};

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
    /// How often the clock was set back between two passes.
    pub clock_set_back: usize,
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
    let Choices { accelerator, schedule, .. } = run.choices;
    let (timed, clock_set_back) = timed(passes);
    let name = format!("raystep: {}, {} {}, {}", run.scene, accelerator, schedule, run.adapter);
    let mut events = vec![named("process_name", PASSES, name), named("thread_name", GAPS, "between passes".into())];
    if let Some(host_ns) = run.host_run_ns.filter(|_| run.timer.is_some_and(|timer| !timer.times_passes())) {
        events.push(named("thread_name", HOST, "host's clock".into()));
        let args = [("passes", passes.len().into())];
        events.push(slice("run".into(), "run", HOST, 0, host_ns, args.into()));
    }
    let mut pass_tracks = Tracks::new(PASSES, "passes");
    let mut draw_tracks = Tracks::new(DRAWS, "copies and draws");
    let (mut sums, mut latest) = (Sums::default(), 0);
    let mut shown = vec![0; passes.first().map_or(0, |pass| pass.counts.len())];
    for at in &timed {
        let (pass, begin, end) = (&passes[at.index], at.begin_ns, at.end_ns());
        if begin > latest {
            events.push(slice("gap".into(), "gap", GAPS, latest, begin - latest, BTreeMap::new()));
            sums.gaps += begin - latest;
        }
        sums.overlaps = sums.overlaps.saturating_add(latest.min(end).saturating_sub(begin));
        sums.passes = sums.passes.saturating_add(at.duration_ns);
        latest = latest.max(end);
        let track = pass_tracks.place(begin, end);
        events.push(slice(pass.kernel.name().into(), "pass", track, begin, at.duration_ns, about(pass)));
        let parts = parts.get(at.index).into_iter().flatten();
        events.extend(parts.filter_map(|part| draw(part, at, &mut draw_tracks)));
        for (tag, &rays) in pass.counts.iter().enumerate() {
            // A counter keeps its value until the next event.
            if rays != std::mem::replace(&mut shown[tag], rays) {
                let args = BTreeMap::from([("rays", rays.into())]);
                let name = format!("rays in {}", pass.kernel.program().states.name(tag as u32));
                events.push(Event { ph: 'C', dur: None, ..slice(name, "rays", PASSES, latest, 0, args) });
            }
        }
    }
    let draw_tracks = Some(draw_tracks).filter(|_| !parts.is_empty());
    let tracks = draw_tracks.iter().chain([&pass_tracks]).flat_map(Tracks::names);
    events.extend(tracks.map(|(track, name)| named("thread_name", track, name)));
    TraceEvents {
        trace_events: events,
        display_time_unit: "ns",
        other_data: About {
            raystep_version: env!("CARGO_PKG_VERSION"),
            run: run.clone(),
            whole_us: us(latest),
            passes_us: us(sums.passes),
            gaps_us: us(sums.gaps),
            overlaps_us: us(sums.overlaps),
            passes_without_times: passes.len() - timed.len(),
            clock_set_back,
        },
    }
}

/// What a slice says about its pass.
fn about(pass: &Pass) -> BTreeMap<&'static str, serde_json::Value> {
    let mut args = BTreeMap::from([
        ("pass", pass.index.into()),
        ("sample", pass.sample.into()),
        ("iteration", pass.iteration.into()),
        ("rays_in", pass.rays_in.into()),
        ("threads_launched", pass.threads_launched.into()),
    ]);
    args.extend(rays_out(pass).map(|rays| ("rays_out", rays.into())));
    if let Some(rounding) = pass.rounding {
        args.extend([("runs", rounding.runs.into()), ("error_us", us(rounding.error_ns).into())]);
    }
    args
}

/// The slice of a part of a pass; `None` if it was not timed.
fn draw(part: &DrawnPart, of: &Timed, tracks: &mut Tracks) -> Option<Event> {
    let (clock_ns, duration) = part.time.begin_ns.zip(part.time.duration_ns)?;
    let begin = of.begin_ns.checked_add(clock_ns.checked_sub(of.clock_ns)?)?;
    let mut args = BTreeMap::from([("targets", part.targets.clone().into())]);
    match part.time.what {
        Drawing::Copies => args.insert("bytes_copied", part.bytes_copied.into()),
        Drawing::Depths | Drawing::Draw(_) => args.insert("fragments_drawn", part.fragments_drawn.into()),
    };
    args.extend(part.time.fragments.map(|fragments| ("fragments_run", fragments.into())));
    let track = tracks.place(begin, begin.checked_add(duration)?);
    Some(slice(part.name(), "draw", track, begin, duration, args))
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
mod tests;
