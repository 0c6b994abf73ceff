//! The history of the selected ray: one row per pass that processed it, with the changes and the reason.
//!
//! Touches: selection, display, asks.

mod rows;

use crate::walk::row_after_passes;
use std::sync::Arc;

use egui::{Color32, RichText, Ui, Vec2, vec2};
use raystep_kernels::export::trace::{RayState, Trace};
use raystep_kernels::tables::state::States;
use raystep_lab::text::counted;
use rows::{RayRows, heads};

use super::picked::of_row;
use super::table::{Table, View, version};
use crate::session::{HistorySource, Model};
use crate::ui::pane::{Context, NO_RAYS, Panel};
use crate::ui::style::strong;
use crate::ui::units::{self, Scale};

/// The ray history.
#[derive(Default)]
pub(in crate::ui) struct RayView {
    table: Table,
    /// The decimals of tmax.x, tmax.y, tmax.z and t, and for which history.
    decimals: Option<(usize, Scale, [usize; 4])>,
    /// The current row of the last frame.
    current: Option<usize>,
}

impl Panel for RayView {
    fn least(&self) -> Vec2 {
        // Some rows below what is said of the ray and of its current row.
        vec2(240.0, 220.0)
    }

    fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        if !cx.has_rays() {
            ui.weak(NO_RAYS);
            return;
        }
        let Some(history) = cx.model.history.clone() else {
            ui.weak("Click a pixel to see the history of its ray.");
            return;
        };
        summary(ui, &history, cx);
        ui.separator();
        let (units, model) = (cx.display.units, &*cx.model);
        let scale = Scale::of(units, &history);
        let opened = model.opened.as_ref();
        let current = row_after_passes(&history, model.place);
        let shown = match cx.display.hides_next {
            true => current.map_or(0, |row| row + 1),
            false => history.rows.len(),
        };
        let rows = RayRows {
            history: &history,
            model,
            states: opened.map_or(States(&[]), |opened| opened.plan.program.states),
            scale,
            decimals: self.decimals(&history, scale),
            current,
            shown,
            picked: cx.selection.picked,
        };
        if let Some(row) = rows.current.and_then(|i| history.rows.get(i)) {
            let state = format!("{}: {}", row.after.state, rows.meaning(row).unwrap_or_default());
            // The row of the table has the rest.
            let told = format!("pass {}, {}: {}; {state}", row.number(), row.kernel, rows.why(row));
            ui.label(state).widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, &told));
        } else {
            ui.weak("No pass has processed this ray yet.");
        }
        let is_tree = opened.is_some_and(|opened| opened.data.features.bvh);
        let is_dda = opened.is_some_and(|opened| opened.data.features.dda);
        let heads = heads(!is_tree, is_dda);
        // A low panel has no room for it: the table marks what has changed.
        let has_room = ui.available_height() > 220.0;
        if let Some(changes) = rows.current.filter(|_| has_room).and_then(|row| rows.changes(row, &heads)) {
            ui.label(changes).on_hover_text("the ray's values before and after this pass");
        }
        let is_compared = matches!(model.history_source, HistorySource::Compared { .. });
        let version = version((
            Arc::as_ptr(&history) as usize,
            model.edition,
            history.pixel,
            shown,
            units,
            (is_tree, is_dda),
            is_compared,
        ));
        let view = View { name: "ray", heads: &heads, rows: &rows, version, current: rows.current };
        // Before the ray's first pass there is no current row: the table begins at its first one.
        if std::mem::replace(&mut self.current, rows.current) != rows.current && rows.current.is_none() {
            self.table.rewind();
        }
        let mut units = units;
        ui.horizontal_wrapped(|ui| {
            self.table.tools(ui, &view);
            units::choose(ui, &mut units, history.scene_units_per_stream_unit);
        });
        let chosen = self.table.show(ui, &view).and_then(|row| history.rows.get(row));
        cx.display.units = units;
        if let Some(row) = chosen {
            (cx.asks.go_to, cx.selection.picked) = (row.place().or(cx.asks.go_to), of_row(row));
        }
    }
}

impl RayView {
    fn decimals(&mut self, history: &Arc<Trace>, scale: Scale) -> [usize; 4] {
        let of = Arc::as_ptr(history) as usize;
        if let Some((known, in_scale, decimals)) = self.decimals
            && (known, in_scale) == (of, scale)
        {
            return decimals;
        }
        // One digit less than elsewhere: ten columns have to fit.
        let decimals = scale.decimals(history).map(|decimals| decimals.saturating_sub(1));
        self.decimals = Some((of, scale, decimals));
        decimals
    }
}

fn summary(ui: &mut Ui, history: &Trace, cx: &mut Context<'_>) {
    let scale = Scale::of(cx.display.units, history);
    let unit = scale.units.name();
    ui.horizontal_wrapped(|ui| {
        let pixel = strong(ui, history.name());
        if let Some(first) = history.rows.first() {
            pixel.on_hover_text(ray(&first.after, &scale));
        }
        ui.label(match history.passes {
            Some(passes) => format!("processed by {} of {}", history.rows.len(), counted(passes, "pass")),
            None => format!("processed by {}", counted(history.rows.len(), "pass")),
        });
        if history.element.is_some() {
            if let Some([x, y]) = cx.selection.pixel
                && ui.button(format!("Back to pixel {x},{y}")).clicked()
            {
                cx.asks.select = cx.selection.pixel;
            }
        } else if let Some(last) = history.rows.last() {
            match (last.after.triangle, last.after.t) {
                (Some(triangle), Some(t)) => {
                    let shown = scale.t(t);
                    let digits = units::decimals(shown.abs());
                    ui.label(format!("hits triangle {triangle} at t {shown:.digits$} {unit}"))
                        .on_hover_text(format!("{} {unit}", scale.exact_t(t)));
                }
                _ => drop(ui.label("hits nothing")),
            }
        }
        if ui.button("Copy as text").clicked() {
            ui.ctx().copy_text(history.table(cx.display.units));
        }
        source(ui, cx.model);
    });
}

/// Origin and direction of the ray.
fn ray(first: &RayState, scale: &Scale) -> String {
    let bits = |v: [f32; 3]| v.map(|c| format!("0x{:08x}", c.to_bits())).join(", ");
    let ([x, y, z], unit) = (first.origin, scale.units.name());
    let [dx, dy, dz] = first.direction;
    format!(
        "origin {} in {unit}\n{x} {y} {z} in traced units ({})\ndirection {dx} {dy} {dz} ({})",
        scale.point(first.origin).join(" "),
        bits(first.origin),
        bits(first.direction),
    )
}

/// Whose kernels the history is from, and whether all of it has happened.
fn source(ui: &mut Ui, model: &Model) {
    const ABOUT: &str = "The CPU reference kernels trace the selected ray alone, at once. Then the device traces it, and \
                         both are compared, row by row and bit by bit.";
    match &model.history_source {
        HistorySource::Device => {}
        HistorySource::Reference => {
            drop(ui.label("by the CPU reference kernels, not yet confirmed").on_hover_text(ABOUT))
        }
        HistorySource::Compared { differing } if differing.is_empty() => {
            ui.label("confirmed by the device").on_hover_text(ABOUT);
        }
        HistorySource::Compared { differing } => {
            let text = format!("{} differ from the CPU reference kernels", counted(differing.len(), "row"));
            ui.label(RichText::new(text).color(changed_color(ui))).on_hover_text(ABOUT);
        }
        HistorySource::Unconfirmed(why) => {
            let text = format!("by the CPU reference kernels; the device could not confirm it: {why}");
            ui.label(RichText::new(text).color(changed_color(ui))).on_hover_text(ABOUT);
        }
    }
    if model.history.as_ref().is_some_and(|history| history.rows.iter().any(|row| model.is_predicted(row))) {
        ui.label(RichText::new("passes that have not run are predicted").italics());
    }
}

fn changed_color(ui: &Ui) -> Color32 {
    if ui.visuals().dark_mode { Color32::from_rgb(255, 205, 125) } else { Color32::from_rgb(130, 50, 0) }
}
