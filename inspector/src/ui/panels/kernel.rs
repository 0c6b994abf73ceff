//! The kernel's WGSL, with the lines that ran for the selected ray in the current pass.

mod listing;

use std::sync::Arc;

use egui::RichText;
use raystep_kernels::Kernel;
use raystep_kernels::export::trace::{RayState, Trace};
use raystep_kernels::programs::closest_hit::states;
use serde::{Deserialize, Serialize};

use super::ray::current_row;
use crate::session::Model;
use crate::session::request::Opened;
use crate::source::{self, Line, Mark};
use crate::ui::pane::{Context, Panel};
use listing::Listing;

/// What of the view is saved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
struct Look {
    /// Show the composed source instead of the kernel's own file.
    composed: bool,
}

/// Key of the displayed lines.
#[derive(Clone)]
struct Shown {
    generation: u64,
    kernel: Kernel,
    /// The ray's history, and the current row.
    row: Option<(Arc<Trace>, usize)>,
    composed: bool,
}

impl PartialEq for Shown {
    fn eq(&self, other: &Self) -> bool {
        let same_row = match (&self.row, &other.row) {
            (Some((a, i)), Some((b, j))) => Arc::ptr_eq(a, b) && i == j,
            (a, b) => a.is_none() && b.is_none(),
        };
        same_row && (self.generation, self.kernel, self.composed) == (other.generation, other.kernel, other.composed)
    }
}

/// The kernel's source.
#[derive(Default)]
pub(in crate::ui) struct KernelView {
    look: Look,
    shown: Option<Shown>,
    listing: Listing,
}

impl Panel for KernelView {
    fn title(&self) -> String {
        self.shown.as_ref().map_or_else(|| "Kernel".into(), |shown| format!("Kernel {}", shown.kernel.name()))
    }

    fn show(&mut self, ui: &mut egui::Ui, cx: &mut Context<'_>) {
        let Some(opened) = &cx.model.opened else {
            ui.weak("Open a scene to see the kernel of its last pass.");
            return;
        };
        let Some(shown) = self.what(cx.model) else {
            ui.weak("This run has no passes.");
            return;
        };
        if self.shown.as_ref() != Some(&shown) {
            self.listing.set(lines(&shown, opened));
            self.shown = Some(shown.clone());
        }
        self.head(ui, &shown, cx.model);
        self.listing.show(ui);
    }

    fn save(&self) -> String {
        serde_json::to_string(&self.look).unwrap_or_default()
    }

    fn load(&mut self, saved: &str) {
        if let Ok(look) = serde_json::from_str(saved) {
            self.look = look;
        }
    }
}

impl KernelView {
    /// The ray's last pass; without a ray the last pass of all, and before the first pass the next one.
    fn what(&self, model: &Model) -> Option<Shown> {
        let row = model.life.as_ref().and_then(|life| Some((life.clone(), current_row(life, model.place)?)));
        let of_row = row
            .as_ref()
            .and_then(|(life, row)| model.opened.as_ref()?.plan.program.kernel(life.rows.get(*row)?.kernel));
        let kernel = of_row.or(model.last_pass().map(|pass| pass.kernel)).or(model.next)?;
        let row = row.filter(|_| of_row.is_some());
        Some(Shown { generation: model.generation, kernel, row, composed: self.look.composed })
    }

    fn head(&mut self, ui: &mut egui::Ui, shown: &Shown, model: &Model) {
        ui.horizontal_wrapped(|ui| {
            let own = "the kernel's own file, including its options (@if)";
            ui.selectable_value(&mut self.look.composed, false, "file").on_hover_text(own);
            let all = "the source given to the device: options resolved, shared functions included; lines are not \
                       marked";
            ui.selectable_value(&mut self.look.composed, true, "composed").on_hover_text(all);
            if ui.button("Copy").on_hover_text("copy the whole source to the clipboard").clicked() {
                ui.ctx().copy_text(self.listing.text());
            }
            ui.strong(shown.kernel.name()).on_hover_text(shown.kernel.info().summary);
            if shown.row.is_some() && !shown.composed {
                listing::legend(ui);
            }
        });
        match shown.row.as_ref().and_then(|(life, row)| life.rows.get(*row)) {
            Some(row) => {
                let is_last = row.place() == Some(model.place);
                let when = if is_last { "" } else { " (the ray's last so far)" };
                ui.label(RichText::new(format!("pass {}{when}: {}", row.number(), row.why)).strong());
            }
            None => drop(ui.weak(shown.kernel.info().summary)),
        }
        ui.separator();
    }
}

fn lines(shown: &Shown, opened: &Opened) -> Vec<Line> {
    let variant = opened.plan.variant(shown.kernel).filter(|_| shown.composed);
    if let Some(variant) = variant {
        return source::composed(variant);
    }
    let states = shown.row.as_ref().and_then(|(life, row)| before_and_after(life, *row));
    source::kernel_file(shown.kernel, &opened.plan.features, states.as_ref().map(|(before, after)| (before, after)))
}

/// The ray before and after a row. Before its first row, only its state is known.
fn before_and_after(life: &Trace, row: usize) -> Option<(RayState, RayState)> {
    let now = life.rows.get(row)?;
    let before = row.checked_sub(1).and_then(|i| life.rows.get(i)).map(|row| row.after);
    let unknown = || {
        let tag = states::STATES
            .iter()
            .find(|state| state.name == now.state_before)
            .map_or(states::UNWRITTEN, |state| state.tag);
        RayState { tag, state: now.state_before, ..now.after }
    };
    Some((before.unwrap_or_else(unknown), now.after))
}

/// The first line of the first branch taken; otherwise the first line that ran.
fn first_taken(lines: &[Line]) -> Option<usize> {
    const BRANCHES: [&str; 6] = ["if", "} else", "for", "while", "loop", "switch"];
    let depth = |line: &Line| line.text.len() - line.text.trim_start().len();
    let is_taken = |pair: &[Line]| {
        let [head, body] = pair else { return false };
        let text = head.text.trim_start();
        let is_branch = BRANCHES.iter().any(|word| {
            text.strip_prefix(word)
                .is_some_and(|rest| !rest.starts_with(|c: char| c.is_ascii_alphanumeric() || c == '_'))
        });
        is_branch && head.mark == Mark::Run && body.mark == Mark::Run && depth(body) > depth(head)
    };
    let branch = lines.windows(2).position(is_taken);
    branch.or_else(|| lines.iter().position(|line| line.mark == Mark::Run))
}

#[cfg(test)]
mod tests {
    use raystep_kernels::Accelerator;
    use raystep_kernels::programs::closest_hit::PROGRAM;

    use super::super::walked::tests::life;
    use super::*;

    #[test]
    fn every_row_has_its_kernel_and_lines_that_ran() {
        for accelerator in [Accelerator::Grid, Accelerator::Bvh] {
            let (life, data) = life(accelerator);
            for (i, row) in life.rows.iter().enumerate() {
                let kernel = PROGRAM.kernel(row.kernel).expect("a kernel");
                let (before, after) = before_and_after(&life, i).expect("a row");
                assert_eq!(before.state, row.state_before, "row {i}");
                let lines = source::kernel_file(kernel, &data.features, Some((&before, &after)));
                let first = first_taken(&lines).expect("a line that ran");
                assert_eq!(lines[first].mark, Mark::Run);
            }
            assert_eq!(before_and_after(&life, life.rows.len()), None);
        }
    }

    #[test]
    fn the_branch_that_was_taken_is_found() {
        let text = "fn f() {\n  if (a) {\n    return;\n  }\n  iffy();\n  if (b) {\n    c();\n  }\n}";
        let mut lines = source::lines(text);
        assert_eq!(first_taken(&lines), None);
        lines[0].mark = Mark::Run;
        lines[1].mark = Mark::Run;
        lines[2].mark = Mark::NotRun;
        lines[4].mark = Mark::Run;
        assert_eq!(first_taken(&lines), Some(0));
        lines[5].mark = Mark::Run;
        lines[6].mark = Mark::Run;
        assert_eq!(first_taken(&lines), Some(5));
    }
}
