//! The buttons over the 3D view.

use super::{Context, TriangleStyle, Walk3d, Wish, event_buttons};

const STYLES: [(TriangleStyle, &str, &str); 4] = [
    (TriangleStyle::Opaque, "opaque", "solid triangles; what is behind them is faint"),
    (TriangleStyle::Translucent, "translucent", "triangles like glass"),
    (TriangleStyle::Wireframe, "edges", "edges of triangles only"),
    (TriangleStyle::Hidden, "off", "no triangles but those that were tested"),
];

impl Walk3d {
    /// Shows the buttons; says what they ask of the camera.
    pub(super) fn tools(&mut self, ui: &mut egui::Ui, cx: &mut Context<'_>) -> Option<Wish> {
        let mut wish = None;
        // One line in a small tile: what does not fit goes into a menu.
        let is_wide = ui.available_width() >= 640.0;
        ui.horizontal_wrapped(|ui| {
            event_buttons(ui, cx);
            self.style(ui);
            if is_wide {
                self.camera_buttons(ui, &mut wish);
            } else {
                ui.menu_button("Camera", |ui| self.camera_buttons(ui, &mut wish));
            }
            ui.menu_button("Show", |ui| self.choices(ui)).response.on_hover_text("what is drawn");
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
                    ui.selectable_value(&mut settings.triangles, style, name).on_hover_text(text);
                }
            })
            .response
            .on_hover_text("how the scene's triangles are drawn")
            .widget_info(|| egui::WidgetInfo::labeled(egui::Role::ComboBox, true, "scene"));
    }

    fn camera_buttons(&mut self, ui: &mut egui::Ui, wish: &mut Option<Wish>) {
        let has_walk = self.walked.walk.is_some();
        let buttons = [
            (Wish::AlongRay, has_walk, "Along the ray", "look the way the ray goes, from a little behind where it is"),
            (Wish::TracedView, true, "Traced view", "see the scene as the traced camera does"),
            (Wish::FrameCell, has_walk, "Frame cell", "the cell or node where the ray is (F; with Shift the scene)"),
            (Wish::Trace, true, "Trace from here", "trace the scene as it is seen here"),
        ];
        for (what, is_on, name, text) in buttons {
            if ui.add_enabled(is_on, egui::Button::new(name)).on_hover_text(text).clicked() {
                *wish = Some(what);
            }
        }
        let text = "trace the scene again whenever this view has moved";
        if ui.checkbox(&mut self.look.traces, "trace as the camera moves").on_hover_text(text).clicked() {
            // What is seen when this is switched on is traced too.
            self.traced = None;
        }
    }

    fn choices(&mut self, ui: &mut egui::Ui) {
        let s = &mut self.look.settings;
        ui.checkbox(&mut self.look.labels, "labels").on_hover_text("cell, tmax and triangle in numbers");
        for (is_on, name, text) in [
            (&mut s.ray, "ray", "solid as far as it has come, with its nearest hit so far"),
            (&mut s.visited, "cells and nodes visited", "from dark (first) to bright (last)"),
            (&mut s.missed_nodes, "nodes that the ray missed", "their boxes were tested too"),
            (&mut s.tested, "triangles tested", "green: hit; orange: missed"),
            (&mut s.crossings, "crossed planes", "red: of x, green: of y, blue: of z"),
            (&mut s.bounds, "box of the grid or tree", "within which the ray walks"),
            (&mut s.camera, "traced camera", "where the rays come from"),
            (&mut s.axes, "axes", "red: x, green: y, blue: z"),
            (&mut s.edges, "edges of triangles", "drawn darker"),
        ] {
            ui.checkbox(is_on, name).on_hover_text(text);
        }
        ui.separator();
        ui.weak("drag: orbit; right drag: pan; wheel: zoom\nclick, then W A S D: fly, with right drag: look around\nF: the cell; Shift+F: the scene; double click: reset");
    }
}
