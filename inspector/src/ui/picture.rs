//! Paints the plots of the lab in the colours of the window.

use egui::epaint::{CircleShape, PathShape, RectShape, TextShape};
use egui::{
    Align, Align2, Color32, CornerRadius, FontId, Pos2, Rect, Sense, Shape, Stroke, StrokeKind, Ui, pos2, vec2,
};
use raystep_lab::plots::Ink;
use raystep_lab::plots::picture::{Element, Form, Picture, Point, Side};

use super::style::SMALLEST;

/// Largest magnification.
const MOST: f32 = 1.6;

/// Size of a font in an SVG file in relation to that of the same font here.
const FONT: f64 = 1.24;

/// Shows a plot as wide as there is room, with a name for screen readers.
pub(super) fn show(ui: &mut Ui, picture: &Picture, name: &str) {
    let (width, height) = (picture.size.0 as f32, picture.size.1 as f32);
    let scale = (ui.available_width() / width.max(1.0)).clamp(0.5, MOST);
    let (rect, response) = ui.allocate_exact_size(vec2(width, height) * scale, Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, name));
    if ui.is_rect_visible(rect) {
        let paint = Paint { ui, rect, scale };
        let shapes: Vec<Shape> = picture.elements.iter().map(|element| paint.shape(element)).collect();
        // In a small picture, texts at the edge are larger than their room.
        ui.painter_at(rect.expand(SMALLEST)).extend(shapes);
    }
}

struct Paint<'a> {
    ui: &'a Ui,
    rect: Rect,
    scale: f32,
}

impl Paint<'_> {
    fn at(&self, (x, y): Point) -> Pos2 {
        self.rect.min + vec2(x as f32, y as f32) * self.scale
    }

    fn color(&self, element: &Element) -> Color32 {
        let visuals = self.ui.visuals();
        let color = match Ink::of(element.color) {
            Ink::Paper => visuals.panel_fill,
            Ink::Rule => visuals.weak_text_color().gamma_multiply(0.35),
            Ink::Text => visuals.text_color(),
            Ink::Data(colors) => {
                let [red, green, blue] = colors[usize::from(visuals.dark_mode)];
                Color32::from_rgb(red, green, blue)
            }
        };
        color.gamma_multiply(element.opacity as f32)
    }

    fn shape(&self, element: &Element) -> Shape {
        let color = self.color(element);
        let stroke = |width: u32| Stroke::new(width as f32, color);
        match &element.form {
            Form::Line { points, width } => {
                Shape::line(points.iter().map(|&point| self.at(point)).collect(), stroke(*width))
            }
            Form::Polygon(points) => {
                let points = points.iter().map(|&point| self.at(point)).collect();
                PathShape::convex_polygon(points, color, Stroke::NONE).into()
            }
            Form::Rectangle { corners: [from, to], is_filled } => {
                let rect = Rect::from_two_pos(self.at(*from), self.at(*to));
                match is_filled {
                    true => RectShape::filled(rect, CornerRadius::ZERO, color).into(),
                    false => RectShape::stroke(rect, CornerRadius::ZERO, stroke(1), StrokeKind::Middle).into(),
                }
            }
            Form::Circle { center, radius, outline } => {
                let (center, radius) = (self.at(*center), *radius as f32 * self.scale);
                match outline {
                    None => CircleShape::filled(center, radius, color).into(),
                    Some(width) => CircleShape::stroke(center, radius, stroke(*width)).into(),
                }
            }
            Form::Text { text, at, size, align, is_vertical } => {
                let size = ((size / FONT) as f32 * self.scale).max(SMALLEST);
                self.text(text, self.at(*at), size, align.map(align_of), *is_vertical, color)
            }
        }
    }

    fn text(&self, text: &str, at: Pos2, size: f32, align: [Align; 2], is_vertical: bool, color: Color32) -> Shape {
        let galley = self.ui.painter().layout_no_wrap(text.to_owned(), FontId::proportional(size), color);
        let [across, down] = align.map(Align::to_factor);
        if is_vertical {
            let corner = pos2(at.x - down * galley.size().y, at.y + across * galley.size().x);
            return TextShape::new(corner, galley, color).with_angle(-std::f32::consts::FRAC_PI_2).into();
        }
        let rect = Align2(align).anchor_size(at, galley.size());
        TextShape::new(rect.min, galley, color).into()
    }
}

fn align_of(side: Side) -> Align {
    match side {
        Side::Start => Align::Min,
        Side::Middle => Align::Center,
        Side::End => Align::Max,
    }
}
