//! Places of labels: near their marks, and clear of everything else that is drawn.

use super::frame::Frame;
use super::picture::Point;

/// Half the height of a line of text.
pub(super) const HALF: f64 = 6.5;

/// Distance from its mark beyond which a label has a line to it.
const NEAR: f64 = 11.0;

/// Between the places that are tried.
const STEP: f64 = 3.0;

/// How often each label is placed: from the second time on, all others are known.
const ROUNDS: usize = 3;

/// How many of the nearest places are tried before all others.
const NEAREST: usize = 1000;

/// What is covered costs more than any distance.
const LABEL: f64 = 3000.0;
const COVERED: f64 = 1000.0;

/// What labels keep clear of.
#[derive(Debug, Default)]
pub(super) struct Obstacles {
    /// Marks, intervals and arrows.
    pub(super) hard: Vec<Frame>,
    /// What a label may interrupt if there is no better place.
    pub(super) soft: Vec<Frame>,
}

/// A mark, and the width of its label.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wanted {
    pub(super) at: Point,
    pub(super) width: f64,
}

/// A label's place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    pub(super) frame: Frame,
    /// A line from the label to its mark, if it is not beside it.
    pub(super) leader: Option<[Point; 2]>,
}

/// The places of all labels within a frame: of those that cover nothing, the nearest to the marks. `None` of a label
/// that covers something everywhere.
pub(super) fn places(room: Frame, wanted: &[Wanted], obstacles: &Obstacles) -> Vec<Option<Placement>> {
    let mut order: Vec<usize> = (0..wanted.len()).collect();
    order.sort_by(|&a, &b| {
        let (a, b) = (wanted[a].at, wanted[b].at);
        a.1.total_cmp(&b.1).then(a.0.total_cmp(&b.0))
    });
    let mut placed: Vec<Option<Placement>> = vec![None; wanted.len()];
    for _ in 0..ROUNDS {
        for &i in &order {
            let others: Vec<Placement> = (0..wanted.len()).filter(|&k| k != i).filter_map(|k| placed[k]).collect();
            placed[i] = best(room, i, wanted, obstacles, &others);
        }
    }
    let covers = |i: usize, frame: Frame| {
        let others = (0..wanted.len()).filter(|&k| k != i).filter_map(|k| placed[k]);
        others.into_iter().any(|other| other.frame.meets(frame)) || obstacles.hard.iter().any(|o| o.meets(frame))
    };
    (0..wanted.len()).map(|i| placed[i].filter(|place| !covers(i, place.frame))).collect()
}

/// The place of least cost. What distance alone costs is known at once, so few places are looked at.
fn best(room: Frame, own: usize, wanted: &[Wanted], obstacles: &Obstacles, others: &[Placement]) -> Option<Placement> {
    let mut places: Vec<(f64, Placement)> =
        candidates(room, wanted[own]).into_iter().map(|place| (place.distance_cost(wanted[own].at), place)).collect();
    // Mostly one of the nearest is taken, so the others need no order.
    let near = places.len().min(NEAREST);
    let by_distance = |a: &(f64, Placement), b: &(f64, Placement)| a.0.total_cmp(&b.0);
    if near < places.len() {
        places.select_nth_unstable_by(near, by_distance);
    }
    let (nearest, others_away) = places.split_at_mut(near);
    nearest.sort_by(by_distance);
    let found = least_of(nearest, own, wanted, obstacles, others);
    if found.is_some_and(|(cost, _)| cost < COVERED) {
        return found.map(|(_, place)| place);
    }
    others_away.sort_by(by_distance);
    let farther = least_of(others_away, own, wanted, obstacles, others);
    found.into_iter().chain(farther).min_by(by_distance).map(|(_, place)| place)
}

/// The place of least cost of places in the order of their distance.
fn least_of(
    places: &[(f64, Placement)],
    own: usize,
    wanted: &[Wanted],
    obstacles: &Obstacles,
    others: &[Placement],
) -> Option<(f64, Placement)> {
    let mut least: Option<(f64, Placement)> = None;
    for &(distance, place) in places {
        if least.is_some_and(|(cost, _)| cost <= distance) {
            break;
        }
        let cost = distance + place.cost(own, wanted, obstacles, others);
        if least.is_none_or(|(least, _)| cost < least) {
            least = Some((cost, place));
        }
    }
    least
}

/// Every place that is tried.
fn candidates(room: Frame, Wanted { at, width }: Wanted) -> Vec<Placement> {
    // So that one of them is exactly beside the mark.
    let from = |low: f64, mark: f64| low + (mark - low).rem_euclid(STEP);
    let steps = |low: f64, high: f64| (0_u16..).map(move |i| low + STEP * f64::from(i)).take_while(move |&v| v <= high);
    let place = |left: f64, y: f64| {
        let frame = Frame { left, right: left + width, top: y - HALF, bottom: y + HALF };
        let end = frame.nearest(at);
        Placement { frame, leader: (distance(end, at) > NEAR).then_some([end, at]) }
    };
    let rows = steps(from(room.top + HALF, at.1), room.bottom - HALF);
    let (first, last) = (from(room.left + 2.0, at.0), room.right - 2.0 - width);
    rows.flat_map(|y| steps(first, last).map(move |left| place(left, y))).collect()
}

impl Placement {
    /// Best beside the mark; else above or below it.
    fn distance_cost(&self, at: Point) -> f64 {
        let Frame { left, right, top, bottom } = self.frame;
        let (across, down) = (f64::midpoint(left, right) - at.0, f64::midpoint(top, bottom) - at.1);
        let leader = if self.leader.is_some() { 12.0 } else { 0.0 };
        distance(self.frame.nearest(at), at) + 0.5 * down.abs() + 0.02 * across.abs() + leader
    }

    /// How bad it is beside that: covering something counts more than any distance.
    fn cost(&self, own: usize, wanted: &[Wanted], obstacles: &Obstacles, others: &[Self]) -> f64 {
        let (frame, at) = (self.frame, wanted[own].at);
        let met = |frames: &[Frame]| frames.iter().filter(|f| f.meets(frame)).count() as f64;
        let labels = others.iter().filter(|o| o.frame.meets(frame)).count() as f64;
        let lines = others.iter().filter(|o| o.leader.is_some_and(|line| is_through(line, frame))).count() as f64;
        let mut cost = LABEL * labels + COVERED * (lines + met(&obstacles.hard)) + 25.0 * met(&obstacles.soft);
        if let Some(line) = self.leader {
            let labels = others.iter().filter(|o| is_through(line, o.frame)).count() as f64;
            let lines = others.iter().filter(|o| o.leader.is_some_and(|other| do_cross(line, other))).count() as f64;
            let is_passed = |i: usize| wanted[i].at != at && is_through(line, Frame::around(wanted[i].at, HALF));
            let marks = (0..wanted.len()).filter(|&i| is_passed(i)).count() as f64;
            cost += 200.0 * labels + 20.0 * marks + 15.0 * lines;
        }
        cost
    }
}

pub(super) fn distance(a: Point, b: Point) -> f64 {
    (a.0 - b.0).hypot(a.1 - b.1)
}

/// Whether a line passes through a frame, at one of some points on it.
fn is_through([from, to]: [Point; 2], frame: Frame) -> bool {
    const POINTS: u8 = 12;
    (0..POINTS).any(|k| {
        let part = f64::from(k) / f64::from(POINTS);
        frame.has((from.0 + (to.0 - from.0) * part, from.1 + (to.1 - from.1) * part))
    })
}

/// Whether two lines have a point in common.
fn do_cross([a, b]: [Point; 2], [c, d]: [Point; 2]) -> bool {
    let side = |p: Point, q: Point, r: Point| ((q.0 - p.0) * (r.1 - p.1) - (q.1 - p.1) * (r.0 - p.0)).signum();
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_of_marks_at_one_point_lie_apart_and_within_the_frame() {
        let room = Frame { left: 64.0, right: 604.0, top: 40.0, bottom: 140.0 };
        for at in [(70.0, 44.0), (300.0, 90.0), (600.0, 136.0)] {
            let wanted = [Wanted { at, width: 110.0 }; 7];
            let hard = vec![Frame::around(at, HALF), Frame::along(&[(64.0, at.1), (604.0, at.1)], 3.0)];
            let obstacles = Obstacles { hard, soft: Vec::new() };
            let places: Vec<Placement> = places(room, &wanted, &obstacles).into_iter().flatten().collect();
            assert_eq!(places.len(), wanted.len());
            for (i, place) in places.iter().enumerate() {
                assert!(room.holds(place.frame), "{place:?}");
                assert!(places[..i].iter().all(|other| !other.frame.meets(place.frame)), "{places:?}");
                assert!(!obstacles.hard.iter().any(|o| o.meets(place.frame)), "{places:?}");
                let is_far = distance(place.frame.nearest(at), at) > NEAR;
                assert_eq!(place.leader.is_some(), is_far, "{place:?}");
            }
        }
    }

    #[test]
    fn a_label_is_beside_its_mark_where_that_is_free_and_nowhere_where_nothing_is() {
        let room = Frame { left: 0.0, right: 400.0, top: 0.0, bottom: 100.0 };
        let wanted = [Wanted { at: (200.0, 50.0), width: 60.0 }];
        let place = |hard: Vec<Frame>| places(room, &wanted, &Obstacles { hard, soft: Vec::new() })[0];
        let on = place(Vec::new()).expect("a place");
        assert!(on.leader.is_none() && on.frame.has((200.0, 50.0)), "nothing is in the way: {on:?}");
        let beside = place(vec![Frame::around((200.0, 50.0), HALF)]).expect("a place");
        assert!(beside.leader.is_none() && !beside.frame.has((200.0, 50.0)), "{beside:?}");
        assert!(place(vec![room]).is_none());
    }
}
