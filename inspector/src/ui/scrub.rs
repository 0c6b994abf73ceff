//! Where the user drags the timeline to: the newest place wins, and at most one step to it is on its way.

/// A place that the timeline asks for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Scrub {
    /// The newest place, as a number of passes, until it is reached or given up.
    wanted: Option<usize>,
    /// Whether the pointer still holds it.
    is_held: bool,
    /// The step on its way: its target, and its number among the requests.
    asked: Option<(usize, u64)>,
}

impl Scrub {
    /// The pointer is over this place, and held.
    pub fn hold(&mut self, place: usize) {
        (self.wanted, self.is_held) = (Some(place), true);
    }

    /// The pointer was released; the last place that it held stays wanted.
    pub fn release(&mut self) {
        self.is_held = false;
    }

    /// Goes to this place: a click, or a key.
    pub fn go(&mut self, place: usize) {
        (self.wanted, self.is_held) = (Some(place), false);
    }

    /// Gives up.
    pub fn stop(&mut self) {
        *self = Self::default();
    }

    /// The place that is wanted, and was not reached yet, or is held.
    #[must_use]
    pub fn wanted(&self) -> Option<usize> {
        self.wanted
    }

    /// Whether a place is still to be reached.
    #[must_use]
    pub fn is_waiting(&self, here: usize) -> bool {
        self.asked.is_some() || self.wanted.is_some_and(|wanted| wanted != here)
    }

    /// The target of the step to send now, if any, for a run that is `here` and has served this many requests. The
    /// caller [tells](Self::sent) which request it was.
    #[must_use]
    pub fn next(&mut self, here: usize, served: u64) -> Option<usize> {
        let arrived = match self.asked {
            Some((_, request)) if served < request => return None,
            Some((target, _)) => Some(target),
            None => None,
        };
        self.asked = None;
        let wanted = self.wanted?;
        // A run that ends earlier than it did, or work that was cancelled: it is as near as it gets.
        let is_over = wanted == here || arrived == Some(wanted);
        if is_over && self.is_held {
            // The pointer may stay there, and the playhead with it.
            self.wanted = Some(here);
        } else if is_over {
            self.wanted = None;
        }
        (!is_over).then_some(wanted)
    }

    /// The step to this target was sent, as the request of this number.
    pub fn sent(&mut self, target: usize, request: u64) {
        self.asked = Some((target, request));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An engine that serves one request at a time.
    #[derive(Default)]
    struct Engine {
        here: usize,
        end: usize,
        sent: u64,
        served: u64,
        on_its_way: Vec<usize>,
        visited: Vec<usize>,
    }

    impl Engine {
        fn frame(&mut self, scrub: &mut Scrub) {
            if let Some(target) = scrub.next(self.here, self.served) {
                self.sent += 1;
                self.on_its_way.push(target);
                scrub.sent(target, self.sent);
            }
            assert!(self.on_its_way.len() <= 1, "more than one step on its way: {:?}", self.on_its_way);
        }

        fn serve(&mut self) {
            if let Some(target) = self.on_its_way.pop() {
                self.here = target.min(self.end);
                self.visited.push(self.here);
                self.served += 1;
            }
        }
    }

    #[test]
    fn the_newest_place_wins_and_those_between_are_dropped() {
        let (mut scrub, mut engine) = (Scrub::default(), Engine { end: 100, ..Engine::default() });
        for place in 1..=50 {
            scrub.hold(place);
            engine.frame(&mut scrub);
            // A step takes as long as ten movements of the pointer: the next one is sent at the movement after it.
            if place % 10 == 0 {
                engine.serve();
            }
        }
        assert_eq!(engine.visited, [1, 11, 21, 31, 41]);
        scrub.release();
        for _ in 0..3 {
            engine.frame(&mut scrub);
            engine.serve();
        }
        engine.frame(&mut scrub);
        assert_eq!((engine.here, scrub.wanted(), scrub.is_waiting(50)), (50, None, false));
        assert_eq!(engine.visited, [1, 11, 21, 31, 41, 50], "no step after the last");
    }

    #[test]
    fn scrubbing_goes_on_beside_other_requests() {
        let mut scrub = Scrub::default();
        scrub.go(7);
        assert_eq!(scrub.next(3, 20), Some(7));
        scrub.sent(7, 24);
        assert_eq!((scrub.next(3, 23), scrub.is_waiting(3)), (None, true), "three requests are before it");
        assert_eq!((scrub.next(7, 24), scrub.is_waiting(7), scrub.wanted()), (None, false, None));
    }

    #[test]
    fn a_place_that_is_not_reached_is_asked_for_once() {
        let (mut scrub, mut engine) = (Scrub::default(), Engine { end: 5, ..Engine::default() });
        for is_held in [true, false] {
            scrub.hold(9);
            if !is_held {
                scrub.release();
            }
            for _ in 0..4 {
                engine.frame(&mut scrub);
                engine.serve();
            }
            assert_eq!(scrub.wanted(), is_held.then_some(5));
            assert!(!scrub.is_waiting(5));
        }
        assert_eq!(engine.visited, [5, 5]);
    }
}
