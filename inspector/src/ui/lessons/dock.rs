//! The lesson beside the panels.

use egui::{Align, Button, Label, Layout, Panel, RichText, ScrollArea, Ui};

use super::candidates::Candidates;
use super::{Lesson, bars};
use crate::lesson::Value;
use crate::ui::Inspector;
use crate::ui::command::Command;

/// Widths in points: at first, and the least.
const WIDTH: [f32; 2] = [330.0, 120.0];

impl Inspector {
    /// Shows the open lesson at the left.
    pub(in crate::ui) fn show_lesson(&mut self, ui: &mut Ui) {
        let Some(mut lesson) = self.lesson.take() else { return };
        let most = (ui.available_width() * 0.45).max(40.0);
        let [first, least] = WIDTH.map(|width| width.min(most));
        let frame = egui::Frame::side_top_panel(ui.style()).fill(egui::Color32::TRANSPARENT);
        let panel = Panel::left("lesson").frame(frame).default_size(first).size_range(least..=most);
        let mut chosen = None;
        let shown = panel.show(ui, |ui| {
            ui.horizontal_wrapped(|ui| {
                ui.strong(RichText::new(&lesson.lesson.title).size(15.0));
            });
            self.steps(ui, &lesson, &mut chosen);
            self.progress(ui, &lesson, &mut chosen);
            ui.separator();
            let area = ScrollArea::vertical().auto_shrink(false).id_salt(("lesson", lesson.step));
            let area = if std::mem::take(&mut lesson.is_new) { area.vertical_scroll_offset(0.0) } else { area };
            area.show(ui, |ui| contents(ui, &lesson));
        });
        lesson.dock = shown.response.rect;
        self.lesson = Some(lesson);
        if let Some(command) = chosen {
            self.perform(command);
        }
    }

    /// The number of the step, and buttons to others.
    fn steps(&self, ui: &mut Ui, lesson: &Lesson, chosen: &mut Option<Command>) {
        ui.horizontal_wrapped(|ui| {
            for (command, name, is_possible) in
                [(Command::PreviousStep, "Back", lesson.has(false)), (Command::NextStep, "Next", lesson.has(true))]
            {
                let text = format!("{} ({})", command.name(), command.key_text(ui.ctx()));
                if ui.add_enabled(is_possible, Button::new(name)).on_hover_text(text).clicked() {
                    *chosen = Some(command);
                }
            }
            ui.label(format!("step {} of {}", lesson.step + 1, lesson.lesson.steps.len()));
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                if ui.button("Close").on_hover_text("closes the lesson and restores the previous panels").clicked() {
                    *chosen = Some(Command::CloseLesson);
                }
            });
        });
    }

    /// What is in progress, and what went wrong.
    fn progress(&self, ui: &mut Ui, lesson: &Lesson, chosen: &mut Option<Command>) {
        if lesson.is_waiting() {
            ui.horizontal_wrapped(|ui| {
                ui.spinner();
                let what =
                    self.model.work.map_or("setting up …".into(), |work| format!("setting up: {} …", work.what));
                ui.label(what);
            });
            return;
        }
        if lesson.problems.is_empty() {
            return;
        }
        for problem in &lesson.problems {
            ui.colored_label(ui.visuals().error_fg_color, problem.to_string());
        }
        if ui.button("Set up again").clicked() {
            *chosen = Some(Command::RepeatStep);
        }
    }
}

/// The step's title, text, and what it shows besides.
fn contents(ui: &mut Ui, lesson: &Lesson) {
    let Some(step) = lesson.lesson.steps.get(lesson.step) else { return };
    ui.strong(&step.title);
    for paragraph in &lesson.told.paragraphs {
        ui.add_space(4.0);
        let job = paragraph.job(ui);
        ui.add(Label::new(job).wrap());
    }
    bars::show(ui, &lesson.measured, &lesson.set_up.bars);
    if let Some(candidates) = &lesson.candidates {
        table(ui, candidates);
    }
}

/// What the ray may hit.
fn table(ui: &mut Ui, candidates: &Candidates) {
    for candidate in &candidates.0 {
        ui.add_space(6.0);
        ui.strong(format!("triangle {}", candidate.triangle));
        egui::Grid::new(("candidate", candidate.triangle)).num_columns(2).spacing([10.0, 2.0]).show(ui, |ui| {
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
