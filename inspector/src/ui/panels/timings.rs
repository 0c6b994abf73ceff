//! Device time by kernel and by pass.
//!
//! Touches: asks.

mod bars;
mod parts;

use std::cmp::Reverse;

use egui::{ScrollArea, Ui};
use raystep_kernels::{Kernel, Pass};
use raystep_lab::text::counted;

use super::chart::kernel_color;
use super::table::{Head, Listed, ListedCell, Look, Table, View, version};
use crate::command::Command;
use crate::session::Model;
use crate::ui::pane::{Context, Panel, saves};

/// Totals of all passes of a kernel.
#[derive(Clone, Debug, PartialEq)]
struct KernelTimes {
    kernel: Kernel,
    passes: usize,
    /// Passes with a known duration.
    timed: usize,
    sum_ns: u64,
    median_ns: u64,
    /// Rays processed by all passes.
    rays: u64,
    /// Rays processed by passes with a known duration.
    timed_rays: u64,
}

/// The panel.
#[derive(Default)]
pub(in crate::ui) struct Timings {
    /// The generation, place and number of passes that the other fields are computed from.
    known: Option<(u64, usize, usize)>,
    kernels: Vec<KernelTimes>,
    listed: Listed,
    table: Table,
    /// The copies and draws of each kernel, if passes are drawn.
    parts: Listed,
    parts_table: Table,
    columns: Vec<bars::Column>,
    /// Logarithmic heights.
    is_log: bool,
}

const ABOUT: &str = "Timing every pass costs several µs per pass. Use these times to compare passes and kernels; for \
                     the time of a whole run, use `raystep bench`, which measures runs without timers.";

impl Panel for Timings {
    fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        if cx.model.passes.is_empty() {
            ui.weak("Step a pass to see its time.");
            return;
        }
        let passes = &cx.model.passes;
        let known = (cx.model.generation, cx.model.place, passes.len());
        if self.known != Some(known) {
            self.known = Some(known);
            self.kernels = by_kernel(passes);
            self.listed = listed(&self.kernels);
            self.columns.clear();
            let plan = cx.model.opened.as_ref().map(|opened| &opened.plan);
            self.parts = plan.map(|plan| parts::listed(plan, passes, &cx.model.draws)).unwrap_or_default();
        }
        let timed: usize = self.kernels.iter().map(|k| k.timed).sum();
        let sum = duration(self.kernels.iter().map(|k| k.sum_ns).sum());
        let heads = heads(cx.has_rays());
        let version = version((known, cx.has_rays()));
        let view = View { name: "kernels", heads: &heads, rows: &self.listed, version, current: None };
        ui.horizontal_wrapped(|ui| {
            if timed == 0 {
                ui.label(format!("{}{}", no_times(cx.model), too_short(passes))).on_hover_text(ABOUT);
            } else {
                let all = passes.len();
                let text = if timed == all {
                    format!("{}, all timed: {sum}", counted(all, "pass"))
                } else {
                    format!("{timed} of {all} passes timed: {sum}{}", too_short(passes))
                };
                ui.label(text).on_hover_text(ABOUT);
                ui.checkbox(&mut self.is_log, "log").on_hover_text("logarithmic bar heights");
            }
            self.table.tools(ui, &view);
            for (name, about, command) in [
                ("CSV…", "export the timings of passes as CSV", Command::ExportPasses),
                ("Trace…", "save passes as trace events for Perfetto", Command::ExportTrace),
            ] {
                if ui.button(name).on_hover_text(about).clicked() {
                    cx.asks.commands.push(command);
                }
            }
        });
        let bottom = ui.max_rect().bottom();
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            ScrollArea::horizontal().show(ui, |ui| self.table.show_all(ui, &view));
            if !self.parts.rows.is_empty() {
                let view = View { name: "parts", heads: &parts::HEADS, rows: &self.parts, version, current: None };
                ScrollArea::horizontal().id_salt("parts").show(ui, |ui| self.parts_table.show_all(ui, &view));
            }
            if timed > 0 {
                let height = (bottom - ui.cursor().top() - 4.0).max(64.0);
                bars::show(ui, height, &mut self.columns, self.is_log, cx);
            }
        });
    }

    saves!(is_log);
}

/// The summary if passes have no times.
fn no_times(model: &Model) -> String {
    let why = model.opened.as_ref().and_then(|opened| opened.why_no_times.as_deref());
    let why = why.unwrap_or("no pass was timed");
    match model.host_ns {
        Some(ns) => format!("{why}; {} took {} by the host's clock", counted(model.place, "pass"), duration(ns)),
        None => format!("{why}: the time of passes is unknown"),
    }
}

/// How many passes are too short to tell by the device's clock, if any.
fn too_short(passes: &[Pass]) -> String {
    let below: Vec<u64> = passes.iter().filter_map(Pass::below_ns).collect();
    match below.iter().max() {
        Some(&most) => format!("; {} too short to tell: {} each", below.len(), less_than(most)),
        None => String::new(),
    }
}

/// Durations by kernel, the longest first.
fn by_kernel(passes: &[Pass]) -> Vec<KernelTimes> {
    let mut all: Vec<(KernelTimes, Vec<u64>)> = Vec::new();
    for pass in passes {
        let at = all.iter().position(|(k, _)| k.kernel == pass.kernel).unwrap_or_else(|| {
            let kernel = pass.kernel;
            all.push((
                KernelTimes { kernel, passes: 0, timed: 0, sum_ns: 0, median_ns: 0, rays: 0, timed_rays: 0 },
                Vec::new(),
            ));
            all.len() - 1
        });
        let (times, durations) = &mut all[at];
        times.passes += 1;
        times.rays += u64::from(pass.rays_in);
        if let Some(ns) = pass.duration_ns {
            times.timed += 1;
            times.sum_ns = times.sum_ns.saturating_add(ns);
            times.timed_rays += u64::from(pass.rays_in);
            durations.push(ns);
        }
    }
    let finished = all.into_iter().map(|(mut times, mut durations)| {
        if !durations.is_empty() {
            let middle = durations.len() / 2;
            times.median_ns = *durations.select_nth_unstable(middle).1;
        }
        times
    });
    let mut kernels: Vec<KernelTimes> = finished.collect();
    kernels.sort_by_key(|times| Reverse(times.sum_ns));
    kernels
}

/// The heads, of a program with rays or without.
const fn heads(has_rays: bool) -> [Head<'static>; 7] {
    let [items, rate] = if has_rays {
        [
            Head::number("rays", "total over its passes: a ray counts in every pass that processes it"),
            Head::number("rays/µs", "rays processed per µs of device time"),
        ]
    } else {
        [
            Head::number("elements", "total over its passes: an element counts in every pass that works on it"),
            Head::number("per µs", "elements worked on per µs of device time"),
        ]
    };
    [
        Head::text("kernel", "kernel"),
        Head::number("passes", "number of passes"),
        Head::number("sum", "total device time of its passes; compared in ns"),
        Head::number("median", "median duration of its passes; compared in ns"),
        Head::number("share", "percentage of the time of all passes"),
        items,
        rate,
    ]
}

/// The kernels as rows.
fn listed(kernels: &[KernelTimes]) -> Listed {
    let whole: u64 = kernels.iter().map(|k| k.sum_ns).sum();
    let unknown = || ListedCell::text("unknown");
    let row = |times: &KernelTimes| {
        let is_timed = times.timed > 0;
        let time = |ns: u64| match is_timed {
            true => ListedCell::number(ns as f64, duration(ns)).about(format!("{ns} ns")),
            false => unknown(),
        };
        let part = times.sum_ns as f64 / whole.max(1) as f64;
        let bar = Some((part as f32, kernel_color(times.kernel).gamma_multiply(0.3)));
        let share = ListedCell::number(part * 100.0, format!("{:.1}%", part * 100.0));
        let swatch = Look { swatch: Some(kernel_color(times.kernel)), ..Look::default() };
        vec![
            ListedCell::text(times.kernel.name()).about(times.kernel.info().summary).look(swatch),
            ListedCell::number(times.passes as f64, times.passes.to_string()),
            time(times.sum_ns),
            time(times.median_ns),
            if is_timed { share.look(Look { bar, ..Look::default() }) } else { unknown() },
            ListedCell::number(times.rays as f64, times.rays.to_string()),
            rate(times).map_or_else(unknown, |rate| ListedCell::number(rate, format!("{rate:.1}"))),
        ]
    };
    Listed { rows: kernels.iter().map(row).collect() }
}

/// Rays that the kernel processes per µs, over passes with a known duration.
fn rate(times: &KernelTimes) -> Option<f64> {
    (times.sum_ns > 0).then(|| times.timed_rays as f64 * 1e3 / times.sum_ns as f64)
}

/// A duration in readable form.
pub(super) fn duration(ns: u64) -> String {
    match ns {
        0..1_000_000 => format!("{:.1} µs", ns as f64 / 1e3),
        1_000_000..1_000_000_000 => format!("{:.2} ms", ns as f64 / 1e6),
        _ => format!("{:.2} s", ns as f64 / 1e9),
    }
}

/// A bound in readable form, rounded up.
fn less_than(ns: u64) -> String {
    let digit = match ns {
        0..1_000_000 => 100,
        1_000_000..1_000_000_000 => 10_000,
        _ => 10_000_000,
    };
    format!("< {}", duration(ns.next_multiple_of(digit)))
}

/// What is known of a pass's duration; `None` if nothing is.
pub(super) fn time_of(pass: &Pass) -> Option<String> {
    let error = pass.rounding.map_or_else(String::new, |rounding| format!(" ± {}", duration(rounding.error_ns)));
    pass.duration_ns.map(|ns| duration(ns) + &error).or_else(|| pass.below_ns().map(less_than))
}

#[cfg(test)]
mod tests {
    use raystep_kernels::programs::closest_hit::kernels::{INTERSECT, SETUP, TRAVERSE_GRID};

    use super::*;

    pub(super) fn pass(index: usize, kernel: Kernel, rays_in: u32, duration_ns: Option<u64>) -> Pass {
        Pass { index, rays_in, duration_ns, ..Pass::of(kernel) }
    }

    #[test]
    fn kernels_are_summed_the_dearest_first_and_what_is_unknown_is_not_counted() {
        let passes = [
            pass(0, SETUP, 100, None),
            pass(1, INTERSECT, 90, Some(1000)),
            pass(2, TRAVERSE_GRID, 80, Some(9000)),
            pass(3, INTERSECT, 30, Some(5000)),
            pass(4, INTERSECT, 10, Some(2000)),
            pass(5, TRAVERSE_GRID, 10, None),
        ];
        let kernels = by_kernel(&passes);
        let row = |k: &KernelTimes| (k.kernel, k.passes, k.timed, k.sum_ns, k.median_ns, k.rays);
        let rows: Vec<_> = kernels.iter().map(row).collect();
        assert_eq!(
            rows,
            [(TRAVERSE_GRID, 2, 1, 9000, 9000, 90), (INTERSECT, 3, 3, 8000, 2000, 130), (SETUP, 1, 0, 0, 0, 100),]
        );
        // 80 rays in 9 µs: those of the pass that was not timed are left out.
        let rates: Vec<_> = kernels.iter().map(rate).collect();
        assert_eq!(rates, [Some(80.0 / 9.0), Some(130.0 / 8.0), None]);
    }

    #[test]
    fn too_short_a_pass_is_below_a_bound_and_not_unknown() {
        use raystep_kernels::Rounding;
        let rounding = Some(Rounding { runs: 256, error_ns: 2048, below_ns: 67_584 });
        let short = Pass { rounding, ..pass(0, INTERSECT, 1, None) };
        let rounded = Pass { rounding, ..pass(1, INTERSECT, 1, Some(20_000)) };
        let unknown = pass(2, INTERSECT, 1, None);
        let fine = pass(3, INTERSECT, 1, Some(20_000));
        let texts = [&short, &rounded, &unknown, &fine].map(time_of);
        let expected = [Some("< 67.6 µs"), Some("20.0 µs ± 2.0 µs"), None, Some("20.0 µs")];
        assert_eq!(texts.each_ref().map(Option::as_deref), expected);
        assert_eq!(too_short(&[short.clone(), rounded.clone(), short]), "; 2 too short to tell: < 67.6 µs each");
        assert_eq!(too_short(&[rounded, unknown]), "");
        let bounds = [999_999, 1_000_001, 1_000_000_001].map(less_than);
        assert_eq!(bounds, ["< 1.00 ms", "< 1.01 ms", "< 1.01 s"], "rounded up");
    }

    #[test]
    fn durations_keep_their_unit() {
        let texts = [950, 12_345, 12_345_678, 12_345_678_901].map(duration);
        assert_eq!(texts, ["0.9 µs", "12.3 µs", "12.35 ms", "12.35 s"]);
    }
}
