//! Built-in lessons: each step has a text and sets up the inspector for it.

mod texts;

use egui::text::LayoutJob;
use egui::{FontSelection, Label, RichText};

use super::command::Command;
use super::layout;
use super::{Arrival, Inspector};
use crate::session::Target;
use crate::session::request::Request;
use crate::settings::Settings;
use texts::LESSONS;

/// An action of a step, besides showing its text.
enum Do {
    /// Opens the built-in Cornell box with these settings, at a pixel, after a number of passes.
    Open(fn() -> Settings, [u32; 2], usize),
    /// Goes to a place.
    Go(usize),
    /// To the end.
    End,
    /// Goes to the selected ray's next event, this many times.
    Events(usize),
    /// Shows a panel.
    Show(super::pane::PaneKind),
    /// Performs a command.
    Perform(Command),
}

/// A step of a lesson.
struct Step {
    /// Its text, one paragraph: `**strong**` and `` `code` `` as in Markdown.
    text: &'static str,
    /// Its actions.
    set_up: &'static [Do],
}

/// A lesson.
struct LessonText {
    command: Command,
    title: &'static str,
    steps: &'static [Step],
}

/// The open lesson, and the current step.
pub(super) struct Lesson {
    lesson: &'static LessonText,
    step: usize,
    /// Actions still to be performed for this step; they need an open run.
    waiting: Vec<&'static Do>,
}

/// The path of the built-in scene.
pub(super) const BUILT_IN: &str = "built-in:cornell-box";

/// Text enclosed in `**` and `` ` ``, in the corresponding styles.
fn paragraph(ui: &egui::Ui, text: &str) -> LayoutJob {
    let mut job = LayoutJob::default();
    for (strong, part) in text.split("**").enumerate() {
        for (code, part) in part.split('`').enumerate() {
            let mut words = RichText::new(part);
            if strong % 2 == 1 {
                words = words.strong();
            }
            if code % 2 == 1 {
                words = words.code();
            }
            words.append_to(&mut job, ui.style(), FontSelection::Default, egui::Align::Center);
        }
    }
    job
}

impl Inspector {
    pub(super) fn begin_lesson(&mut self, command: Command) {
        if let Some(lesson) = LESSONS.iter().find(|lesson| lesson.command == command) {
            let mut lesson = Lesson { lesson, step: 0, waiting: Vec::new() };
            lesson.set_up();
            self.lesson = Some(lesson);
        }
    }

    /// Shows the open lesson, and sets up its step once nothing else is in progress.
    pub(super) fn show_lesson(&mut self, ctx: &egui::Context) {
        let Some(mut lesson) = self.lesson.take() else { return };
        let mut is_open = true;
        let steps = lesson.lesson.steps;
        egui::Window::new(lesson.lesson.title)
            .open(&mut is_open)
            .default_width(360.0)
            .default_pos(ctx.content_rect().right_bottom() - egui::vec2(400.0, 380.0))
            .resizable(true)
            .show(ctx, |ui| {
                egui::ScrollArea::vertical().max_height(300.0).show(ui, |ui| {
                    ui.add(Label::new(paragraph(ui, steps[lesson.step].text)).wrap());
                });
                ui.separator();
                ui.horizontal(|ui| {
                    ui.label(format!("step {} of {}", lesson.step + 1, steps.len()));
                    if ui.add_enabled(lesson.step > 0, egui::Button::new("Back")).clicked() {
                        lesson.step -= 1;
                        lesson.set_up();
                    }
                    let is_last = lesson.step + 1 == steps.len();
                    if ui.add_enabled(!is_last, egui::Button::new("Next")).clicked() {
                        lesson.step += 1;
                        lesson.set_up();
                    }
                });
            });
        while !self.model.is_busy() && self.todo.is_empty() && !lesson.waiting.is_empty() {
            let next = lesson.waiting.remove(0);
            self.set_up(next);
        }
        if is_open {
            self.lesson = Some(lesson);
        }
    }

    fn set_up(&mut self, what: &Do) {
        match *what {
            Do::Open(settings, pixel, place) => {
                let arrival = Arrival { pixel: Some(pixel), place: Some(place), shown: None };
                self.shared.pixel = None;
                self.open(BUILT_IN, settings(), arrival);
            }
            Do::Go(place) => {
                self.model.ask(Request::Step(Target::Pass(place)));
            }
            Do::End => {
                self.model.ask(Request::Step(Target::End));
            }
            Do::Events(times) => (0..times).for_each(|_| self.perform(Command::NextEvent)),
            Do::Show(kind) => layout::show(&mut self.tree, kind),
            Do::Perform(command) => self.perform(command),
        }
    }
}

impl Lesson {
    fn set_up(&mut self) {
        self.waiting = self.lesson.steps[self.step].set_up.iter().collect();
    }

    /// Whether actions remain.
    pub(super) fn is_waiting(&self) -> bool {
        !self.waiting.is_empty()
    }
}
