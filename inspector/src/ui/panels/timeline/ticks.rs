//! The events of the selected ray as marks along the timeline.

use std::sync::Arc;

use egui::{Color32, Painter, Pos2, Rect, Shape, Stroke, pos2, vec2};
use raystep_kernels::export::trace::Trace;
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::tables::state::States;

use crate::walk::{EventKind, events};

/// What happens to the ray; each has its own shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mark {
    /// It enters a cell, or reaches a node: a line.
    Move,
    /// A triangle is tested: an outlined triangle.
    Test,
    /// A nearer hit is found, and kept: a filled triangle.
    Hit,
    /// The hit is accepted as the nearest: a disc.
    Accepted,
    /// It leaves the grid or the BVH: a cross.
    Left,
}

impl Mark {
    /// All that a legend needs: the mark, its name, and what it means.
    pub(super) const ALL: [(Self, &'static str, &'static str); 5] = [
        (Self::Move, "cell", "the selected ray enters a cell, or reaches a node of the BVH"),
        (Self::Test, "test", "a triangle is tested against the selected ray"),
        (Self::Hit, "hit", "a triangle is hit, nearer than any before"),
        (Self::Accepted, "accepted", "the nearest hit of the selected ray is accepted"),
        (Self::Left, "left", "the selected ray leaves the grid or the BVH"),
    ];

    fn is_hit(self) -> bool {
        matches!(self, Self::Hit | Self::Accepted)
    }

    /// Paints it, about 8 points high.
    pub(super) fn paint(self, painter: &Painter, at: Pos2, color: Color32) {
        let stroke = Stroke::new(1.3, color);
        match self {
            Self::Move => drop(painter.vline(at.x, at.y - 4.0..=at.y + 4.0, stroke)),
            Self::Test | Self::Hit => {
                let corners = [vec2(-3.5, 3.0), vec2(3.5, 3.0), vec2(0.0, -3.5)].map(|corner| at + corner);
                let fill = if self == Self::Hit { color } else { Color32::TRANSPARENT };
                painter.add(Shape::convex_polygon(corners.to_vec(), fill, stroke));
            }
            Self::Accepted => drop(painter.circle_filled(at, 4.0, color)),
            Self::Left => {
                painter.line_segment([at - vec2(3.0, 3.0), at + vec2(3.0, 3.0)], stroke);
                painter.line_segment([at - vec2(3.0, -3.0), at + vec2(3.0, -3.0)], stroke);
            }
        }
    }
}

/// An event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tick {
    /// The place after its pass.
    pub(super) place: usize,
    /// Its row of the history.
    pub(super) row: usize,
    pub(super) mark: Mark,
}

/// The events of a history, kept while it is the same.
#[derive(Default)]
pub(super) struct Ticks {
    of: Option<Arc<Trace>>,
    /// In the order of their places.
    all: Vec<Tick>,
}

impl Ticks {
    /// Those of this history.
    pub(super) fn of(&mut self, history: Option<&Arc<Trace>>, run: Option<(&SceneData, States)>) -> &[Tick] {
        let is_same = match (&self.of, history) {
            (Some(known), Some(history)) => Arc::ptr_eq(known, history),
            (None, None) => true,
            _ => false,
        };
        if !is_same {
            self.of = history.cloned();
            self.all =
                history.zip(run).map(|(history, (data, states))| ticks(history, data, states)).unwrap_or_default();
        }
        &self.all
    }
}

/// The events of a history whose passes are known.
fn ticks(history: &Trace, data: &SceneData, states: States) -> Vec<Tick> {
    let mut events = events(history, data).into_iter().peekable();
    let (mut hit, mut is_walking) = ((None, None), true);
    let mut all = Vec::new();
    for (row, r) in history.rows.iter().enumerate() {
        let event = events.next_if(|event| event.row == row);
        let before = std::mem::replace(&mut hit, (r.after.triangle, r.after.t.map(f32::to_bits)));
        let was_walking = std::mem::replace(&mut is_walking, !states.is_decided(r.after.tag));
        let mark = match event.map(|event| event.kind) {
            _ if was_walking && !is_walking && r.after.triangle.is_some() => Mark::Accepted,
            _ if before != hit && r.after.triangle.is_some() => Mark::Hit,
            Some(EventKind::Test(_)) => Mark::Test,
            Some(EventKind::Cell(_) | EventKind::Node(_)) => Mark::Move,
            Some(EventKind::Left) => Mark::Left,
            None => continue,
        };
        if let Some(place) = r.place() {
            all.push(Tick { place, row, mark });
        }
    }
    all
}

/// The tick that is drawn nearest to a position, if it is near.
pub(super) fn nearest(ticks: &[Tick], at: f32, x: impl Fn(usize) -> Option<f32>) -> Option<Tick> {
    const NEAR: f32 = 6.0;
    let off = |tick: &Tick| x(tick.place).map_or(f32::INFINITY, |x| (x - at).abs());
    // Where several are on top of each other, the most telling one.
    let rank = |tick: &Tick| !tick.mark.is_hit();
    let by = |a: &&Tick, b: &&Tick| off(a).total_cmp(&off(b)).then(rank(a).cmp(&rank(b)));
    ticks.iter().min_by(by).filter(|tick| off(tick) <= NEAR).copied()
}

/// Paints them in their lane: those ahead of the place are fainter.
pub(super) fn paint(
    painter: &Painter,
    lane: Rect,
    ticks: &[Tick],
    place: usize,
    [color, accent]: [Color32; 2],
    x: impl Fn(usize) -> Option<f32>,
) {
    let mut last = f32::NEG_INFINITY;
    // Accepted hits are painted last.
    for is_hit in [false, true] {
        for tick in ticks.iter().filter(|tick| tick.mark.is_hit() == is_hit) {
            let Some(x) = x(tick.place) else { continue };
            // Lines closer than a point are one.
            if tick.mark == Mark::Move && (x - last).abs() < 1.0 {
                continue;
            }
            last = if tick.mark == Mark::Move { x } else { last };
            let color = if is_hit { accent } else { color };
            let color = if tick.place > place { color.gamma_multiply(0.55) } else { color };
            tick.mark.paint(painter, pos2(x, lane.center().y), color);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use raystep_kernels::export::trace::{Rays, TraceRow, trace};
    use raystep_kernels::{Device, Renderer};
    use raystep_scenes::generate;

    use super::*;
    use crate::settings::Settings;

    #[test]
    fn every_test_move_and_accepted_hit_of_a_ray_has_its_mark() {
        let scene = generate::cornell_box();
        let settings = Settings { size: [16, 16], ..Settings::default() };
        let (history, ticks) = pollster::block_on(async {
            let mut renderer =
                Renderer::new(&scene, &settings.options(&scene), &Device::Cpu(None)).await.expect("a run");
            let go_on = |_: &_| ControlFlow::Continue(());
            let history = trace(&mut renderer, 9, 9, Rays::All, go_on).await.expect("a history");
            let ticks = ticks(&history, renderer.data(), renderer.plan().program.states);
            (history, ticks)
        });
        let count = |mark: Mark| ticks.iter().filter(|tick| tick.mark == mark).count();
        // The reasons are found from other numbers of the same rows.
        let says = |part: &str| history.rows.iter().filter(|row| row.why.contains(part)).count();
        let (hits, accepted) = (says(", v "), says("accepted"));
        // The pass that accepts the hit may test a triangle, too.
        let is_only_test =
            |row: &&TraceRow| row.tested.is_some() && ![", v ", "accepted"].iter().any(|p| row.why.contains(p));
        let tests = history.rows.iter().filter(is_only_test).count();
        let texts: Vec<_> = history.rows.iter().map(|row| &row.why).collect();
        assert!(hits > 0 && accepted == 1 && tests > 0, "{texts:#?}");
        assert_eq!([Mark::Hit, Mark::Test, Mark::Accepted].map(count), [hits, tests, accepted], "{texts:#?}");
        assert!(count(Mark::Move) > 1);
        assert!(ticks.windows(2).all(|two| two[0].place < two[1].place));
        assert!(ticks.iter().all(|tick| history.rows[tick.row].place() == Some(tick.place)));
        let x = |place: usize| Some(10.0 * place as f32);
        let some = ticks[2];
        assert_eq!(nearest(&ticks, 10.0 * some.place as f32 + 4.0, x), Some(some));
        assert_eq!(nearest(&ticks, -50.0, x), None);
        assert_eq!(nearest(&[], 0.0, x), None);
    }
}
