//! Summary of a run, for the terminal and for `--summary-json`.

use std::fmt::Write as _;

use raystep_kernels::export::json::{self, AdapterInfo, CheckSummary, CounterSums, Summary};
use raystep_kernels::plan::{Bytes, Plan};
use raystep_kernels::{Accelerator, Options, Samples, ScheduleKind};
use raystep_lab::judge::Report;

use crate::session::Running;

/// The summary of a complete run.
pub(crate) fn of(running: &Running, hits: u64, counters: Option<CounterSums>, report: Option<&Report>) -> Summary {
    let (renderer, plan) = (&running.renderer, running.renderer.plan());
    Summary {
        schema_version: json::SCHEMA_VERSION,
        raystep_version: env!("CARGO_PKG_VERSION"),
        run_id: running.run_id.clone(),
        scene: running.scene.name.clone(),
        notes: running.scene.notes.iter().map(|n| n.0.clone()).collect(),
        device: running.chosen.kind(),
        device_reason: running.chosen.reason.clone(),
        adapter: running.chosen.gpu().map(AdapterInfo::from),
        options: running.run_options(),
        triangles: plan.triangles,
        structure: running.structure(),
        scene_units_per_stream_unit: renderer.data().units.scene_units_per_stream_unit(),
        scene_offset: renderer.data().units.offset.to_array(),
        clock: running.options.timings.then(|| running.chosen.timer().name()),
        host_run_ns: renderer.host_ns(),
        passes: renderer.pass_count(),
        kernels: renderer.totals().kernels.clone(),
        rays: plan.rays * u64::from(running.options.samples.count.max(1)),
        hits,
        unfinished: renderer.unfinished(),
        counters,
        check: report.map(CheckSummary::from),
        seconds: running.watch.stages.iter().copied().collect(),
        stream_bytes: plan.streams.iter().map(|s| (s.what.name(), s.bytes)).collect(),
        buffer_bytes: plan.buffers.iter().map(|b| (b.what, b.bytes)).collect(),
    }
}

/// The structure and the schedule that rays were traced by.
pub(crate) fn way(options: &Options, plan: &Plan) -> String {
    let (accelerator, schedule) = (plan.accelerator, options.schedule);
    let chosen = match options.accelerator {
        Accelerator::Auto if schedule == ScheduleKind::Fused => ": chosen for this scene",
        Accelerator::Auto => ": structure chosen for this scene",
        Accelerator::Grid if options.timings && schedule == ScheduleKind::Compact => {
            ": passes are recorded; faster: --accelerator auto --schedule fused; as in the paper: --schedule second"
        }
        _ => "",
    };
    format!("{accelerator}, {schedule}{chosen}")
}

/// A stage's displayed name.
fn in_words(stage: &str) -> String {
    match stage {
        // The key in JSON is older than the BVH.
        "plan_and_grid" => "plan and structure".into(),
        other => other.replace('_', " "),
    }
}

/// A few lines for the terminal.
pub(crate) fn text(summary: &Summary, running: &Running) -> String {
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{name:<9} {value}");
    };
    let device = match &summary.adapter {
        Some(a) => format!("{} ({}, {}, {})", a.name, a.kind, a.backend, a.driver),
        None => "CPU".into(),
    };
    line("device", format!("{device}: {}", summary.device_reason));
    line("triangles", summary.triangles.to_string());
    line("tracing", way(&running.options, running.renderer.plan()));
    // It includes its own name.
    let _ = writeln!(text, "{}", summary.structure);
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "{name:<9} {value}");
    };
    // In execution order, not by name.
    let mut kernels: Vec<String> = Vec::new();
    for variant in &running.renderer.plan().variants {
        if let Some(k) = summary.kernels.get(variant.kernel.name()) {
            let time = k.duration_ns.map(|ns| format!(" in {:.1} ms", ns as f64 / 1e6)).unwrap_or_default();
            kernels.push(format!("{} {}{time}", variant.kernel.name(), k.passes));
        }
    }
    line("passes", format!("{}: {}", summary.passes, kernels.join(", ")));
    let Samples { count, sampler, seed, .. } = summary.options.choices.samples;
    if count > 1 {
        line("samples", format!("{count} per pixel, {sampler}, seed {seed}"));
    }
    line("rays", format!("{}, {} hit something", summary.rays, summary.hits));
    if summary.unfinished > 0 {
        line("", format!("{} unresolved at the limit on passes", summary.unfinished));
    }
    if let Some(c) = &summary.counters {
        let places = if summary.structure.bvh.is_some() { "nodes" } else { "cells" };
        let again = c.repeated_tests.map(|n| format!(", {n} of them repeated")).unwrap_or_default();
        line(
            "counters",
            format!("{} {places} visited, {} triangles tested{again}", c.cells_visited, c.triangles_tested),
        );
    }
    let seconds: Vec<_> = running.watch.stages.iter().map(|(name, s)| format!("{} {s:.3}", in_words(name))).collect();
    line("seconds", seconds.join(", "));
    let (streams, buffers) = (summary.stream_bytes.values().sum(), summary.buffer_bytes.values().sum());
    line("memory", format!("{} of streams, {} of buffers", Bytes(streams), Bytes(buffers)));
    text.truncate(text.trim_end().len());
    text
}
