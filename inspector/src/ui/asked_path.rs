//! Asks for a path inside the window, for systems without a file dialog.

use egui::{Key, TextEdit, Ui};

use super::Inspector;
use super::dialogs::Dialog;
use super::host::FileToSave;

/// Shown when the user cancels an export.
pub(super) const NOT_WRITTEN: &str = "cancelled: nothing written";
/// Shown when the user cancels opening a scene.
const NOT_OPENED: &str = "cancelled: no scene opened";

/// A path that the user is being asked for.
pub(super) struct AskedPath {
    /// The file to write; `None` to open a scene.
    file: Option<FileToSave>,
    path: String,
    why: String,
    replaces: bool,
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
}

impl Inspector {
    /// Opens the dialog for the next requested path, once no other dialog is open.
    pub(super) fn ask_path(&mut self) {
        if self.dialog.is_none() {
            self.dialog = self.asked.pop_front().map(Dialog::Path);
        }
    }

    /// The path was entered.
    pub(super) fn go_on_with(&mut self, asked: &mut AskedPath) {
        let path = asked.path.trim();
        match asked.file.take() {
            Some(file) => self.host.save_as(file, path, asked.replaces),
            None => self.open_file(path),
        }
    }

    /// The dialog was closed.
    pub(super) fn give_up(&mut self, asked: &AskedPath) {
        self.note(if asked.file.is_some() { NOT_WRITTEN } else { NOT_OPENED });
    }
}
