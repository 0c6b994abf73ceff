//! List lengths written into cells that are large enough, and the axes beside the layer.

use egui::{Align2, Color32, FontId, Painter, Rect, Stroke, Ui, pos2, vec2};
use raystep_lab::structure_stats::Slice;

use super::placement::{Placement, others};
use crate::ui::panels::structure::picture::color;
use crate::ui::style::SMALLEST;
use crate::walk::AXES;

/// Points around the digits of a cell.
const ROOM: f32 = 4.0;
/// Points per digit at the smallest size.
const DIGIT: f32 = 6.6;
/// Least points between the numbers of two columns or rows.
const BETWEEN: f32 = 34.0;

/// The size of the digits that fit into every cell of a layer; `None` if they would be too small to read.
pub(super) fn text_size(cell: egui::Vec2, longest: u32) -> Option<f32> {
    let digits = longest.max(1).ilog10() as f32 + 1.0;
    let fits = ((cell.x - ROOM) / digits * (SMALLEST / DIGIT)).min(cell.y - ROOM);
    (fits >= SMALLEST).then(|| fits.min(16.0))
}

/// Writes the lengths of the visible cells.
pub(super) fn lengths(painter: &Painter, slice: &Slice, place: &Placement, visible: Rect, longest: u32) {
    let most = slice.lengths.iter().copied().max().unwrap_or(0);
    let Some(size) = text_size(place.cell_size(), most) else { return };
    let [columns, rows] = place.visible(visible);
    for row in rows[0]..=rows[1] {
        for column in columns[0]..=columns[1] {
            let Some(&length) = slice.lengths.get((row * slice.width + column) as usize) else { continue };
            let ink = ink_on(color(length, longest), length);
            let font = FontId::monospace(size);
            painter.text(place.cell([column, row]).center(), Align2::CENTER_CENTER, length.to_string(), font, ink);
        }
    }
}

/// A colour that can be read on another one; grey for empty cells, which are many.
fn ink_on(background: Color32, length: u32) -> Color32 {
    if length == 0 {
        return Color32::from_gray(150);
    }
    let [r, g, b] = [background.r(), background.g(), background.b()].map(|part| (f32::from(part) / 255.0).powf(2.2));
    // At this luminance, black and white have the same contrast (WCAG 2.1).
    if 0.2126 * r + 0.7152 * g + 0.0722 * b > 0.18 { Color32::BLACK } else { Color32::WHITE }
}

/// Names the axes of a layer, and numbers its columns and rows.
pub(super) fn axes(ui: &Ui, painter: &Painter, slice: &Slice, place: &Placement, room: Rect, picture: Rect) {
    let [across, up] = others(slice.axis);
    let (ink, font) = (ui.visuals().text_color(), FontId::proportional(SMALLEST));
    let cell = place.cell_size();
    let [columns, rows] = place.visible(picture);
    let every = |points: f32| {
        let least = (BETWEEN / points.max(1e-3)).ceil().min(1e6) as i32;
        [1, 2, 5, 10, 20, 50, 100, 200, 500].into_iter().find(|&step| step >= least).unwrap_or(1000)
    };
    // The names are at the ends: no number is written over them.
    let (name_x, name_y) = (format!("+{}", AXES[across]), format!("+{}", AXES[up]));
    let (right, top) = (picture.right() - 34.0, picture.top() + 14.0);
    let step = every(cell.x);
    for column in (columns[0]..=columns[1]).filter(|column| column % step == 0) {
        let x = place.cell([column, 0]).center().x;
        if (picture.left()..right).contains(&x) {
            painter.text(pos2(x, picture.bottom() + 2.0), Align2::CENTER_TOP, column.to_string(), font.clone(), ink);
        }
    }
    let step = every(cell.y);
    for row in rows[0]..=rows[1] {
        let (y, number) = (place.cell([0, row]).center().y, slice.height - 1 - row);
        if number % step == 0 && (top..picture.bottom()).contains(&y) {
            painter.text(pos2(picture.left() - 4.0, y), Align2::RIGHT_CENTER, number.to_string(), font.clone(), ink);
        }
    }
    let strong = ui.visuals().strong_text_color();
    let [at_x, at_y] = [pos2(picture.right() - 14.0, picture.bottom() + 2.0), pos2(picture.left() - 12.0, room.top())];
    let x = painter.text(at_x, Align2::RIGHT_TOP, name_x, font.clone(), strong);
    let y = painter.text(at_y, Align2::RIGHT_TOP, name_y, font, strong);
    let stroke = Stroke::new(1.5, strong);
    painter.arrow(x.right_center() + vec2(2.0, 0.0), vec2(11.0, 0.0), stroke);
    painter.arrow(y.right_bottom() + vec2(4.0, -1.0), vec2(0.0, -11.0), stroke);
    if cell.min_elem() >= 8.0 {
        let stroke = Stroke::new(0.5, Color32::from_black_alpha(140));
        let inside = painter.with_clip_rect(painter.clip_rect().intersect(picture));
        let lines = place.rect.intersect(picture);
        for column in columns[0]..=columns[1] + 1 {
            inside.vline(place.rect.left() + column as f32 * cell.x, lines.y_range(), stroke);
        }
        for row in rows[0]..=rows[1] + 1 {
            inside.hline(lines.x_range(), place.rect.top() + row as f32 * cell.y, stroke);
        }
    }
}

/// The part of the panel that is left for the layer beside its axes.
pub(super) fn beside_axes(room: Rect) -> Rect {
    Rect::from_min_max(room.min + vec2(34.0, 2.0), room.max - vec2(4.0, 18.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_only_where_they_can_be_read() {
        assert_eq!(text_size(vec2(14.0, 40.0), 99), None, "two digits need more");
        assert_eq!(text_size(vec2(40.0, 14.0), 9), None, "not high enough");
        assert!(text_size(vec2(20.0, 16.0), 99).is_some_and(|size| size >= SMALLEST));
        assert_eq!(text_size(vec2(500.0, 500.0), 9), Some(16.0));
    }

    #[test]
    fn digits_have_contrast_to_their_cell() {
        let luminance = |c: Color32| {
            let [r, g, b] = [c.r(), c.g(), c.b()].map(|part| {
                let part = f32::from(part) / 255.0;
                if part <= 0.04045 { part / 12.92 } else { ((part + 0.055) / 1.055).powf(2.4) }
            });
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        for length in 0..=100 {
            let background = color(length, 100);
            let (a, b) = (luminance(background), luminance(ink_on(background, length)));
            let contrast = (a.max(b) + 0.05) / (a.min(b) + 0.05);
            assert!(contrast >= 4.5, "length {length}: {contrast}");
        }
    }
}
