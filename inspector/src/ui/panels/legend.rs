//! Legend entries.

use egui::{Color32, FontSelection, Painter, Rect, Sense, TextStyle, Ui, vec2};

const SIDE: f32 = 10.0;

/// A colour patch and its name, kept together when the row wraps.
pub(super) fn entry(ui: &mut Ui, color: Color32, name: &str, about: &str) {
    painted(ui, name, about, |painter, rect| {
        painter.rect_filled(rect, 2.0, color);
    });
}

/// A painted sign and its name.
pub(super) fn painted(ui: &mut Ui, name: &str, about: &str, paint: impl FnOnce(&Painter, Rect)) {
    let font = FontSelection::Style(TextStyle::Small).resolve(ui.style());
    let text = ui.painter().layout_no_wrap(name.to_owned(), font, Color32::WHITE).size().x;
    let room = ui.available_size_before_wrap().x;
    if room < SIDE + 2.0 * ui.spacing().item_spacing.x + text {
        ui.end_row();
    }
    // As high as the name: in a row that begins with it, it would stand higher than the others.
    let height = ui.text_style_height(&TextStyle::Small).max(SIDE);
    let (rect, _) = ui.allocate_exact_size(vec2(SIDE, height), Sense::hover());
    paint(ui.painter(), Rect::from_center_size(rect.center(), vec2(SIDE, SIDE)));
    let name = ui.small(name);
    if !about.is_empty() {
        name.on_hover_text(about);
    }
}
