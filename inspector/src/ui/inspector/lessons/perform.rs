//! Sets a step up, one thing after the other: each waits until nothing is in progress.

use super::Lesson;
use super::arrange::arrange;
use super::candidates::{Candidates, FINDING, SEEKING, Sought};
use super::measured::{MEASURING, Measured, launched_by};
use super::play::Play;
use crate::lesson::command::middle_of;
use crate::lesson::{Goal, Wrong};
use crate::link::Shown;
use crate::session::request::Request;
use crate::session::{Model, Target};
use crate::ui::{Arrival, Inspector};

/// What is set up next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Phase {
    /// The panels, and the scene.
    Open,
    /// The scene was asked for.
    Opening,
    /// The ray, and the run to its end: all passes are known then.
    Complete,
    /// The run was asked to go to its end.
    Completing,
    /// A ray with certain values was asked for.
    Seeking,
    /// A ray was selected.
    Selected,
    /// The place.
    Go,
    /// The run was asked to go there.
    Going(usize),
    /// A command.
    Command(usize),
    /// A measured run.
    Measure(usize),
    /// It was asked for.
    Measuring(usize),
    /// What the ray may hit.
    Candidates,
    /// It was asked for.
    Finding,
    /// The text's values.
    Tell,
    /// Nothing: all is done, or failed.
    Done,
}

impl Inspector {
    /// Goes on with the set-up of the lesson's step, once nothing else is in progress.
    pub(in crate::ui) fn set_up_lesson(&mut self) {
        let Some(mut lesson) = self.lesson.take() else { return };
        while lesson.is_waiting() && self.is_at_rest() {
            match self.set_up(&mut lesson) {
                Ok(next) => lesson.phase = next,
                Err((line, wrong)) => {
                    let problem = lesson.error(line, wrong);
                    lesson.problems.push(problem);
                    lesson.phase = Phase::Done;
                }
            }
        }
        // Values that were not measured cannot be told.
        if lesson.phase == Phase::Done && !lesson.is_cancelled {
            // The device may have confirmed the ray since.
            self.tell_lesson(&mut lesson, false);
        }
        self.lesson = Some(lesson);
    }

    /// Drops answers that an earlier step did not wait for; what it measured is kept.
    fn forget_answers(&mut self, lesson: &mut Lesson) {
        while let Some(measured) = self.model.take_answer::<Measured>(MEASURING) {
            if measured.is_of(&lesson.lesson) && !lesson.has_measured(&measured.name) {
                lesson.measured.push(*measured);
            }
        }
        while self.model.take_answer::<Candidates>(FINDING).is_some() {}
        while self.model.take_answer::<Option<[u32; 2]>>(SEEKING).is_some() {}
    }

    /// Whether nothing is in progress or about to be.
    pub(super) fn is_at_rest(&self) -> bool {
        let is_busy = self.model.is_busy() || self.other.as_ref().is_some_and(Model::is_busy);
        !is_busy
            && self.todo.is_empty()
            && self.scene.arrival.is_none()
            && self.state.asks.select.is_none()
            && !self.is_to_follow()
            // On the device, the ray may take another course than the CPU reference's.
            && !self.is_confirming()
    }

    fn set_up(&mut self, lesson: &mut Lesson) -> Result<Phase, (usize, Wrong)> {
        let line = lesson.set_up.line;
        let failed = |line: usize, why: &str| Err((line, Wrong::SetUp(why.to_owned())));
        Ok(match lesson.phase {
            Phase::Open => {
                self.forget_answers(lesson);
                lesson.is_opened_now = self.open_for(lesson);
                if lesson.is_opened_now { Phase::Opening } else { Phase::Complete }
            }
            Phase::Opening if self.is_open_for(lesson) => Phase::Complete,
            Phase::Opening => return failed(line, self.last_error().unwrap_or("the scene was not opened")),
            Phase::Complete => {
                if let Some(pixel) = lesson.set_up.pixel {
                    self.state.asks.select = Some(pixel);
                }
                if !self.model.is_complete {
                    self.model.ask(Request::Step(Target::End));
                }
                Phase::Completing
            }
            Phase::Completing if self.model.is_complete => match &lesson.set_up.find {
                // An answer is about the ray of its question.
                Some((_, wanted)) if !lesson.is_answered => {
                    let row = match &lesson.set_up.goal {
                        Some((_, Goal::Row(number, text))) => Some((*number, text.clone())),
                        _ => None,
                    };
                    let sought = Sought { near: lesson.set_up.pixel, wanted: wanted.clone(), row };
                    self.model.ask(sought.request());
                    Phase::Seeking
                }
                _ => Phase::Selected,
            },
            Phase::Seeking => {
                let line = lesson.set_up.find.as_ref().map_or(line, |(line, _)| *line);
                match self.model.take_answer::<Option<[u32; 2]>>(SEEKING).map(|found| *found) {
                    Some(Some(pixel)) => {
                        lesson.set_up.pixel = Some(pixel);
                        self.state.asks.select = Some(pixel);
                        Phase::Selected
                    }
                    Some(None) => return failed(line, "no ray of this run on this device is like that"),
                    None => return failed(line, self.last_error().unwrap_or("the search for a ray was stopped")),
                }
            }
            Phase::Selected => {
                if lesson.is_opened_now {
                    lesson.work +=
                        self.model.opened.as_ref().map_or(0, |run| launched_by(&run.plan, &self.model.passes));
                }
                if let Some([x, y]) = lesson.set_up.pixel.filter(|pixel| self.state.selection.pixel != Some(*pixel)) {
                    return failed(line, &format!("the image has no pixel {x},{y}"));
                }
                if let Some(shown) = lesson.set_up.shown.filter(|shown| shown.zoom.is_some() && shown.pan.is_none()) {
                    self.state.asks.show = Some(Shown { pan: lesson.set_up.pixel.map(middle_of), ..shown });
                }
                Phase::Go
            }
            Phase::Completing => return failed(line, "the run was stopped before its end"),
            Phase::Go => {
                let place = self.place_of(lesson)?;
                if self.model.place != place {
                    self.model.ask(Request::Step(Target::Pass(place)));
                }
                Phase::Going(place)
            }
            Phase::Going(place) if self.model.place == place => Phase::Command(0),
            Phase::Going(place) => {
                let line = lesson.set_up.goal.as_ref().map_or(line, |(line, _)| *line);
                return failed(line, &format!("after {} passes instead of {place}", self.model.place));
            }
            Phase::Command(index) => match lesson.set_up.commands.get(index) {
                Some(&command) if self.can(command) => {
                    self.perform(command);
                    Phase::Command(index + 1)
                }
                Some(command) => return failed(line, &format!("{:?} cannot be done here", command.name())),
                None => Phase::Candidates,
            },
            Phase::Measure(index) => match lesson.set_up.measurements.get(index) {
                Some(wanted) if lesson.has_measured(&wanted.name) => Phase::Measure(index + 1),
                Some(wanted) => {
                    self.model.ask(Measured::request(wanted, &lesson.lesson));
                    // What is known by now can be read meanwhile.
                    self.tell_lesson(lesson, true);
                    Phase::Measuring(index)
                }
                None => Phase::Tell,
            },
            Phase::Measuring(index) => match self.model.take_answer::<Measured>(MEASURING) {
                Some(measured) => {
                    lesson.work += measured.work();
                    lesson.measured.push(*measured);
                    Phase::Measure(index + 1)
                }
                None => {
                    let line = lesson.set_up.measurements.get(index).map_or(line, |wanted| wanted.line);
                    return failed(line, self.last_error().unwrap_or("the measurement was stopped"));
                }
            },
            Phase::Candidates if lesson.set_up.has_candidates => {
                let request = self.model.history.as_ref().and_then(|history| Candidates::request(history));
                match request {
                    Some(request) => drop(self.model.ask(request)),
                    None => return failed(line, "no ray is selected"),
                }
                Phase::Finding
            }
            Phase::Candidates => Phase::Measure(0),
            Phase::Finding => {
                lesson.candidates = self.model.take_answer::<Candidates>(FINDING).map(|found| *found);
                if lesson.candidates.is_none() {
                    return failed(line, "the search for what the ray may hit was stopped");
                }
                Phase::Measure(0)
            }
            Phase::Tell => {
                // Nothing is still to come.
                lesson.phase = Phase::Done;
                self.tell_lesson(lesson, true);
                let history = self.model.history.as_ref();
                let play = lesson.set_up.play.zip(history);
                lesson.play = play.map(|(steps, history)| Play::of(history, self.model.place, steps));
                Phase::Done
            }
            Phase::Done => Phase::Done,
        })
    }

    /// Shows the step's panels, and opens its scene unless that run is open already. Returns whether it is asked for.
    fn open_for(&mut self, lesson: &Lesson) -> bool {
        let set_up = &lesson.set_up;
        self.is_playing = false;
        if let Some(other) = self.other.take() {
            other.cancel();
        }
        if !lesson.keeps_panels() {
            self.desk.tree = arrange(set_up.panels.as_deref(), &set_up.more);
        }
        self.state.display.code.clone_from(&set_up.code);
        // What an earlier step asked of the stream panel, and was not shown yet, does not matter any more.
        (self.state.selection.picked, self.state.asks.show) = (None, set_up.shown);
        if self.is_open_for(lesson) {
            return false;
        }
        let link = &set_up.link;
        let arrival = Arrival { pixel: set_up.pixel, shown: set_up.shown, ..Arrival::picture() };
        let path = link.scene.as_deref().map(|scene| self.host.path_of(scene, link.scene_index));
        self.open(&path.unwrap_or_default(), self.settings_of(link), arrival);
        true
    }

    /// Whether the open run is that of the step, as it was opened.
    fn is_open_for(&self, lesson: &Lesson) -> bool {
        let link = &lesson.set_up.link;
        let path = link.scene.as_deref().map(|scene| self.host.path_of(scene, link.scene_index));
        let wanted = self.settings_of(link).on(&self.devices.gpu);
        let is_same = |opened: &crate::session::request::Opened| opened.settings == wanted && opened.path == path;
        self.model.edits.is_empty() && self.model.twins.is_none() && self.model.opened.as_ref().is_some_and(is_same)
    }

    /// The number of passes at which the step is.
    fn place_of(&self, lesson: &Lesson) -> Result<usize, (usize, Wrong)> {
        let passes = self.model.passes.len();
        let Some((line, goal)) = &lesson.set_up.goal else { return Ok(passes) };
        let failed = |why: String| Err((*line, Wrong::SetUp(why)));
        match goal {
            Goal::End => Ok(passes),
            Goal::Passes(place) if *place <= passes => Ok(*place),
            Goal::Passes(place) => failed(format!("the run has {passes} passes, so none with index {}", place - 1)),
            Goal::Row(number, text) => {
                let rows = self.model.history.as_ref().map_or(&[][..], |history| &history.rows);
                let mut found = rows.iter().filter(|row| row.why.contains(text)).filter_map(|row| row.place());
                match found.nth(number - 1) {
                    Some(place) => Ok(place),
                    None => failed(format!("the ray's history has no {number}. row with {text:?}")),
                }
            }
        }
    }
}

impl Lesson {
    /// Which of the step's runs is being measured, from 1, and how many there are.
    pub(super) fn measures(&self) -> Option<[usize; 2]> {
        match self.phase {
            Phase::Measuring(index) => Some([index + 1, self.set_up.measurements.len()]),
            _ => None,
        }
    }

    /// Whether the answer to a question has the panels that are there already: they stay as the reader left them.
    fn keeps_panels(&self) -> bool {
        let asked = self.lesson.set_up(self.step, false);
        let is_same = (&asked.panels, &asked.more) == (&self.set_up.panels, &self.set_up.more);
        self.is_answered && is_same && self.set_up.commands.is_empty()
    }
}
