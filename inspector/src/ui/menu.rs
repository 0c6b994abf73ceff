//! Menus, the toolbar and the status bar.

use egui::containers::menu::MenuBar;
use egui::{Button, Color32, Painter, Pos2, Rect, Shape, Stroke, vec2};

use raystep_kernels::export::trace::Trace;
use raystep_kernels::plan::Bytes;
use raystep_lab::text::counted;

use super::Inspector;
use super::command::{COMMANDS, Command, Menu};

/// The buttons of the toolbar.
const BUTTONS: [Command; 7] = [
    Command::Start,
    Command::PreviousPass,
    Command::NextPass,
    Command::End,
    Command::Play,
    Command::PreviousEvent,
    Command::NextEvent,
];

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
            });
            ui.horizontal_wrapped(|ui| {
                BUTTONS.into_iter().for_each(|command| self.tool(ui, command));
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
        for info in COMMANDS.iter().filter(|info| info.menu == menu) {
            let button = Button::new(info.name).shortcut_text(info.command.key_text(ui.ctx()));
            if ui.add_enabled(self.can(info.command), button).clicked() {
                self.perform(info.command);
                ui.close();
            }
            if info.command == Command::OpenScene && !self.shared.recent.is_empty() {
                ui.menu_button("Open recent", |ui| {
                    for path in &self.shared.recent {
                        if ui.button(path).clicked() {
                            self.shared.open = Some(path.clone());
                            ui.close();
                        }
                    }
                });
            }
        }
    }

    fn tool(&mut self, ui: &mut egui::Ui, command: Command) {
        let is_on = command == Command::Play && self.is_playing;
        let button = Button::new("").selected(is_on).min_size(vec2(28.0, 20.0));
        let response = ui.add_enabled(self.can(command), button);
        let color = if self.can(command) { ui.visuals().text_color() } else { ui.visuals().weak_text_color() };
        sign(ui.painter(), response.rect.center(), command, is_on, color);
        let key = command.key_text(ui.ctx());
        let name = command.name();
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, name));
        let text = if key.is_empty() { name.to_owned() } else { format!("{name} ({key})") };
        if response.on_hover_text(text).clicked() {
            self.perform(command);
        }
    }

    pub(super) fn status_bar(&mut self, ui: &mut egui::Ui) {
        egui::Panel::bottom("status").frame(frame(ui)).show(ui, |ui| {
            ui.horizontal(|ui| {
                let Some(opened) = &self.model.opened else {
                    ui.weak("no scene: drop a glTF file here, or open one");
                    return;
                };
                let end = if self.model.is_complete { self.model.passes.len().to_string() } else { "…".into() };
                let kernel = self.model.last_pass().map_or("before the first pass", |pass| pass.kernel.name());
                ui.label(format!("after {} of {end} passes: {kernel}", self.model.place));
                ui.separator();
                if self.model.has_rays() {
                    ui.label(format!("{} × {}", opened.plan.width, opened.plan.height));
                    ui.separator();
                }
                ui.label(&opened.device);
                ui.separator();
                if let Some([x, y]) = self.shared.hovered.or(self.shared.pixel) {
                    let what = if self.model.has_rays() { "pixel" } else { "element" };
                    let glanced = self.model.glanced().filter(|_| self.shared.hovered.is_some()).map(|t| outcome(t));
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
        self.shared.hovered = None;
    }
}

/// What becomes of a ray, after the name of its pixel.
fn outcome(trace: &Trace) -> String {
    let passes = counted(trace.rows.len(), "pass");
    let last = trace.rows.last().map(|row| (row.after.triangle, row.after.t));
    match last {
        Some((Some(triangle), Some(t))) => {
            format!(": hits triangle {triangle} at t {:.5}, {passes}", f64::from(t) * trace.t_scale)
        }
        Some(_) => format!(": hits nothing, {passes}"),
        None => String::new(),
    }
}

/// A button's icon, as on tape recorders; event buttons have a dot.
fn sign(painter: &Painter, middle: Pos2, command: Command, is_on: bool, color: Color32) {
    let triangle = |x: f32, width: f32| {
        let [base, tip] = [middle + vec2(x, 0.0), middle + vec2(x + width, 0.0)];
        let corners = vec![base + vec2(0.0, -5.0), base + vec2(0.0, 5.0), tip];
        painter.add(Shape::convex_polygon(corners, color, Stroke::NONE));
    };
    let bar = |x: f32| {
        painter.rect_filled(Rect::from_center_size(middle + vec2(x, 0.0), vec2(2.0, 10.0)), 0.0, color);
    };
    match command {
        Command::Start => {
            bar(-5.0);
            triangle(5.0, -8.0);
        }
        Command::PreviousPass => triangle(4.0, -8.0),
        Command::NextPass => triangle(-4.0, 8.0),
        Command::End => {
            triangle(-5.0, 8.0);
            bar(5.0);
        }
        Command::Play if is_on => {
            bar(-2.5);
            bar(2.5);
        }
        Command::Play => {
            triangle(-7.0, 7.0);
            triangle(0.0, 7.0);
        }
        Command::PreviousEvent => {
            triangle(1.0, -7.0);
            painter.circle_filled(middle + vec2(5.0, 0.0), 2.0, color);
        }
        _ => {
            triangle(-1.0, 7.0);
            painter.circle_filled(middle + vec2(-5.0, 0.0), 2.0, color);
        }
    }
}
