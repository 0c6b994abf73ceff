//! Nodes of a BVH as bars over the interval in which the ray is in their boxes.

use egui::{Align2, FontId, Rect, Stroke, StrokeKind, pos2, vec2};

use super::super::Under;
use super::super::picture::{current_color, in_order};
use super::super::progress::row_of;
use super::words::node_words;
use super::{MOST, Pen, SIZE};
use crate::ui::state::Picked;

/// Height of the space for labels of tests.
const NOTES: f32 = 32.0;

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
            if line >= 12.0 {
                self.name(node.node, t, bar, has_come);
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
        under
    }

    /// The node's index and its interval, as far as there is room for them in the bar.
    fn name(&self, node: u32, t: [f64; 2], bar: Rect, has_come: bool) {
        let [near, far] = t.map(|t| self.scene.t(t));
        let color = self.text_color(has_come);
        let long = format!("{node}: {near} to {far}");
        let layout = |text: String| self.painter.layout_no_wrap(text, FontId::proportional(SIZE), color);
        let galleys = [long, node.to_string()].map(layout);
        if let Some(galley) = galleys.into_iter().find(|galley| galley.size().x + 10.0 < bar.width()) {
            // Beside the dots, which lie where the ray enters as often as not.
            let rect = Align2::RIGHT_CENTER.anchor_size(bar.right_center() - vec2(4.0, 0.0), galley.size());
            self.painter.galley(rect.min, galley, color);
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
