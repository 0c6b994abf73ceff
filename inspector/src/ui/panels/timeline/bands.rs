//! The turns of the schedule's loops above the columns: a band per level, outermost on top, with a segment per turn.

use egui::{Align2, Color32, FontId, Pos2, Rect, Ui, pos2};
use raystep_kernels::Pass;
use raystep_kernels::program::schedule::Schedule;

use super::axis::Axis;
use crate::ui::panels::timings::duration;
use crate::ui::panels::turns::{Turn, Turns, names, range};
use crate::ui::style::{SMALLEST, ink_on};

/// Height of a band.
const HEIGHT: f32 = 13.0;
/// Without room for this, there are none.
const LEAST: f32 = 4.0;
/// Segments have gaps between them, and labels, only if they are wider than this.
const WIDE: f32 = 3.0;

/// A turn as it is painted, or several that are narrower than a point.
#[derive(Clone, Debug, PartialEq)]
struct Segment {
    left: f32,
    right: f32,
    turn: Option<Turn>,
}

/// The bands, made again with the axis.
#[derive(Default)]
pub(super) struct Bands {
    turns: Turns,
    /// The segments of each level in a lane, kept while it stays there.
    segments: Option<(Rect, Vec<Vec<Segment>>)>,
}

impl Bands {
    /// Those of these passes. None if no level has several turns.
    pub(super) fn new(passes: &[Pass]) -> Self {
        let mut turns = Turns::default();
        turns.extend(passes);
        Self { turns, segments: None }
    }

    /// The height of their lane, of the height that there is for it and the columns.
    pub(super) fn height(&self, room: f32) -> f32 {
        let levels = self.turns.levels().len() as f32;
        let height = (HEIGHT * levels).min(0.5 * room);
        if height < LEAST * levels { 0.0 } else { height }
    }

    /// The level and the turn at a position in the lane, above a pass.
    pub(super) fn at(&self, lane: Rect, pos: Pos2, pass: Option<usize>) -> Option<(usize, Turn)> {
        let is_met = lane.is_positive() && lane.contains(pos);
        let part = (pos.y - lane.top()) / lane.height();
        let level = (part * self.turns.levels().len() as f32) as usize;
        Some((level, self.turns.of(level, pass.filter(|_| is_met)?)?))
    }

    /// Paints them. The turns of the pass before `place` are emphasised.
    pub(super) fn paint(&mut self, ui: &Ui, lane: Rect, (passes, axis): (&[Pass], &Axis), of: &Schedule, place: usize) {
        if !lane.is_positive() {
            return;
        }
        let x = |place: usize| lane.left() + (axis.part_of(place) * f64::from(lane.width())) as f32;
        if self.segments.as_ref().is_none_or(|(rect, _)| *rect != lane) {
            self.segments = Some((lane, self.turns.levels().iter().map(|turns| segments(turns, x)).collect()));
        }
        let height = lane.height() / self.turns.levels().len() as f32;
        let fills = [ui.visuals().widgets.inactive.bg_fill, ui.visuals().selection.bg_fill];
        for (level, segments) in self.segments.iter().flat_map(|(_, segments)| segments.iter().enumerate()) {
            let top = lane.top() + height * level as f32;
            let paint = |segment: &Segment, fill: Color32| {
                let gap = if segment.right - segment.left > WIDE { 1.0 } else { 0.0 };
                let corner = pos2((segment.right - gap).max(segment.left + 0.5), top + height - 1.0);
                let rect = Rect::from_min_max(pos2(segment.left, top), corner);
                ui.painter().rect_filled(rect, 0.0, fill);
                if let Some(pass) = segment.turn.and_then(|turn| passes.get(turn[0])) {
                    label(ui, rect, of, pass, level, ink_on(fill));
                }
            };
            let current = place.checked_sub(1).and_then(|pass| self.turns.of(level, pass));
            for segment in segments.iter().filter(|segment| segment.turn.is_none() || segment.turn != current) {
                paint(segment, fills[0]);
            }
            if let Some(turn) = current {
                let [left, right] = turn.map(x);
                paint(&Segment { left, right: right.max(left + 2.0), turn: Some(turn) }, fills[1]);
            }
        }
    }

    /// What is said about a turn: its name within those of the levels above, its passes, and its time.
    pub(super) fn about((level, [first, end]): (usize, Turn), passes: &[Pass], of: &Schedule) -> Vec<String> {
        let Some(turn) = passes.get(first..end).filter(|turn| !turn.is_empty()) else { return Vec::new() };
        let which = format!("{} {}", if end - first == 1 { "pass" } else { "passes" }, range([first, end]));
        let time = turn.iter().try_fold(0u64, |sum, pass| Some(sum.saturating_add(pass.duration_ns?)));
        let time = time.map(|ns| format!("{} on the device", duration(ns)));
        let names = names(of, &turn[0]);
        let name = names.get(..=level).unwrap_or(&names).join(", ");
        let keys = "click: to its first pass; double click: to its end".to_owned();
        [name, which].into_iter().chain(time).chain([keys]).collect()
    }

    /// The turns of a pass in words, if there are bands.
    pub(super) fn words(&self, pass: &Pass, of: &Schedule) -> String {
        let names = if self.turns.levels().is_empty() { Vec::new() } else { names(of, pass) };
        names.into_iter().map(|name| format!(", {name}")).collect()
    }
}

/// The name of a turn or, where that does not fit, its number.
fn label(ui: &Ui, rect: Rect, of: &Schedule, pass: &Pass, level: usize, ink: Color32) {
    let Some(turn) = pass.loops.get(level).filter(|_| rect.width() > 2.0 * WIDE) else { return };
    let name = names(of, pass).into_iter().nth(level);
    for text in name.into_iter().chain([turn.to_string()]) {
        let galley = ui.painter().layout_no_wrap(text, FontId::proportional(SMALLEST), ink);
        let at = Align2::CENTER_CENTER.anchor_size(rect.center(), galley.size());
        // A line of text is blank above and below its letters.
        if at.width() + WIDE <= rect.width() && at.height() <= rect.height() + 2.0 {
            ui.painter().galley(at.min, galley, ink);
            return;
        }
    }
}

/// The segments of a level. There are at most about two per point.
fn segments(turns: &[Turn], x: impl Fn(usize) -> f32) -> Vec<Segment> {
    let mut all: Vec<Segment> = Vec::new();
    for &turn in turns {
        let [left, right] = turn.map(&x);
        let is_narrow = right - left < 1.0;
        match all.last_mut() {
            Some(last) if is_narrow && last.turn.is_none() && left - last.right < 1.0 => last.right = right,
            _ => all.push(Segment { left, right, turn: (!is_narrow).then_some(turn) }),
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use raystep_kernels::programs::sort;

    use super::super::axis::Scale;
    use super::*;

    fn passes(loops: impl IntoIterator<Item = Vec<u32>>) -> Vec<Pass> {
        let of = |(index, loops)| Pass { index, loops, duration_ns: Some(1000), ..Pass::of(sort::EXCHANGE) };
        loops.into_iter().enumerate().map(of).collect()
    }

    /// The first stages of a sort.
    fn stages(count: u32) -> Vec<Pass> {
        passes((0..count).flat_map(|stage| (0..=stage).map(move |step| vec![stage, step])))
    }

    #[test]
    fn a_band_has_a_segment_from_the_first_to_the_last_pass_of_every_turn() {
        let bands = Bands::new(&stages(3));
        assert_eq!(bands.turns.levels()[0], [[0, 1], [1, 3], [3, 6]]);
        assert_eq!(bands.turns.levels()[1], [0, 1, 2, 3, 4, 5].map(|pass| [pass, pass + 1]), "step 0 follows step 0");
        // Passes before, between and after loops are in no turn.
        let bands = Bands::new(&passes([vec![], vec![0], vec![0], vec![1], vec![], vec![0], vec![]]));
        assert_eq!(bands.turns.levels(), [vec![[1, 3], [3, 4], [5, 6]]]);
        let found = [0, 1, 2, 3, 4, 5, 6, 7].map(|pass| bands.turns.of(0, pass).map_or(0, |turn| turn[1]));
        assert_eq!(found, [0, 3, 3, 4, 0, 6, 0, 0]);
        for loops in [vec![], vec![vec![]; 3], vec![vec![0]; 3], vec![vec![], vec![0], vec![]]] {
            let bands = Bands::new(&passes(loops));
            assert!(bands.turns.levels().is_empty() && bands.height(100.0) == 0.0, "there is nothing to tell apart");
        }
    }

    #[test]
    fn a_turn_is_named_with_those_around_it_its_passes_and_its_time() {
        let (passes, schedule) = (stages(3), sort::schedule(8));
        let bands = Bands::new(&passes);
        let lane = Rect::from_min_max(pos2(10.0, 20.0), pos2(110.0, 40.0));
        let about =
            |y: f32, pass| Bands::about(bands.at(lane, pos2(50.0, y), pass).expect("a turn"), &passes, &schedule);
        assert_eq!(about(21.0, Some(4))[..3], ["stage 2", "passes 3–5", "3.0 µs on the device"]);
        assert_eq!(about(39.0, Some(4))[..3], ["stage 2, step 1", "pass 4", "1.0 µs on the device"]);
        for (y, pass) in [(19.0, Some(4)), (41.0, Some(4)), (21.0, None), (21.0, Some(6))] {
            assert_eq!(bands.at(lane, pos2(50.0, y), pass), None, "{y}, {pass:?}");
        }
        assert_eq!(bands.words(&passes[4], &schedule), ", stage 2, step 1");
        let mut untimed = passes.clone();
        untimed[3].duration_ns = None;
        assert_eq!(Bands::about((0, [3, 6]), &untimed, &schedule).len(), 3, "no time if one is unknown");
    }

    #[test]
    fn turns_narrower_than_a_point_are_merged() {
        let passes = passes((0..100_000).map(|pass| vec![pass / 50_000, pass]));
        let (bands, axis) = (Bands::new(&passes), Axis::new(&passes, Scale::Passes, false));
        let x = |place| (axis.part_of(place) * 500.0) as f32;
        let [outer, inner] = [0, 1].map(|level: usize| segments(&bands.turns.levels()[level], x));
        assert_eq!(
            outer.iter().map(|segment| [segment.left, segment.right]).collect::<Vec<_>>(),
            [[0.0, 250.0], [250.0, 500.0]]
        );
        assert_eq!(inner, [Segment { left: 0.0, right: 500.0, turn: None }]);
        // Wide ones stay apart from narrow ones, also from those beyond a gap.
        let xs = [0.0, 5.0, 5.5, 6.0, 9.0, 9.2, 20.0];
        let turns = [[0, 1], [1, 2], [2, 3], [4, 5], [5, 6]];
        let found: Vec<_> =
            segments(&turns, |place| xs[place]).into_iter().map(|s| (s.left, s.right, s.turn)).collect();
        assert_eq!(found, [(0.0, 5.0, Some([0, 1])), (5.0, 6.0, None), (9.0, 9.2, None), (9.2, 20.0, Some([5, 6]))]);
    }

    #[test]
    fn bands_leave_room_for_the_columns() {
        let bands = Bands::new(&stages(3));
        assert_eq!([200.0, 40.0, 10.0, -5.0].map(|room| bands.height(room)), [26.0, 20.0, 0.0, 0.0]);
    }
}
