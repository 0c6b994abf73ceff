//! The walk unfolded along t: cells side by side with their tmax bars above, or nodes below each other.

use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Stroke, StrokeKind, pos2, vec2};
use raystep_lab::text::counted;

use super::super::walked::number;
use super::picture::{current_color, in_order, outcome_color, ray_color};
use super::progress::row_of;
use super::{Scene, Under};
use crate::walk::{Entry, Outcome, Spacing, Strip, StripCell, StripTest};

/// Points above and below a BVH's bars: a margin and the scale of t.
pub(super) const TREE_EDGES: f32 = 26.0;
const SCALE: f32 = 20.0;
/// Most bars of nodes and dots of tests painted.
const MOST: usize = 4000;

/// Draws it; describes the item under the cursor.
pub(super) fn draw(
    painter: &Painter,
    rect: Rect,
    strip: &Strip,
    spacing: Spacing,
    scene: &Scene<'_>,
    cursor: Option<Pos2>,
) -> Option<Under> {
    let rect = rect.shrink2(vec2(4.0, 0.0));
    let (body, scale) = rect.split_top_bottom_at_y((rect.bottom() - SCALE).max(rect.top()));
    let pen = Pen { painter, body, strip, spacing, scene, cursor };
    let under = match (strip.cells.is_empty(), strip.nodes.is_empty()) {
        (false, _) => pen.cells(),
        (true, false) => pen.nodes(),
        (true, true) => pen.tests(&strip.tests, |test| test.t.map(|t| pen.place(t)), body.center().y, 3.5),
    };
    pen.axis(scale);
    under
}

struct Pen<'a> {
    painter: &'a Painter,
    body: Rect,
    strip: &'a Strip,
    spacing: Spacing,
    scene: &'a Scene<'a>,
    cursor: Option<Pos2>,
}

impl Pen<'_> {
    fn x(&self, share: f64) -> f32 {
        self.body.left() + share as f32 * self.body.width()
    }

    fn place(&self, t: f64) -> f32 {
        self.x(self.strip.place(t, self.spacing))
    }

    fn is_over(&self, rect: Rect) -> bool {
        self.cursor.is_some_and(|at| rect.contains(at))
    }

    fn row(&self, test: &StripTest) -> Option<usize> {
        self.scene.walk.tested.get(test.test).map(|tested| tested.row)
    }

    fn cells(&self) -> Option<Under> {
        let height = (self.body.height() * 0.34).clamp(18.0, 46.0);
        let has_names = self.body.height() >= 110.0;
        let names = if has_names { 13.0 } else { 0.0 };
        let cells_bottom = self.body.bottom() - names;
        let cells_top = cells_bottom - height;
        // Between them, the names of the axes.
        let bars_bottom = cells_top - 16.0;
        let mut under = None;
        for (cell, [left, right]) in self.strip.cells.iter().zip(self.strip.columns(self.spacing)) {
            let (left, right) = (self.x(left), self.x(right).max(self.x(left) + 0.5));
            let column = Rect::from_min_max(pos2(left, cells_top), pos2(right, cells_bottom));
            let has_come = self.has_come(cell.visit);
            let is_here = self.scene.progress.visit == Some(cell.visit);
            let color = in_order(cell.visit, self.strip.cells.len());
            self.painter.rect_filled(column, 0.0, color.gamma_multiply(if has_come { 0.45 } else { 0.08 }));
            let line = Stroke::new(1.0, color.gamma_multiply(if has_come { 0.9 } else { 0.25 }));
            self.painter.rect_stroke(column, 0.0, line, StrokeKind::Inside);
            let bars = Rect::from_min_max(pos2(left, self.body.top() + 2.0), pos2(right, bars_bottom));
            if bars.height() > 8.0 {
                self.tmax(cell, bars, has_come);
            }
            if is_here {
                let stroke = Stroke::new(2.0, current_color(self.scene.visuals));
                self.painter.rect_stroke(column.expand2(vec2(1.0, 1.0)), 0.0, stroke, StrokeKind::Inside);
            }
            let text_color = self.text_color(has_come);
            if column.width() >= 12.0 {
                let font = FontId::proportional(11.0);
                self.painter.text(
                    column.center_top() + vec2(0.0, 1.0),
                    Align2::CENTER_TOP,
                    &cell.letters,
                    font,
                    text_color,
                );
            }
            if has_names && column.width() >= 40.0 {
                let [x, y, z] = cell.cell;
                let (at, font) = (column.center_bottom() + vec2(0.0, 1.0), FontId::proportional(11.0));
                self.painter.text(at, Align2::CENTER_TOP, format!("{x},{y},{z}"), font, text_color);
            }
            let whole = Rect::from_min_max(pos2(left, self.body.top()), column.max);
            if self.is_over(whole) {
                under = row_of(self.scene.walk, cell.visit).map(|row| Under { text: cell_words(cell), row });
            }
            // In test order: their t often lies outside the cell.
            let count = cell.tests.len() as f32;
            let radius = (column.width() / (2.6 * count)).clamp(0.8, 4.0);
            for (i, test) in cell.tests.iter().enumerate() {
                let x = left + column.width() * (i as f32 + 0.5) / count;
                under = self.test(test, pos2(x, column.bottom() - 8.0), radius).or(under);
            }
        }
        under
    }

    /// Three bars, the smallest in the ray's colour.
    fn tmax(&self, cell: &StripCell, rect: Rect, has_come: bool) {
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
            if bar >= 8.0 {
                let at = pos2(left + bar * 0.5, rect.bottom());
                let name = ["x", "y", "z"][axis];
                self.painter.text(at, Align2::CENTER_TOP, name, FontId::proportional(11.0), self.text_color(has_come));
            }
        }
    }

    fn nodes(&self) -> Option<Under> {
        let lines = self.strip.lines().max(1) as f32;
        let line = ((self.body.height() - 6.0) / lines).clamp(1.0, 16.0);
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
            let stroke = Stroke::new(1.0, color.gamma_multiply(if has_come { 0.9 } else { 0.25 }));
            self.painter.rect_stroke(bar, 1.0, stroke, StrokeKind::Inside);
            if self.scene.now.and_then(|now| now.current_node) == Some(node.node) {
                let stroke = Stroke::new(2.0, current_color(self.scene.visuals));
                self.painter.rect_stroke(bar, 1.0, stroke, StrokeKind::Outside);
            }
            let name = node.node.to_string();
            if line >= 12.0 && bar.width() > 7.0 * name.len() as f32 + 10.0 {
                let (at, font) = (bar.right_center() - vec2(4.0, 0.0), FontId::proportional(11.0));
                self.painter.text(at, Align2::RIGHT_CENTER, name, font, self.text_color(has_come));
            }
            if self.is_over(bar) {
                let kind = if node.is_leaf { "leaf" } else { "node" };
                let met = if node.is_met { "entered" } else { "not entered before the nearest hit" };
                let text = format!(
                    "{kind} {}, level {}: t {} to {}, {met}",
                    node.node,
                    node.depth,
                    number(t[0]),
                    number(t[1])
                );
                under = row_of(self.scene.walk, node.visit).map(|row| Under { text, row });
            }
            let on_bar = |test: &StripTest| test.t.filter(|t| (self.strip.t[0]..=self.strip.t[1]).contains(t));
            let radius = (line * 0.25).clamp(1.0, 3.5);
            under =
                self.tests(&node.tests, |test| on_bar(test).map(|t| self.place(t)), bar.center().y, radius).or(under);
        }
        under
    }

    fn tests(&self, tests: &[StripTest], x: impl Fn(&StripTest) -> Option<f32>, y: f32, radius: f32) -> Option<Under> {
        let mut under = None;
        let mut tests: Vec<&StripTest> = tests.iter().take(MOST).collect();
        // Hits over misses: triangles in one plane are met at the same t.
        tests.sort_by_key(|test| test.outcome);
        for test in tests {
            if let Some(x) = x(test).filter(|x| x.is_finite()) {
                under = self.test(test, pos2(x, y), radius).or(under);
            }
        }
        under
    }

    /// A dot.
    fn test(&self, test: &StripTest, at: Pos2, radius: f32) -> Option<Under> {
        let row = self.row(test)?;
        let visuals = self.scene.visuals;
        let has_come = self.scene.progress.has(row);
        let color =
            if has_come { outcome_color(visuals, test.outcome) } else { visuals.weak_text_color().gamma_multiply(0.5) };
        match test.outcome {
            Outcome::NotNearest => self.painter.circle(at, radius, visuals.panel_fill, Stroke::new(1.5, color)),
            Outcome::Missed | Outcome::Nearest => self.painter.circle_filled(at, radius, color),
        };
        if self.scene.progress.row == Some(row) {
            self.painter.circle_stroke(at, radius + 2.0, Stroke::new(1.5, current_color(visuals)));
        }
        let is_over = self.cursor.is_some_and(|cursor| cursor.distance(at) <= radius.max(4.0));
        let t = test.t.map_or_else(|| "never meets its plane".into(), |t| format!("t {}", number(t)));
        is_over.then(|| Under { text: format!("triangle {}: {}, {t}", test.triangle, test.outcome.name()), row })
    }

    /// A scale of t.
    fn axis(&self, rect: Rect) {
        let y = rect.top() + 3.0;
        let visuals = self.scene.visuals;
        let stroke = Stroke::new(1.0, visuals.weak_text_color());
        self.painter.hline(rect.x_range(), y, stroke);
        let mut written = f32::NEG_INFINITY;
        for t in marks(self.strip, self.spacing) {
            let x = self.place(t);
            // Cells that the ray barely touches end at the same t.
            if x - written < 46.0 || x > rect.right() - 20.0 && written > rect.right() - 66.0 {
                continue;
            }
            let first = written == f32::NEG_INFINITY;
            written = x;
            self.painter.vline(x, y..=y + 4.0, stroke);
            let text = if first { format!("t {}", number(t)) } else { number(t) };
            let align = match x {
                _ if first => Align2::LEFT_TOP,
                _ if x > rect.right() - 20.0 => Align2::RIGHT_TOP,
                _ => Align2::CENTER_TOP,
            };
            self.painter.text(pos2(x, y + 4.0), align, text, FontId::proportional(11.0), visuals.weak_text_color());
        }
        let Some(now) = self.scene.now else { return };
        let inside = |t: &f64| (self.strip.t[0]..=self.strip.t[1]).contains(t);
        if let Some(hit) = now.hit.map(|hit| hit.t).filter(inside) {
            self.painter.circle_filled(pos2(self.place(hit), y), 4.0, outcome_color(visuals, Outcome::Nearest));
        }
        if inside(&now.t) {
            self.painter.circle_filled(pos2(self.place(now.t), y), 3.0, ray_color(visuals));
        }
    }

    fn has_come(&self, visit: usize) -> bool {
        row_of(self.scene.walk, visit).is_some_and(|row| self.scene.progress.has(row))
    }

    fn text_color(&self, has_come: bool) -> Color32 {
        let visuals = self.scene.visuals;
        if has_come { visuals.strong_text_color() } else { visuals.weak_text_color() }
    }
}

/// Tick marks of the scale: at the ends of cells if these are equally wide, otherwise evenly spaced.
fn marks(strip: &Strip, spacing: Spacing) -> Vec<f64> {
    match spacing {
        Spacing::Equal if !strip.cells.is_empty() => {
            std::iter::once(strip.t[0]).chain(strip.cells.iter().map(|cell| cell.t[1])).collect()
        }
        _ => (0..=8).map(|i| strip.t[0] + (strip.t[1] - strip.t[0]) * f64::from(i) / 8.0).collect(),
    }
}

/// Describes a cell.
fn cell_words(cell: &StripCell) -> String {
    let [x, y, z] = cell.cell;
    let [from, to] = cell.t.map(number);
    let [tx, ty, tz] = cell.tmax.map(|t| t.map_or_else(|| "never".into(), number));
    let axis = ["x", "y", "z"][cell.exit_axis];
    let on = match cell.next {
        Some(Entry::Leap { cells: [x, y, z] }) => format!(", then skips {x},{y},{z} cells"),
        Some(Entry::Wrap) => ", then wraps around at the grid's face into another row".into(),
        _ => String::new(),
    };
    format!(
        "{}: cell {x},{y},{z}, t {from} to {to}\ntmax x {tx}, y {ty}, z {tz}: leaves along {axis}{on}\n{} in its \
         list, {} tested",
        cell.letters,
        counted(cell.listed, "triangle"),
        cell.tests.len()
    )
}

#[cfg(test)]
mod tests {
    use raystep_kernels::{Accelerator, Options, Skip};

    use super::super::super::walked::tests::life;
    use super::*;
    use crate::walk::WalkGeometry;
    use crate::walk::tests::{TEAPOT, options, scene, traced};

    #[test]
    fn a_cell_is_told_in_numbers() {
        let (life, data) = life(Accelerator::Grid);
        let strip = Strip::new(&WalkGeometry::new(&life, &data, usize::MAX));
        let cell = strip.cells.iter().find(|cell| !cell.tests.is_empty()).expect("a test");
        let text = cell_words(cell);
        let [x, y, z] = cell.cell;
        let tmax = number(cell.tmax[cell.exit_axis].expect("a tmax"));
        assert!(text.contains(&format!("cell {x},{y},{z}, t {}", number(cell.t[0]))), "{text}");
        assert!(text.contains(&format!("{} {tmax}", ["x", "y", "z"][cell.exit_axis])), "{text}");
        assert!(text.contains(&format!("{} tested", cell.tests.len())), "{text}");
    }

    #[test]
    fn a_cell_that_is_left_by_a_leap_says_so() {
        let scene = scene(TEAPOT);
        let (life, data) = traced(&scene, &Options { skip: Skip::On, ..options(&scene) }, [32, 32]);
        let strip = Strip::new(&WalkGeometry::new(&life, &data, usize::MAX));
        let mut leaps = 0;
        for pair in strip.cells.windows(2) {
            let [from, to] = [pair[0].cell, pair[1].cell];
            let moved = [0, 1, 2].map(|axis: usize| to[axis] - from[axis]);
            let [x, y, z] = moved;
            let is_leap = moved.iter().map(|n| n.abs()).sum::<i32>() > 1;
            let said = cell_words(&pair[0]).contains(&format!(", then skips {x},{y},{z} cells\n"));
            assert_eq!(said, is_leap, "{}", cell_words(&pair[0]));
            leaps += u32::from(is_leap);
        }
        assert!(leaps > 0 && !cell_words(&strip.cells[strip.cells.len() - 1]).contains("goes on"));
    }

    #[test]
    fn the_scale_goes_over_the_whole_strip() {
        for accelerator in [Accelerator::Grid, Accelerator::Bvh] {
            let (life, data) = life(accelerator);
            let strip = Strip::new(&WalkGeometry::new(&life, &data, usize::MAX));
            for spacing in [Spacing::ByT, Spacing::Equal] {
                let marks = marks(&strip, spacing);
                assert_eq!(marks.first(), Some(&strip.t[0]));
                assert!(
                    marks.is_sorted() && (marks[marks.len() - 1] - strip.t[1]).abs() <= strip.t[1] * 1e-9,
                    "{marks:?}"
                );
            }
        }
    }
}
