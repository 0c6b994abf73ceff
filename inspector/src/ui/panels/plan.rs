//! What the run needs, and what is omitted and why.
//!
//! Touches: nothing.

mod lists;

use egui::{Align2, CollapsingHeader, Color32, FontId, Rect, ScrollArea, Sense, Ui, pos2, vec2};
use lists::List;
use raystep_kernels::Plan;
use raystep_kernels::options::mapping::Fragment;
use raystep_kernels::plan::{Bytes, DrawnPlan};
use raystep_lab::text::counted;

use crate::ui::pane::{Context, Panel};
use crate::ui::style::{SMALLEST, in_strong, ink_on, strong, towards};

/// The panel.
#[derive(Default)]
pub(in crate::ui) struct PlanView {
    generation: u64,
    parts: Vec<Part>,
    lists: [List; 5],
}

/// An item that takes memory.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Part {
    name: &'static str,
    bytes: u64,
    is_stream: bool,
}

impl Panel for PlanView {
    fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        let Some(opened) = &cx.model.opened else {
            ui.weak("Open a scene to see what its run needs.");
            return;
        };
        let plan = &opened.plan;
        if self.generation != cx.model.generation {
            self.generation = cx.model.generation;
            self.parts = parts(plan);
            self.lists.iter_mut().zip(lists::of(plan)).for_each(|(list, rows)| list.set(rows));
        }
        ScrollArea::both().auto_shrink(false).show(ui, |ui| {
            ui.horizontal_wrapped(|ui| {
                strong(ui, Bytes(plan.bytes()).to_string()).on_hover_text(format!("{} bytes", plan.bytes()));
                ui.label(format!(
                    "for {} × {} texels, {}, {}",
                    plan.width,
                    plan.height,
                    counted(plan.rays, "ray"),
                    counted(plan.triangles, "triangle")
                ));
            });
            bar(ui, &self.parts);
            let bytes = |is_stream: bool| {
                let of_kind = self.parts.iter().filter(|part| part.is_stream == is_stream);
                Bytes(of_kind.map(|part| part.bytes).sum())
            };
            let titles = [
                format!("Kernels: {}", plan.variants.len()),
                plan.drawn.as_ref().map_or_else(String::new, drawn_as),
                format!("Streams: {}, {}", plan.streams.len(), bytes(true)),
                format!("Buffers: {}, {}", plan.buffers.len(), bytes(false)),
                format!("Omitted: {}", plan.left_out.len()),
            ];
            ui.horizontal_wrapped(|ui| lists::field(ui, &mut self.lists));
            let names = lists::NAMES.into_iter().zip(lists::HEADS);
            let all = self.lists.iter_mut().zip(titles).zip(names);
            // Compute shaders have no draws.
            for ((list, title), (name, heads)) in
                all.filter(|((list, _), (name, _))| *name != "draws" || !list.is_empty())
            {
                section(ui, name, title, |ui| list.show(ui, name, heads, cx.model.generation));
            }
        });
    }
}

/// How many draws the kernels take together, and with which choices.
fn drawn_as(drawn: &DrawnPlan) -> String {
    let Fragment { targets, update, cull, until } = drawn.how;
    let draws: usize = drawn.kernels.iter().map(|kernel| kernel.draws.len()).sum();
    format!("Draws: {draws}, targets {targets}, update {update}, cull {cull}, until {until}")
}

fn section(ui: &mut Ui, id: &str, title: String, show: impl FnOnce(&mut Ui)) {
    CollapsingHeader::new(in_strong(title)).id_salt(id).default_open(true).show(ui, show);
}

/// Streams and buffers, the largest first, streams before buffers.
fn parts(plan: &Plan) -> Vec<Part> {
    let streams = plan.streams.iter().map(|s| Part { name: s.what.name(), bytes: s.bytes, is_stream: true });
    let buffers = plan.buffers.iter().map(|b| Part { name: b.what, bytes: b.bytes, is_stream: false });
    let mut parts: Vec<Part> = streams.chain(buffers).collect();
    parts.sort_by_key(|part| std::cmp::Reverse((part.is_stream, part.bytes)));
    parts
}

/// A bar of bytes: streams, then buffers.
fn bar(ui: &mut Ui, parts: &[Part]) {
    let whole: u64 = parts.iter().map(|part| part.bytes).sum();
    let width = ui.available_width().clamp(60.0, 900.0);
    let (rect, response) = ui.allocate_exact_size(vec2(width, 22.0), Sense::hover());
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
    let mut left = rect.left();
    let mut hovered = None;
    for (i, part) in parts.iter().enumerate() {
        let width = part.bytes as f32 / whole.max(1) as f32 * rect.width();
        let piece = Rect::from_min_max(pos2(left, rect.top()), pos2(left + width, rect.bottom()));
        left += width;
        // Neighbours of the same kind differ slightly.
        let shade = if i % 2 == 0 { 1.0 } else { 0.8 };
        let color = if part.is_stream { Color32::from_rgb(66, 124, 200) } else { Color32::from_rgb(90, 165, 90) };
        let color = towards(ui.visuals().extreme_bg_color, color, shade);
        painter.rect_filled(piece, 0.0, color);
        if part.name.len() as f32 * 7.0 < width {
            let font = FontId::proportional(SMALLEST);
            painter.text(piece.center(), Align2::CENTER_CENTER, part.name, font, ink_on(color));
        }
        if response.hover_pos().is_some_and(|at| piece.x_range().contains(at.x)) {
            hovered = Some(part);
        }
    }
    let text = format!("{} of memory: streams, then buffers", Bytes(whole));
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &text));
    if let Some(part) = hovered {
        let kind = if part.is_stream { "stream" } else { "buffer" };
        let share = part.bytes as f64 / whole.max(1) as f64 * 100.0;
        response.on_hover_text_at_pointer(format!("{kind} {}\n{}, {share:.1}%", part.name, Bytes(part.bytes)));
    }
}

#[cfg(test)]
mod tests {
    use raystep_kernels::{Limits, Options, RaySource};
    use raystep_scenes::generate;

    use super::*;

    #[test]
    fn every_byte_is_in_the_bar() {
        let scene = generate::cornell_box();
        let camera = scene.cameras[0].clone();
        let options = Options::new(RaySource::Camera { camera, width: 16, height: 8 });
        let plan = Plan::new(&scene, &options, &Limits::CPU).expect("a small scene").0;
        let parts = parts(&plan);
        assert_eq!(parts.iter().map(|part| part.bytes).sum::<u64>(), plan.bytes());
        assert!(parts.is_sorted_by_key(|part| std::cmp::Reverse((part.is_stream, part.bytes))));
        assert!(parts[0].is_stream && parts.last().is_some_and(|part| !part.is_stream));
    }
}
