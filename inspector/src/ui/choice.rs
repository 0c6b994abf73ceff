//! Choices, of which those that are not chosen have an outline: beside buttons with frames, bare text reads as a caption.

use egui::{Button, Color32, IntoAtoms, Response, Stroke, StrokeKind, Ui, Widget};

use super::style::towards;

/// One of several choices, or a switch, of which it is known whether it is on.
#[must_use = "You should put this widget in a ui with `ui.add(widget);`"]
pub(in crate::ui) struct Choice<'a> {
    is_chosen: bool,
    button: Button<'a>,
}

impl<'a> Choice<'a> {
    pub(in crate::ui) fn new(is_chosen: bool, text: impl IntoAtoms<'a>) -> Self {
        Self { is_chosen, button: Button::selectable(is_chosen, text) }
    }

    /// No higher than text.
    pub(in crate::ui) fn small(self) -> Self {
        Self { button: self.button.small(), ..self }
    }

    /// Moves to the next line instead of being cut off.
    pub(in crate::ui) fn extend(self) -> Self {
        Self { button: self.button.wrap_mode(egui::TextWrapMode::Extend), ..self }
    }
}

impl Widget for Choice<'_> {
    fn ui(self, ui: &mut Ui) -> Response {
        let response = ui.add(self.button);
        let look = &ui.visuals().widgets.inactive;
        // In menus and lists nothing has a frame. Under the cursor, egui paints one.
        let is_plain = !self.is_chosen && look.weak_bg_fill != Color32::TRANSPARENT;
        if is_plain && !response.hovered() && !response.has_focus() && ui.is_rect_visible(response.rect) {
            ui.painter().rect_stroke(response.rect, look.corner_radius, outline(ui), StrokeKind::Inside);
        }
        response
    }
}

/// Quieter than the frame of a button, yet clearly there in both themes.
fn outline(ui: &Ui) -> Stroke {
    let visuals = ui.visuals();
    Stroke::new(1.0, towards(visuals.panel_fill, visuals.weak_text_color(), 0.4))
}

/// Choices as egui's selectable labels.
pub(in crate::ui) trait Choices {
    /// One of several choices.
    fn choice<'a>(&mut self, is_chosen: bool, text: impl IntoAtoms<'a>) -> Response;

    /// One of several values; sets `now` when it is clicked.
    fn choice_of<'a, T: PartialEq>(&mut self, now: &mut T, value: T, text: impl IntoAtoms<'a>) -> Response;
}

impl Choices for Ui {
    fn choice<'a>(&mut self, is_chosen: bool, text: impl IntoAtoms<'a>) -> Response {
        self.add(Choice::new(is_chosen, text))
    }

    fn choice_of<'a, T: PartialEq>(&mut self, now: &mut T, value: T, text: impl IntoAtoms<'a>) -> Response {
        let mut response = self.choice(*now == value, text);
        if response.clicked() && *now != value {
            *now = value;
            response.mark_changed();
        }
        response
    }
}
