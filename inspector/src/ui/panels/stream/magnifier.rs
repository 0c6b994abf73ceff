//! The value of the texel under the cursor: a line at the edge of the picture, or an enlarged part of it with all
//! components beside the cursor.

use crate::ui::canvas::WHOLE;
use crate::ui::panels::zoom::Placed;
use egui::{
    Area, Color32, Frame, Grid, Id, Order, Pos2, Rect, RichText, Sense, Stroke, StrokeKind, Ui, Vec2, pos2, vec2,
};

use raystep_kernels::Stream;

use super::StreamView;
use super::paint::Drawn;
use super::tile::Tiles;
use super::values::{self, Reader, Value};
use crate::ui::canvas::Picture;
use crate::ui::pane::Context;
use crate::ui::style::strong;

/// Texels along a side of the enlarged part; odd, so that one is in the middle.
const TEXELS: f32 = 9.0;
/// Points per texel in it.
const SCALE: f32 = 14.0;
/// Distance from the texel, points.
const GAP: f32 = 12.0;

/// The enlarged part, between frames.
#[derive(Default)]
pub(super) struct Magnifier {
    picture: Picture,
    drawn: Option<Drawn>,
    tiles: Tiles,
}

impl StreamView {
    /// Shows the texel under the cursor; returns its value as the end of a sentence.
    pub(super) fn magnify(
        &mut self,
        ui: &Ui,
        cx: &mut Context<'_>,
        stream: Stream,
        texel: [u32; 2],
        response: &egui::Response,
        placed: &Placed,
    ) -> String {
        let Some(pointer) = response.hover_pos() else { return String::new() };
        let values = self.values(cx, stream, texel);
        let [x, y] = texel;
        let heading = format!("{} {x},{y}", stream.name());
        let line = match &values[..] {
            [] => format!("{x},{y}   reading…"),
            values => format!("{x},{y}   {}", values::line(values, cx.display.units)),
        };
        if cx.display.is_magnified {
            self.enlarge(ui, cx, stream, texel);
            let shown = Rect::from_center_size(placed.middle(texel), Vec2::splat(placed.scale));
            // A texel that is larger than the room beside it is left in view around the cursor.
            let near = Rect::from_center_size(pointer, vec2(160.0, 160.0));
            inset(ui, self.magnifier.picture.id(), shown.intersect(near), &heading, &values);
        } else {
            self::line(ui, response.rect, pointer, line.clone());
        }
        format!("; under the cursor {line}")
    }

    /// The components of a texel; empty while they are read.
    fn values(&mut self, cx: &mut Context<'_>, stream: Stream, texel: [u32; 2]) -> Vec<Value> {
        let Some(opened) = cx.model.opened.as_ref() else { return Vec::new() };
        let (plan, data) = (opened.plan.clone(), opened.data.clone());
        let t_scale = cx
            .model
            .history
            .as_ref()
            .filter(|history| history.pixel == texel && history.element.is_none())
            .map(|history| history.t_scale);
        let bits = match &self.pinned {
            Some(pinned) => self.magnifier.tiles.texel(cx.model, &cx.canvas.gpu, pinned, texel),
            None => {
                let read = cx.model.texels.iter().find(|t| t.stream == stream && t.place == cx.model.place);
                read.and_then(|read| read.texel(texel))
            }
        };
        let reader = Reader::new(plan.program, &data, stream, t_scale);
        let bits = bits.unwrap_or_default().into_iter().enumerate();
        bits.map(|(layer, bits)| reader.value(layer, bits)).collect()
    }

    /// Draws the texels around one, if they have changed.
    fn enlarge(&mut self, ui: &Ui, cx: &Context<'_>, stream: Stream, [x, y]: [u32; 2]) {
        let source = match &self.pinned {
            Some(pinned) => Some(&pinned.texture),
            None => self.still.of(stream).map(|(_, texture)| texture),
        };
        let states = cx.model.opened.as_ref().map(|opened| opened.plan.program.states);
        let (Some(texture), Some(drawn), Some(states)) = (source, self.drawn, states) else { return };
        let points = ui.pixels_per_point();
        let side = (TEXELS * SCALE * points).round().max(1.0);
        let scale = side / TEXELS;
        let first = [x, y].map(|at| at as f32 - 0.5 * (TEXELS - 1.0));
        let drawn = Drawn { offset: first.map(|at| -at * scale), scale, ..drawn };
        let is_changed = self.magnifier.drawn != Some(drawn);
        if let Some(target) = self.magnifier.picture.target(cx.canvas, [side as u32; 2], is_changed) {
            cx.canvas.streams.draw(&drawn.picture(states, texture), target);
            self.magnifier.drawn = Some(drawn);
        }
    }
}

/// Paints a line at the lower edge of the picture, or at the upper one where the cursor is low.
fn line(ui: &Ui, rect: Rect, pointer: Pos2, text: String) {
    let font = egui::TextStyle::Monospace.resolve(ui.style());
    let color = ui.visuals().strong_text_color();
    let galley = ui.painter().layout(text, font, color, (rect.width() - 12.0).max(60.0));
    let size = galley.size() + vec2(12.0, 6.0);
    let is_low = pointer.y > rect.bottom() - size.y - 0.2 * rect.height();
    let top = if is_low { rect.top() } else { rect.bottom() - size.y };
    let back = Rect::from_min_size(pos2(rect.left(), top), size);
    let painter = ui.painter().with_clip_rect(rect);
    painter.rect_filled(back, 2.0, ui.visuals().extreme_bg_color.gamma_multiply(0.92));
    painter.galley(back.min + vec2(6.0, 3.0), galley, color);
}

/// Shows the enlarged part beside a texel, with its components.
fn inset(ui: &Ui, picture: Option<egui::TextureId>, texel: Rect, heading: &str, values: &[Value]) {
    let id = Id::unique("magnifier");
    let screen = ui.ctx().content_rect();
    let size = ui.memory(|memory| memory.area_rect(id)).map_or(vec2(260.0, 240.0), |rect| rect.size());
    let place = place(texel, size, screen);
    let area = Area::new(id).order(Order::Tooltip).fixed_pos(place).interactable(false).constrain(false);
    area.show(ui.ctx(), |ui| {
        Frame::popup(ui.style()).show(ui, |ui| {
            ui.style_mut().wrap_mode = Some(egui::TextWrapMode::Extend);
            strong(ui, heading);
            let (rect, _) = ui.allocate_exact_size(vec2(TEXELS, TEXELS) * SCALE, Sense::hover());
            if let Some(picture) = picture {
                ui.painter().image(picture, rect, WHOLE, Color32::WHITE);
            }
            let middle = Rect::from_center_size(rect.center(), vec2(SCALE, SCALE));
            ui.painter().rect_stroke(middle, 0.0, Stroke::new(3.0, Color32::BLACK), StrokeKind::Outside);
            ui.painter().rect_stroke(middle, 0.0, Stroke::new(1.5, Color32::WHITE), StrokeKind::Outside);
            if values.is_empty() {
                ui.label("reading…");
            }
            Grid::new("values of a texel").num_columns(4).spacing([10.0, 2.0]).show(ui, |ui| {
                for value in values {
                    ui.label(value.name);
                    ui.label(RichText::new(&value.text).monospace().strong());
                    ui.label(RichText::new(format!("0x{:08x}", value.bits)).monospace());
                    ui.label(value.more.as_deref().unwrap_or_default());
                    ui.end_row();
                }
            });
        });
    });
}

/// Beside the texel, on the side where there is room: the texel itself stays in view.
fn place(texel: Rect, size: egui::Vec2, screen: Rect) -> Pos2 {
    let right = texel.right() + GAP;
    let left = texel.left() - GAP - size.x;
    let x = if right + size.x <= screen.right() || left < screen.left() { right } else { left };
    let below = texel.bottom() + GAP;
    let y = if below + size.y <= screen.bottom() { below } else { texel.top() - GAP - size.y };
    pos2(x, y.max(screen.top()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inset_is_beside_the_texel_wherever_it_is() {
        let screen = Rect::from_min_size(Pos2::ZERO, vec2(1280.0, 720.0));
        let size = vec2(300.0, 260.0);
        for x in (0..1280).step_by(40) {
            for y in (0..720).step_by(40) {
                for side in [1.0, 9.0, 120.0] {
                    let texel = Rect::from_min_size(pos2(x as f32, y as f32), vec2(side, side));
                    let inset = Rect::from_min_size(place(texel, size, screen), size);
                    assert!(!inset.intersects(texel), "{texel:?} {inset:?}");
                    let seen = inset.intersect(screen);
                    assert!(seen.area() >= 0.99 * inset.area(), "{texel:?} {inset:?}");
                }
            }
        }
    }
}
