//! Paints the plots of the lab in the colours of the window.

use egui::epaint::{CircleShape, PathShape, TextShape};
use egui::{Align, Align2, Color32, FontId, Pos2, Rect, Sense, Shape, Stroke, Ui, vec2};
use raystep_lab::plots::picture::{Element, Form, Picture, Point, Side};
use raystep_lab::plots::{Ink, font};

use super::style::SMALLEST;

/// Largest magnification.
const MOST: f32 = 1.2;

/// Shows a plot as wide as there is room, but with texts that can be read, and with a name for screen readers.
pub(super) fn show(ui: &mut Ui, picture: &Picture, name: &str) {
    let (width, height) = (picture.size.0 as f32, picture.size.1 as f32);
    let sizes = picture.elements.iter().filter_map(|element| match element.form {
        Form::Text { size, .. } => Some(size as f32),
        _ => None,
    });
    let least = (SMALLEST / sizes.fold(f32::INFINITY, f32::min)).min(MOST);
    let scale = (ui.available_width() / width.max(1.0)).clamp(least, MOST);
    let (rect, response) = ui.allocate_exact_size(vec2(width, height) * scale, Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, name));
    if ui.is_rect_visible(rect) {
        let paint = Paint { ui, rect, scale };
        let shapes: Vec<Shape> = picture.elements.iter().map(|element| paint.shape(element)).collect();
        ui.painter_at(rect).extend(shapes);
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
        let stroke = |width: f64| Stroke::new(width as f32, color);
        let all = |points: &[Point]| points.iter().map(|&point| self.at(point)).collect::<Vec<Pos2>>();
        match &element.form {
            Form::Line { points, width, dashes: [] } => Shape::line(all(points), stroke(*width)),
            Form::Line { points, width, dashes } => {
                let lengths =
                    |first: usize| dashes.iter().skip(first).step_by(2).map(|part| part * self.scale).collect();
                let [on, off]: [Vec<f32>; 2] = [lengths(0), lengths(1)];
                Shape::Vec(Shape::dashed_line_with_offset(&all(points), stroke(*width), &on, &off, 0.0))
            }
            Form::Polygon { points, outline: None } => {
                PathShape::convex_polygon(all(points), color, Stroke::NONE).into()
            }
            Form::Polygon { points, outline: Some(width) } => Shape::closed_line(all(points), stroke(*width)),
            Form::Circle { center, radius, outline } => {
                let (center, radius) = (self.at(*center), *radius as f32 * self.scale);
                match outline {
                    None => CircleShape::filled(center, radius, color).into(),
                    Some(width) => CircleShape::stroke(center, radius, stroke(*width)).into(),
                }
            }
            Form::Text { text, at, size, align } => {
                let width = font::width(text, *size) as f32 * self.scale;
                self.text(text, self.at(*at), *size as f32 * self.scale, width, align.map(align_of), color)
            }
        }
    }

    /// No wider than the plot was laid out for: the window's font is not that of the files.
    fn text(&self, text: &str, at: Pos2, size: f32, width: f32, align: [Align; 2], color: Color32) -> Shape {
        let layout = |size: f32| {
            let font = FontId::proportional(size);
            self.ui.painter().layout_no_wrap(text.to_owned(), font, color)
        };
        let galley = layout(size);
        let galley = if galley.size().x > width { layout(size * width / galley.size().x) } else { galley };
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
