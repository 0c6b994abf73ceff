//! Legend entries.

use egui::{Color32, FontSelection, Sense, TextStyle, Ui, vec2};

const SIDE: f32 = 10.0;

/// A colour patch and its name, kept together when the row wraps.
pub(super) fn entry(ui: &mut Ui, color: Color32, name: &str, about: &str) {
    let font = FontSelection::Style(TextStyle::Small).resolve(ui.style());
    let text = ui.painter().layout_no_wrap(name.to_owned(), font, color).size().x;
    let room = ui.available_size_before_wrap().x;
    if room < SIDE + 2.0 * ui.spacing().item_spacing.x + text {
        ui.end_row();
    }
    let (rect, _) = ui.allocate_exact_size(vec2(SIDE, SIDE), Sense::hover());
    ui.painter().rect_filled(rect, 2.0, color);
    ui.small(name).on_hover_text(about);
}
