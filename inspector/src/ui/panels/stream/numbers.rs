//! Values drawn in texels that are large enough.

use egui::{Align2, Color32, FontId, Pos2, Rect, vec2};
use raystep_kernels::tables::stream::STATE_TAG;
use raystep_kernels::{Program, Stream, StreamData};

use crate::session::request::Texels;
use crate::ui::pane::Context;
use crate::ui::style::SMALLEST;

/// Width of a character, as a part of the font's size.
const CHARACTER: f32 = 0.61;
/// Characters that a value takes at most.
const CHARACTERS: f32 = 7.0;

/// Whose values are drawn.
pub(super) enum Whose<'a> {
    /// The current run's.
    Run,
    /// A kept run's.
    Kept(&'a StreamData),
    /// None: they are not known.
    Nobody,
}

/// Draws the values of visible texels.
pub(super) fn draw(
    ui: &egui::Ui,
    cx: &Context<'_>,
    rect: Rect,
    scale: f32,
    origin: Pos2,
    stream: Stream,
    whose: Whose<'_>,
) {
    let count = stream.layers();
    let size = (scale / (count as f32 + 1.0)).min(scale / CHARACTERS).min(13.0);
    if size < SMALLEST {
        return;
    }
    let Some(opened) = &cx.model.opened else { return };
    let is_now = |t: &&Texels| t.stream == stream && t.place == cx.model.place;
    let layers: Vec<&[u32]>;
    let (width, height) = match whose {
        Whose::Nobody => return,
        Whose::Kept(data) => {
            layers = (0..stream.layers()).map(|layer| data.layer(layer)).collect();
            (data.width, data.height)
        }
        Whose::Run => {
            let Some(texels) = cx.model.texels.iter().find(is_now) else { return };
            layers = (0..stream.layers()).map(|layer| texels.layer(layer)).collect();
            let [_, _, width, height] = texels.region;
            (width, height)
        }
    };
    let first = (rect.min - origin) / scale;
    let last = (rect.max - origin) / scale;
    let columns = first.x.max(0.0) as u32..(last.x.max(0.0).ceil() as u32).min(width);
    let rows = first.y.max(0.0) as u32..(last.y.max(0.0).ceil() as u32).min(height);
    let count = layers.len();
    let painter = ui.painter().with_clip_rect(rect);
    for y in rows {
        for x in columns.clone() {
            let middle = origin + vec2(x as f32 + 0.5, y as f32 + 0.5) * scale;
            for (layer, values) in layers.iter().enumerate() {
                let Some(&bits) = values.get((y * width + x) as usize) else { continue };
                let text = text(opened.plan.program, stream, layer, bits);
                let down = (layer as f32 - 0.5 * (count as f32 - 1.0)) * size * 1.1;
                let at = middle + vec2(0.0, down);
                // Cut off at the edge, it would be a wrong number.
                let room = vec2(CHARACTER * text.chars().count() as f32, 1.2) * size;
                if !rect.contains_rect(Rect::from_center_size(at, room)) {
                    continue;
                }
                let font = FontId::monospace(size);
                for (dx, dy) in [(-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0)] {
                    painter.text(
                        at + vec2(dx, dy),
                        Align2::CENTER_CENTER,
                        &text,
                        font.clone(),
                        Color32::from_black_alpha(150),
                    );
                }
                painter.text(at, Align2::CENTER_CENTER, &text, font, Color32::WHITE);
            }
        }
    }
}

/// A component in readable form.
fn text(program: &Program, stream: Stream, layer: usize, bits: u32) -> String {
    if program.state_stream() == Some(stream) && layer == STATE_TAG {
        return program.states.name(bits).into();
    }
    if stream.is_float_layer(layer) {
        let value = f32::from_bits(bits);
        let is_never = value.is_finite() && value >= raystep_kernels::shared::constants::INF;
        return if is_never { "never".into() } else { format!("{value:.4}") };
    }
    if bits == u32::MAX { "–".into() } else { bits.to_string() }
}
