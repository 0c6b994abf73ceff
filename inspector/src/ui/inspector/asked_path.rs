//! Asks for a path inside the window, for systems without a file dialog.

use egui::{Key, TextEdit, Ui};

use crate::ui::host::FileToSave;

/// Shown when the user cancels an export.
pub(super) const NOT_WRITTEN: &str = "cancelled: nothing written";
/// Shown when the user cancels opening a scene.
const NOT_OPENED: &str = "cancelled: no scene opened";

/// A path that the user is being asked for.
pub(super) struct AskedPath {
    /// The file to write; `None` to open a scene.
    pub(super) file: Option<FileToSave>,
    pub(super) path: String,
    why: String,
    pub(super) replaces: bool,
}

impl AskedPath {
    pub(super) fn new(file: Option<FileToSave>, path: String, why: String) -> Self {
        Self { file, path, why, replaces: false }
    }

    /// Whether the path was entered.
    pub(super) fn show(&mut self, ui: &mut Ui) -> bool {
        ui.set_width(520.0);
        let (heading, button) = match &self.file {
            Some(file) => (format!("Save {}", file.holds), "Save"),
            None => ("Open a scene".into(), "Open"),
        };
        ui.heading(heading);
        ui.label(&self.why);
        let label = ui.label("Path").id;
        let field = ui.add(TextEdit::singleline(&mut self.path).desired_width(f32::INFINITY)).labelled_by(label);
        if self.file.is_some() {
            ui.checkbox(&mut self.replaces, "replace an existing file");
        }
        if ui.memory(|memory| memory.focused().is_none()) {
            field.request_focus();
        }
        let is_entered = ui.input(|input| input.key_pressed(Key::Enter));
        ui.button(button).clicked() || is_entered
    }

    /// What is said if it is closed.
    pub(super) fn given_up(&self) -> &'static str {
        if self.file.is_some() { NOT_WRITTEN } else { NOT_OPENED }
    }
}
