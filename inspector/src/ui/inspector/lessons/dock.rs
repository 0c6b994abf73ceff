//! The lesson beside the panels.

use egui::{Align, Button, Label, Layout, Panel, ScrollArea, Ui};

use raystep_lab::text::counted;

use super::step_text::Shown;
use super::{Lesson, bars, tables};
use crate::command::Command;
use crate::ui::inspector::Inspector;
use crate::ui::style::strong;

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
                ui.heading(&lesson.lesson.title);
            });
            self.steps(ui, &lesson, &mut chosen);
            self.problems(ui, &lesson, &mut chosen);
            ui.separator();
            let area = ScrollArea::vertical().auto_shrink(false).id_salt(("lesson", lesson.step));
            let area = if std::mem::take(&mut lesson.is_new) { area.vertical_scroll_offset(0.0) } else { area };
            let is_chosen_now = std::mem::take(&mut lesson.is_chosen_now);
            area.show(ui, |ui| self.contents(ui, &lesson, is_chosen_now, &mut chosen));
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

    /// What went wrong.
    fn problems(&self, ui: &mut Ui, lesson: &Lesson, chosen: &mut Option<Command>) {
        if lesson.is_waiting() || lesson.problems.is_empty() {
            return;
        }
        for problem in &lesson.problems {
            ui.colored_label(ui.visuals().error_fg_color, problem.to_string());
        }
        if ui.button("Set up again").clicked() {
            *chosen = Some(Command::RepeatStep);
        }
    }

    /// The step's title, text, question and answer, and what it shows besides.
    fn contents(&self, ui: &mut Ui, lesson: &Lesson, is_chosen_now: bool, chosen: &mut Option<Command>) {
        let Some(step) = lesson.lesson.steps.get(lesson.step) else { return };
        strong(ui, &step.title);
        paragraphs(ui, &lesson.text.first);
        if let Some(known) = lesson.set_up.before_after.filter(|_| !lesson.is_waiting()) {
            tables::before_after(ui, &self.model, known);
        }
        if let Some(command) = lesson.ask(ui, is_chosen_now) {
            *chosen = Some(command);
        }
        paragraphs(ui, &lesson.text.answer);
        if lesson.is_waiting() {
            self.progress(ui, lesson);
        }
        play(ui, lesson, chosen);
        if lesson.set_up.has_states && !lesson.is_waiting() {
            tables::states(ui, &self.model);
        }
        bars::show(ui, &lesson.measured, &lesson.set_up.bars);
        if let Some(candidates) = &lesson.candidates {
            tables::candidates(ui, candidates);
        }
    }

    /// What is in progress, in the place of what is still to come.
    fn progress(&self, ui: &mut Ui, lesson: &Lesson) {
        ui.add_space(4.0);
        ui.horizontal_wrapped(|ui| {
            ui.spinner();
            let what = self.model.work.map_or("setting up", |work| work.what);
            let text =
                if lesson.text.is_pending() { format!("{what}: the text goes on then") } else { what.to_owned() };
            ui.label(text);
        });
    }
}

/// Paragraphs, without those that wait for values.
fn paragraphs(ui: &mut Ui, paragraphs: &[Option<Shown>]) {
    for paragraph in paragraphs.iter().flatten() {
        ui.add_space(4.0);
        let job = paragraph.job(ui);
        ui.add(Label::new(job).wrap());
    }
}

/// How far what goes on by itself has come, and buttons for it.
fn play(ui: &mut Ui, lesson: &Lesson, chosen: &mut Option<Command>) {
    let Some(play) = &lesson.play else { return };
    ui.add_space(6.0);
    ui.horizontal_wrapped(|ui| {
        let [made, all] = play.steps();
        let name = if play.is_paused { "Play" } else { "Pause" };
        for (command, name) in [(Command::Play, name), (Command::SkipPlay, "Skip")] {
            if ui.add_enabled(!play.is_over(), Button::new(name)).clicked() {
                *chosen = Some(command);
            }
        }
        ui.label(format!("{made} of {}", counted(all, "iteration")));
    });
}
