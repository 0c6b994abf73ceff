//! What to do before a run is kept.

use egui::{Button, ScrollArea, Ui};

use crate::command::{Command, PaneKind};
use crate::ui::pane::Context;

/// Comparisons that need no kept run.
const AT_ONCE: [(Command, &str); 4] = [
    (Command::Compare, "a second run through the BVH, pass by pass beside this one"),
    (Command::Divergence, "the first pass in which the device differs from the CPU, and f32 from f64"),
    (Command::Judge, "how many hits are wrong, against f64 and exact predicates"),
    (Command::Measure, "times of many choices of options, for this scene and view"),
];

/// The button that keeps the run.
pub(super) fn keep(ui: &mut Ui, cx: &mut Context<'_>) {
    let button = Button::new(Command::KeepRun.name());
    let about = "Completes the run if necessary, keeps its results and times, and returns to this pass.";
    if ui.add_enabled(!cx.model.is_busy(), button).on_hover_text(about).clicked() {
        cx.asks.commands.push(Command::KeepRun);
    }
}

/// Points from which both parts are side by side.
const WIDE: f32 = 900.0;

pub(super) fn show(ui: &mut Ui, cx: &mut Context<'_>) {
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        if !cx.has_rays() {
            steps(ui, cx);
        } else if ui.available_width() >= WIDE {
            ui.columns(2, |sides| {
                steps(&mut sides[0], cx);
                at_once(&mut sides[1], cx);
            });
        } else {
            steps(ui, cx);
            ui.separator();
            at_once(ui, cx);
        }
    });
}

fn steps(ui: &mut Ui, cx: &mut Context<'_>) {
    let [keep, next, previous] =
        [Command::KeepRun, Command::NextRun, Command::PreviousRun].map(|command| command.key_text(ui.ctx()));
    ui.strong("Keep two runs to see where they differ, and how long each takes.");
    ui.label(format!("1. Keep this run: the button above, or {keep}."));
    ui.horizontal_wrapped(|ui| {
        ui.label("2. Change its options, and keep that run, too:");
        if ui.button("Options").clicked() {
            cx.asks.commands.push(Command::Show(PaneKind::Options));
        }
    });
    ui.label(format!(
        "3. Flip between their pictures ({next} and {previous}), go through the rays that differ, measure both."
    ));
}

fn at_once(ui: &mut Ui, cx: &mut Context<'_>) {
    ui.strong("Or compare at once, without keeping a run.");
    for (command, about) in AT_ONCE {
        ui.horizontal_wrapped(|ui| {
            if ui.add_enabled(!cx.model.is_busy(), Button::new(command.name())).clicked() {
                cx.asks.commands.push(command);
            }
            ui.weak(about);
        });
    }
}
