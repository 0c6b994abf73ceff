//! What a run did, for people and for `--summary-json`.

use std::fmt::Write as _;

use raystep_kernels::export::json::{self, AdapterInfo, CheckSummary, CounterSums, GridSummary, Summary};
use raystep_kernels::plan::Bytes;
use raystep_kernels::reference::Report;

use crate::session::Running;

/// Of a run that is complete.
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
        adapter: running.chosen.gpu().map(|gpu| AdapterInfo::from(&gpu.info)),
        options: running.run_options(),
        triangles: plan.triangles,
        grid: GridSummary::of(renderer.data()),
        scene_units_per_stream_unit: renderer.data().units.scene_units_per_stream_unit(),
        passes: renderer.passes().len(),
        kernels: json::kernels(renderer.passes()),
        rays: plan.rays,
        hits,
        unfinished: renderer.unfinished(),
        counters,
        check: report.map(CheckSummary::from),
        seconds: running.watch.stages.iter().copied().collect(),
        stream_bytes: plan.streams.iter().map(|s| (s.what.name(), s.bytes)).collect(),
        buffer_bytes: plan.buffers.iter().map(|b| (b.what, b.bytes)).collect(),
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
    line(
        "grid",
        match &summary.grid {
            None => "none".into(),
            Some(g) => {
                let [x, y, z] = g.cells;
                format!(
                    "{x} x {y} x {z} cells, {} empty; {} references, longest list {}",
                    g.empty_cells, g.references, g.longest_list
                )
            }
        },
    );
    // In the order in which they ran, not by name.
    let mut kernels: Vec<String> = Vec::new();
    for variant in &running.renderer.plan().variants {
        if let Some(k) = summary.kernels.get(variant.kernel.name()) {
            let time = k.duration_ns.map(|ns| format!(" in {:.1} ms", ns as f64 / 1e6)).unwrap_or_default();
            kernels.push(format!("{} {}{time}", variant.kernel.name(), k.passes));
        }
    }
    line("passes", format!("{}: {}", summary.passes, kernels.join(", ")));
    line("rays", format!("{}, {} hit something", summary.rays, summary.hits));
    if summary.unfinished > 0 {
        line("", format!("{} were still walking at the bound on passes", summary.unfinished));
    }
    if let Some(c) = &summary.counters {
        let (cells, tests, repeated) = (c.cells_visited, c.triangles_tested, c.repeated_tests);
        line("counters", format!("{cells} cells visited, {tests} triangles tested, {repeated} of them again"));
    }
    let seconds: Vec<_> =
        running.watch.stages.iter().map(|(name, s)| format!("{} {s:.3}", name.replace('_', " "))).collect();
    line("seconds", seconds.join(", "));
    let (streams, buffers) = (summary.stream_bytes.values().sum(), summary.buffer_bytes.values().sum());
    line("memory", format!("{} of streams, {} of buffers", Bytes(streams), Bytes(buffers)));
    text.truncate(text.trim_end().len());
    text
}
