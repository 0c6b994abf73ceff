//! Watches, edits by hand, and passes that run on the CPU reference.
//!
//! Touches: selection, asks, watches.

use egui::DragValue;
use raystep_lab::text::counted;

use super::table::{Head, Listed, ListedCell, Table, View, version};
use crate::command::Command;
use crate::session::request::Request;
use crate::session::{Direction, Edit, Watch};
use crate::ui::pane::{Context, Panel};
use crate::ui::style::strong;

/// Watches and edits.
#[derive(Default)]
pub(in crate::ui) struct Watches {
    /// The number of passes for the CPU reference, as edited.
    until: usize,
    edits: Table,
}

impl Panel for Watches {
    fn show(&mut self, ui: &mut egui::Ui, cx: &mut Context<'_>) {
        egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            strong(ui, "Stop when");
            let has_rays = cx.has_rays();
            // Elements without states have values that change, and nothing else that can be watched.
            let is_shown = |watch: &Watch| has_rays || *watch == Watch::RayState;
            for (watch, is_on) in cx.watches.list.iter_mut().filter(|(watch, _)| is_shown(watch)) {
                ui.horizontal(|ui| {
                    let name = match *watch {
                        Watch::MoreSteps(_) => "any ray: more steps than".into(),
                        _ if !has_rays => "selected element: its values change".into(),
                        other => other.name(),
                    };
                    let label = ui.checkbox(is_on, name);
                    if let Watch::MoreSteps(steps) = watch {
                        ui.add(DragValue::new(steps).range(1..=100_000)).labelled_by(label.id);
                    }
                });
            }
            ui.horizontal_wrapped(|ui| {
                for command in [Command::RunBackToWatch, Command::RunToWatch] {
                    let key = command.key_text(ui.ctx());
                    if ui
                        .add_enabled(!cx.model.is_busy(), egui::Button::new(command.name()))
                        .on_hover_text(key)
                        .clicked()
                    {
                        cx.asks.commands.push(command);
                    }
                }
            });
            if let Some(text) = &cx.watches.fired {
                strong(ui, text);
            }
            ui.separator();
            strong(ui, "Edits");
            if cx.model.edits.is_empty() {
                ui.weak("None. You can edit a texel of the selected ray or element; the run continues from there.");
            }
            self.edits(ui, cx);
            ui.horizontal_wrapped(|ui| {
                let can = cx.model.opened.is_some();
                if ui.add_enabled(can, egui::Button::new(Command::EditTexel.name())).clicked() {
                    cx.asks.commands.push(Command::EditTexel);
                }
                if ui.add_enabled(!cx.model.edits.is_empty(), egui::Button::new("Undo all")).clicked() {
                    again(cx, Request::ClearEdits);
                }
            });
            ui.separator();
            strong(ui, "CPU reference first")
                .on_hover_text("To find a faulty kernel, increase this number until the image is right: the kernel of the last replaced pass is at fault.");
            ui.horizontal_wrapped(|ui| {
                let label = ui.label("passes run on the CPU reference, the rest on the device");
                ui.add(DragValue::new(&mut self.until).range(0..=cx.model.passes.len().max(1))).labelled_by(label.id);
                if ui.add_enabled(self.until > 0, egui::Button::new("Use the CPU reference")).clicked() {
                    again(cx, Request::TwinsUntil(Some(self.until)));
                }
                if let Some(passes) = cx.model.twins {
                    strong(ui, format!("{} on the CPU reference now", counted(passes, "pass")));
                }
                if ui.button("Device only").clicked() {
                    again(cx, Request::TwinsUntil(None));
                }
            });
        });
    }
}

const EDITS: [Head<'_>; 5] = [
    Head::number("passes", "passes before the edit"),
    Head::text("pixel", "column and row"),
    Head::text("component", "stream and layer"),
    Head::number("value", "the new value"),
    Head::text("bits", "its bits"),
];

impl Watches {
    /// The edits by hand; a click goes to one and selects its ray.
    fn edits(&mut self, ui: &mut egui::Ui, cx: &mut Context<'_>) {
        let edits = &cx.model.edits;
        if edits.is_empty() {
            return;
        }
        let row = |edit: &Edit| {
            let (name, layer) = (edit.stream.name(), edit.stream.info().layers[edit.layer]);
            let float = edit.stream.is_float_layer(edit.layer).then(|| f32::from_bits(edit.bits));
            let value = float.map_or_else(|| edit.bits.to_string(), |value| value.to_string());
            vec![
                ListedCell::number(edit.place as f64, edit.place.to_string()),
                ListedCell::text(format!("{},{}", edit.x, edit.y)),
                ListedCell::text(format!("{name}.{layer}")),
                ListedCell::number(float.map_or(f64::from(edit.bits), f64::from), value),
                ListedCell::text(format!("0x{:08x}", edit.bits)),
            ]
        };
        let rows = Listed { rows: edits.iter().map(row).collect() };
        let view =
            View { name: "edits", heads: &EDITS, rows: &rows, version: version(cx.model.edition), current: None };
        ui.horizontal_wrapped(|ui| self.edits.tools(ui, &view));
        let chosen = self.edits.show_all(ui, &view).and_then(|row| edits.get(row));
        if let Some((place, pixel)) = chosen.map(|edit| (edit.place, [edit.x, edit.y])) {
            (cx.asks.go_to, cx.asks.select) = (Some(place), Some(pixel));
        }
    }
}

/// Requests a change to the run, and follows the ray again.
fn again(cx: &mut Context<'_>, request: Request) {
    cx.model.ask(request);
    if let Some(subject) = cx.selection.subject(cx.model) {
        cx.model.ask(Request::Follow(subject));
    }
}

/// The active watches.
pub(in crate::ui) fn wanted(cx: &[(Watch, bool)]) -> Vec<Watch> {
    cx.iter().filter(|(_, is_on)| *is_on).map(|(watch, _)| *watch).collect()
}

/// A request to run to them.
pub(in crate::ui) fn run(watches: &[(Watch, bool)], direction: Direction) -> Option<Request> {
    let watches = wanted(watches);
    (!watches.is_empty()).then_some(Request::RunToWatch { watches, direction })
}
