//! The cost of every ray as colours over the picture.

use crate::ui::canvas::WHOLE;
use crate::ui::panels::zoom::Placed;
use egui::{Color32, ColorImage, Sense, Stroke, TextureHandle, TextureOptions, Ui, vec2};
use raystep_kernels::Stream;
use raystep_kernels::tables::kernel::Role;

use super::scale::Scale;
use super::source::{Of, Sorted};
use crate::draw::stream::{self, Colors, Meaning};
use crate::ui::canvas::{Moment, Picture, Still};
use crate::ui::pane::Context;
use crate::ui::panels::zoom::Zoom;
use crate::ui::style::strong;

/// Colours of the texture of costs.
const SHADES: usize = 256;
/// The colour of the pixels of a selected warp.
const WARP: Color32 = Color32::from_rgb(255, 80, 200);

/// What the colours are of.
pub(super) struct Heat<'a> {
    pub(super) of: Of,
    pub(super) sorted: &'a Sorted,
    pub(super) scale: Scale,
    /// How much of the picture they cover, 0 to 1.
    pub(super) opacity: f32,
    /// The lowest and highest cost of the rays to show alone.
    pub(super) only: Option<[u32; 2]>,
}

/// The inputs of the texture of costs.
type Colored = (Of, Scale, Option<[u32; 2]>);

/// The inputs of the picture below.
#[derive(Clone, Copy, PartialEq)]
struct Drawn {
    moment: Moment,
    stream: Stream,
    offset: [f32; 2],
    scale: f32,
    size: [u32; 2],
}

/// The picture.
#[derive(Default)]
pub(super) struct HeatView {
    pub(super) zoom: Zoom,
    picture: Picture,
    /// The last picture of this run with colours, and the current states of rays.
    color: Still,
    state: Still,
    drawn: Option<Drawn>,
    colored: Option<(Colored, TextureHandle)>,
}

impl HeatView {
    /// Shows it in this height. `marked` are rays to frame.
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        cx: &mut Context<'_>,
        heat: Option<&Heat<'_>>,
        marked: &[u32],
        height: f32,
    ) {
        let Some([width, rows]) = cx.model.opened.as_ref().map(|opened| [opened.plan.width, opened.plan.height]) else {
            return;
        };
        let size = vec2(width as f32, rows as f32);
        let room = vec2(ui.available_width(), height).max(vec2(32.0, 32.0));
        let (rect, response) = ui.allocate_exact_size(room, Sense::click_and_drag());
        self.zoom.follow(ui, &response, rect, size);
        let placed = self.zoom.place(rect, [width, rows]);
        self.paint_below(ui, cx, &placed, heat.is_some_and(|heat| heat.of.place.is_none()));
        if let Some(heat) = heat {
            let texture = self.texture(ui, heat, [width, rows]);
            let opacity = if heat.only.is_some() { 1.0 } else { heat.opacity };
            let painter = ui.painter().with_clip_rect(rect.intersect(ui.clip_rect()));
            painter.image(texture, placed.whole(), WHOLE, Color32::WHITE.gamma_multiply(opacity));
        }
        for &ray in marked {
            let pixel = [ray % width.max(1), ray / width.max(1)];
            placed.mark(ui, Some(pixel), 2.0, Stroke::new(1.0, WARP));
        }
        placed.mark_clearly(ui, cx.selection.pixel, Color32::WHITE);
        let text = match heat {
            Some(heat) => format!(
                "heatmap of {} by {rows} pixels: {} from 0 to {}",
                width,
                heat.of.shown.unit(),
                heat.sorted.spread.most
            ),
            None => format!("picture of {width} by {rows} pixels, without costs"),
        };
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &text));
        if let Some(texel) =
            response.interact_pointer_pos().filter(|_| response.clicked()).and_then(|at| placed.texel(at))
        {
            cx.asks.select = Some(texel);
        }
        let Some([x, y]) = response.hover_pos().and_then(|at| placed.texel(at)) else { return };
        cx.selection.hovered = Some([x, y]);
        let order = heat.map(|heat| &heat.sorted.order);
        let ray = y as usize * width as usize + x as usize;
        if let Some((heat, (cost, rank))) = heat.zip(order.and_then(|o| o.cost(ray).zip(o.rank(ray)))) {
            response.on_hover_ui_at_pointer(|ui| {
                strong(ui, format!("pixel {x},{y}: {cost} {}", heat.of.shown.unit()));
                ui.label(format!(
                    "{} of {} by cost; click to select the ray",
                    rank + 1,
                    heat.sorted.order.rays().len()
                ));
            });
        }
    }

    /// The picture that costs are laid over: colours if the run has them, else the states of its rays.
    fn paint_below(&mut self, ui: &Ui, cx: &Context<'_>, placed: &Placed, is_of_end: bool) {
        let Some(opened) = &cx.model.opened else { return };
        let now = (cx.model.edition, cx.model.place);
        let color = opened.plan.streams.iter().map(|planned| planned.what).find(|stream| stream.is_color());
        let is_shaded =
            cx.model.last_pass().is_some_and(|pass| matches!(pass.kernel.role(), Role::Finish | Role::Sample));
        let take = |still: &mut Still, stream: Option<Stream>| {
            if let Some((stream, texture)) = stream.and_then(|s| Some((s, cx.model.drawn(s)?))) {
                still.take(cx.canvas, now, stream, texture);
            }
        };
        if is_shaded {
            take(&mut self.color, color);
        } else {
            take(&mut self.state, opened.plan.program.state_stream());
        }
        let of = |still: &Still, stream: Option<Stream>| {
            let (moment, texture) = still.of(stream?).filter(|(moment, _)| moment.0 == now.0)?;
            Some((stream?, moment, texture.clone()))
        };
        let (colored, states) = (of(&self.color, color), of(&self.state, opened.plan.program.state_stream()));
        let first = if is_shaded || is_of_end { colored.or(states) } else { states };
        let Some((stream, moment, texture)) = first else {
            ui.ctx().request_repaint();
            return;
        };
        let size = Picture::pixels(ui, placed.rect);
        let scale = placed.scale * ui.pixels_per_point();
        let drawn = Drawn { moment, stream, offset: placed.offset(ui), scale, size };
        if let Some(target) = self.picture.target(cx.canvas, size, self.drawn != Some(drawn)) {
            let meaning = Meaning::of(stream, None);
            cx.canvas.streams.draw(
                &stream::Picture {
                    stream,
                    states: opened.plan.program.states,
                    texture: &texture,
                    minus: None,
                    layer: 0,
                    meaning,
                    range: [0.0, 1.0],
                    exposure: 1.0,
                    colors: Colors::Gray,
                    offset: drawn.offset,
                    scale: drawn.scale,
                },
                target,
            );
            self.drawn = Some(drawn);
        }
        self.picture.show(ui, placed.rect);
    }

    fn texture(&mut self, ui: &Ui, heat: &Heat<'_>, size: [u32; 2]) -> egui::TextureId {
        let now = (heat.of, heat.scale, heat.only);
        if let Some((known, texture)) = &self.colored
            && *known == now
        {
            return texture.id();
        }
        let most = ui.ctx().input(|input| input.max_texture_side);
        let image = image(heat.sorted.order.costs(), size, heat.scale, heat.sorted.spread.most, heat.only, most);
        let texture = ui.ctx().load_texture("cost", image, TextureOptions::NEAREST);
        let id = texture.id();
        self.colored = Some((now, texture));
        id
    }
}

/// Costs as colours, one texel per ray, or for several if the image has more than `most_side` on a side. Rays that cost
/// anything else than `only` are dark.
fn image(
    costs: &[u32],
    [width, height]: [u32; 2],
    scale: Scale,
    most: u32,
    only: Option<[u32; 2]>,
    most_side: usize,
) -> ColorImage {
    let shades: Vec<Color32> = (0..SHADES).map(|i| scale.color(i as f64 / (SHADES - 1) as f64)).collect();
    // Few different costs: each has its colour once.
    let shade = |cost: u32| shades[(scale.part(f64::from(cost), most) * (SHADES - 1) as f64).round() as usize];
    let by_cost: Vec<Color32> = (0..=most.min(1 << 16)).map(shade).collect();
    let color = |cost: u32| match only {
        Some([from, to]) if !(from..=to).contains(&cost) => Color32::from_black_alpha(215),
        _ => by_cost.get(cost as usize).copied().unwrap_or_else(|| shade(cost)),
    };
    let [width, height] = [width as usize, height as usize];
    let step = width.max(height).div_ceil(most_side.max(1)).max(1);
    let size = [width.div_ceil(step), height.div_ceil(step)];
    let rays = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| y * step * width + x * step));
    let pixels = rays.map(|ray| costs.get(ray).map_or(Color32::TRANSPARENT, |&cost| color(cost)));
    ColorImage::new(size, pixels.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_those_of_the_axis_and_a_bar_alone_stays_lit() {
        let scale = Scale::default();
        let costs = [0, 10, 5, 10, 0];
        let whole = image(&costs, [3, 2], scale, 10, None, 100);
        assert_eq!((whole.size, whole.pixels[0], whole.pixels[1]), ([3, 2], scale.color(0.0), scale.color(1.0)));
        assert_eq!(whole.pixels[5], Color32::TRANSPARENT, "no ray is there");
        let lit = image(&costs, [3, 2], scale, 10, Some([4, 6]), 100);
        let is_lit: Vec<usize> = (0..5).filter(|&i| lit.pixels[i] == whole.pixels[i]).collect();
        assert_eq!(is_lit, [2]);
        assert_eq!(image(&costs, [3, 2], scale, 10, None, 2).size, [2, 1], "no larger than a texture may be");
    }
}
