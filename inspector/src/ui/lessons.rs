//! Lessons in the window: a dock with the text beside the panels, and the set-up of each step.
//!
//! A step's set-up does not depend on what was shown before: it is always the whole of [`SetUp`], from the scene to the
//! panels. So a reader may click around, go back, or press *Next* while the set-up of a step is still in progress.

mod arrange;
mod bars;
mod candidates;
mod check;
mod dock;
mod facts;
mod measured;
mod perform;
mod told;

use std::sync::Arc;

use egui_tiles::Tree;

use super::Inspector;
use super::pane::Pane;
use crate::lesson::{self, LessonError, SetUp, built_in};
use candidates::Candidates;
pub use check::CheckedStep;
use measured::Measured;
use perform::Phase;
use told::Told;

/// The open lesson.
pub(super) struct Lesson {
    lesson: Arc<lesson::Lesson>,
    /// The current step, from 0.
    step: usize,
    set_up: SetUp,
    /// What is set up next.
    phase: Phase,
    /// What went wrong with the current step.
    problems: Vec<LessonError>,
    /// Runs that were measured, for all steps.
    measured: Vec<Measured>,
    /// What the ray may hit, if the step asks for it.
    candidates: Option<Candidates>,
    /// The text with its values.
    told: Told,
    /// The panels before the lesson.
    before: Option<Tree<Pane>>,
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
            None => Some(std::mem::replace(&mut self.tree, super::layout::Layout::Simple.tree())),
        };
        let mut open = Lesson {
            lesson: Arc::new(lesson),
            step: 0,
            set_up: SetUp::default(),
            phase: Phase::Done,
            problems: Vec::new(),
            measured: Vec::new(),
            candidates: None,
            told: Told::default(),
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
        if let Some(lesson) = &mut self.lesson {
            lesson.go_to(step);
        }
    }

    /// Ends the lesson: the panels are again those of before.
    pub(super) fn close_lesson(&mut self) {
        if let Some(before) = self.lesson.take().and_then(|lesson| lesson.before) {
            self.tree = before;
        }
    }

    /// The panels to save: not those of a lesson.
    pub(super) fn own_tree(&self) -> &Tree<Pane> {
        self.lesson.as_ref().and_then(|lesson| lesson.before.as_ref()).unwrap_or(&self.tree)
    }

    /// The same, to restore them.
    pub(super) fn own_tree_mut(&mut self) -> &mut Tree<Pane> {
        self.lesson.as_mut().and_then(|lesson| lesson.before.as_mut()).unwrap_or(&mut self.tree)
    }
}

impl Lesson {
    /// Goes to a step. What is in progress for another one ends first.
    fn go_to(&mut self, step: usize) {
        self.step = step.min(self.lesson.steps.len().saturating_sub(1));
        self.set_up = self.lesson.set_up(self.step);
        (self.phase, self.is_new) = (Phase::Open, true);
        self.problems.clear();
        self.candidates = None;
        self.told = Told::of(&self.lesson, self.step);
    }

    /// Stops the set-up of its step.
    pub(super) fn stop(&mut self) {
        if self.is_waiting() {
            let problem = self.error(self.set_up.line, lesson::Wrong::SetUp("cancelled".into()));
            self.problems.push(problem);
            self.phase = Phase::Done;
        }
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
