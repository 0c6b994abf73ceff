//! Menus, progress and the status bar.

use egui::containers::menu::MenuBar;
use egui::{Button, Color32};
use raystep_kernels::export::trace::Trace;
use raystep_kernels::plan::Bytes;
use raystep_lab::text::counted;

use super::Inspector;
use crate::command::{COMMANDS, Command, Layout, Menu};
use crate::ui::choice::Choices as _;
use crate::ui::units::{Scale, Units};

/// The window's background is behind it.
fn frame(ui: &egui::Ui) -> egui::Frame {
    egui::Frame::side_top_panel(ui.style()).fill(egui::Color32::TRANSPARENT)
}

impl Inspector {
    pub(super) fn menu_bar(&mut self, ui: &mut egui::Ui) {
        egui::Panel::top("menu").frame(frame(ui)).show(ui, |ui| {
            MenuBar::new().ui(ui, |ui| {
                for menu in Menu::ALL {
                    ui.menu_button(menu.name(), |ui| self.menu(ui, menu));
                }
                self.layouts(ui);
            });
            ui.horizontal_wrapped(|ui| {
                self.toolbar(ui);
                if let Some(work) = self.model.work.or(self.other.as_ref().and_then(|other| other.work)) {
                    ui.separator();
                    let part = if work.of == 0 { 0.0 } else { work.done as f32 / work.of as f32 };
                    let bar = egui::ProgressBar::new(part).desired_width(200.0).animate(work.of == 0);
                    ui.add(bar.text(work.what));
                    if ui.small_button("Cancel").clicked() {
                        self.perform(Command::Cancel);
                    }
                }
            });
        });
    }

    fn menu(&mut self, ui: &mut egui::Ui, menu: Menu) {
        ui.set_min_width(240.0);
        let height = ui.ctx().content_rect().bottom() - ui.cursor().top() - 16.0;
        egui::ScrollArea::vertical().max_height(height.max(60.0)).show(ui, |ui| self.items(ui, menu));
    }

    fn items(&mut self, ui: &mut egui::Ui, menu: Menu) {
        let mut group = None;
        for info in COMMANDS.iter().filter(|info| info.menu == menu) {
            let name = match info.command {
                Command::ArrangeOwn(index) => match self.desk.arranged.own.get(index) {
                    Some(own) => own.name.clone(),
                    None => continue,
                },
                _ => info.name.to_owned(),
            };
            if group.replace(info.group).is_some_and(|last| last != info.group) {
                ui.separator();
            }
            let button = Button::new(name).shortcut_text(info.command.key_text(ui.ctx()));
            let why_not = self.why_not(info.command);
            let item = ui.add_enabled(why_not.is_none(), button);
            if item.on_disabled_hover_text(why_not.unwrap_or_default()).clicked() {
                self.perform(info.command);
                ui.close();
            }
            if info.command == Command::OpenScene && !self.state.display.recent.is_empty() {
                ui.menu_button("Open recent", |ui| {
                    for path in &self.state.display.recent {
                        if ui.button(path).clicked() {
                            self.state.asks.open = Some(path.clone());
                            ui.close();
                        }
                    }
                });
            }
        }
    }

    /// The names of the layouts at the right of the menus, as far as there is room.
    fn layouts(&mut self, ui: &mut egui::Ui) {
        let tasks = Layout::ALL.into_iter().map(|layout| (Command::Arrange(layout), layout.name().to_owned()));
        let own = self.desk.arranged.own.iter().enumerate();
        let own = own.map(|(index, own)| (Command::ArrangeOwn(index), own.name.clone()));
        let all: Vec<(Command, String)> = tasks.chain(own).collect();
        let font = egui::TextStyle::Button.resolve(ui.style());
        let spacing = ui.spacing().item_spacing.x + 2.0 * ui.spacing().button_padding.x;
        let text = |name: &String| ui.painter().layout_no_wrap(name.clone(), font.clone(), Color32::PLACEHOLDER);
        let width: f32 = all.iter().map(|(_, name)| text(name).size().x + spacing).sum();
        if width + spacing > ui.available_width() {
            return;
        }
        ui.add_space(ui.available_width() - width);
        for (command, name) in all {
            let is_on = self.desk.arranged.of(command).as_ref() == Some(&self.desk.arranged.now);
            let about = format!("{} ({})", command.name(), command.key_text(ui.ctx()));
            let response = ui.choice(is_on, &name).on_hover_text(&about);
            response.widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, true, is_on, &about));
            if response.clicked() {
                self.perform(command);
            }
        }
    }

    pub(super) fn status_bar(&mut self, ui: &mut egui::Ui) {
        egui::Panel::bottom("status").frame(frame(ui)).show(ui, |ui| {
            ui.horizontal_wrapped(|ui| {
                let Some(opened) = &self.model.opened else {
                    ui.weak("no scene: drop a scene file here, or open one");
                    return;
                };
                ui.label(match (self.model.last_pass(), self.model.is_complete) {
                    (None, _) => "before the first pass".into(),
                    (Some(pass), true) => {
                        format!(
                            "after {} of {}: {}",
                            self.model.place,
                            counted(self.model.passes.len(), "pass"),
                            pass.kernel.name()
                        )
                    }
                    (Some(pass), false) => {
                        format!("after {}: {}", counted(self.model.place, "pass"), pass.kernel.name())
                    }
                });
                ui.separator();
                if self.model.has_rays() {
                    ui.label(format!("{} × {}", opened.plan.width, opened.plan.height));
                    ui.separator();
                }
                if self.devices.gpu.computes {
                    ui.label(&opened.device);
                } else if cfg!(target_arch = "wasm32") {
                    ui.label(format!("{}; drawn by WebGL 2", opened.device)).on_hover_text(NO_WEBGPU);
                } else {
                    ui.label(format!("{}; drawn by OpenGL", opened.device)).on_hover_text(NO_COMPUTE);
                }
                ui.separator();
                if let Some([x, y]) = self.state.selection.hovered.or(self.state.selection.pixel) {
                    let what = if self.model.has_rays() { "pixel" } else { "element" };
                    let glanced = self
                        .model
                        .glanced()
                        .filter(|_| self.state.selection.hovered.is_some())
                        .map(|t| outcome(t, self.state.display.units));
                    ui.label(format!("{what} {x},{y}{}", glanced.unwrap_or_default()));
                    ui.separator();
                }
                let (kept, budget) = (Bytes(self.model.kept_bytes), Bytes(self.model.budget));
                if kept.0 > 0 {
                    let text = "Memory for checkpoints. To go back, the run restarts from a checkpoint and repeats the \
                         passes after it.";
                    ui.weak(format!("checkpoints: {kept} of {budget}")).on_hover_text(text);
                }
            });
        });
        self.state.selection.hovered = None;
    }
}

const NO_COMPUTE: &str = "This adapter has no compute shaders: on it, kernels run as fragment programs, with --mapping \
                          fragment and --scene-data textures; otherwise on the CPU.";

const NO_WEBGPU: &str = "This browser has no WebGPU: kernels run on the CPU, on one core, or, if Options say GPU, by WebGL 2, \
                         as fragment programs with --scene-data textures.";

/// What becomes of a ray, after the name of its pixel.
fn outcome(trace: &Trace, units: Units) -> String {
    let scale = Scale::of(units, trace);
    let passes = counted(trace.rows.len(), "pass");
    let last = trace.rows.last().map(|row| (row.after.triangle, row.after.t));
    match last {
        Some((Some(triangle), Some(t))) => {
            format!(": hits triangle {triangle} at t {:.5} {}, {passes}", scale.t(t), units.name())
        }
        Some(_) => format!(": hits nothing, {passes}"),
        None => String::new(),
    }
}
