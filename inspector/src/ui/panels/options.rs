//! The options of the run. A change prepares a new run and keeps the view.
//!
//! Touches: asks.

use std::fmt::Display;

use egui::{ComboBox, DragValue, Ui};
use raystep_kernels::options::mapping::{Cull, Mapping, MappingName, Targets, Until, Update};
use raystep_kernels::{Accelerator, GridSize, Numerics, ScheduleKind, Skip, Traversal};

use crate::command::Command;
use crate::ray_text::GivenRay;
use crate::session::request::Request;
use crate::settings::{DeviceKind, Settings, View};
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
            (self.draft, self.asked) = (Some((generation, opened.settings.clone())), None);
        }
        let Self { draft: Some((_, draft)), asked } = self else { return };
        egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            egui::Grid::new("options").num_columns(2).spacing([12.0, 6.0]).show(ui, |ui| {
                tracing(ui, draft);
                size(ui, draft);
                camera(ui, draft, opened.scene.cameras.len());
            });
            ui.checkbox(&mut draft.counters, "count cells and tests").on_hover_text(
                "adds a stream of counters per \
                ray",
            );
            ui.checkbox(&mut draft.keep_all, "keep what is not needed")
                .on_hover_text("also run kernels and keep streams that the result does not need, as --keep-all does");
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

fn choice<T: Copy + PartialEq + Display>(ui: &mut Ui, name: &str, about: &str, all: &[T], value: &mut T) {
    let label = ui.label(name).on_hover_text(about);
    let combo = ComboBox::from_id_salt(name).selected_text(value.to_string());
    let response = combo.show_ui(ui, |ui| {
        for &one in all {
            ui.selectable_value(value, one, one.to_string());
        }
    });
    response.response.labelled_by(label.id);
    ui.end_row();
}

fn tracing(ui: &mut Ui, draft: &mut Settings) {
    choice(ui, "accelerator", "acceleration structure", Accelerator::ALL, &mut draft.accelerator);
    let stepped = draft.schedules();
    choice(ui, "schedule", "the order in which kernels run", &stepped, &mut draft.schedule);
    mapping(ui, draft);
    choice(ui, "numerics", "the rules for planes, steps and hits", Numerics::ALL, &mut draft.numerics);
    if draft.can_use_dda() {
        let about = "how rays walk through the grid: by the smallest tMax, or by control terms along a driving axis";
        choice(ui, "traversal", about, Traversal::ALL, &mut draft.traversal);
    }
    if draft.accelerator == Accelerator::Grid {
        choice(ui, "skip empty space", "whether rays skip over empty cells", Skip::ALL, &mut draft.skip);
        grid(ui, &mut draft.grid);
    }
    if draft.numerics == Numerics::Paper && draft.skip == Skip::On {
        // The paper's rules visit every cell.
        draft.skip = Skip::Off;
    }
    if draft.schedule == ScheduleKind::Compact {
        let label = ui.label("steps per pass").on_hover_text("1 shows one cell, node or triangle per pass");
        ui.add(DragValue::new(&mut draft.steps_per_pass).range(1..=4096)).labelled_by(label.id);
        ui.end_row();
    } else {
        draft.steps_per_pass = 1;
    }
    let label = ui.label("device").on_hover_text("where passes run; CPU: the same kernels in Rust, as a reference");
    let combo = ComboBox::from_id_salt("device").selected_text(draft.device.name());
    let response = combo.show_ui(ui, |ui| {
        for kind in DeviceKind::ALL {
            ui.selectable_value(&mut draft.device, kind, kind.name());
        }
    });
    response.response.labelled_by(label.id);
    ui.end_row();
}

/// How kernels are mapped to a GPU.
fn mapping(ui: &mut Ui, draft: &mut Settings) {
    let mut name = draft.mapping.name();
    let about =
        "how kernels run: as compute shaders, or as fragment programs that draw into streams, as on GPUs before 2006";
    choice(ui, "mapping", about, MappingName::ALL, &mut name);
    if name != draft.mapping.name() {
        draft.map_kernels(name);
    }
    let Mapping::Fragment(how) = &mut draft.mapping else { return };
    choice(ui, "targets", "streams that a draw writes", Targets::ALL, &mut how.targets);
    choice(ui, "update", "how a kernel reads a stream that it also writes", Update::ALL, &mut how.update);
    // What does not go together cannot be chosen.
    if how.update == Update::Swap {
        how.cull = Cull::None;
    }
    choice(ui, "cull", "how a kernel avoids rays in other states", Cull::ALL, &mut how.cull);
    if how.cull == Cull::None {
        how.until = Until::Count;
    } else {
        how.update = Update::Copy;
    }
    choice(ui, "until", "what ends the loops of the schedule", Until::ALL, &mut how.until);
    if how.cull == Cull::None {
        how.until = Until::Count;
    }
}

fn grid(ui: &mut Ui, size: &mut GridSize) {
    let label = ui.label("cells").on_hover_text("cells of the grid along x, y and z");
    ui.horizontal(|ui| {
        let mut is_auto = *size == GridSize::Auto;
        if ui.checkbox(&mut is_auto, "auto").changed() {
            *size = if is_auto { GridSize::Auto } else { GridSize::Cells([16; 3]) };
        }
        if let GridSize::Cells(cells) = size {
            for count in cells {
                ui.add(DragValue::new(count).range(1..=1024).speed(0.2)).labelled_by(label.id);
            }
        }
    });
    ui.end_row();
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
            ui.selectable_value(&mut draft.view, View::Scene(index), text);
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
