//! The question of a step: the reader chooses, is told whether that is right and why, and only then gets the answer.

use egui::{Button, RichText, Ui};

use super::Lesson;
use crate::command::Command;
use crate::lesson::{Action, Step};
use crate::ui::inspector::Inspector;
use crate::ui::style::in_strong;

impl Lesson {
    /// How many choices the reader has now: none without a question, or once it is answered.
    pub(in crate::ui) fn choices(&self) -> usize {
        let is_open = !self.is_answered && !self.is_waiting();
        self.text.asked.as_ref().filter(|_| is_open).map_or(0, |asked| asked.choices.len())
    }

    /// Whether the views leave out what comes next: the reader is asked for it, or is to say it before it is played, in
    /// this step or a later one.
    pub(in crate::ui) fn hides_next(&self) -> bool {
        let asks = |step: &Step| step.question.is_some();
        let plays = |step: &Step| {
            let mut actions = step.sections().into_iter().flat_map(|section| &section.actions);
            actions.any(|(_, action)| matches!(action, Action::Play(_)))
        };
        let mut steps = self.lesson.steps.iter().skip(self.step);
        let is_here = steps.next().is_some_and(|step| plays(step) || asks(step) && !self.is_answered);
        is_here || steps.any(|step| plays(step) || asks(step))
    }

    /// The reader's choice: if it is right, the answer is set up.
    pub(in crate::ui) fn choose(&mut self, choice: usize) {
        if choice >= self.choices() {
            return;
        }
        (self.chosen, self.is_chosen_now) = (Some(choice), true);
        if self.text.asked.as_ref().is_some_and(|asked| asked.right == choice) {
            self.is_answered = true;
            self.begin_set_up();
        }
    }

    /// Shows the question, and what the reader's choice was worth. Returns the command of a button.
    pub(super) fn ask(&self, ui: &mut Ui, is_new: bool) -> Option<Command> {
        let asked = self.text.asked.as_ref()?;
        ui.add_space(8.0);
        ui.add(egui::Label::new(asked.text.job(ui)).wrap());
        let mut command = None;
        for (index, choice) in asked.choices.iter().enumerate() {
            let text = RichText::new(format!("{}  {}", index + 1, choice.label));
            let is_chosen = self.chosen == Some(index);
            let button = Button::selectable(is_chosen, text).frame(true).frame_when_inactive(true).wrap();
            if ui.add_enabled(!self.is_answered || is_chosen, button).clicked() {
                command = Some(Command::Choose(index));
            }
        }
        if let Some((index, choice)) = self.chosen.and_then(|index| Some((index, asked.choices.get(index)?))) {
            let is_right = index == asked.right;
            let verdict = if is_right { "Right." } else { "Not right." };
            let color = if is_right { right_color(ui) } else { ui.visuals().warn_fg_color };
            let label = ui.colored_label(color, in_strong(verdict));
            let label = match choice.why_not.as_ref().filter(|_| !is_right) {
                Some(why) => ui.add(egui::Label::new(why.job(ui)).wrap()),
                None => label,
            };
            if is_new {
                label.scroll_to_me(None);
            }
        }
        command
    }
}

fn right_color(ui: &Ui) -> egui::Color32 {
    let [r, g, b] = if ui.visuals().dark_mode { [80, 200, 120] } else { [20, 120, 55] };
    egui::Color32::from_rgb(r, g, b)
}

impl Inspector {
    /// Does what a reader would do in the lesson's step next, for a check of it: tries every wrong choice of the
    /// question, chooses the right one, or waits for what is played. Returns whether there was anything to do.
    pub fn go_on_with_step(&mut self) -> bool {
        let Some(lesson) = &mut self.lesson else { return false };
        if lesson.choices() > 0 {
            lesson.try_choices();
            return true;
        }
        let plays = lesson.plays();
        self.skip_lesson_play();
        plays
    }
}

impl Lesson {
    /// Performs all choices, the right one last, and notes what goes wrong.
    fn try_choices(&mut self) {
        let Some(question) = self.lesson.steps.get(self.step).and_then(|step| step.question.clone()) else { return };
        let Some(right) = self.text.asked.as_ref().map(|asked| asked.right) else { return };
        let mut wrong = Vec::new();
        for index in (0..question.choices.len()).filter(|index| *index != right).chain([right]) {
            self.choose(index);
            let line = question.choices.get(index).map_or(question.line, |choice| choice.line);
            let is_refused = !self.is_answered;
            if is_refused == (index == right) {
                let what = if is_refused { "the right choice is refused" } else { "a wrong choice is accepted" };
                wrong.push(self.error(line, crate::lesson::Wrong::Expected(what.into())));
            }
        }
        self.problems.extend(wrong);
    }
}
