//! The toolbar of the 3D view.

use raystep_kernels::programs::photons::stored;

use super::{Context, Heat, Layer, Opened, TriangleStyle, Walk3d, Wish, event_buttons};
use crate::ui::choice::Choices as _;

const STYLES: [(TriangleStyle, &str, &str); 4] = [
    (TriangleStyle::Opaque, "opaque", "solid triangles; items behind them are faint"),
    (TriangleStyle::Translucent, "translucent", "transparent triangles"),
    (TriangleStyle::Wireframe, "edges", "only the edges of triangles"),
    (TriangleStyle::Hidden, "off", "only tested triangles"),
];

impl Walk3d {
    /// Shows the toolbar; returns requests to the camera.
    pub(super) fn tools(&mut self, ui: &mut egui::Ui, cx: &mut Context<'_>, opened: &Opened) -> Option<Wish> {
        let mut wish = None;
        // One line in a small tile: the rest goes into a menu.
        let is_wide = ui.available_width() >= 640.0;
        ui.horizontal_wrapped(|ui| {
            event_buttons(ui, cx.asks);
            self.style(ui);
            Heat::choose(ui, &mut self.look.paint);
            if self.look.is_moved && self.framed.has_walk() && !is_wide {
                self.frame_button(ui, &mut wish);
            }
            if is_wide {
                self.camera_buttons(ui, &mut wish);
            } else {
                ui.menu_button("Camera", |ui| self.camera_buttons(ui, &mut wish));
            }
            ui.menu_button("Show", |ui| self.choices(ui, cx, opened)).response.on_hover_text("visible items");
        });
        wish
    }

    fn style(&mut self, ui: &mut egui::Ui) {
        let settings = &mut self.look.settings;
        let now = STYLES.iter().find(|style| style.0 == settings.triangles).map_or("", |style| style.1);
        egui::ComboBox::from_id_salt("triangles")
            .selected_text(now)
            .width(84.0)
            .show_ui(ui, |ui| {
                for (style, name, text) in STYLES {
                    ui.choice_of(&mut settings.triangles, style, name).on_hover_text(text);
                }
            })
            .response
            .on_hover_text("how the scene's triangles are drawn")
            .widget_info(|| egui::WidgetInfo::labeled(egui::Role::ComboBox, true, "scene"));
    }

    fn frame_button(&self, ui: &mut egui::Ui, wish: &mut Option<Wish>) {
        let text =
            "show the whole walk from its side; the view then follows the selected ray until it is moved by hand";
        let button = ui.add_enabled(self.framed.has_walk(), egui::Button::new("Frame walk"));
        if button.on_hover_text(text).clicked() {
            *wish = Some(Wish::FrameWalk);
        }
    }

    fn camera_buttons(&mut self, ui: &mut egui::Ui, wish: &mut Option<Wish>) {
        let has_walk = self.walked.walk.is_some();
        self.frame_button(ui, wish);
        let buttons = [
            (Wish::AlongRay, has_walk, "Along the ray", "look along the ray, from a little behind its position"),
            (Wish::TracedView, true, "Traced view", "the view of the traced camera"),
            (Wish::FrameCell, has_walk, "Frame cell", "frame the ray's cell or node (F; Shift+F frames the scene)"),
            (Wish::Trace, true, "Trace from here", "trace the scene from this view"),
        ];
        for (what, is_on, name, text) in buttons {
            if ui.add_enabled(is_on, egui::Button::new(name)).on_hover_text(text).clicked() {
                *wish = Some(what);
            }
        }
        let text = "trace again whenever this view moves";
        if ui.checkbox(&mut self.look.traces, "trace as the camera moves").on_hover_text(text).clicked() {
            // The current view is traced as soon as this is switched on.
            self.traced = None;
        }
    }

    fn choices(&mut self, ui: &mut egui::Ui, cx: &mut Context<'_>, opened: &Opened) {
        let s = &mut self.look.settings;
        ui.checkbox(&mut self.look.labels, "labels").on_hover_text("labels with cell, tmax and triangle");
        for (is_on, name, text) in [
            (&mut s.ray, "ray", "solid up to the current position, with the nearest hit so far"),
            (
                &mut s.light,
                "rays to lights",
                "in the colour of the light; dark up to what is in the way, and dashed beyond it",
            ),
            (&mut s.visited, "cells and nodes visited", "dark (first) to bright (last)"),
            (&mut s.missed_nodes, "nodes that the ray missed", "their boxes were tested as well"),
            (&mut s.tested, "triangles tested", "green: hit; orange: missed"),
            (&mut s.crossings, "crossed planes", "red: x, green: y, blue: z"),
            (&mut s.bounds, "box of the grid or BVH", "the region that the ray traverses"),
            (&mut s.camera, "traced camera", "the origin of the rays"),
            (&mut s.axes, "axes", "red: x, green: y, blue: z"),
            (&mut s.edges, "edges of triangles", "drawn darker"),
            (
                &mut s.cut,
                "cut away what hides the walk",
                "draws triangles between the eye and the walk faintly, or leaves them out if triangles are opaque",
            ),
        ] {
            ui.checkbox(is_on, name).on_hover_text(text);
        }
        if stored::has_photons(&opened.plan) {
            Layer::choices(ui, &mut self.look.settings, cx, opened);
        }
        ui.separator();
        ui.weak(
            "drag: orbit; right drag: pan; wheel: zoom\nclick: select a cell, node or triangle; again: the next one \
                 behind it\nthen W A S D: fly, with right drag: look around\nF: frame cell; Shift+F: frame scene; \
                 double click: frame the walk",
        );
    }
}
