//! Lines above the panels: what a new user can do next, until it is known, and that the scene changed on disk.

use super::Inspector;
use crate::command::Command;
use crate::saved::FirstSteps;

/// A lower window has no room for the line, in points.
const LEAST_HEIGHT: f32 = 250.0;

/// The next thing to try, after what was done, and whether the run is at its end.
fn next(done: FirstSteps, is_at_end: bool) -> &'static str {
    match (done.has_clicked, done.has_followed, is_at_end) {
        (false, _, true) => "Click any pixel to see its ray's walk through the voxels, or press Start, then Next pass.",
        (false, ..) => {
            "Click any pixel: Unfolded walk shows its ray's path through the voxels, Ray explains each step."
        }
        (true, false, true) => {
            "Now go back along this ray: Shift+F11 to its previous cell or triangle, F11 to the next. Home goes to the \
             start."
        }
        (true, false, false) => {
            "Now follow this ray: F11 goes to its next cell or triangle, Shift+F11 to the previous one."
        }
        (true, true, _) => {
            "F10 runs the next pass for all rays, Shift+F10 goes back. Dragging in the Timeline goes to any pass."
        }
    }
}

/// A line above the panels.
fn line(ui: &mut egui::Ui, name: &'static str, contents: impl FnOnce(&mut egui::Ui)) {
    let frame = egui::Frame::side_top_panel(ui.style()).fill(ui.visuals().selection.bg_fill.gamma_multiply(0.25));
    egui::Panel::top(name).frame(frame).show(ui, |ui| ui.horizontal_wrapped(contents));
}

impl Inspector {
    /// Says that the scene's file was written since it was opened, and offers to read it again.
    pub(super) fn offer_reload(&mut self, ui: &mut egui::Ui) {
        if !self.scene.has_changed {
            return;
        }
        line(ui, "reload", |ui| {
            ui.label(format!("{} has changed on disk.", self.scene.path.as_deref().unwrap_or("The scene")));
            if ui.button("Reload").on_hover_text("reads it again, and returns to this ray and pass").clicked() {
                self.perform(Command::ReloadScene);
            }
            self.scene.has_changed &= !ui.button("Not now").clicked();
        });
    }

    /// Shows the line while a scene with rays is open.
    pub(super) fn first_steps(&mut self, ui: &mut egui::Ui) {
        let has_room = ui.ctx().content_rect().height() >= LEAST_HEIGHT;
        // A lesson says itself what to do.
        if self.lesson.is_some()
            || !self.saved.first_steps.is_needed()
            || self.model.opened.is_none()
            || !self.model.has_rays()
            || !has_room
        {
            return;
        }
        let text = next(self.saved.first_steps, self.model.next.is_none());
        line(ui, "first steps", |ui| {
            ui.label(text);
            let button = ui.button("Dismiss").on_hover_text("do not show this again");
            self.saved.first_steps.is_dismissed |= button.clicked();
        });
    }
}

/// Notes what a command does.
pub(super) fn note(done: &mut FirstSteps, command: Command) {
    done.has_stepped |= matches!(command, Command::NextPass | Command::PreviousPass);
    done.has_followed |= matches!(command, Command::NextEvent | Command::PreviousEvent);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hint_for_beginners_depends_on_what_they_have_done() {
        let mut done = FirstSteps::default();
        assert!(next(done, true).starts_with("Click any pixel to see"));
        done.has_clicked = true;
        assert!(next(done, true).contains("Shift+F11") && next(done, false).contains("F11 goes to its next"));
        done.has_followed = true;
        assert!(next(done, true).starts_with("F10"));
    }
}
