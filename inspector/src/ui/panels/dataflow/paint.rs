//! The graph on the screen.

use egui::{Align2, Color32, CornerRadius, FontId, Pos2, Rect, Shape, Stroke, StrokeKind, Ui, Vec2, pos2, vec2};
use raystep_kernels::Kernel;
use raystep_lab::text::counted;

use super::Touched;
use crate::dataflow::{Access, CHARACTER, DataFlow, HEIGHT, Node, NodeKind};
use crate::ui::panels::chart::kernel_color;
use crate::ui::style::{SMALLEST, ink_on, towards};

/// Parts of a node's height that its first, its second and its only line take at most.
const LINES: [f32; 3] = [0.36, 0.29, 0.7];
/// Node height, in points, above which a node has two lines.
const TWO_LINES: f32 = SMALLEST / LINES[1];
/// The largest font, in points.
const LARGEST: f32 = 16.0;
/// Width of a character, as a part of the font's size.
const WIDTH: f32 = 0.58;

/// The smallest scale at which the names can be read.
pub(super) const LEAST: Vec2 = vec2(WIDTH * SMALLEST / CHARACTER, SMALLEST / (LINES[2] * HEIGHT));

/// Blue, orange, purple, green: distinguishable with any colour vision.
pub(super) fn access_color(access: Access, ui: &Ui) -> Color32 {
    let [r, g, b] = match (access, ui.visuals().dark_mode) {
        (Access::Read, false) => [42, 111, 187],
        (Access::Write, false) => [200, 98, 27],
        (Access::Update, false) => [122, 59, 154],
        (Access::Redraw, false) => [20, 122, 90],
        (Access::Read, true) => [104, 168, 240],
        (Access::Write, true) => [245, 150, 80],
        (Access::Update, true) => [196, 140, 230],
        (Access::Redraw, true) => [90, 200, 160],
    };
    Color32::from_rgb(r, g, b)
}

/// What is painted, and where.
pub(super) struct Paint<'a> {
    pub(super) ui: &'a Ui,
    pub(super) rect: Rect,
    pub(super) flow: &'a DataFlow,
    pub(super) place: &'a dyn Fn([f32; 2]) -> Pos2,
    /// The kernel of the last pass.
    pub(super) last: Option<Kernel>,
    /// The kernel of the next pass.
    pub(super) next: Option<Kernel>,
    /// Rays waiting for each kernel.
    pub(super) rays: &'a [(Kernel, u64)],
    pub(super) touched: Option<Touched>,
}

impl Paint<'_> {
    /// Edges below nodes, highlighted items on top.
    pub(super) fn all(&self) {
        let painter = self.ui.painter_at(self.rect);
        painter.rect_filled(self.rect, 2.0, self.ui.visuals().extreme_bg_color);
        for is_lit in [false, true] {
            for (i, edge) in self.flow.edges.iter().enumerate().filter(|(i, _)| self.is_lit(*i) == is_lit) {
                let color = if is_lit { access_color(edge.access, self.ui) } else { self.faded() };
                let is_touched = self.touched == Some(Touched::Edge(i));
                let width = if is_touched { 3.0 } else { 1.5 };
                let [kernel, data] = [(self.place)(edge.at_kernel), (self.place)(edge.at_data)];
                painter.line_segment([kernel, data], Stroke::new(width, color));
                if edge.access != Access::Write {
                    painter.add(self.head(data, kernel, color));
                }
                if edge.access != Access::Read {
                    painter.add(self.head(kernel, data, color));
                }
            }
        }
        let sizes = self.sizes();
        for (i, node) in self.flow.nodes.iter().enumerate() {
            self.node(&painter, node, sizes, self.touched == Some(Touched::Node(i)));
        }
    }

    /// Edges of the item under the cursor; otherwise those of the last pass, or all before the first pass.
    fn is_lit(&self, index: usize) -> bool {
        let edge = &self.flow.edges[index];
        match (self.touched, self.last) {
            (Some(Touched::Edge(touched)), _) => touched == index,
            (Some(Touched::Node(node)), _) => edge.kernel == node || edge.data == node,
            (None, Some(last)) => self.flow.nodes[edge.kernel].kind == NodeKind::Kernel(last),
            (None, None) => true,
        }
    }

    fn faded(&self) -> Color32 {
        if self.ui.visuals().dark_mode { Color32::from_gray(62) } else { Color32::from_gray(212) }
    }

    /// An arrowhead at `to`.
    fn head(&self, from: Pos2, to: Pos2, color: Color32) -> Shape {
        let along = (to - from).normalized() * 8.0f32.min(0.2 * (to - from).length());
        let side = along.rot90() * 0.4;
        Shape::convex_polygon(vec![to, to - along + side, to - along - side], color, Stroke::NONE)
    }

    fn node(&self, painter: &egui::Painter, node: &Node, sizes: [f32; 2], is_touched: bool) {
        let visuals = self.ui.visuals();
        let rect = Rect::from_two_pos((self.place)(node.min), (self.place)(node.max));
        // The name of a node that is cut off is in the part that is left; a part without room for it says nothing.
        let (visible, lines) = (rect.intersect(painter.clip_rect()), self.lines(node, rect.height()));
        let fits = |line: &Line| line.fits(rect, visible) >= SMALLEST;
        if visible != rect && !lines.first().is_some_and(fits) {
            return;
        }
        let (fill, corner) = match node.kind {
            NodeKind::Kernel(kernel) => (kernel_color(kernel), 0.15 * rect.height()),
            NodeKind::Stream(_) => (Color32::from_rgb(66, 124, 200), rect.height() / 2.0),
            NodeKind::Buffer(_) => (Color32::from_gray(128), 0.0),
        };
        let is_kernel = |wanted: Option<Kernel>| wanted.is_some_and(|k| node.kind == NodeKind::Kernel(k));
        let strength = if is_kernel(self.last) { 0.75 } else { 0.28 };
        let fill = towards(visuals.extreme_bg_color, fill, strength);
        let corner = CornerRadius::same(corner.clamp(0.0, 255.0) as u8);
        let stroke = match is_touched || is_kernel(self.last) {
            true => Stroke::new(2.0, visuals.strong_text_color()),
            false => Stroke::new(1.0, visuals.weak_text_color()),
        };
        painter.rect(rect, corner, fill, stroke, StrokeKind::Inside);
        if is_kernel(self.next) {
            painter.extend(Shape::dashed_line(
                &outline(rect.expand(4.0)),
                Stroke::new(2.0, visuals.warn_fg_color),
                5.0,
                4.0,
            ));
        }
        for (i, line) in lines.into_iter().enumerate() {
            if fits(&line) {
                let middle = pos2(visible.center().x, rect.top() + line.middle * rect.height());
                let font = FontId::proportional(sizes[i].min(line.fits(rect, visible)));
                painter.text(middle, Align2::CENTER_CENTER, line.text, font, ink_on(fill));
            }
        }
    }

    /// Name and second line; in a low node the name alone.
    fn lines(&self, node: &Node, height: f32) -> Vec<Line> {
        let rays = match node.kind {
            NodeKind::Kernel(kernel) => self.rays.iter().find(|(k, _)| *k == kernel).map(|(_, rays)| *rays),
            _ => None,
        };
        let line = |text: String, size: f32, middle: f32| Line { text, size, middle };
        let [first, second, only] = LINES;
        if height < TWO_LINES {
            // There is room for the name alone; hovering shows the rest.
            return vec![line(node.label.clone(), only, 0.5)];
        }
        let detail = rays.map_or_else(|| node.detail.clone(), |rays| counted(rays, "ray"));
        vec![line(node.label.clone(), first, 0.3), line(detail, second, 0.71)]
    }

    /// The fonts of first and second lines: the same in all nodes, small enough to fit each of them.
    fn sizes(&self) -> [f32; 2] {
        let mut sizes = [LARGEST, LARGEST];
        for node in &self.flow.nodes {
            let rect = Rect::from_two_pos((self.place)(node.min), (self.place)(node.max));
            for (size, line) in sizes.iter_mut().zip(self.lines(node, rect.height())) {
                *size = size.min(line.fits(rect, rect));
            }
        }
        sizes.map(|size| size.max(SMALLEST))
    }
}

/// A line of text in a node.
struct Line {
    text: String,
    /// Maximum font size, as a fraction of the node's height.
    size: f32,
    /// Vertical position of its middle, as a fraction of the node's height.
    middle: f32,
}

impl Line {
    /// The largest font that fits the visible part of a node; 0 where the line is above or below it.
    fn fits(&self, rect: Rect, visible: Rect) -> f32 {
        let size = (self.size * rect.height()).min(visible.width() / (WIDTH * self.text.chars().count().max(1) as f32));
        let middle = rect.top() + self.middle * rect.height();
        let is_inside = visible.y_range().expand(0.5).contains(middle - 0.6 * size)
            && visible.y_range().expand(0.5).contains(middle + 0.6 * size);
        if is_inside { size } else { 0.0 }
    }
}

/// The outline of a rectangle.
fn outline(rect: Rect) -> [Pos2; 5] {
    let Rect { min, max } = rect;
    [min, pos2(max.x, min.y), max, pos2(min.x, max.y), min]
}
