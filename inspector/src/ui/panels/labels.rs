//! Places of labels over a picture: near their marks, within the picture, and never over each other. Labels are placed
//! one after the other, the most important first; one for which there is no room is left out.

use egui::{Pos2, Rect, Vec2, vec2};

/// Distance from its mark beyond which a label has a line to it.
const NEAR: f32 = 9.0;
/// Points between two labels.
const GAP: f32 = 2.0;
/// Points between the places that are tried, and how far from the mark they go.
const STEP: f32 = 8.0;
const REACH: Vec2 = vec2(190.0, 130.0);

/// A mark, and the size of its label.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Wanted {
    pub(super) at: Pos2,
    pub(super) size: Vec2,
}

/// A label's place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LabelRect {
    pub(super) rect: Rect,
    /// A line from the label to its mark, if it is not beside it.
    pub(super) leader: Option<[Pos2; 2]>,
}

/// What labels should rather not cover.
#[derive(Clone, Debug, Default)]
pub(super) struct Avoid {
    /// Areas, such as the current cell.
    pub(super) areas: Vec<Rect>,
    /// Lines, such as the ray.
    pub(super) lines: Vec<[Pos2; 2]>,
}

/// The places of labels within `room`, the most important first; `None` for a label without room.
pub(super) fn places(room: Rect, wanted: &[Wanted], avoid: &Avoid) -> Vec<Option<LabelRect>> {
    let mut placed: Vec<LabelRect> = Vec::new();
    let mut places = Vec::with_capacity(wanted.len());
    for (i, label) in wanted.iter().enumerate() {
        let free =
            candidates(room, *label).filter(|place| placed.iter().all(|p| !p.rect.expand(GAP).intersects(place.rect)));
        let best =
            free.map(|place| (cost(&place, i, wanted, avoid, &placed), place)).min_by(|a, b| a.0.total_cmp(&b.0));
        let place = best.map(|(_, place)| place);
        placed.extend(place);
        places.push(place);
    }
    places
}

/// Orders labels that are side by side as their marks are, so that their lines do not cross.
pub(super) fn in_order(room: Rect, wanted: &[Wanted], places: &mut [Option<LabelRect>]) {
    let mut left: Vec<usize> = (0..places.len()).filter(|&i| places[i].is_some()).collect();
    while let Some(&first) = left.first() {
        let top = |i: &usize| places[*i].map_or(f32::NAN, |place| place.rect.top());
        let is_beside = |i: &usize| (top(i) - top(&first)).abs() < 1.0;
        let (mut row, others): (Vec<usize>, Vec<usize>) = left.iter().partition(|i| is_beside(i));
        left = others;
        row.sort_by(|&a, &b| wanted[a].at.x.total_cmp(&wanted[b].at.x));
        let rects: Vec<Rect> = row.iter().filter_map(|&i| places[i]).map(|place| place.rect).collect();
        if rects.is_sorted_by(|a, b| a.left() <= b.left()) {
            continue;
        }
        // As near to their marks as they can be without overlapping: from the left, then back into the room.
        let mut x: Vec<f32> = Vec::with_capacity(row.len());
        for (&i, rect) in row.iter().zip(&rects) {
            let after =
                x.last().zip(rects.get(x.len().wrapping_sub(1))).map_or(room.left(), |(x, r)| x + r.width() + GAP);
            x.push((wanted[i].at.x - 0.5 * rect.width()).max(after));
        }
        let mut end = room.right();
        for (x, rect) in x.iter_mut().zip(&rects).rev() {
            *x = x.min(end - rect.width());
            end = *x - GAP;
        }
        let moved = rects.iter().zip(&x).map(|(rect, &x)| Rect::from_min_size(egui::pos2(x, rect.top()), rect.size()));
        let moved: Vec<Rect> = moved.collect();
        let meets = |rect: &Rect| {
            places
                .iter()
                .enumerate()
                .any(|(i, place)| !row.contains(&i) && place.is_some_and(|place| place.rect.intersects(*rect)))
        };
        if moved.iter().any(|rect| meets(rect) || rect.left() < room.left()) {
            continue;
        }
        for (&i, rect) in row.iter().zip(moved) {
            places[i] = Some(LabelRect::new(rect, wanted[i].at));
        }
    }
}

/// Every place that is tried: right beside the mark, and on a lattice around it.
fn candidates(room: Rect, Wanted { at, size }: Wanted) -> impl Iterator<Item = LabelRect> {
    let fits = size.x <= room.width() && size.y <= room.height() && at.x.is_finite() && at.y.is_finite();
    let most = room.max - size;
    let inside = move |min: Pos2| min.clamp(room.min, most.max(room.min));
    let sides = [vec2(7.0, -0.5 * size.y), vec2(-7.0 - size.x, -0.5 * size.y)];
    let above = [vec2(-0.5 * size.x, -7.0 - size.y), vec2(-0.5 * size.x, 7.0)];
    let beside = sides.into_iter().chain(above).map(move |by| at + by);
    let count = |reach: f32, size: f32| ((2.0 * reach + size) / STEP).ceil().max(0.0) as i32;
    let (columns, rows) = (count(REACH.x, size.x), count(REACH.y, size.y));
    let first = at - REACH - size;
    let lattice =
        (0..=rows).flat_map(move |row| (0..=columns).map(move |column| first + STEP * vec2(column as f32, row as f32)));
    let all = beside.chain(lattice).filter(move |_| fits);
    all.map(move |min| LabelRect::new(Rect::from_min_size(inside(min), size), at))
}

impl LabelRect {
    fn new(rect: Rect, at: Pos2) -> Self {
        let end = rect.clamp(at);
        Self { rect, leader: (end.distance(at) > NEAR).then_some([end, at]) }
    }
}

/// How bad a place is, in points of distance: covering something counts more than being near.
fn cost(place: &LabelRect, own: usize, wanted: &[Wanted], avoid: &Avoid, placed: &[LabelRect]) -> f32 {
    let (rect, at) = (place.rect, wanted[own].at);
    let leaders = placed.iter().filter_map(|p| p.leader);
    let covered = leaders.clone().filter(|&line| is_through(line, rect)).count() as f32;
    let marks = wanted.iter().filter(|other| rect.expand(3.0).contains(other.at)).count() as f32;
    let lines = avoid.lines.iter().filter(|&&line| is_through(line, rect)).count() as f32;
    let share = |area: &Rect| area.intersect(rect).area().max(0.0) / rect.area().max(1.0);
    let meets = avoid.areas.iter().filter(|area| area.intersects(rect)).map(share).sum::<f32>();
    let away = rect.center() - at;
    let mut cost = rect.clamp(at).distance(at) + 0.3 * away.y.abs() + 0.02 * away.x.abs();
    cost += 120.0 * covered + 60.0 * marks + 25.0 * lines + 40.0 * meets;
    if let Some(line) = place.leader {
        let texts = placed.iter().filter(|p| is_through(line, p.rect)).count() as f32;
        let crossed = leaders.filter(|&other| do_cross(line, other)).count() as f32;
        cost += 10.0 + 120.0 * texts + 25.0 * crossed;
    }
    cost
}

/// Whether a line passes through a rectangle (clipped as by Liang and Barsky, 1984).
pub(super) fn is_through([from, to]: [Pos2; 2], rect: Rect) -> bool {
    let way = to - from;
    let (mut enter, mut leave) = (0.0f32, 1.0f32);
    for (start, by, min, max) in [(from.x, way.x, rect.min.x, rect.max.x), (from.y, way.y, rect.min.y, rect.max.y)] {
        if by == 0.0 {
            if start < min || start > max {
                return false;
            }
            continue;
        }
        let (a, b) = ((min - start) / by, (max - start) / by);
        (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
    }
    enter <= leave
}

/// Whether two lines cross.
fn do_cross([a, b]: [Pos2; 2], [c, d]: [Pos2; 2]) -> bool {
    let side = |p: Pos2, q: Pos2, r: Pos2| ((q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x)).signum();
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}

/// No two overlap, and all lie within: for the tests of everything that has labels.
#[cfg(test)]
pub(super) fn assert_apart(room: Rect, rects: &[Rect], what: &str) {
    for (i, rect) in rects.iter().enumerate() {
        assert!(room.expand(0.01).contains_rect(*rect), "{what}: {rect} is not within {room}");
        for other in &rects[..i] {
            assert!(!other.shrink(0.01).intersects(*rect), "{what}: {rect} lies over {other}");
        }
    }
}

#[cfg(test)]
mod tests {
    use egui::pos2;

    use super::*;

    #[test]
    fn labels_side_by_side_are_in_the_order_of_their_marks() {
        let room = Rect::from_min_size(pos2(0.0, 0.0), vec2(120.0, 14.0));
        let size = |width| vec2(width, 14.0);
        let wanted = [(100.0, 10.0), (90.0, 20.0), (80.0, 12.0), (95.0, 10.0), (20.0, 10.0)]
            .map(|(x, width)| Wanted { at: pos2(x, 30.0), size: size(width) });
        let mut places = places(room, &wanted, &Avoid::default());
        assert!(places.iter().all(Option::is_some), "there is room for all");
        in_order(room, &wanted, &mut places);
        let rects: Vec<Rect> = places.iter().flatten().map(|place| place.rect).collect();
        assert_apart(room, &rects, "in order");
        let mut order: Vec<usize> = (0..wanted.len()).collect();
        order.sort_by(|&a, &b| rects[a].left().total_cmp(&rects[b].left()));
        assert_eq!(order, [4, 2, 1, 3, 0]);
        let lines: Vec<_> = places.iter().flatten().filter_map(|place| place.leader).collect();
        assert!(lines.iter().all(|a| lines.iter().all(|b| a == b || !do_cross(*a, *b))), "{lines:?}");
    }

    #[test]
    fn labels_of_any_marks_lie_apart_and_within_or_are_left_out() {
        let mut random = fastrand::Rng::with_seed(7);
        for round in 0..300 {
            let room =
                Rect::from_min_size(pos2(30.0, 50.0), vec2(30.0 + random.f32() * 700.0, 12.0 + random.f32() * 400.0));
            let wanted: Vec<Wanted> = (0..random.usize(1..12))
                .map(|_| {
                    let at = room.min + vec2(random.f32(), random.f32()) * room.size();
                    Wanted { at, size: vec2(20.0 + 160.0 * random.f32(), 17.0) }
                })
                .collect();
            let places = places(room, &wanted, &Avoid::default());
            assert_eq!(places.len(), wanted.len());
            let rects: Vec<Rect> = places.iter().flatten().map(|place| place.rect).collect();
            assert_apart(room, &rects, &format!("round {round}"));
            for (place, label) in places.iter().zip(&wanted) {
                let Some(place) = place else { continue };
                // Its place is rounded, its size is not.
                assert!((place.rect.size() - label.size).length() < 1e-3);
                let is_far = place.rect.clamp(label.at).distance(label.at) > NEAR;
                assert_eq!(place.leader.is_some(), is_far, "{place:?}");
            }
            // The most important one is only left out where it is larger than the picture.
            let fits = wanted[0].size.x <= room.width() && wanted[0].size.y <= room.height();
            assert_eq!(places[0].is_some(), fits);
        }
    }

    #[test]
    fn labels_of_one_mark_all_find_room_and_the_first_is_beside_it() {
        let room = Rect::from_min_size(pos2(0.0, 0.0), vec2(470.0, 120.0));
        for at in [pos2(235.0, 60.0), pos2(0.0, 0.0), pos2(470.0, 120.0)] {
            let places = places(room, &[Wanted { at, size: vec2(110.0, 18.0) }; 6], &Avoid::default());
            assert!(places.iter().all(Option::is_some) && places[0].is_some_and(|p| p.leader.is_none()), "{places:?}");
        }
        assert_eq!(
            places(room, &[Wanted { at: pos2(f32::NAN, 0.0), size: vec2(1.0, 1.0) }], &Avoid::default()),
            [None]
        );
    }

    #[test]
    fn a_label_rather_keeps_off_the_ray_and_off_marks() {
        let room = Rect::from_min_size(pos2(0.0, 0.0), vec2(400.0, 200.0));
        let at = pos2(200.0, 100.0);
        let avoid = Avoid { lines: vec![[pos2(0.0, 100.0), pos2(400.0, 100.0)]], areas: Vec::new() };
        let place = places(room, &[Wanted { at, size: vec2(90.0, 18.0) }], &avoid)[0].expect("room");
        assert!(!is_through(avoid.lines[0], place.rect), "{place:?}");
        assert!(place.rect.clamp(at).distance(at) < 12.0, "but stays near: {place:?}");
    }
}
