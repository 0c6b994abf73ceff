//! Lessons in the window: a dock with the text beside the panels, and the set-up of each step.
//!
//! A step's set-up does not depend on what was shown before: it is always the whole of [`SetUp`], from the scene to the
//! panels. So a reader may click around, go back, or press *Next* while the set-up of a step is still in progress.

mod arrange;
mod ask;
mod bars;
mod before;
mod candidates;
mod cell_step;
mod check;
mod dock;
mod facts;
mod light;
mod measured;
mod perform;
mod play;
mod step_text;
mod tables;

use std::sync::Arc;

use egui_tiles::Tree;

use self::before::Before;
use self::candidates::Candidates;
pub use self::check::CheckedStep;
use self::measured::Measured;
use self::perform::Phase;
use self::play::Play;
use self::step_text::StepText;
use super::Inspector;
use crate::lesson::{self, LessonError, SetUp, built_in};
use crate::ui::desk::arranged::Now;
use crate::ui::panes::Pane;

/// The open lesson.
pub(super) struct Lesson {
    lesson: Arc<lesson::Lesson>,
    /// The current step, from 0.
    step: usize,
    set_up: SetUp,
    /// What is set up next.
    phase: Phase,
    /// Whether the set-up of the step was cancelled: what is missing is offered again.
    is_cancelled: bool,
    /// What went wrong with the current step.
    problems: Vec<LessonError>,
    /// Runs that were measured, for all steps.
    measured: Vec<Measured>,
    /// What the ray may hit, if the step asks for it.
    candidates: Option<Candidates>,
    /// The text with its values.
    text: StepText,
    /// Which choice of the question the reader made last, and whether it was since the last frame.
    chosen: Option<usize>,
    is_chosen_now: bool,
    /// Whether that was the right one: the answer is shown.
    is_answered: bool,
    /// What goes on by itself.
    play: Option<Play>,
    /// What was there before the lesson.
    before: Before,
    /// Whether the step has opened a run.
    is_opened_now: bool,
    /// Threads that a GPU would have launched for all that this step has traced so far.
    work: u64,
    /// Where the lesson was drawn last.
    dock: egui::Rect,
    /// Whether the text is scrolled to its beginning in the next frame.
    is_new: bool,
}

impl Inspector {
    /// Begins a lesson at one of its steps, counted from 0.
    pub fn begin_lesson(&mut self, lesson: lesson::Lesson, step: usize) {
        let before = match self.lesson.take() {
            Some(other) => other.before,
            None => Before::take(self),
        };
        self.cancel_lesson_job();
        let mut open = Lesson {
            lesson: Arc::new(lesson),
            step: 0,
            set_up: SetUp::default(),
            phase: Phase::Done,
            is_cancelled: false,
            problems: Vec::new(),
            measured: Vec::new(),
            candidates: None,
            text: StepText::default(),
            chosen: None,
            is_chosen_now: false,
            is_answered: false,
            play: None,
            is_opened_now: false,
            work: 0,
            before,
            dock: egui::Rect::NOTHING,
            is_new: true,
        };
        open.go_to(step);
        self.lesson = Some(open);
    }

    /// Begins a built-in lesson.
    pub(super) fn begin_built_in(&mut self, index: usize) {
        let Some((file, text)) = built_in::LESSONS.get(index) else { return };
        match lesson::Lesson::parse(file, text) {
            Ok(lesson) => self.begin_lesson(lesson, 0),
            Err(error) => self.fail(error.to_string()),
        }
    }

    /// Begins a built-in lesson by its name, that of its file without the ending, at a step counted from 0.
    pub fn begin_named_lesson(&mut self, name: &str, step: usize) {
        match built_in::lesson(name) {
            Some(index) => {
                self.begin_built_in(index);
                self.go_to_step(step);
            }
            None => {
                let names: Vec<&str> = built_in::lessons().collect();
                self.fail(format!("there is no lesson {name:?}; there are {}", names.join(", ")));
            }
        }
    }

    /// The step of the open lesson, counted from 0, and their number.
    #[must_use]
    pub fn lesson_step(&self) -> Option<(usize, usize)> {
        self.lesson.as_ref().map(|lesson| (lesson.step, lesson.lesson.steps.len()))
    }

    /// Goes to a step of the open lesson, counted from 0; the last one if there are fewer.
    pub fn go_to_step(&mut self, step: usize) {
        self.cancel_lesson_job();
        if let Some(lesson) = &mut self.lesson {
            lesson.go_to(step);
        }
    }

    /// Sets the step up again; one that was cancelled keeps its answer.
    pub(super) fn repeat_step(&mut self) {
        self.cancel_lesson_job();
        match &mut self.lesson {
            Some(lesson) if lesson.is_cancelled => lesson.begin_set_up(),
            Some(lesson) => lesson.go_to(lesson.step),
            None => {}
        }
    }

    /// Ends the lesson: the panels, the scene and its options are again those of before.
    pub(super) fn close_lesson(&mut self) {
        self.cancel_lesson_job();
        self.state.display.code = None;
        if let Some(lesson) = self.lesson.take() {
            lesson.before.restore(self);
        }
    }

    /// Does not wait for what the step has measured or looked for so far, and is not needed any more.
    fn cancel_lesson_job(&mut self) {
        let is_own = |what: &str| [measured::MEASURING, candidates::FINDING, candidates::SEEKING].contains(&what);
        if self.model.work.is_some_and(|work| is_own(work.what)) {
            self.model.cancel();
        }
    }

    /// The panels to save: not those of a lesson.
    pub(super) fn own_tree(&self) -> &Tree<Pane> {
        self.lesson.as_ref().map_or(&self.desk.tree, |lesson| &lesson.before.tree)
    }

    /// The same, to restore them.
    pub(super) fn own_tree_mut(&mut self) -> &mut Tree<Pane> {
        self.lesson.as_mut().map_or(&mut self.desk.tree, |lesson| &mut lesson.before.tree)
    }

    /// The layout to save: not that of a lesson.
    pub(super) fn own_arranged(&self) -> &Now {
        self.lesson.as_ref().map_or(&self.desk.arranged.now, |lesson| &lesson.before.arranged)
    }

    /// The same, to restore it.
    pub(super) fn own_arranged_mut(&mut self) -> &mut Now {
        self.lesson.as_mut().map_or(&mut self.desk.arranged.now, |lesson| &mut lesson.before.arranged)
    }

    /// The units to save: not those of a lesson.
    pub(super) fn own_units(&self) -> crate::ui::units::Units {
        self.lesson.as_ref().map_or(self.state.display.units, |lesson| lesson.before.units)
    }

    /// The same, to restore them.
    pub(super) fn own_units_mut(&mut self) -> &mut crate::ui::units::Units {
        self.lesson.as_mut().map_or(&mut self.state.display.units, |lesson| &mut lesson.before.units)
    }
}

impl Lesson {
    /// Goes to a step. What is in progress for another one ends first.
    fn go_to(&mut self, step: usize) {
        self.step = step.min(self.lesson.steps.len().saturating_sub(1));
        (self.is_new, self.is_answered, self.chosen, self.work) = (true, false, None, 0);
        self.problems.clear();
        self.text = StepText::of(&self.lesson, self.step);
        self.begin_set_up();
    }

    /// Sets its step up, with the answer if the question is answered.
    fn begin_set_up(&mut self) {
        let before = std::mem::replace(&mut self.set_up, self.lesson.set_up(self.step, self.is_answered));
        // The ray that was found stays.
        if self.is_answered && self.set_up.find.is_some() {
            self.set_up.pixel = before.pixel;
        }
        (self.phase, self.is_cancelled) = (Phase::Open, false);
        (self.candidates, self.play) = (None, None);
    }

    /// Whether a run of this name was measured.
    fn has_measured(&self, name: &str) -> bool {
        self.measured.iter().any(|run| run.name == name)
    }

    /// Stops the set-up of its step.
    pub(super) fn stop(&mut self) {
        if self.is_waiting() {
            (self.phase, self.is_cancelled) = (Phase::Done, true);
        }
    }

    /// Runs that the step needs and that are not measured yet.
    fn unmeasured(&self) -> usize {
        self.set_up.measurements.iter().filter(|wanted| !self.has_measured(&wanted.name)).count()
    }

    /// Whether its step is still being set up.
    pub(super) fn is_waiting(&self) -> bool {
        self.phase != Phase::Done
    }

    /// Whether there is a step after or before this one.
    pub(super) fn has(&self, is_next: bool) -> bool {
        if is_next { self.step + 1 < self.lesson.steps.len() } else { self.step > 0 }
    }

    fn error(&self, line: usize, wrong: lesson::Wrong) -> LessonError {
        LessonError { file: self.lesson.file.clone(), line, wrong }
    }
}
