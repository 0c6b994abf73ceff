//! The walk unfolded along t: cells side by side with their tmax above, or nodes below each other, and the triangles
//! tested; below them a scale of t.

mod cells;
mod dots;
mod nodes;
mod words;

use egui::epaint::{CircleShape, RectShape};
use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Shape, Stroke, pos2, vec2};

use super::super::picked;
use super::picture::{outcome_color, ray_color};
use super::progress::row_of;
use super::{Scene, Under};
use crate::ui::state::Picked;
use crate::walk::{Outcome, Spacing, Strip, Ticks};
use dots::Note;
use nodes::Name;

/// Points above and below a BVH's bars: a margin, labels, and the scale of t.
pub(super) const TREE_EDGES: f32 = 60.0;
/// Height of the scale of t.
pub(super) const SCALE: f32 = 22.0;
/// Most bars of nodes and dots of tests painted.
const MOST: usize = 4000;
/// Size of texts.
const SIZE: f32 = 11.0;

/// Draws it; describes the item under the cursor.
pub(super) fn draw(painter: &Painter, rect: Rect, strip: &Strip, scene: &Scene<'_>) -> Option<Under> {
    let (body, scale) = split_scale(rect);
    let under = lanes(painter, body, strip, scene);
    axis(painter, body, scale, strip, scene);
    under
}

/// The space of the lanes, and that of the scale below them.
pub(super) fn split_scale(rect: Rect) -> (Rect, Rect) {
    let rect = rect.shrink2(vec2(4.0, 0.0));
    rect.split_top_bottom_at_y((rect.bottom() - SCALE).max(rect.top()))
}

/// Draws everything but the scale.
pub(super) fn lanes(painter: &Painter, body: Rect, strip: &Strip, scene: &Scene<'_>) -> Option<Under> {
    Pen::new(painter, body, strip, scene).draw()
}

struct Pen<'a> {
    painter: &'a Painter,
    body: Rect,
    strip: &'a Strip,
    scene: &'a Scene<'a>,
    /// Labels that are still to be placed.
    notes: Vec<Note>,
    /// Names of bars that are still to be written.
    names: Vec<Name>,
    /// Where tests were painted, and lines from their labels to them: names keep off both.
    dots: Vec<Rect>,
    leaders: Vec<[Pos2; 2]>,
    /// Where labels were painted.
    #[cfg(test)]
    placed: Vec<Rect>,
    /// Where bars were painted.
    #[cfg(test)]
    bars: Vec<Rect>,
    /// Where the letters of names were painted, and in which bar.
    #[cfg(test)]
    written: Vec<[Rect; 2]>,
}

impl<'a> Pen<'a> {
    fn new(painter: &'a Painter, body: Rect, strip: &'a Strip, scene: &'a Scene<'a>) -> Self {
        Self {
            painter,
            body,
            strip,
            scene,
            notes: Vec::new(),
            names: Vec::new(),
            dots: Vec::new(),
            leaders: Vec::new(),
            #[cfg(test)]
            placed: Vec::new(),
            #[cfg(test)]
            bars: Vec::new(),
            #[cfg(test)]
            written: Vec::new(),
        }
    }

    fn draw(&mut self) -> Option<Under> {
        match (self.strip.cells.is_empty(), self.strip.nodes.is_empty()) {
            (false, _) => self.cells(),
            (true, false) => self.nodes(),
            (true, true) => self.tests_alone(),
        }
    }
}

impl Pen<'_> {
    fn x(&self, share: f64) -> f32 {
        self.body.left() + share as f32 * self.body.width()
    }

    fn place(&self, t: f64) -> f32 {
        self.x(self.strip.place(t, self.scene.spacing))
    }

    /// Whether the cursor is over it; `text` is what it then tells.
    fn is_over(&self, rect: Rect, text: impl FnOnce() -> String) -> bool {
        self.scene.title(self.painter, RectShape::filled(rect, 0.0, Color32::BLACK), text);
        self.scene.cursor.is_some_and(|at| rect.contains(at))
    }

    fn is_picked(&self, what: Option<Picked>) -> bool {
        what.is_some() && self.scene.picked == what
    }

    fn picked_stroke(&self) -> Stroke {
        Stroke::new(2.0, picked::color(self.scene.visuals))
    }

    fn has_come(&self, visit: usize) -> bool {
        row_of(self.scene.walk, visit).is_some_and(|row| self.scene.progress.has(row))
    }

    fn text(&self, at: Pos2, align: Align2, text: impl ToString, color: Color32) {
        self.painter.text(at, align, text, FontId::proportional(SIZE), color);
    }

    fn text_color(&self, has_come: bool) -> Color32 {
        let visuals = self.scene.visuals;
        if has_come { visuals.strong_text_color() } else { visuals.weak_text_color() }
    }

    /// A line of dashes with an arrowhead.
    fn arrow(&self, from: Pos2, to: Pos2, color: Color32) {
        let stroke = Stroke::new(1.5, color);
        self.painter.extend(Shape::dashed_line(&[from, to], stroke, 3.0, 3.0));
        for by in [-3.0, 3.0] {
            self.painter.line_segment([to, to + vec2(-4.0, by)], stroke);
        }
    }
}

/// A scale of t: at the ends of cells if these are equally wide, otherwise at round numbers.
pub(super) fn axis(painter: &Painter, body: Rect, rect: Rect, strip: &Strip, scene: &Scene<'_>) {
    let y = rect.top() + 5.0;
    let visuals = scene.visuals;
    let stroke = Stroke::new(1.0, visuals.weak_text_color());
    painter.hline(rect.x_range(), y, stroke);
    let x_of = |t: f64| body.left() + strip.place(t, scene.spacing) as f32 * body.width();
    let name = painter.text(
        pos2(rect.left(), y + 4.0),
        Align2::LEFT_TOP,
        "t",
        FontId::proportional(SIZE),
        visuals.weak_text_color(),
    );
    let (mut written, mut is_first) = (name.right(), true);
    for (t, text) in marks(strip, scene.spacing, scene.unit, rect.width()) {
        let x = x_of(t);
        painter.vline(x, y..=y + 4.0, stroke);
        let galley = painter.layout_no_wrap(text, FontId::proportional(SIZE), visuals.weak_text_color());
        let half = galley.size().x * 0.5;
        let most = (rect.right() - galley.size().x).max(rect.left());
        // The first number makes room for the name.
        let least = if is_first && x < written + 6.0 { written + 5.0 } else { rect.left() };
        let left = (x - half).clamp(least.min(most), most);
        // Cells that the ray barely touches end at the same t.
        if left < written + 5.0 {
            continue;
        }
        is_first = false;
        written = left + galley.size().x;
        painter.galley(pos2(left, y + 4.0), galley, visuals.weak_text_color());
    }
    let Some(now) = scene.now else { return };
    let inside = |t: &f64| (strip.t[0]..=strip.t[1]).contains(t);
    if let Some(hit) = now.hit.map(|hit| hit.t).filter(inside) {
        let at = pos2(x_of(hit), y);
        painter.circle_filled(at, 4.0, outcome_color(visuals, Outcome::Nearest));
        scene.title(painter, CircleShape::filled(at, 4.0, Color32::BLACK), || {
            format!("nearest hit, t {}", scene.t(hit))
        });
    }
    if inside(&now.t) {
        painter.circle_filled(pos2(x_of(now.t), y), 3.0, ray_color(visuals));
    }
}

/// Tick marks of the scale with their texts, in the units shown.
fn marks(strip: &Strip, spacing: Spacing, unit: f64, width: f32) -> Vec<(f64, String)> {
    match spacing {
        Spacing::Equal if !strip.cells.is_empty() => {
            let ends = strip.cells.iter().map(|cell| cell.t[1]);
            std::iter::once(strip.t[0]).chain(ends).map(|t| (t, super::super::walked::number(t * unit))).collect()
        }
        _ => {
            let ticks = Ticks::of(strip.t.map(|t| t * unit), ((width / 62.0) as usize).clamp(2, 24));
            ticks.values.iter().map(|&t| (t / unit, ticks.text(t))).collect()
        }
    }
}

#[cfg(test)]
mod tests;
