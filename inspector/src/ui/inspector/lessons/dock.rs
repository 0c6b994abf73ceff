//! The lesson beside the panels.

use egui::{Align, Button, Label, Layout, Panel, ProgressBar, ScrollArea, TextStyle, Ui};

use raystep_lab::text::counted;

use super::step_text::Shown;
use super::{Lesson, bars, tables};
use crate::command::Command;
use crate::session::Work;
use crate::ui::inspector::Inspector;
use crate::ui::style::strong;

/// Widths in points: at first, in a small window and in a large one, and the least.
const WIDTH: [f32; 3] = [330.0, 480.0, 120.0];
/// Its first width as a part of the window's.
const PART: f32 = 0.27;
/// How much larger than the text of panels its text is.
const LARGER: f32 = 1.15;
/// Most characters in a line, about.
const LINE: f32 = 70.0;

impl Inspector {
    /// Shows the open lesson at the left.
    pub(in crate::ui) fn show_lesson(&mut self, ui: &mut Ui) {
        let Some(mut lesson) = self.lesson.take() else { return };
        let most = (ui.available_width() * 0.45).max(40.0);
        let [narrow, wide, least] = WIDTH.map(|width| width.min(most));
        let first = (PART * ui.available_width()).clamp(narrow, wide);
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
                let mut text = format!("{} ({})", command.name(), command.key_text(ui.ctx()));
                if lesson.measures().is_some() {
                    text += "; the measurement ends, and is repeated when you come back to this step";
                }
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

    /// What was cancelled or went wrong.
    fn problems(&self, ui: &mut Ui, lesson: &Lesson, chosen: &mut Option<Command>) {
        if lesson.is_cancelled {
            ui.horizontal_wrapped(|ui| {
                let (text, button) = match lesson.unmeasured() {
                    0 => ("This step is not set up: it was cancelled.".to_owned(), "Set up"),
                    runs => (format!("{} of this step still to be measured.", counted(runs, "run")), "Measure"),
                };
                ui.label(text);
                if ui.button(button).clicked() {
                    *chosen = Some(Command::RepeatStep);
                }
            });
        }
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
        prose(ui, |ui| {
            strong(ui, &step.title);
            paragraphs(ui, &lesson.text.first);
        });
        if let Some(known) = lesson.set_up.before_after.filter(|_| !lesson.is_waiting()) {
            tables::before_after(ui, &self.model, known);
        }
        prose(ui, |ui| {
            if let Some(command) = lesson.ask(ui, is_chosen_now) {
                *chosen = Some(command);
            }
            paragraphs(ui, &lesson.text.answer);
        });
        if lesson.is_waiting() {
            self.progress(ui, lesson, chosen);
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
    fn progress(&self, ui: &mut Ui, lesson: &Lesson, chosen: &mut Option<Command>) {
        ui.add_space(4.0);
        let what = match lesson.measures() {
            Some([index, all]) if all > 1 => format!("measuring run {index} of {all} for this step"),
            _ => self.model.work.map_or("setting up", |work| work.what).to_owned(),
        };
        let text = if lesson.text.is_pending() { format!("{what}: the text goes on then") } else { what };
        ui.horizontal_wrapped(|ui| {
            ui.spinner();
            ui.label(text);
        });
        let Some(Work { done, of, .. }) = self.model.work.filter(|work| work.of > 0) else { return };
        ui.horizontal(|ui| {
            let width = (ui.available_width() - 70.0).max(20.0);
            ui.add(ProgressBar::new(done as f32 / of as f32).desired_width(width).show_percentage());
            if ui.button("Cancel").clicked() {
                *chosen = Some(Command::Cancel);
            }
        });
    }
}

/// Text to be read as a whole: larger than that of panels, and not in long lines.
fn prose(ui: &mut Ui, add: impl FnOnce(&mut Ui)) {
    ui.scope(|ui| {
        ui.style_mut().text_styles.values_mut().for_each(|font| font.size *= LARGER);
        let font = TextStyle::Body.resolve(ui.style());
        let character = ui.fonts_mut(|fonts| fonts.glyph_width(&font, 'n'));
        ui.set_max_width(ui.available_width().min(LINE * character));
        add(ui);
    });
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
