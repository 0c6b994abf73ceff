//! Dialogs.

use std::collections::VecDeque;

use egui::{ComboBox, Id, Key, Modal};
use raystep_kernels::Stream;
use raystep_lab::text::counted;

use super::Inspector;
use super::asked_path::AskedPath;
use super::palette::Palette;
use crate::command::{COMMANDS, Command, Menu};
use crate::ui::choice::Choices as _;
use crate::ui::style::strong;

/// A dialog.
pub(super) enum Dialog {
    /// The command palette.
    Palette(Palette),
    /// Keyboard shortcuts.
    Help,
    /// The text of a pixel.
    Pixel(String),
    /// The text of a ray.
    Ray(String),
    /// The text of a link.
    Link(String),
    /// An edit of the selected ray: stream, layer, and the text of the value.
    Edit(Stream, usize, String),
    /// Exports, and whether to include passes and rows only up to the current place.
    Export(bool),
    /// The name of a layout to save.
    Layout(String),
    /// A path, if there is no file dialog.
    Path(AskedPath),
}

/// The dialog that is open, why it refused what was entered last, and paths that the user still has to enter.
#[derive(Default)]
pub(super) struct Dialogs {
    pub(super) open: Option<Dialog>,
    refused: Option<String>,
    pub(super) asked: VecDeque<AskedPath>,
}

/// A dialog that is there at once: faded in, its text would be hard to read for a fifth of a second.
fn dialog_at(id: Id) -> Modal {
    Modal::new(id).area(Modal::default_area(id).fade_in(false))
}

impl Inspector {
    pub(super) fn show_dialog(&mut self, ctx: &egui::Context) {
        let asked = || self.dialogs.asked.pop_front().map(Dialog::Path);
        let Some(mut dialog) = self.dialogs.open.take().or_else(asked) else { return };
        let mut stays = true;
        let response = dialog_at(Id::unique(("dialog", std::mem::discriminant(&dialog)))).show(ctx, |ui| {
            match &mut dialog {
                Dialog::Palette(palette) => {
                    if let Some(command) = palette.show(ui, &|command| self.why_not(command)) {
                        self.perform(command);
                        stays = false;
                    }
                }
                Dialog::Help => help(ui),
                Dialog::Pixel(text) => {
                    if let Some(text) = ask(ui, "Pixel, as column,row", text) {
                        stays = self.is_refused(|own| own.go_to_pixel(&text));
                    }
                }
                Dialog::Ray(text) => {
                    ui.set_width(460.0);
                    ui.label("Origin and direction in scene units, decimal or bits such as 0x3f800000.");
                    if let Some(text) = ask(ui, "Ray, as ox,oy,oz,dx,dy,dz", text) {
                        stays = self.is_refused(|own| own.trace_ray(&text));
                    }
                }
                Dialog::Link(text) => {
                    ui.set_width(560.0);
                    if let Some(text) = ask(ui, "Link, as created by 'Copy link to this view'", text) {
                        stays = self.is_refused(|own| own.visit(&text));
                    }
                }
                Dialog::Edit(stream, layer, text) => {
                    ui.set_width(420.0);
                    self.choose_component(ui, stream, layer);
                    if let Some(text) = ask(ui, "Value, decimal or bits such as 0x3f800000", text) {
                        stays = self.is_refused(|own| own.edit_texel(*stream, *layer, &text));
                    }
                }
                Dialog::Export(is_up_to_here) => {
                    if let Some(command) = self.choose_export(ui, is_up_to_here) {
                        self.state.asks.is_up_to_here = *is_up_to_here;
                        self.perform(command);
                        stays = false;
                    }
                }
                Dialog::Layout(name) => stays = self.name_layout(ui, name),
                Dialog::Path(asked) => {
                    if asked.show(ui) {
                        match asked.file.take() {
                            Some(file) => self.host.save_as(file, asked.path.trim(), asked.replaces),
                            None => self.open_file(asked.path.trim()),
                        }
                        stays = false;
                    }
                }
            }
            if let Some(why) = &self.dialogs.refused {
                ui.colored_label(ui.visuals().error_fg_color, why);
            }
        });
        // Asking takes the key Escape away: once.
        let closes = response.should_close();
        if !stays || closes {
            self.dialogs.refused = None;
        }
        match dialog {
            Dialog::Path(asked) if stays && closes => self.note(asked.given_up()),
            dialog if stays && !closes => self.dialogs.open = Some(dialog),
            _ => {}
        }
    }
}

impl Inspector {
    fn choose_component(&self, ui: &mut egui::Ui, stream: &mut Stream, layer: &mut usize) {
        let Some(opened) = &self.model.opened else { return };
        ui.horizontal_wrapped(|ui| {
            let label = ui.label("stream").id;
            let shown = ComboBox::from_id_salt("edited stream").selected_text(stream.name());
            let response = shown.show_ui(ui, |ui| {
                for choice in &opened.plan.streams {
                    ui.choice_of(stream, choice.what, choice.what.name());
                }
            });
            response.response.labelled_by(label);
            *layer = (*layer).min(stream.layers() - 1);
            for (i, name) in stream.info().layers.iter().enumerate() {
                ui.choice_of(layer, i, *name);
            }
        });
        if let Some([x, y]) = self.state.selection.pixel {
            ui.weak(format!("of the ray of pixel {x},{y}, after {}", counted(self.model.place, "pass")));
        }
    }
}

impl Inspector {
    /// Whether what was entered has to be corrected first; the dialog then says why.
    fn is_refused(&mut self, perform: impl FnOnce(&mut Self) -> Result<(), String>) -> bool {
        self.dialogs.refused = perform(self).err();
        if let Some(why) = &self.dialogs.refused {
            self.state.log.say(true, why.clone());
        }
        self.dialogs.refused.is_some()
    }

    /// Saves the layout under a name, and deletes saved ones; returns whether the dialog stays.
    fn name_layout(&mut self, ui: &mut egui::Ui, name: &mut String) -> bool {
        ui.set_width(420.0);
        if let Some(entered) = ask(ui, "Name of this arrangement of panels", name) {
            return self.is_refused(|own| {
                own.desk.save_layout(&entered)?;
                own.state.log.tell(format!("layout saved as {}", entered.trim()));
                Ok(())
            });
        }
        let own = self.desk.arranged.own.iter().enumerate();
        let own: Vec<(usize, String)> = own.map(|(index, own)| (index, own.name.clone())).collect();
        for (index, name) in own {
            ui.horizontal_wrapped(|ui| {
                ui.monospace(Command::ArrangeOwn(index).key_text(ui.ctx()));
                ui.label(&name);
                let delete = ui.button("Delete");
                let label = format!("delete the layout {name}");
                delete.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &label));
                if delete.clicked() {
                    self.desk.delete_layout(index);
                }
            });
        }
        true
    }
}

/// A line of text; returns it once it is entered.
fn ask(ui: &mut egui::Ui, label: &'static str, text: &mut String) -> Option<String> {
    let name = ui.label(label).id;
    let field = ui.add(egui::TextEdit::singleline(text).desired_width(f32::INFINITY)).labelled_by(name);
    let enter = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
    if ui.memory(|memory| memory.focused().is_none()) {
        field.request_focus();
    }
    (ui.button("Go").clicked() || enter).then(|| text.clone())
}

fn help(ui: &mut egui::Ui) {
    ui.heading("Keyboard shortcuts");
    egui::ScrollArea::vertical().max_height(420.0).auto_shrink(false).show(ui, |ui| {
        for menu in Menu::ALL {
            strong(ui, menu.name());
            egui::Grid::new(menu.name()).num_columns(2).striped(true).show(ui, |ui| {
                for info in COMMANDS.iter().filter(|info| info.menu == menu && !info.keys.is_empty()) {
                    let mut keys: Vec<String> = info.command.key_texts(ui.ctx()).collect();
                    keys.dedup();
                    ui.monospace(keys.join(" or "));
                    ui.label(info.name);
                    ui.end_row();
                }
            });
            ui.add_space(6.0);
        }
        strong(ui, "In pictures");
        ui.label("Click: select a ray. Drag: pan. Wheel: zoom. Double click: fit.");
    });
}
