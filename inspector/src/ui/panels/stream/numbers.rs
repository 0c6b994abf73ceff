//! Values drawn in texels that are large enough.

use crate::ui::panels::zoom::Placed;
use egui::{Align2, Color32, FontId, Rect, vec2};
use raystep_kernels::tables::stream::{Meaning, STATE_TAG};
use raystep_kernels::{Program, Stream, StreamData};

use crate::session::request::Texels;
use crate::ui::pane::Context;
use crate::ui::style::SMALLEST;
use crate::ui::units::Scale;

/// Points per texel at which values may fit.
const FROM: f32 = 40.0;
/// The largest text.
const LARGEST: f32 = 13.0;
/// Width of a monospaced character, as part of the font's size.
const ADVANCE: f32 = 0.62;
/// Height of a line, as part of the font's size.
const LINE: f32 = 1.1;

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
pub(super) fn draw(ui: &egui::Ui, cx: &Context<'_>, placed: &Placed, stream: Stream, whose: Whose<'_>) {
    let Placed { rect, origin, scale, .. } = *placed;
    if scale < FROM {
        return;
    }
    let Some(opened) = &cx.model.opened else { return };
    let in_units = Scale::in_scene(cx.display.units, &opened.data);
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
    let text_of = |x: u32, y: u32, layer: usize| {
        let at = y as usize * width as usize + x as usize;
        let bits = layers.get(layer).and_then(|values| values.get(at)).copied();
        bits.map_or_else(String::new, |bits| text(opened.plan.program, stream, layer, bits, &in_units))
    };
    let all = rows.clone().flat_map(|y| columns.clone().map(move |x| [x, y]));
    let texts: Vec<([u32; 2], Vec<String>)> =
        all.map(|[x, y]| ([x, y], (0..layers.len()).map(|layer| text_of(x, y, layer)).collect())).collect();
    let longest = texts.iter().flat_map(|(_, texts)| texts).map(|text| text.chars().count()).max().unwrap_or(0);
    let Some(size) = size(scale, layers.len(), longest) else { return };
    let painter = ui.painter().with_clip_rect(rect);
    for ([x, y], texts) in &texts {
        let middle = placed.middle([*x, *y]);
        for (layer, text) in texts.iter().enumerate() {
            let down = (layer as f32 - 0.5 * (layers.len() as f32 - 1.0)) * size * LINE;
            let at = middle + vec2(0.0, down);
            // Cut off at the edge, it would be a wrong number.
            let room = vec2(ADVANCE * text.chars().count() as f32, LINE) * size;
            if !rect.contains_rect(Rect::from_center_size(at, room)) {
                continue;
            }
            let font = FontId::monospace(size);
            for (dx, dy) in [(-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0)] {
                let shadow = Color32::from_black_alpha(150);
                painter.text(at + vec2(dx, dy), Align2::CENTER_CENTER, text, font.clone(), shadow);
            }
            painter.text(at, Align2::CENTER_CENTER, text, font, Color32::WHITE);
        }
    }
}

/// The size of text that fits in texels of this many points; `None` if it would be too small to read.
fn size(scale: f32, layers: usize, longest: usize) -> Option<f32> {
    let (high, wide) = (0.96 * scale / (LINE * layers.max(1) as f32), 0.96 * scale / (ADVANCE * longest.max(1) as f32));
    Some(high.min(wide).min(LARGEST)).filter(|&size| size >= SMALLEST)
}

/// A component in readable form.
fn text(program: &Program, stream: Stream, layer: usize, bits: u32, in_units: &Scale) -> String {
    if program.has_states(stream) && layer == STATE_TAG {
        return program.states.name(bits).into();
    }
    if stream.is_float_layer(layer) {
        let value = f32::from_bits(bits);
        let is_never = value.is_finite() && value >= raystep_kernels::shared::constants::INF;
        let is_t = stream.info().meaning.get(layer) == Some(&Meaning::Distance);
        return match is_never {
            true => "never".into(),
            false if is_t => format!("{:.4}", in_units.t(value)),
            false => format!("{value:.4}"),
        };
    }
    if bits == u32::MAX { "–".into() } else { bits.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_in_texels_fits_or_is_not_there() {
        for layers in 1..8 {
            for longest in 1..14 {
                for scale in (10..257).map(|scale| scale as f32) {
                    let Some(size) = size(scale, layers, longest) else { continue };
                    assert!((SMALLEST..=LARGEST).contains(&size), "{scale} {layers} {longest}: {size}");
                    assert!(size * LINE * layers as f32 <= scale && size * ADVANCE * longest as f32 <= scale);
                }
            }
        }
        assert_eq!(
            (size(46.0, 4, 7), size(52.0, 4, 7), size(256.0, 1, 3)),
            (None, Some(0.96 * 52.0 / 4.4), Some(13.0))
        );
    }
}
