//! The history of the selected ray: one row per pass that processed it, with the changes and the reason.

use egui::{Color32, RichText};
use egui_extras::{Column, TableBuilder};
use raystep_kernels::export::trace::{Trace, TraceRow};
use raystep_kernels::tables::state::States;
use raystep_lab::text::counted;

use super::picked::{of_row, touches};
use super::scroll::Scroll;
use crate::draw::stream::state_color;
use crate::session::{Model, Told};
use crate::ui::pane::{Context, NO_RAYS, Panel};

/// The ray history.
#[derive(Default)]
pub(in crate::ui) struct RayView {
    scroll: Scroll,
}

const HEADS: [(&str, &str); 8] = [
    ("pass", "index in the run"),
    ("kernel", "kernel"),
    ("state", "the ray's state after the pass"),
    ("cell", "cell (x, y, z) or BVH node that the pass worked in"),
    ("tmax", "t at which the ray leaves its cell, per axis"),
    ("item", "position in the cell's list"),
    ("t", "nearest t so far"),
    ("hit", "nearest triangle so far"),
];

impl Panel for RayView {
    fn title(&self) -> String {
        "Ray".into()
    }

    fn show(&mut self, ui: &mut egui::Ui, cx: &mut Context<'_>) {
        if !cx.has_rays() {
            ui.weak(NO_RAYS);
            return;
        }
        let Some(life) = cx.model.life.clone() else {
            ui.weak("Click a pixel to see the history of its ray.");
            return;
        };
        let current = current_row(&life, cx.model.place);
        summary(ui, &life, cx);
        ui.separator();
        if let Some(row) = current.and_then(|i| life.rows.get(i)) {
            ui.label(RichText::new(format!("pass {}, {}: {}", row.number(), row.kernel, row.why)).strong());
        } else {
            ui.weak("No pass has processed this ray yet.");
        }
        ui.separator();
        egui::ScrollArea::horizontal().show(ui, |ui| self.table(ui, &life, current, cx));
    }
}

/// The last row whose pass has run.
pub(in crate::ui) fn current_row(life: &Trace, place: usize) -> Option<usize> {
    life.rows.partition_point(|row| row.is_within(place)).checked_sub(1)
}

fn summary(ui: &mut egui::Ui, life: &Trace, cx: &mut Context<'_>) {
    let [x, y] = life.pixel;
    ui.horizontal_wrapped(|ui| {
        ui.strong(format!("pixel {x},{y}"));
        ui.label(match life.passes {
            Some(passes) => format!("processed by {} of {}", life.rows.len(), counted(passes, "pass")),
            None => format!("processed by {}", counted(life.rows.len(), "pass")),
        });
        if let Some(last) = life.rows.last() {
            match (last.after.triangle, last.after.t) {
                (Some(triangle), Some(t)) => {
                    ui.label(format!("hits triangle {triangle} at t {}", short(t * life.t_scale as f32)))
                        .on_hover_text(format!("full precision: {}", f64::from(t) * life.t_scale));
                }
                _ => drop(ui.label("hits nothing")),
            }
        }
        if ui.button("Copy as text").clicked() {
            ui.ctx().copy_text(life.table());
        }
        source(ui, cx.model);
    });
    let Some(first) = life.rows.first() else { return };
    let (o, d) = (first.after.origin, first.after.direction);
    ui.horizontal_wrapped(|ui| {
        for (name, v) in [("origin", o), ("direction", d)] {
            let bits = v.map(|c| format!("0x{:08x}", c.to_bits())).join(", ");
            ui.label(format!("{name} {} {} {}", short(v[0]), short(v[1]), short(v[2])))
                .on_hover_text(format!("{} {} {} in traced units\n{bits}", v[0], v[1], v[2]));
        }
        let unit = life.scene_units_per_stream_unit;
        ui.weak(format!("1 traced unit = {unit} scene units"));
    });
}

/// Whose kernels the history is from, and whether all of it has happened.
fn source(ui: &mut egui::Ui, model: &Model) {
    const ABOUT: &str = "The CPU reference kernels trace the selected ray alone, at once. Then the device traces it, and \
                         both are compared, row by row and bit by bit.";
    match &model.told {
        Told::Device => {}
        Told::Reference => drop(ui.label("by the CPU reference kernels, not yet confirmed").on_hover_text(ABOUT)),
        Told::Compared { differing } if differing.is_empty() => {
            ui.label("confirmed by the device").on_hover_text(ABOUT);
        }
        Told::Compared { differing } => {
            let text = format!("{} differ from the CPU reference kernels", counted(differing.len(), "row"));
            ui.label(RichText::new(text).color(changed_color(ui))).on_hover_text(ABOUT);
        }
        Told::Unconfirmed(why) => {
            let text = format!("by the CPU reference kernels; the device could not confirm it: {why}");
            ui.label(RichText::new(text).color(changed_color(ui))).on_hover_text(ABOUT);
        }
    }
    if model.life.as_ref().is_some_and(|life| life.rows.iter().any(|row| model.is_predicted(row))) {
        ui.label(RichText::new("passes that have not run are predicted").italics());
    }
}

/// What to know about a row: that it is predicted, or how the device's differs from the CPU reference's.
fn mark(model: &Model, index: usize, row: &TraceRow) -> Option<(&'static str, String)> {
    match &model.told {
        Told::Compared { differing } if differing.contains(&index) => {
            let reference = model.reference_life.as_ref().and_then(|life| life.rows.get(index));
            let about = reference.map_or_else(
                || "the CPU reference kernels have no such row".into(),
                |row| format!("CPU reference kernels: {}, {}", row.kernel, row.why),
            );
            Some(("≠", about))
        }
        _ if model.is_predicted(row) => Some(("", "this pass has not run yet: the row is predicted".into())),
        _ => None,
    }
}

impl RayView {
    fn table(&mut self, ui: &mut egui::Ui, life: &Trace, current: Option<usize>, cx: &mut Context<'_>) {
        // All columns are wider than most panels.
        egui::ScrollArea::horizontal().auto_shrink(false).show(ui, |ui| self.columns(ui, life, current, cx));
    }

    fn columns(&mut self, ui: &mut egui::Ui, life: &Trace, current: Option<usize>, cx: &mut Context<'_>) {
        let height = ui.text_style_height(&egui::TextStyle::Monospace) + 4.0;
        let scroll_to = self.scroll.to(ui, current);
        let mut table = TableBuilder::new(ui)
            .striped(true)
            .sense(egui::Sense::click())
            .auto_shrink(false)
            // Where it is now matters, not the way there.
            .animate_scrolling(false)
            .columns(Column::auto().at_least(28.0), HEADS.len())
            .column(Column::remainder().at_least(480.0));
        if let Some(row) = scroll_to {
            table = table.scroll_to_row(row, Some(egui::Align::Center));
        }
        let states = cx.model.opened.as_ref().map_or(States(&[]), |opened| opened.plan.program.states);
        let is_grid = cx.model.opened.as_ref().is_some_and(|opened| opened.data.features.grid);
        let mut chosen = None;
        table
            .header(height, |mut header| {
                for (head, text) in HEADS.into_iter().chain([("why", "why the pass left the ray in this state")]) {
                    header.col(|ui| drop(ui.strong(head).on_hover_text(text)));
                }
            })
            .body(|body| {
                body.rows(height, life.rows.len(), |mut table_row| {
                    let index = table_row.index();
                    let row = &life.rows[index];
                    let before = index.checked_sub(1).map(|i| &life.rows[i]);
                    table_row.set_selected(Some(index) == current);
                    table_row.set_hovered(cx.shared.picked.is_some_and(|picked| touches(row, picked)));
                    let is_ahead = current.is_none_or(|c| index > c);
                    let mark = mark(cx.model, index, row);
                    let (mut now, then) = (cells(row, is_grid), before.map(|row| cells(row, is_grid)));
                    now[0] += mark.as_ref().map_or("", |(mark, _)| mark);
                    for (c, cell) in now.iter().enumerate() {
                        table_row.col(|ui| {
                            let changed = c >= 2 && then.as_ref().is_some_and(|then| then[c] != *cell);
                            let mut text = RichText::new(cell).monospace();
                            if mark.as_ref().is_some_and(|(sign, _)| sign.is_empty()) {
                                text = text.italics();
                            }
                            if is_ahead {
                                text = text.weak();
                            }
                            if changed {
                                text = text.color(changed_color(ui));
                            }
                            ui.horizontal(|ui| {
                                if c == 2 {
                                    let [r, g, b] = state_color(states, row.after.tag);
                                    let (rect, _) = ui.allocate_exact_size(egui::vec2(7.0, 12.0), egui::Sense::hover());
                                    ui.painter().rect_filled(rect, 1.0, Color32::from_rgb(r, g, b));
                                }
                                let label = egui::Label::new(text).selectable(false).extend();
                                let about = mark.as_ref().filter(|_| c == 0).map(|(_, about)| about.clone());
                                ui.add(label).on_hover_text(about.unwrap_or_else(|| full(row, c)));
                            });
                        });
                    }
                    table_row.col(|ui| {
                        let text = RichText::new(&row.why);
                        let text = if is_ahead { text.weak() } else { text };
                        ui.add(egui::Label::new(text).selectable(false).extend()).on_hover_text(&row.why);
                    });
                    if table_row.response().clicked() {
                        chosen = row.place();
                        cx.shared.picked = of_row(row);
                    }
                });
            });
        if chosen.is_some() {
            cx.shared.go_to = chosen;
        }
    }
}

fn changed_color(ui: &egui::Ui) -> Color32 {
    if ui.visuals().dark_mode { Color32::from_rgb(255, 205, 125) } else { Color32::from_rgb(135, 50, 0) }
}

/// A number for a narrow column.
fn short(value: f32) -> String {
    format!("{value:.5}")
}

fn or_dash(value: Option<f32>) -> String {
    value.map_or_else(|| "–".into(), short)
}

fn cells(row: &TraceRow, is_grid: bool) -> [String; 8] {
    let a = &row.after;
    let [x, y, z] = a.tmax.map(or_dash);
    [
        row.number(),
        row.kernel.into(),
        a.state.into(),
        match row.cell {
            Some([x, y, z]) => format!("{x},{y},{z}"),
            // Only a pass of the walk works in a cell.
            None if is_grid => "–".into(),
            None => a.cell_index.to_string(),
        },
        if a.tmax.iter().all(Option::is_none) { "–".into() } else { format!("{x} {y} {z}") },
        a.item.to_string(),
        or_dash(a.t),
        a.triangle.map_or_else(|| "–".into(), |t| t.to_string()),
    ]
}

/// A cell with all its digits.
fn full(row: &TraceRow, column: usize) -> String {
    let a = &row.after;
    let exact = |t: Option<f32>| t.map_or_else(|| "never".into(), |t| format!("{t} (0x{:08x})", t.to_bits()));
    match column {
        2 => format!("{} before the pass, {} after it", row.state_before, a.state),
        4 => format!("x {}\ny {}\nz {}", exact(a.tmax[0]), exact(a.tmax[1]), exact(a.tmax[2])),
        6 => exact(a.t),
        7 => match (a.triangle, a.barycentric) {
            (Some(triangle), Some([u, v])) => format!("triangle {triangle}, u {u}, v {v}"),
            _ => "no triangle".into(),
        },
        _ => HEADS[column].1.into(),
    }
}
