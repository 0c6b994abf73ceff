//! Places of labels: near their marks, and clear of everything else that is drawn.

use super::draw::Frame;
use super::picture::Point;

/// Half the height of a line of text.
pub(super) const HALF: i32 = 6;

/// Distance from its mark beyond which a label has a line to it.
const NEAR: f64 = 11.0;

/// Pixels between the places that are tried.
const STEP: usize = 3;

/// How often each label is placed: from the second time on, all others are known.
const ROUNDS: usize = 3;

/// An upper estimate of a text's width: fonts differ.
pub(super) fn width_of(text: &str) -> i32 {
    11 * text.chars().count() as i32 / 2 + 2
}

impl Frame {
    /// Whether the two have more than an edge in common.
    pub(super) fn meets(self, other: Self) -> bool {
        self.left < other.right && self.right > other.left && self.top < other.bottom && self.bottom > other.top
    }

    /// Around a point.
    pub(super) fn around((x, y): Point, half: i32) -> Self {
        Self { left: x - half, right: x + half, top: y - half, bottom: y + half }
    }

    /// Around a line.
    pub(super) fn along([from, to]: [Point; 2], half: i32) -> Self {
        Self {
            left: from.0.min(to.0) - half,
            right: from.0.max(to.0) + half,
            top: from.1.min(to.1) - half,
            bottom: from.1.max(to.1) + half,
        }
    }

    fn has(self, (x, y): Point) -> bool {
        (self.left..=self.right).contains(&x) && (self.top..=self.bottom).contains(&y)
    }

    /// The point of it that is nearest to another.
    fn nearest(self, (x, y): Point) -> Point {
        (x.clamp(self.left, self.right), y.clamp(self.top, self.bottom))
    }
}

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
    pub(super) width: i32,
}

/// A label's place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) frame: Frame,
    /// A line from the label to its mark, if it is not beside it.
    pub(super) leader: Option<[Point; 2]>,
}

/// The places of all labels within a frame: of those that cover nothing, the nearest to the marks.
pub(super) fn places(room: Frame, wanted: &[Wanted], obstacles: &Obstacles) -> Vec<Place> {
    let mut order: Vec<usize> = (0..wanted.len()).collect();
    order.sort_by_key(|&i| (wanted[i].at.1, wanted[i].at.0));
    let mut placed: Vec<Option<Place>> = vec![None; wanted.len()];
    for _ in 0..ROUNDS {
        for &i in &order {
            let others: Vec<Place> = (0..wanted.len()).filter(|&k| k != i).filter_map(|k| placed[k]).collect();
            let places = candidates(room, wanted[i]).map(|place| (place.cost(i, wanted, obstacles, &others), place));
            placed[i] = places.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, place)| place);
        }
    }
    // A label that is larger than the frame lies on its mark.
    let or_on = |(place, wanted): (Option<Place>, &Wanted)| {
        place.unwrap_or(Place { frame: Frame::around(wanted.at, HALF), leader: None })
    };
    placed.into_iter().zip(wanted).map(or_on).collect()
}

/// Every place that is tried.
fn candidates(room: Frame, Wanted { at, width }: Wanted) -> impl Iterator<Item = Place> {
    // So that one of them is exactly beside the mark.
    let from = |low: i32, mark: i32| low + (mark - low).rem_euclid(STEP as i32);
    let rows = (from(room.top + HALF, at.1)..=room.bottom - HALF).step_by(STEP);
    rows.flat_map(move |y| {
        let columns = (from(room.left + 2, at.0)..=room.right - 2 - width).step_by(STEP);
        columns.map(move |left| {
            let frame = Frame { left, right: left + width, top: y - HALF, bottom: y + HALF };
            let end = frame.nearest(at);
            Place { frame, leader: (distance(end, at) > NEAR).then_some([end, at]) }
        })
    })
}

impl Place {
    /// How bad it is: covering something counts more than any distance.
    fn cost(&self, own: usize, wanted: &[Wanted], obstacles: &Obstacles, others: &[Self]) -> f64 {
        let (frame, at) = (self.frame, wanted[own].at);
        let met = |frames: &[Frame]| frames.iter().filter(|f| f.meets(frame)).count() as f64;
        let labels = others.iter().filter(|o| o.frame.meets(frame)).count() as f64;
        let lines = others.iter().filter(|o| o.leader.is_some_and(|line| is_through(line, frame))).count() as f64;
        let middle = |low: i32, high: i32| f64::from(low + high) / 2.0;
        let [across, down] =
            [middle(frame.left, frame.right) - f64::from(at.0), middle(frame.top, frame.bottom) - f64::from(at.1)];
        let mut cost = 3000.0 * labels + 1000.0 * (lines + met(&obstacles.hard)) + 25.0 * met(&obstacles.soft);
        // Best beside the mark; else above or below it.
        cost += distance(frame.nearest(at), at) + 0.5 * down.abs() + 0.02 * across.abs();
        if let Some(line) = self.leader {
            let labels = others.iter().filter(|o| is_through(line, o.frame)).count() as f64;
            let lines = others.iter().filter(|o| o.leader.is_some_and(|other| do_cross(line, other))).count() as f64;
            let is_passed = |i: usize| wanted[i].at != at && is_through(line, Frame::around(wanted[i].at, HALF));
            let marks = (0..wanted.len()).filter(|&i| is_passed(i)).count() as f64;
            cost += 12.0 + 60.0 * labels + 20.0 * marks + 15.0 * lines;
        }
        cost
    }
}

fn distance(a: Point, b: Point) -> f64 {
    f64::from(a.0 - b.0).hypot(f64::from(a.1 - b.1))
}

/// Whether a line passes through a frame, at one of some points on it.
fn is_through([from, to]: [Point; 2], frame: Frame) -> bool {
    const POINTS: i32 = 8;
    (0..POINTS).any(|k| frame.has((from.0 + (to.0 - from.0) * k / POINTS, from.1 + (to.1 - from.1) * k / POINTS)))
}

/// Whether two lines have a point in common.
fn do_cross([a, b]: [Point; 2], [c, d]: [Point; 2]) -> bool {
    let side = |p: Point, q: Point, r: Point| ((q.0 - p.0) * (r.1 - p.1) - (q.1 - p.1) * (r.0 - p.0)).signum();
    side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_of_marks_at_one_point_lie_apart_and_within_the_frame() {
        let room = Frame { left: 64, right: 604, top: 40, bottom: 140 };
        for at in [(70, 44), (300, 90), (600, 136)] {
            let wanted = [Wanted { at, width: 110 }; 7];
            let hard = vec![Frame::around(at, HALF), Frame::along([(64, at.1), (604, at.1)], 3)];
            let obstacles = Obstacles { hard, soft: Vec::new() };
            let places = places(room, &wanted, &obstacles);
            for (i, place) in places.iter().enumerate() {
                let Frame { left, right, top, bottom } = place.frame;
                assert!(
                    left > room.left && right < room.right && top >= room.top && bottom <= room.bottom,
                    "{place:?}"
                );
                assert!(places[..i].iter().all(|other| !other.frame.meets(place.frame)), "{places:?}");
                assert!(!obstacles.hard.iter().any(|o| o.meets(place.frame)), "{places:?}");
                let is_far = distance(place.frame.nearest(at), at) > NEAR;
                assert_eq!(place.leader.is_some(), is_far, "{place:?}");
            }
        }
    }

    #[test]
    fn a_label_is_beside_its_mark_where_that_is_free() {
        let room = Frame { left: 0, right: 400, top: 0, bottom: 100 };
        let places = places(room, &[Wanted { at: (200, 50), width: 60 }], &Obstacles::default());
        assert!(places[0].leader.is_none() && places[0].frame.has((200, 50)), "nothing is in the way: {places:?}");
        let obstacles = Obstacles { hard: vec![Frame::around((200, 50), HALF)], soft: Vec::new() };
        let places = super::places(room, &[Wanted { at: (200, 50), width: 60 }], &obstacles);
        assert!(places[0].leader.is_none() && !places[0].frame.has((200, 50)), "{places:?}");
    }
}
