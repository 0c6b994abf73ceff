//! What a step shows below its text: a step from cell to cell before and after, the states of a ray, and what it may
//! hit.

use egui::{Grid, RichText, Ui};
use raystep_kernels::export::trace::Trace;
use raystep_kernels::program::KernelInfo;
use raystep_kernels::tables::kernel::Transition;

use super::candidates::Candidates;
use super::cell_step::CellStep;
use crate::lesson::Value;
use crate::lesson::command::Values;
use crate::session::Model;
use crate::session::request::Opened;
use crate::ui::style::{in_strong, strong};
use crate::walk::{AXES, row_after_passes};

/// Shows the ray's next step from cell to cell, or the one just made. Of what comes after it, only `known` is shown.
pub(super) fn before_after(ui: &mut Ui, model: &Model, known: Values) {
    let (Some(history), Some(opened)) = (&model.history, &model.opened) else { return };
    let Ok(step) = CellStep::of(history, &opened.data, model.place) else { return };
    // Once the step is made, there is nothing to guess.
    let known = if step.is_made { Values { axis: true, cell: true, tmax: true, state: true } } else { known };
    let has_after = known != Values::default();
    let short = |t: Option<f32>| t.map_or_else(|| "never".into(), |t| format!("{t:.5}"));
    ui.add_space(6.0);
    Grid::new("before and after").num_columns(6).spacing([9.0, 2.0]).striped(true).show(ui, |ui| {
        let heads: &[&str] = match has_after {
            true => &["", "cell", "new cell", "tMax", "new tMax", "tDelta"],
            false => &["", "cell", "tMax", "tDelta"],
        };
        for head in heads {
            ui.small(*head);
        }
        ui.end_row();
        for axis in 0..3 {
            let is_next = known.axis && axis == step.axis;
            let name = RichText::new(AXES[axis]);
            ui.label(if is_next { name.strong().background_color(ui.visuals().selection.bg_fill) } else { name });
            let number = |ui: &mut Ui, text: String, is_strong: bool| {
                let text = RichText::new(text).monospace().small();
                ui.label(if is_strong { text.strong() } else { text });
            };
            let after = |ui: &mut Ui, is_known: bool, before: String, after: String| match is_known {
                _ if !has_after => {}
                true => number(ui, after.clone(), after != before),
                false => number(ui, "?".into(), false),
            };
            let [from, to] = [step.from, step.to].map(|cell| cell[axis].to_string());
            number(ui, from.clone(), false);
            after(ui, known.cell, from, to);
            let [before, new] = [step.before, step.after].map(|ray| short(ray.tmax[axis]));
            number(ui, before.clone(), is_next);
            after(ui, known.tmax, before, new);
            number(ui, short(step.t_delta(axis)), false);
            ui.end_row();
        }
    });
    // Before that, the ray may still have another state.
    if known.state {
        ui.small(format!("state: {}, after: {}", step.before.state, step.after.state));
    }
}

/// Shows every state that the run's kernels take, where they send a ray from there, and how often this ray went there.
pub(super) fn states(ui: &mut Ui, model: &Model) {
    let (Some(history), Some(opened)) = (&model.history, &model.opened) else { return };
    let current =
        row_after_passes(history, model.place).and_then(|row| history.rows.get(row)).map(|row| row.after.state);
    ui.add_space(6.0);
    let mut kernels: Vec<_> = opened.plan.schedule.kernels();
    kernels.sort_by_key(|kernel| kernel.takes().first().copied());
    for kernel in kernels {
        let info = kernel.info();
        for &state in info.takes {
            let name = opened.plan.program.states.name(state);
            let text = in_strong(format!("{name}: {}", info.name));
            ui.label(if current == Some(name) { text.background_color(ui.visuals().selection.bg_fill) } else { text });
            let mut shown = Vec::new();
            for sent in info.sends.iter().filter(|sent| sent.from == state && is_possible(sent, info, opened)) {
                if shown.contains(&sent.to) {
                    continue;
                }
                shown.push(sent.to);
                let to = opened.plan.program.states.name(sent.to);
                let count = times(history, info.name, name, to);
                let text = RichText::new(format!("    to {to}: {}", sent.when)).small();
                if count > 0 {
                    ui.label(RichText::new(format!("{} ({count}×)", text.text())).small().strong());
                } else {
                    ui.label(text.weak());
                }
            }
        }
    }
}

/// How often a ray went from one state to another.
fn times(history: &Trace, kernel: &str, from: &str, to: &str) -> usize {
    let is_it = |row: &&raystep_kernels::export::trace::TraceRow| {
        (row.kernel, row.state_before, row.after.state) == (kernel, from, to)
    };
    history.rows.iter().filter(is_it).count()
}

/// Whether a run with this structure has a transition of a kernel.
fn is_possible(sent: &Transition, kernel: &KernelInfo, opened: &Opened) -> bool {
    let features = &opened.data.features;
    let has_grid = features.grid || features.irregular;
    !(sent.when.starts_with("with a BVH") && !features.bvh
        || sent.when.starts_with("without a grid") && has_grid
        || sent.when.starts_with("loop turns spent") && !(kernel.resumes)(features))
}

/// Shows what the ray may hit.
pub(super) fn candidates(ui: &mut Ui, candidates: &Candidates) {
    for candidate in &candidates.0 {
        ui.add_space(6.0);
        strong(ui, format!("triangle {}", candidate.triangle));
        Grid::new(("candidate", candidate.triangle)).num_columns(2).spacing([10.0, 2.0]).show(ui, |ui| {
            let [t, t_bound] = candidate.exact_t;
            let [weight, weight_bound] = candidate.weight;
            for (name, text) in [
                ("t in f32", candidate.t.map_or_else(|| "missed".into(), |t| t.to_string())),
                ("t in f64", format!("{t:?}")),
                ("error of f32", format!("up to {}", Value::small(t_bound))),
                ("smallest weight", Value::small(weight).to_string()),
                ("error of f32", format!("up to {}", Value::small(weight_bound))),
            ] {
                ui.label(name);
                ui.monospace(text);
                ui.end_row();
            }
        });
    }
}
