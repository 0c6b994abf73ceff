//! What a new user needs to know, in one line, until it is known.

use super::Inspector;
use super::command::Command;

const TEXT: &str = "Click a pixel to follow its ray. F10 runs the next pass, Shift+F10 goes back.";

/// A lower window has no room for the line, in points.
const LEAST_HEIGHT: f32 = 250.0;

impl Inspector {
    /// Shows the line while a scene with rays is open.
    pub(super) fn first_steps(&mut self, ui: &mut egui::Ui) {
        let has_room = ui.ctx().content_rect().height() >= LEAST_HEIGHT;
        if !self.saved.first_steps.is_needed() || self.model.opened.is_none() || !self.model.has_rays() || !has_room {
            return;
        }
        let frame = egui::Frame::side_top_panel(ui.style()).fill(ui.visuals().selection.bg_fill.gamma_multiply(0.25));
        egui::Panel::top("first steps").frame(frame).show(ui, |ui| {
            ui.horizontal_wrapped(|ui| {
                ui.label(TEXT);
                let button = ui.button("Dismiss").on_hover_text("do not show this again");
                self.saved.first_steps.is_dismissed |= button.clicked();
            });
        });
    }

    /// A panel has selected a pixel, or not.
    pub(super) fn note_click(&mut self, before: Option<[u32; 2]>) {
        self.saved.first_steps.has_clicked |= self.shared.select.is_some() && self.shared.select != before;
    }

    pub(super) fn note_step(&mut self, command: Command) {
        self.saved.first_steps.has_stepped |= matches!(command, Command::NextPass | Command::PreviousPass);
    }
}
