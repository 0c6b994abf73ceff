//! Tests of triangles: dots, and labels with t and the result where there is room for them.

use egui::epaint::CircleShape;
use egui::{Color32, FontId, Pos2, Rect, Stroke, Vec2, vec2};

use super::super::Under;
use super::super::picture::{current_color, outcome_color};
use super::words::{note_words, test_words};
use super::{MOST, Pen, SIZE};
use crate::ui::panels::labels::{Avoid, Wanted, in_order, places};
use crate::ui::state::Picked;
use crate::walk::{Outcome, StripTest};

/// Most labels that are placed.
const MOST_NOTES: usize = 24;

/// A label.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Note {
    /// The most important ones have the lowest rank.
    pub(super) rank: u32,
    pub(super) at: Pos2,
    pub(super) text: String,
    pub(super) color: Color32,
}

impl Pen<'_> {
    /// Tests at their t.
    pub(super) fn tests_along(
        &mut self,
        tests: &[StripTest],
        y: f32,
        radius: f32,
        visit: Option<usize>,
    ) -> Option<Under> {
        let [first, last] = self.strip.t;
        let mut under = None;
        let mut tests: Vec<&StripTest> = tests.iter().take(MOST).collect();
        // Hits over misses: triangles in one plane are met at the same t.
        tests.sort_by_key(|test| test.outcome);
        for test in tests {
            let t = test.t.filter(|t| (first..=last).contains(t));
            if let Some(x) = t.map(|t| self.place(t)).filter(|x| x.is_finite()) {
                under = self.test(test, Pos2::new(x, y), radius, visit).or(under);
            }
        }
        under
    }

    /// A dot. `visit` is the cell or leaf that it belongs to.
    pub(super) fn test(&mut self, test: &StripTest, at: Pos2, radius: f32, visit: Option<usize>) -> Option<Under> {
        let tested = self.scene.walk.tested.get(test.test)?;
        let row = tested.row;
        let visuals = self.scene.visuals;
        let has_come = self.scene.progress.has(row);
        let color =
            if has_come { outcome_color(visuals, test.outcome) } else { visuals.weak_text_color().gamma_multiply(0.5) };
        match test.outcome {
            Outcome::NotNearest => self.painter.circle(at, radius, visuals.panel_fill, Stroke::new(1.5, color)),
            Outcome::Missed | Outcome::Nearest => self.painter.circle_filled(at, radius, color),
        };
        self.dots.push(Rect::from_center_size(at, Vec2::splat(2.0 * radius + 4.0)));
        let is_now = self.scene.progress.row == Some(row);
        if is_now {
            self.painter.circle_stroke(at, radius + 2.0, Stroke::new(1.5, current_color(visuals)));
        }
        let what = Some(Picked::Triangle(test.triangle));
        let is_picked = self.is_picked(what);
        if is_picked {
            self.painter.circle_stroke(at, radius + 3.0, self.picked_stroke());
        }
        if has_come {
            let hit = self.scene.now.and_then(|now| now.hit).map(|hit| hit.triangle);
            let is_hit = test.outcome == Outcome::Nearest && hit == Some(test.triangle);
            let is_here = visit.is_some() && self.scene.progress.visit == visit;
            let rank = match () {
                () if is_now => 0,
                () if is_hit => 1,
                () if is_picked => 3,
                () if is_here => 4,
                () if test.outcome.is_hit() => 5,
                () => 6,
            };
            let text = note_words(tested, rank < 4, self.scene);
            self.notes.push(Note { rank, at, text, color: outcome_color(visuals, test.outcome) });
        }
        let (words, reach) = (|| test_words(tested, self.scene), radius.max(4.0));
        // In a file the dot alone: what lies beneath it has a title too.
        self.scene.title(self.painter, CircleShape::filled(at, radius, Color32::BLACK), words);
        let is_over = self.scene.cursor.is_some_and(|cursor| cursor.distance(at) <= reach);
        is_over.then(|| Under { text: words(), row, what })
    }

    /// Places and paints the labels; those without room are left out.
    pub(super) fn write_notes(&mut self, room: Rect) {
        let mut notes = std::mem::take(&mut self.notes);
        notes.sort_by_key(|note| note.rank);
        notes.truncate(MOST_NOTES);
        let margin = vec2(3.0, 0.5);
        let font = FontId::proportional(SIZE);
        let galleys: Vec<_> =
            notes.iter().map(|n| self.painter.layout_no_wrap(n.text.clone(), font.clone(), n.color)).collect();
        let wanted: Vec<Wanted> =
            notes.iter().zip(&galleys).map(|(n, g)| Wanted { at: n.at, size: g.size() + 2.0 * margin }).collect();
        let mut places = places(room, &wanted, &Avoid::default());
        in_order(room, &wanted, &mut places);
        // Opaque: bars beneath it would take contrast from the text.
        let background = self.scene.visuals.panel_fill;
        for (note, place) in notes.iter().zip(&places) {
            if let Some(line) = place.and_then(|place| place.leader) {
                self.painter.line_segment(line, Stroke::new(1.0, note.color.gamma_multiply(0.6)));
                self.leaders.push(line);
            }
        }
        for ((note, galley), place) in notes.iter().zip(galleys).zip(places) {
            let Some(place) = place else { continue };
            #[cfg(test)]
            self.placed.push(place.rect);
            self.painter.rect_filled(place.rect, 2.0, background);
            self.painter.galley(place.rect.min + margin, galley, note.color);
        }
    }
}
