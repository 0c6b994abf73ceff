//! The built-in lessons.
//!
//! Touches: asks.

use egui::{Button, Label, RichText, ScrollArea, Ui};
use raystep_lab::text::counted;

use crate::command::Command;
use crate::lesson::{Lesson, built_in};
use crate::ui::pane::{Context, Panel};
use crate::ui::style::in_strong;

/// The panel.
pub(in crate::ui) struct Lessons {
    lessons: Vec<Lesson>,
}

impl Default for Lessons {
    fn default() -> Self {
        // A test reads all of them.
        let lessons = built_in::LESSONS.iter().filter_map(|(file, text)| Lesson::parse(file, text).ok());
        Self { lessons: lessons.collect() }
    }
}

impl Panel for Lessons {
    fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            ui.add(
                Label::new("Each lesson opens a scene of its own and asks questions; yours comes back afterwards.")
                    .wrap(),
            );
            for (index, lesson) in self.lessons.iter().enumerate() {
                ui.add_space(10.0);
                ui.add(Label::new(in_strong(&lesson.title)).wrap());
                let steps: Vec<&str> = lesson.steps.iter().map(|step| step.title.as_str()).collect();
                ui.add(Label::new(RichText::new(steps.join(" · ")).weak()).wrap());
                let begin = Button::new(format!("Begin: {}", counted(steps.len(), "step")));
                if ui.add(begin).on_hover_text(Command::Lesson(index).name()).clicked() {
                    cx.asks.commands.push(Command::Lesson(index));
                }
            }
        });
    }
}
