//! The picture of a stream, drawn again where it differs.

use crate::ui::panels::zoom::Placed;
use egui::{Rect, vec2};
use raystep_kernels::Stream;
use raystep_kernels::executor::gpu::StreamTexture;
use raystep_kernels::tables::state::States;

use super::StreamView;
use crate::draw::picture::picture;
use crate::draw::stream::{Colors, Meaning, Picture};
use crate::ui::canvas::Moment;
use crate::ui::pane::Context;
use crate::ui::state::kept_runs::Flipped;

/// The inputs that the picture was drawn from: it is only redrawn if they change.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Drawn {
    pub(super) moment: Moment,
    pub(super) stream: Stream,
    pub(super) layer: usize,
    pub(super) meaning: Meaning,
    pub(super) range: [f32; 2],
    pub(super) exposure: f32,
    pub(super) colors: Colors,
    pub(super) offset: [f32; 2],
    pub(super) scale: f32,
}

impl Drawn {
    /// What it shows, wherever it is in its panel.
    pub(super) fn of(self) -> Self {
        Self { offset: [0.0; 2], scale: 1.0, ..self }
    }

    /// The picture of a texture.
    pub(super) fn picture(self, states: States, texture: &StreamTexture) -> Picture<'_> {
        let Self { stream, layer, meaning, range, exposure, colors, offset, scale, moment: _ } = self;
        Picture { stream, states, texture, minus: None, layer, meaning, range, exposure, colors, offset, scale }
    }
}

impl StreamView {
    /// The stream in the colours of the view, with a pixel for each texel.
    pub(super) fn texels(&self, cx: &Context<'_>) -> Option<wgpu::Texture> {
        let (drawn, states) = (self.drawn?.of(), cx.model.opened.as_ref()?.plan.program.states);
        let kept = self.kept.as_ref().and_then(|kept| kept.texture.as_ref()).map(|(_, texture)| texture);
        let texture = match &self.pinned {
            Some(pinned) => &pinned.texture,
            None => kept.or_else(|| Some(self.still.of(drawn.stream)?.1))?,
        };
        let target = picture(&cx.canvas.gpu.device, [texture.width(), texture.height()]);
        cx.canvas.streams.draw(&drawn.picture(states, texture), &target.create_view(&Default::default()));
        Some(target)
    }

    pub(super) fn paint(
        &mut self,
        ui: &egui::Ui,
        cx: &mut Context<'_>,
        placed: &Placed,
        stream: Stream,
        layer: Option<usize>,
        meaning: Meaning,
    ) {
        let (rect, scale) = (placed.rect, placed.scale);
        let size = crate::ui::canvas::Picture::pixels(ui, rect);
        let now = (cx.model.edition, cx.model.place);
        // While the run moves between two places, the last valid snapshot stays.
        if let Some(texture) = self.pinned.is_none().then(|| cx.model.drawn(stream)).flatten() {
            self.still.take(cx.canvas, now, stream, texture);
        }
        // Until the picture of another run is there, the last one stays, if it has the same size.
        let size_now = cx.model.texture(stream).map(StreamTexture::size);
        let still = self.still.of(stream).filter(|(at, t)| at.0 == now.0 || Some(t.size()) == size_now);
        let glimpse = cx.model.glimpse.as_ref().filter(|g| g.stream == stream && meaning == Meaning::Color);
        let glimpse = glimpse.filter(|_| self.pinned.is_none() && !self.is_kept());
        let source = match (&self.pinned, &self.kept, glimpse) {
            (Some(pinned), ..) => Some((now, &pinned.texture)),
            (None, Some(Flipped { texture: Some((moment, texture)), .. }), _) => Some((*moment, texture)),
            // No run has so many passes.
            (None, _, Some(glimpse)) => Some(((glimpse.index, usize::MAX), &glimpse.texture)),
            (None, _, None) => still,
        };
        if glimpse.is_none() && !self.is_kept() && source.is_none_or(|(moment, _)| moment != now) {
            cx.display.is_behind = true;
            ui.ctx().request_repaint();
        }
        let Some((moment, texture)) = source else { return };
        let scale = match glimpse.zip(size_now) {
            Some((glimpse, size)) => scale * size.width as f32 / glimpse.texture.width() as f32,
            None => scale,
        };
        let Some(states) = cx.model.opened.as_ref().map(|opened| opened.plan.program.states) else { return };
        let (range, colors) = (self.range(), self.colors(stream, layer.unwrap_or(0)));
        let drawn = Drawn {
            moment,
            stream,
            layer: layer.unwrap_or(0),
            meaning,
            range: match meaning {
                Meaning::Color => [self.look.offset, 1.0],
                Meaning::Scalar | Meaning::Count => range,
                // It becomes known later, but has no effect.
                Meaning::Id | Meaning::Tag => [0.0, 1.0],
            },
            exposure: self.look.exposure,
            colors,
            offset: placed.offset(ui),
            scale: scale * ui.pixels_per_point(),
        };
        let is_chosen = self.look.stream.is_some() || self.look.layer.is_some();
        let view = is_chosen.then_some((stream, layer));
        if self.pinned.is_none() {
            cx.display.thumbs.look(view);
        }
        if let Some(target) = self.picture.target(cx.canvas, size, self.drawn != Some(drawn)) {
            let picture = drawn.picture(states, texture);
            cx.canvas.streams.draw(&picture, target);
            if self.pinned.is_none() && self.drawn.is_none_or(|before| before.of() != drawn.of()) {
                cx.display.thumbs.take(cx.canvas, moment, view, &picture);
            }
            self.drawn = Some(drawn);
        }
        self.picture.show(ui, rect);
        if self.pinned.is_none() {
            let picture =
                Rect::from_min_size(placed.origin, scale * vec2(texture.width() as f32, texture.height() as f32));
            cx.display.thumbs.cover(ui, rect, picture, moment.1, cx.asks.scrub.wanted());
        }
    }
}
