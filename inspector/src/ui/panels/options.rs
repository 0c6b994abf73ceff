//! The options of the run. A change prepares a new run and keeps the view.
//!
//! Touches: asks, log.

use egui::{ComboBox, DragValue, Ui};
use raystep_kernels::GridSize;
use raystep_kernels::options::mapping;
use raystep_kernels::options::rows::{ROWS, Row, Values};

use crate::command::Command;
use crate::ray_text::GivenRay;
use crate::session::request::Request;
use crate::settings::{DeviceKind, Settings, View};
use crate::ui::choice::Choices as _;
use crate::ui::pane::{Context, Panel};

/// Most pixels per side that the panel offers.
const MOST_PIXELS: u32 = 16_384;

/// The options.
#[derive(Default)]
pub(in crate::ui) struct Options {
    /// The edited settings, and the run that they were taken from.
    draft: Option<(u64, Settings)>,
    /// The last request: it is sent once, even if it is refused.
    asked: Option<Settings>,
}

impl Panel for Options {
    fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        let Some(opened) = cx.model.opened.clone() else {
            ui.weak("Open a scene first.");
            return;
        };
        let generation = cx.model.generation;
        if self.draft.as_ref().is_none_or(|(known, _)| *known != generation) {
            if let Some(asked) = self.asked.take().filter(|asked| asked.is_drawn_otherwise(&opened.settings)) {
                cx.log.warn(format!("{}: {}", asked.order(), mapping::ONLY_DRAWS));
            }
            self.draft = Some((generation, opened.settings.clone()));
        }
        let Self { draft: Some((_, draft)), asked } = self else { return };
        egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            egui::Grid::new("options").num_columns(2).spacing([12.0, 6.0]).show(ui, |ui| {
                for (row, name, about) in offered(draft, false) {
                    option(ui, draft, row, name, about);
                }
                device(ui, draft);
                size(ui, draft);
                camera(ui, draft, opened.scene.cameras.len());
            });
            ui.checkbox(&mut draft.counters, "count cells and tests").on_hover_text(
                "adds a stream of counters per \
                ray",
            );
            for (row, name, about) in offered(draft, true) {
                option(ui, draft, row, name, about);
            }
            if let Some(GivenRay([ox, oy, oz, dx, dy, dz])) = draft.ray {
                ui.label(format!("one ray: {ox} {oy} {oz} towards {dx} {dy} {dz}"));
                if ui.button("Back to the image").clicked() {
                    draft.ray = None;
                }
            } else if ui.button("Enter a ray…").clicked() {
                cx.asks.commands.push(Command::TypeRay);
            }
            if ui.button("Defaults").on_hover_text("default options, except size, view and device").clicked() {
                let Settings { size, view, device, .. } = draft.clone();
                *draft = Settings { size, view, device, ..Settings::default() };
            }
        });
        // One at a time: during a drag, the last value counts.
        let is_dragged = ui.input(|input| input.pointer.any_down());
        if *draft == opened.settings {
            *asked = None;
        } else if is_dragged {
            cx.model.ask_glimpse(draft.clone());
        } else if asked.as_ref() != Some(&*draft) && !cx.model.is_busy() && !ui.ctx().egui_wants_keyboard_input() {
            *asked = Some(draft.clone());
            cx.model.ask(Request::Plan(Box::new(draft.clone())));
        }
    }
}

/// The control of an option, by the kind of its values.
fn option(ui: &mut Ui, draft: &mut Settings, row: &Row, name: &str, about: &str) {
    let mut value = row.get(&draft.choices).to_string();
    let before = value.clone();
    let label = |ui: &mut Ui| ui.label(name).on_hover_text(about).id;
    match row.values {
        Values::Switch => {
            let mut is_on = value == "true";
            ui.checkbox(&mut is_on, name).on_hover_text(about);
            value = is_on.to_string();
        }
        Values::Names(_) => {
            let label = label(ui);
            let combo = ComboBox::from_id_salt(name).selected_text(value.clone());
            let response = combo.show_ui(ui, |ui| {
                for name in draft.offered(row) {
                    ui.choice_of(&mut value, name.into(), name);
                }
            });
            response.response.labelled_by(label);
        }
        Values::Whole(least, most) => {
            let label = label(ui);
            let mut number = value.parse().unwrap_or(least);
            ui.add(DragValue::new(&mut number).range(least..=most)).labelled_by(label);
            value = number.to_string();
        }
        Values::Cells => {
            let label = label(ui);
            value = cells(ui, draft.choices.grid, label).to_string();
        }
    }
    ui.end_row();
    if value != before {
        // What a control offers can be chosen.
        _ = draft.choose(row, &value);
    }
}

/// The options that the panel offers and that come into question.
fn offered(draft: &Settings, are_switches: bool) -> Vec<(&'static Row, &'static str, &'static str)> {
    let is_shown = |row: &&Row| matches!(row.values, Values::Switch) == are_switches && (row.applies)(&draft.choices);
    ROWS.iter().filter(is_shown).filter_map(|row| row.panel.map(|(name, about)| (row, name, about))).collect()
}

fn device(ui: &mut Ui, draft: &mut Settings) {
    let label = ui.label("device").on_hover_text("where passes run; CPU: the same kernels in Rust, as a reference");
    let combo = ComboBox::from_id_salt("device").selected_text(draft.device.name());
    let response = combo.show_ui(ui, |ui| {
        for kind in DeviceKind::ALL {
            ui.choice_of(&mut draft.device, kind, kind.name());
        }
    });
    response.response.labelled_by(label.id);
    ui.end_row();
}

fn cells(ui: &mut Ui, mut size: GridSize, label: egui::Id) -> GridSize {
    ui.horizontal(|ui| {
        let mut is_auto = size == GridSize::Auto;
        if ui.checkbox(&mut is_auto, "auto").changed() {
            size = if is_auto { GridSize::Auto } else { GridSize::Cells([16; 3]) };
        }
        if let GridSize::Cells(cells) = &mut size {
            for count in cells {
                ui.add(DragValue::new(count).range(1..=1024).speed(0.2)).labelled_by(label);
            }
        }
    });
    size
}

fn size(ui: &mut Ui, draft: &mut Settings) {
    let label = ui.label("size").on_hover_text("width and height in pixels");
    ui.horizontal(|ui| {
        for side in &mut draft.size {
            ui.add(DragValue::new(side).range(1..=MOST_PIXELS)).labelled_by(label.id);
        }
    });
    ui.end_row();
}

fn camera(ui: &mut Ui, draft: &mut Settings, cameras: usize) {
    let label = ui.label("camera").on_hover_text("a camera of the scene, or a custom one from the 3D view");
    let text = match draft.view {
        View::Scene(_) if cameras == 0 => "frames the scene".into(),
        View::Scene(index) => format!("scene camera {index}"),
        View::Free { .. } => "custom".into(),
    };
    let response = ComboBox::from_id_salt("camera").selected_text(text).show_ui(ui, |ui| {
        for index in 0..cameras.max(1) {
            let text = if cameras == 0 { "frames the scene".into() } else { format!("the scene's {index}") };
            ui.choice_of(&mut draft.view, View::Scene(index), text);
        }
    });
    response.response.labelled_by(label.id);
    ui.end_row();
    if let View::Free { eye, look_at, fov_deg, .. } = &mut draft.view {
        for (name, point) in [("eye", eye), ("look at", look_at)] {
            let label = ui.label(name);
            ui.horizontal(|ui| {
                for c in point {
                    let speed = c.abs().max(0.01) / 100.0;
                    ui.add(DragValue::new(c).speed(speed).max_decimals(4)).labelled_by(label.id);
                }
            });
            ui.end_row();
        }
        if let Some(fov) = fov_deg {
            let label = ui.label("angle of view").on_hover_text("vertical, degrees");
            ui.add(DragValue::new(fov).range(0.1..=179.0).speed(0.2).suffix("°")).labelled_by(label.id);
            ui.end_row();
        }
    }
}
