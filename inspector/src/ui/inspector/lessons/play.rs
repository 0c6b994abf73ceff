//! Steps that a lesson makes by itself: pass by pass of the ray, at a pace that can be followed.

use raystep_kernels::export::trace::{Trace, TraceRow};

use super::Lesson;
use super::cell_step::steps_after;
use crate::session::Target;
use crate::session::request::Request;
use crate::ui::inspector::Inspector;
use crate::walk::row_after_passes;

/// Seconds between two passes of the ray.
const PACE: f64 = 0.9;

/// What is played.
pub(super) struct Play {
    /// The places to go to, in order, each with the number of steps from cell to cell made by then.
    stops: Vec<(usize, usize)>,
    /// How many of them were reached.
    reached: usize,
    pub(super) is_paused: bool,
    /// When the next one is due, in seconds of the context's time.
    due: Option<f64>,
}

impl Play {
    /// The passes of the ray after `place` in which it makes this many steps.
    pub(super) fn of(history: &Trace, place: usize, steps: usize) -> Self {
        let here = row_after_passes(history, place).unwrap_or(0);
        let made: Vec<usize> = steps_after(history, here).take(steps).collect();
        let last = made.last().copied().unwrap_or(here);
        // With the pass that looks at the last cell's list, if the ray is still on its way then.
        let last = history.rows.len().saturating_sub(1).min(last + usize::from(!made.is_empty()));
        let rows = (here + 1..=last).filter_map(|row| {
            let place = history.rows.get(row).and_then(TraceRow::place)?;
            Some((place, made.iter().filter(|step| **step <= row).count()))
        });
        Self { stops: rows.collect(), reached: 0, is_paused: false, due: None }
    }

    pub(super) fn is_over(&self) -> bool {
        self.reached >= self.stops.len()
    }

    /// Steps from cell to cell made, and in total.
    pub(super) fn steps(&self) -> [usize; 2] {
        let made = self.reached.checked_sub(1).and_then(|last| self.stops.get(last)).map_or(0, |stop| stop.1);
        [made, self.stops.last().map_or(0, |stop| stop.1)]
    }

    /// The next place, if it is due.
    fn next(&mut self, now: f64) -> Option<usize> {
        if now < *self.due.get_or_insert(now + PACE) {
            return None;
        }
        self.due = Some(now + PACE);
        let (place, _) = *self.stops.get(self.reached)?;
        self.reached += 1;
        Some(place)
    }
}

impl Inspector {
    /// Goes on with what the lesson plays.
    pub(in crate::ui) fn play_lesson(&mut self, ctx: &egui::Context) {
        let is_ready = self.is_at_rest();
        let Some(play) = self.lesson.as_mut().filter(|lesson| !lesson.is_waiting()).and_then(|l| l.play.as_mut())
        else {
            return;
        };
        if play.is_paused || play.is_over() {
            return;
        }
        ctx.request_repaint_after(std::time::Duration::from_millis(50));
        if let Some(place) = is_ready.then(|| play.next(ctx.input(|input| input.time))).flatten() {
            self.model.ask(Request::Step(Target::Pass(place)));
        }
    }

    /// Goes to the end of what the lesson plays.
    pub(in crate::ui) fn skip_lesson_play(&mut self) {
        let Some(play) = self.lesson.as_mut().and_then(|lesson| lesson.play.as_mut()) else { return };
        play.reached = play.stops.len();
        if let Some((place, _)) = play.stops.last() {
            self.model.ask(Request::Step(Target::Pass(*place)));
        }
    }
}

impl Lesson {
    /// Whether it is playing something, or would if it were not paused.
    pub(in crate::ui) fn plays(&self) -> bool {
        !self.is_waiting() && self.play.as_ref().is_some_and(|play| !play.is_over())
    }

    /// Whether its step has something to play, also once it is over.
    pub(in crate::ui) fn has_play(&self) -> bool {
        self.play.is_some()
    }

    /// Stops what it plays, or goes on.
    pub(in crate::ui) fn toggle_play(&mut self) {
        if let Some(play) = self.play.as_mut().filter(|play| !play.is_over()) {
            (play.is_paused, play.due) = (!play.is_paused, None);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn playing_goes_on_at_its_pace_and_stops_at_the_end() {
        let mut play = Play { stops: vec![(3, 0), (5, 1), (7, 1)], reached: 0, is_paused: false, due: None };
        let places: Vec<_> = [0.0, 0.5, 1.0, 1.1, 2.0, 3.0, 9.0].map(|now| play.next(10.0 + now)).to_vec();
        assert_eq!(places, [None, None, Some(3), None, Some(5), Some(7), None]);
        assert!(play.is_over());
        assert_eq!(play.steps(), [1, 1]);
    }
}
