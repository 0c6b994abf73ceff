//! Rays in each state over all passes, stacked; by pass, or by time on the device.

use egui::{Color32, Pos2, Rect, Sense, Stroke, pos2, vec2};
use raystep_kernels::Pass;
use raystep_kernels::tables::state::{StateInfo, StateRole};
use raystep_lab::text::counted;
use serde::{Deserialize, Serialize};

use super::legend;
use super::ray::current_row;
use crate::ui::pane::{Context, Panel};

/// The horizontal axis of the timeline.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
enum Scale {
    /// All passes have equal width.
    #[default]
    Passes,
    /// Width is proportional to time on the device.
    Time,
}

/// The timeline.
#[derive(Default)]
pub(in crate::ui) struct Timeline {
    scale: Scale,
    /// The end of each pass, as a fraction of the total, and the inputs of that result.
    ends: Vec<f64>,
    known: Option<(u64, usize, Scale)>,
}

impl Panel for Timeline {
    fn title(&self) -> String {
        "Timeline".into()
    }

    fn show(&mut self, ui: &mut egui::Ui, cx: &mut Context<'_>) {
        let passes = &cx.model.passes;
        if passes.is_empty() {
            ui.weak("Step a pass to see how many rays are in each state.");
            return;
        }
        let has_times = passes.iter().any(|pass| pass.duration_ns.is_some());
        ui.horizontal_wrapped(|ui| {
            ui.selectable_value(&mut self.scale, Scale::Passes, "by pass");
            ui.add_enabled_ui(has_times, |ui| ui.selectable_value(&mut self.scale, Scale::Time, "by device time"));
            ui.separator();
            for state in passes[0].kernel.program().states.iter().skip(1) {
                legend::entry(ui, color(state), state.name, state.meaning);
            }
        });
        if !has_times {
            self.scale = Scale::Passes;
        }
        let known = (cx.model.generation, passes.len(), self.scale);
        if self.known != Some(known) {
            self.ends = ends(passes, self.scale);
            self.known = Some(known);
        }
        let (rect, response) =
            ui.allocate_exact_size(ui.available_size().max(vec2(40.0, 24.0)), Sense::click_and_drag());
        self.draw(ui, rect, cx);
        let at = |x: f32| f64::from((x - rect.left()) / rect.width().max(1.0)).clamp(0.0, 1.0);
        let pass_at = |pos: Pos2| self.ends.partition_point(|&end| end < at(pos.x)).min(passes.len() - 1);
        if let Some(pass) = response.hover_pos().map(pass_at).and_then(|i| passes.get(i)) {
            response.clone().on_hover_ui_at_pointer(|ui| about(ui, pass));
        }
        // During a drag, one place at a time; intermediate ones are skipped.
        let is_asked = response.clicked() || response.dragged() && !cx.model.is_busy();
        if let Some(pos) = response.interact_pointer_pos().filter(|_| is_asked) {
            cx.shared.go_to = Some(pass_at(pos) + 1);
        }
        let text = format!("after {} of {} known passes", cx.model.place, passes.len());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Slider, true, &text));
    }

    fn save(&self) -> String {
        serde_json::to_string(&self.scale).unwrap_or_default()
    }

    fn load(&mut self, saved: &str) {
        self.scale = serde_json::from_str(saved).unwrap_or_default();
    }
}

fn color(state: &StateInfo) -> Color32 {
    let [r, g, b] = state.colour;
    Color32::from_rgb(r, g, b)
}

/// The end of each pass, as a fraction of the total.
fn ends(passes: &[Pass], scale: Scale) -> Vec<f64> {
    let width = |pass: &Pass| match scale {
        Scale::Passes => 1.0,
        Scale::Time => pass.duration_ns.unwrap_or(0) as f64,
    };
    let whole: f64 = passes.iter().map(width).sum();
    let mut end = 0.0;
    passes
        .iter()
        .map(|pass| {
            end += width(pass);
            if whole > 0.0 { end / whole } else { 1.0 }
        })
        .collect()
}

fn about(ui: &mut egui::Ui, pass: &Pass) {
    ui.strong(format!("pass {}: {}", pass.index, pass.kernel.name()));
    ui.label(format!("processed {}", counted(pass.rays_in, "ray")));
    if let Some(ns) = pass.duration_ns {
        ui.label(format!("{:.1} µs on the device", ns as f64 / 1e3));
    }
    for StateInfo { tag, name, .. } in pass.kernel.program().states.iter() {
        let count = pass.counts[*tag as usize];
        if count > 0 {
            ui.label(format!("{count} {name} after it"));
        }
    }
}

impl Timeline {
    fn draw(&self, ui: &egui::Ui, rect: Rect, cx: &Context<'_>) {
        let painter = ui.painter().with_clip_rect(rect);
        painter.rect_filled(rect, 0.0, ui.visuals().extreme_bg_color);
        let (passes, model) = (&cx.model.passes, &cx.model);
        let x = |part: f64| rect.left() + (part * f64::from(rect.width())) as f32;
        let rays: u32 = passes[0].counts.iter().sum();
        // One bar per point if there are more passes than points: the last pass that ends in it.
        let columns = rect.width().ceil().max(1.0) as usize;
        let bars: Vec<(f32, f32, usize)> = if passes.len() <= columns {
            (0..passes.len()).map(|i| (x(if i == 0 { 0.0 } else { self.ends[i - 1] }), x(self.ends[i]), i)).collect()
        } else {
            let pass = |c: usize| self.ends.partition_point(|&end| end < (c as f64 + 0.5) / columns as f64);
            (0..columns)
                .map(|c| (rect.left() + c as f32, rect.left() + c as f32 + 1.0, pass(c).min(passes.len() - 1)))
                .collect()
        };
        for (left, right, i) in bars {
            let mut bottom = rect.bottom();
            // Waiting rays at the bottom, finished ones on top: the remaining work shrinks downwards.
            let is_shown = |state: &&StateInfo| matches!(state.role, StateRole::Active | StateRole::Resolved);
            for state in passes[i].kernel.program().states.iter().filter(is_shown) {
                let share = passes[i].counts[state.tag as usize] as f32 / rays.max(1) as f32;
                let top = bottom - share * rect.height();
                let bar = Rect::from_min_max(pos2(left, top), pos2(right.max(left + 0.5), bottom));
                if share > 0.0 {
                    painter.rect_filled(bar, 0.0, color(state));
                }
                bottom = top;
            }
        }
        let tick = |place: usize| if place == 0 { rect.left() } else { x(self.ends[place.min(passes.len()) - 1]) };
        if let Some(life) = &model.life {
            let current = current_row(life, model.place);
            for (i, row) in life.rows.iter().enumerate() {
                let Some(place) = row.place().filter(|&place| place <= passes.len()) else { continue };
                let color = if Some(i) == current { Color32::WHITE } else { Color32::from_white_alpha(90) };
                let at = tick(place);
                painter.vline(at, rect.top()..=rect.top() + 5.0, Stroke::new(1.0, color));
            }
        }
        let stroke = Stroke::new(2.0, ui.visuals().selection.stroke.color);
        painter.vline(tick(model.place).clamp(rect.left() + 1.0, rect.right() - 1.0), rect.y_range(), stroke);
    }
}
