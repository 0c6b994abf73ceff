//! The rays in which two kept runs differ, as a picture and in numbers.

use crate::ui::choice::Choices as _;
use crate::ui::panels::zoom::Placed;
use std::sync::Arc;

use egui::{Color32, Sense, Ui, vec2};
use raystep_kernels::Stream;
use raystep_kernels::executor::gpu::StreamTexture;
use raystep_kernels::tables::state::States;
use raystep_lab::flip::Errors;
use raystep_lab::text::counted;

use super::super::legend::{Entry, line};
use crate::command::Command;
use crate::draw::stream::{self, Colors, Meaning, drawable};
use crate::runs::differ::{Aspect, CLASSES, Counts, Differences};
use crate::ui::canvas::{Canvas, Picture};
use crate::ui::pane::Context;
use crate::ui::state::kept_runs::Question;

/// Of rays that hit in one run only: that of an infinity in stream views.
const ONE_SIDED: Color32 = Color32::from_rgb(242, 51, 26);

/// The view.
#[derive(Default)]
pub(super) struct DifferenceView {
    /// The values on the GPU, and what they are of.
    values: Option<(Question, StreamTexture)>,
    picture: Picture,
    drawn: Option<(Question, [u32; 2], [f32; 2])>,
    /// The range of each aspect: that of the first pair, for all pairs after it.
    ranges: [Option<[f32; 2]>; 4],
}

impl DifferenceView {
    pub(super) fn tools(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        ui.separator();
        for aspect in Aspect::ALL {
            ui.choice_of(&mut cx.runs.aspect, aspect, aspect.name());
        }
        let can = cx.runs.why_not_compared().is_none();
        let next = egui::Button::new(Command::NextDifferingRay.name());
        let about = format!(
            "selects the next ray that differs in {} ({})",
            cx.runs.aspect.name(),
            Command::NextDifferingRay.key_text(ui.ctx())
        );
        if ui.add_enabled(can, next).on_hover_text(about).clicked() {
            cx.asks.commands.push(Command::NextDifferingRay);
        }
    }

    pub(super) fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        if let Some(why) = cx.runs.why_not_compared() {
            if cx.runs.runs.list().len() > 1 {
                ui.label(why);
            }
            return;
        }
        cx.runs.compare(cx.model);
        let names = cx.runs.pair().map(|pair| pair.map(|kept| kept.name.clone()));
        let stream = cx.runs.pair().and_then(|[a, _]| Some(a.picture.as_ref().ok()?.results.color));
        let Some((question, found)) = cx.runs.differences() else {
            if cx.model.is_busy() {
                ui.spinner();
            } else {
                ui.weak("The comparison was cancelled, or failed; see the log.");
            }
            return;
        };
        let (Some([reference, compared]), Some(stream)) = (names, stream) else { return };
        let (question, aspect) = (*question, question.1);
        if self.values.as_ref().is_none_or(|(of, _)| *of != question) {
            self.values = Some((question, upload(cx.canvas, found)));
        }
        let range = *self.ranges[aspect as usize].get_or_insert_with(|| fitted(aspect, found));
        ui.label(format!("{compared} against {reference}: {}", sentence(&found.counts)));
        let mut is_refit = false;
        ui.horizontal_wrapped(|ui| is_refit = legend(ui, aspect, range));
        if is_refit {
            self.ranges[aspect as usize] = Some(fitted(aspect, found));
        }
        let (size, text) = (found.size, describe(aspect, found));
        let (selected, hovered) = self.paint(ui, cx, question, stream, range, size, &text);
        if let Some(hovered) = hovered {
            cx.selection.hovered = Some(hovered);
        }
        if selected.is_some() {
            cx.asks.select = selected;
        }
    }

    /// Draws the picture; returns the ray that was clicked, and the one under the cursor.
    #[expect(clippy::too_many_arguments)]
    fn paint(
        &mut self,
        ui: &mut Ui,
        cx: &Context<'_>,
        question: Question,
        stream: Stream,
        range: [f32; 2],
        [width, height]: [u32; 2],
        text: &str,
    ) -> (Option<[u32; 2]>, Option<[u32; 2]>) {
        let room = ui.available_size().max(vec2(64.0, 64.0));
        let scale = (room.x / width as f32).min(room.y / height as f32);
        let (rect, response) = ui.allocate_exact_size(vec2(width as f32, height as f32) * scale, Sense::click());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, text));
        let pixels = Picture::pixels(ui, rect);
        let placed = Placed { rect, origin: rect.min, scale, size: [width, height] };
        let now = (question, pixels, range);
        let target = self.picture.target(cx.canvas, pixels, self.drawn != Some(now));
        if let Some(((_, texture), target)) = self.values.as_ref().zip(target) {
            let picture = stream::Picture {
                stream,
                states: States(&[]),
                texture,
                minus: None,
                layer: 0,
                meaning: Meaning::Scalar,
                range,
                exposure: 1.0,
                colors: colors(question.1),
                offset: [0.0; 2],
                scale: scale * ui.pixels_per_point(),
            };
            cx.canvas.streams.draw(&picture, target);
            self.drawn = Some(now);
        }
        self.picture.show(ui, rect);
        let selected = cx.selection.pixel.filter(|[x, y]| *x < width && *y < height);
        placed.mark(ui, selected, 9.0, egui::Stroke::new(1.5, Color32::WHITE));
        let texel = response.hover_pos().and_then(|at| placed.texel(at));
        (texel.filter(|_| response.clicked()), texel)
    }
}

/// FLIP's authors draw it in magma.
fn colors(aspect: Aspect) -> Colors {
    if matches!(aspect, Aspect::Distance | Aspect::Flip) { Colors::Magma } else { Colors::Viridis }
}

/// A range for the values of a pair: whole powers of ten for distances.
fn fitted(aspect: Aspect, found: &Differences) -> [f32; 2] {
    match aspect {
        // Other bits of the same triangle are the darkest, as they are the most.
        Aspect::Triangle => [1.0, (CLASSES.len() - 1) as f32],
        Aspect::Distance => found.range().map_or([-8.0, 0.0], |[lo, hi]| [lo.floor(), hi.ceil().max(lo.floor() + 1.0)]),
        // Of all pairs on one scale.
        Aspect::Flip => [0.0, 1.0],
        Aspect::Color => [0.0, found.range().map_or(1.0, |[_, hi]| if hi > 0.0 { hi } else { 1.0 })],
    }
}

/// The meaning of colours; returns whether the range is to be fitted again.
fn legend(ui: &mut Ui, aspect: Aspect, [lo, hi]: [f32; 2]) -> bool {
    let patch = |value: f32, name: String| {
        let [r, g, b] = colors(aspect).at(f64::from((value - lo) / (hi - lo)));
        Entry::new(Color32::from_rgb(r, g, b), name, "")
    };
    let mut entries = vec![Entry::new(Color32::from_rgb(28, 28, 33), "same bits", "")];
    match aspect {
        Aspect::Triangle => {
            let classes = CLASSES.iter().enumerate().skip(1);
            entries.extend(classes.map(|(class, name)| patch(class as f32, (*name).into())));
        }
        Aspect::Distance => {
            let powers = [lo, (0.5 * (lo + hi)).round(), hi];
            entries.extend(powers.map(|power| patch(power, format!("|Δt| = 1e{power}"))));
            entries.push(Entry::new(ONE_SIDED, CLASSES[3], ""));
        }
        Aspect::Color => {
            entries.extend([lo, 0.5 * (lo + hi), hi].map(|value| patch(value, format!("{value:.2e}"))));
        }
        Aspect::Flip => entries.extend([0.0, 0.25, 0.5, 0.75, 1.0].map(|value| patch(value, value.to_string()))),
    }
    line(ui, &entries);
    let about = "Fits the range to this pair. Otherwise it stays the same for all pairs.";
    let has_range = matches!(aspect, Aspect::Distance | Aspect::Color);
    has_range && ui.button("Fit range").on_hover_text(about).clicked()
}

/// How many rays differ in which way.
fn sentence(counts: &Counts) -> String {
    let Counts { hit_or_miss, triangle, t, weights, color, .. } = *counts;
    if hit_or_miss + triangle + t + weights + color == 0 {
        return format!("no ray differs: the same bits for all of {}", counted(counts.rays, "ray"));
    }
    let mut parts = vec![
        format!("{} differ in triangle", counts.triangle),
        format!("{} hit in only one of the runs", counts.hit_or_miss),
    ];
    parts.push(match counts.t {
        0 => "0 differ in t".into(),
        t => format!("{t} differ in t, by up to {} ulp or {:.2e} in scene units", counts.max_ulps, counts.max_t),
    });
    parts.push(format!("{} only in barycentric weights", counts.weights));
    parts.push(match counts.color {
        0 => "0 differ in colour".into(),
        color => format!("{color} differ in colour, by up to {:.2e}", counts.max_color),
    });
    if let Some(Errors { rmse, mae }) = counts.errors.filter(|errors| errors.rmse > 0.0) {
        parts.push(format!("RMSE {rmse:.2e}, MAE {mae:.2e} in linear light"));
    }
    if let Some(flip) = counts.flip {
        parts.push(format!("mean FLIP {flip:.4}"));
    }
    format!("of {}, {}", counted(counts.rays, "ray"), parts.join("; "))
}

/// The picture, for screen readers.
fn describe(aspect: Aspect, found: &Differences) -> String {
    format!("map of {} that differ in {}", counted(found.rays.len(), "ray"), aspect.name())
}

fn upload(canvas: &Arc<Canvas>, found: &Differences) -> StreamTexture {
    let [width, height] = found.size;
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
    let texture = drawable(&canvas.gpu.device, "differences of kept runs", wgpu::TextureFormat::R32Float, size);
    canvas.gpu.write_texture(texture.as_image_copy(), size, bytemuck::cast_slice(&found.values));
    texture
}
