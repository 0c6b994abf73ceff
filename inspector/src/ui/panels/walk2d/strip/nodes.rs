//! Nodes of a BVH as bars over the interval in which the ray is in their boxes.

use egui::{Align2, Color32, FontId, Rect, Stroke, StrokeKind, Vec2, pos2, vec2};

use super::super::Under;
use super::super::picture::{current_color, in_order};
use super::super::progress::row_of;
use super::words::node_words;
use super::{MOST, Pen, SIZE};
use crate::ui::panels::labels::is_through;
use crate::ui::state::Picked;

/// Height of the space for labels of tests.
const NOTES: f32 = 32.0;
/// Points between a name and the ends, and the edges, of its bar.
const MARGIN: Vec2 = vec2(4.0, 1.0);
/// Height of digits, which round ones surpass a little.
const HEIGHT: f32 = 0.72 * SIZE + 0.5;

/// A node's index and interval, or its index alone, to be written in its bar.
pub(super) struct Name {
    bar: Rect,
    texts: [String; 2],
    color: Color32,
}

impl Pen<'_> {
    pub(super) fn nodes(&mut self) -> Option<Under> {
        let lines = self.strip.lines().max(1) as f32;
        let notes = if self.body.height() >= NOTES + 10.0 + 6.0 * lines { NOTES } else { 0.0 };
        let line = ((self.body.height() - 6.0 - notes) / lines).clamp(1.0, 16.0);
        let gap = if line >= 5.0 { 2.0 } else { 0.0 };
        let mut under = None;
        for node in self.strip.nodes.iter().take(MOST) {
            let Some(t) = node.t else { continue };
            let [left, right] = t.map(|t| self.place(t));
            let top = self.body.top() + 3.0 + node.line as f32 * line;
            let bar = Rect::from_min_size(pos2(left, top), vec2((right - left).max(1.5), (line - gap).max(1.0)));
            let has_come = self.has_come(node.visit);
            let color = in_order(node.visit, self.strip.nodes.len());
            if node.is_met {
                self.painter.rect_filled(bar, 1.0, color.gamma_multiply(if has_come { 0.55 } else { 0.08 }));
            }
            // The last nodes are yellow, which is faint on white.
            let ahead = if self.scene.visuals.dark_mode { 0.25 } else { 0.6 };
            let stroke = Stroke::new(1.0, color.gamma_multiply(if has_come { 0.9 } else { ahead }));
            self.painter.rect_stroke(bar, 1.0, stroke, StrokeKind::Inside);
            if self.scene.now.and_then(|now| now.current_node) == Some(node.node) {
                let stroke = Stroke::new(2.0, current_color(self.scene.visuals));
                self.painter.rect_stroke(bar, 1.0, stroke, StrokeKind::Outside);
            }
            let what = Some(Picked::Node(node.node));
            if self.is_picked(what) {
                self.painter.rect_stroke(bar.expand(1.0), 1.0, self.picked_stroke(), StrokeKind::Outside);
            }
            if bar.height() >= HEIGHT + 2.0 * MARGIN.y && bar.width() >= SIZE {
                let [near, far] = t.map(|t| self.scene.t(t));
                let texts = [format!("{}: {near} to {far}", node.node), node.node.to_string()];
                self.names.push(Name { bar, texts, color: self.text_color(has_come) });
            }
            let words = || node_words(node, t, self.scene);
            if self.is_over(bar, words) {
                under = row_of(self.scene.walk, node.visit).map(|row| Under { text: words(), row, what });
            }
            let radius = (line * 0.25).clamp(1.0, 3.5);
            let y = bar.center().y;
            under = self.tests_along(&node.tests, y, radius, Some(node.visit)).or(under);
        }
        let room = Rect::from_min_max(pos2(self.body.left(), self.body.bottom() - notes), self.body.max);
        if notes > 0.0 {
            self.write_notes(room);
        }
        self.write_names();
        under
    }

    /// Writes each name as far as there is room for it in its bar beside dots and lines: at the right, for dots lie where
    /// the ray enters as often as not, otherwise at the left. A name without room is left out.
    fn write_names(&mut self) {
        for Name { bar, texts, color } in std::mem::take(&mut self.names) {
            let places = texts.into_iter().flat_map(|text| {
                let galley = self.painter.layout_no_wrap(text, FontId::proportional(SIZE), color);
                let free = bar.shrink2(MARGIN);
                let size = vec2(galley.mesh_bounds.width(), HEIGHT);
                [Align2::RIGHT_CENTER, Align2::LEFT_CENTER]
                    .map(|align| (align.align_size_within_rect(size, free), galley.clone()))
            });
            let is_free = |ink: &Rect| {
                bar.contains_rect(ink.expand2(MARGIN - vec2(0.01, 0.01)))
                    && !self.dots.iter().any(|dot| dot.intersects(*ink))
                    && !self.leaders.iter().any(|&line| is_through(line, ink.expand(1.0)))
            };
            let Some((ink, galley)) = places.into_iter().find(|(ink, _)| is_free(ink)) else { continue };
            #[cfg(test)]
            self.written.push([ink, bar]);
            let from = ink.center() - galley.mesh_bounds.center().to_vec2();
            self.painter.galley(from, galley, color);
        }
    }

    /// Without a structure, only tests.
    pub(super) fn tests_alone(&mut self) -> Option<Under> {
        let y = self.body.bottom() - (self.body.height() * 0.3).clamp(6.0, 16.0);
        let stroke = Stroke::new(1.0, self.scene.visuals.weak_text_color().gamma_multiply(0.4));
        self.painter.hline(self.body.x_range(), y, stroke);
        let under = self.tests_along(&self.strip.tests, y, 3.5, None);
        let room = Rect::from_min_max(self.body.min, pos2(self.body.right(), y - 6.0));
        self.write_notes(room);
        under
    }
}
