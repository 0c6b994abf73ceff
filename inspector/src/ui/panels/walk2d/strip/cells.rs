//! Cells side by side: three bars and numbers of tmax above each, the triangles tested in it, and leaps between them.

use egui::{Align2, Rect, Stroke, StrokeKind, pos2, vec2};

use super::super::Under;
use super::super::picture::{current_color, in_order, outlined, ray_color};
use super::super::progress::row_of;
use super::dots::Note;
use super::words::{cell_words, leap_words};
use super::{MOST, Pen, picked};
use crate::walk::{AXES, Entry, Outcome, StripCell};

/// Height of a line of numbers.
const LINE: f32 = 12.5;
/// Height of the space for labels of tests, and of that for a line of them.
const NOTES: f32 = 32.0;
const NOTE: f32 = 16.0;
/// Lower bars have no names.
const ROOM_FOR_NAMES: f32 = 22.0;
/// Narrower columns have no numbers.
const ROOM_FOR_TMAX: f32 = 54.0;

impl Pen<'_> {
    pub(super) fn cells(&mut self) -> Option<Under> {
        let height = (self.body.height() * 0.3).clamp(16.0, 46.0);
        let has_names = self.body.height() >= 110.0;
        let names = if has_names { 13.0 } else { 0.0 };
        let bottom = self.body.bottom() - names;
        let top = (bottom - height).max(self.body.top());
        // Labels have a space of their own, not over the bars.
        let notes = if self.body.height() >= 150.0 { NOTES } else { NOTE };
        let notes = notes.min((top - self.body.top()).max(0.0));
        let columns = self.strip.columns(self.scene.spacing);
        let mut under = None;
        let count = self.strip.cells.len();
        for (i, (cell, [left, right])) in self.strip.cells.iter().zip(&columns).enumerate() {
            let (left, right) = (self.x(*left), self.x(*right).max(self.x(*left) + 0.5));
            let column = Rect::from_min_max(pos2(left, top), pos2(right, bottom));
            let has_come = self.has_come(cell.visit);
            let color = in_order(cell.visit, count);
            self.painter.rect_filled(column, 0.0, color.gamma_multiply(if has_come { 0.45 } else { 0.08 }));
            let line = Stroke::new(1.0, color.gamma_multiply(if has_come { 0.9 } else { 0.25 }));
            self.painter.rect_stroke(column, 0.0, line, StrokeKind::Inside);
            let above = Rect::from_min_max(pos2(left, self.body.top() + 2.0), pos2(right, top - notes));
            under = self.over_cell(cell, above, column).or(under);
            if has_names && column.width() >= 40.0 {
                let [x, y, z] = cell.cell;
                let at = column.center_bottom() + vec2(0.0, 1.0);
                self.text(at, Align2::CENTER_TOP, format!("{x},{y},{z}"), self.text_color(has_come));
            }
            if let Some(next) = columns.get(i + 1).filter(|_| cell.is_left_by_a_leap()) {
                let gap = Rect::from_min_max(pos2(right, top), pos2(self.x(next[0]), bottom));
                under = self.leap(cell, gap).or(under);
            }
            under = self.tests_in(cell, column).or(under);
        }
        let room = Rect::from_min_max(pos2(self.body.left(), top - notes), pos2(self.body.right(), top - 1.0));
        self.write_notes(room);
        under
    }

    /// Letters, tmax, and marks of a cell.
    fn over_cell(&mut self, cell: &StripCell, above: Rect, column: Rect) -> Option<Under> {
        let has_come = self.has_come(cell.visit);
        let is_here = self.scene.progress.visit == Some(cell.visit);
        let is_wide = above.width() >= ROOM_FOR_TMAX;
        let has_numbers = is_wide && above.height() >= 3.0 * LINE + 10.0;
        if has_numbers {
            self.numbers(cell, above, has_come);
        } else if is_here {
            let texts = (0..3).filter_map(|axis| Some(format!("{} {}", AXES[axis], self.scene.t(cell.tmax[axis]?))));
            let text = format!("tmax {}", texts.collect::<Vec<_>>().join(", "));
            let color = ray_color(self.scene.visuals);
            self.notes.push(Note { rank: 2, at: pos2(column.center().x, above.bottom()), text, color });
        }
        let down = if has_numbers { 3.0 * LINE } else { 0.0 };
        let height = above.height() - down;
        // Low bars have no names.
        let names = if height >= ROOM_FOR_NAMES { 12.0 } else { 0.0 };
        let bars = Rect::from_min_max(above.min + vec2(0.0, down), above.max - vec2(0.0, names));
        if bars.height() > 8.0 {
            self.bars(cell, bars, has_come, names > 0.0);
            #[cfg(test)]
            self.bars.push(bars);
        }
        if is_here {
            let stroke = Stroke::new(2.0, current_color(self.scene.visuals));
            self.painter.rect_stroke(column.expand2(vec2(1.0, 1.0)), 0.0, stroke, StrokeKind::Inside);
        }
        let what = picked::cell(cell.cell);
        if self.is_picked(what) {
            self.painter.rect_stroke(column.expand(2.0), 0.0, self.picked_stroke(), StrokeKind::Inside);
        }
        let at = column.center_top() + vec2(0.0, 1.0);
        if column.width() >= 12.0 && at.y + LINE <= self.painter.clip_rect().bottom() {
            outlined(
                self.painter,
                at,
                Align2::CENTER_TOP,
                &cell.letters,
                self.text_color(has_come),
                self.scene.visuals,
            );
        }
        let words = || cell_words(cell, self.scene);
        let is_over = self.is_over(above.union(column), words);
        let row = row_of(self.scene.walk, cell.visit).filter(|_| is_over)?;
        Some(Under { text: words(), row, what })
    }

    /// tmax per axis as numbers, the smallest in the ray's colour.
    fn numbers(&self, cell: &StripCell, rect: Rect, has_come: bool) {
        for (axis, tmax) in cell.tmax.iter().enumerate() {
            let is_least = axis == cell.exit_axis && tmax.is_some();
            let color = if is_least && has_come { ray_color(self.scene.visuals) } else { self.text_color(has_come) };
            let text = format!("{} {}", AXES[axis], tmax.map_or_else(|| "never".into(), |t| self.scene.t(t)));
            let at = pos2(rect.center().x, rect.top() + LINE * axis as f32);
            self.text(at, Align2::CENTER_TOP, text, color);
        }
    }

    /// tmax per axis as bars, the smallest in the ray's colour.
    fn bars(&self, cell: &StripCell, rect: Rect, has_come: bool, has_names: bool) {
        let bar = (rect.width() / 4.0).min(14.0);
        let visuals = self.scene.visuals;
        for (axis, tmax) in cell.tmax.iter().enumerate() {
            let Some(tmax) = tmax else { continue };
            let share = self.strip.tmax_height(*tmax) as f32;
            let height = (share.min(1.0) * rect.height()).max(1.0);
            let left = rect.center().x + (axis as f32 - 1.5) * bar;
            let is_least = axis == cell.exit_axis;
            let color = if is_least { ray_color(visuals) } else { visuals.weak_text_color() };
            let color = color.gamma_multiply(if has_come { 1.0 } else { 0.3 });
            let gap = (bar * 0.1).min(0.5);
            let area =
                Rect::from_min_max(pos2(left + gap, rect.bottom() - height), pos2(left + bar - gap, rect.bottom()));
            self.painter.rect_filled(area, 0.0, color);
            if share > 1.0 && rect.height() > 20.0 {
                // Truncated.
                for down in [4.0, 8.0] {
                    let cut = Rect::from_min_size(pos2(left, rect.top() + down), vec2(bar, 1.5));
                    self.painter.rect_filled(cut, 0.0, visuals.panel_fill);
                }
            }
            if bar >= 8.0 && has_names {
                let at = pos2(left + bar * 0.5, rect.bottom());
                self.text(at, Align2::CENTER_TOP, AXES[axis], self.text_color(has_come));
            }
        }
    }

    /// The way from a cell to one that is not its neighbour.
    fn leap(&self, cell: &StripCell, gap: Rect) -> Option<Under> {
        let has_come = self.has_come(cell.visit + 1);
        let visuals = self.scene.visuals;
        let is_wrap = cell.next == Some(Entry::Wrap);
        let color = match is_wrap {
            true => super::outcome_color(visuals, Outcome::Missed),
            false => self.text_color(has_come),
        };
        let (from, to) = (gap.left_center(), gap.right_center());
        if gap.width() >= 6.0 {
            self.arrow(from + vec2(1.0, 0.0), to - vec2(1.0, 0.0), color);
        }
        if is_wrap {
            // A break: the next cell is not where the ray is.
            for by in [-2.0, 2.0] {
                let at = gap.center() + vec2(by, 0.0);
                self.painter.line_segment([at + vec2(-3.0, 7.0), at + vec2(3.0, -7.0)], Stroke::new(1.5, color));
            }
        }
        let name = if is_wrap { "wrap" } else { "leap" };
        if gap.width() >= 28.0 {
            self.text(gap.center() - vec2(0.0, 4.0), Align2::CENTER_BOTTOM, name, color);
        }
        let over = gap.expand2(vec2((8.0 - gap.width()).max(0.0) * 0.5, 0.0));
        let words = || leap_words(cell, self.scene);
        let is_over = self.is_over(over, words);
        let row = row_of(self.scene.walk, cell.visit + 1).filter(|_| is_over)?;
        Some(Under { text: words(), row, what: None })
    }

    /// Dots in the order of the tests: their t often lies outside of the cell.
    fn tests_in(&mut self, cell: &StripCell, column: Rect) -> Option<Under> {
        let count = cell.tests.len() as f32;
        let radius = (column.width() / (2.6 * count)).clamp(0.8, 4.0);
        let mut under = None;
        for (i, test) in cell.tests.iter().take(MOST).enumerate() {
            let x = column.left() + column.width() * (i as f32 + 0.5) / count;
            under = self.test(test, pos2(x, column.bottom() - 8.0), radius, Some(cell.visit)).or(under);
        }
        under
    }
}
