//! The list of passes: kernel, duration, rays. A click goes there.

use egui_extras::{Column, TableBuilder};
use raystep_kernels::Pass;

use super::scroll::Scroll;
use crate::ui::pane::{Context, Panel};

/// The list of passes.
#[derive(Default)]
pub(in crate::ui) struct Passes {
    scroll: Scroll,
    /// Show only the passes that processed the selected ray.
    only_ray: bool,
}

impl Panel for Passes {
    fn title(&self) -> String {
        "Passes".into()
    }

    fn show(&mut self, ui: &mut egui::Ui, cx: &mut Context<'_>) {
        if cx.model.opened.is_none() {
            ui.weak("No run yet.");
            return;
        }
        if cx.has_rays() {
            ui.checkbox(&mut self.only_ray, "only the selected ray")
                .on_hover_text("show only passes that processed the selected ray");
        }
        let of_ray: Option<Vec<usize>> = cx
            .model
            .life
            .as_ref()
            .filter(|_| self.only_ray)
            .map(|life| life.rows.iter().filter_map(|r| r.pass).collect());
        let known = cx.model.passes.len();
        let rows: Vec<usize> = match of_ray {
            Some(rows) => rows.into_iter().filter(|&i| i < known).collect(),
            None => (0..known).collect(),
        };
        let place = cx.model.place;
        // Row 0 is before the first pass.
        let current = rows.partition_point(|&i| i < place);
        let height = ui.text_style_height(&egui::TextStyle::Body) + 4.0;
        // All four columns must fit the narrow column of the simple layout.
        ui.spacing_mut().item_spacing.x = 4.0;
        let scroll_to = self.scroll.to(ui, Some(place));
        let mut table = TableBuilder::new(ui)
            .striped(true)
            .sense(egui::Sense::click())
            .auto_shrink(false)
            // Where it is now matters, not the way there.
            .animate_scrolling(false)
            .columns(Column::auto().at_least(30.0), 3)
            .column(Column::remainder().at_least(40.0));
        if scroll_to.is_some() {
            table = table.scroll_to_row(current, Some(egui::Align::Center));
        }
        let mut chosen = None;
        table
            .header(height, |mut header| {
                let heads = [
                    ("pass", "index in the run"),
                    ("kernel", "kernel"),
                    ("µs", "by the device's clock; empty if it has no valid one"),
                    if cx.has_rays() {
                        ("rays", "rays processed by the pass")
                    } else {
                        ("elements", "elements that the pass works on: triangles, spans, references, cells or blocks")
                    },
                ];
                for (head, text) in heads {
                    header.col(|ui| {
                        ui.strong(head).on_hover_text(text);
                    });
                }
            })
            .body(|body| {
                body.rows(height, rows.len() + 1, |mut row| {
                    let index = row.index();
                    row.set_selected(index == current);
                    let pass = index.checked_sub(1).and_then(|i| cx.model.passes.get(rows[i]));
                    let cells = pass.map_or_else(|| ["–".into(), "start".into(), String::new(), String::new()], cells);
                    let mut cells = cells;
                    if cx.shared.bookmark_at(pass.map_or(0, |pass| pass.index + 1)).is_some() {
                        cells[0] += " •";
                    }
                    for cell in cells {
                        row.col(|ui| {
                            // Passes ahead are known from an earlier run.
                            let text = egui::RichText::new(cell);
                            let text = if index > current { text.weak() } else { text };
                            ui.add(egui::Label::new(text).extend());
                        });
                    }
                    if row.response().clicked() {
                        chosen = Some(pass.map_or(0, |pass| pass.index + 1));
                    }
                });
            });
        if chosen.is_some() {
            cx.shared.go_to = chosen;
        }
    }
}

fn cells(pass: &Pass) -> [String; 4] {
    let duration = pass.duration_ns.map_or_else(String::new, |ns| format!("{:.1}", ns as f64 / 1e3));
    [pass.index.to_string(), pass.kernel.name().into(), duration, pass.rays_in.to_string()]
}
