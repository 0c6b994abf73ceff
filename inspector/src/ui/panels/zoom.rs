//! Zoom and position of a picture in a panel.

use egui::{Color32, Pos2, Rect, Response, Stroke, StrokeKind, Ui, Vec2, vec2};
use serde::{Deserialize, Serialize};

/// The smallest and largest scale, relative to the one at which the picture fits its panel.
const RANGE: [f32; 2] = [0.25, 400.0];

/// The visible part of a picture; by default all of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct Zoom {
    /// Points per unit of the picture; `None` fits it to the panel.
    pub(super) scale: Option<f32>,
    /// The point of the picture in the middle of the panel.
    pub(super) center: [f32; 2],
}

impl Zoom {
    /// Points per unit of a picture of this size, and the position of its upper left corner.
    pub(super) fn placement(&self, rect: Rect, size: Vec2) -> (f32, Pos2) {
        let fit = fit(rect, size);
        match self.scale.filter(|scale| scale.is_finite() && *scale > 0.0) {
            Some(scale) => (scale, rect.center() - vec2(self.center[0], self.center[1]) * scale),
            None => (fit, rect.center() - 0.5 * fit * size),
        }
    }

    /// Where a picture of so many texels is.
    pub(super) fn place(&self, rect: Rect, size: [u32; 2]) -> Placed {
        let (scale, origin) = self.placement(rect, vec2(size[0] as f32, size[1] as f32));
        Placed { rect, origin, scale, size }
    }

    /// Follows wheel, pinch and drag; a double click fits the picture.
    pub(super) fn follow(&mut self, ui: &Ui, response: &Response, rect: Rect, size: Vec2) {
        self.follow_within(ui, response, rect, size, RANGE.map(|part| part * fit(rect, size)));
    }

    /// The same within a range of scales.
    pub(super) fn follow_within(&mut self, ui: &Ui, response: &Response, rect: Rect, size: Vec2, range: [f32; 2]) {
        let (scale, origin) = self.placement(rect, size);
        let zoom = match response.hovered() {
            true => ui.input(|input| input.zoom_delta() * (input.smooth_scroll_delta().y / 200.0).exp()),
            false => 1.0,
        };
        if response.double_clicked() {
            self.fit();
        } else if zoom != 1.0
            && let Some(at) = response.hover_pos()
        {
            let point = (at - origin) / scale;
            let scale = (scale * zoom).clamp(range[0], range[1]);
            self.show(scale, point + (rect.center() - at) / scale);
        } else if response.dragged() && response.drag_delta() != Vec2::ZERO {
            self.show(scale, (rect.center() - origin - response.drag_delta()) / scale);
        }
    }

    /// All of the picture in place of what is not finite.
    pub(super) fn finite(self) -> Self {
        let is_finite = self.center.iter().chain(&self.scale).all(|v| v.is_finite());
        if is_finite { self } else { Self::default() }
    }

    /// Shows all of the picture.
    pub(super) fn fit(&mut self) {
        self.scale = None;
    }

    /// Whether all of it is shown.
    pub(super) fn is_fit(&self) -> bool {
        self.scale.is_none()
    }

    fn show(&mut self, scale: f32, center: Vec2) {
        if scale.is_finite() && center.is_finite() {
            (self.scale, self.center) = (Some(scale), [center.x, center.y]);
        }
    }
}

/// Where a picture is in its panel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placed {
    /// The part of the panel that shows it.
    pub(super) rect: Rect,
    /// Its upper left corner.
    pub(super) origin: Pos2,
    /// Points per texel.
    pub(super) scale: f32,
    /// Its texels.
    pub(super) size: [u32; 2],
}

impl Placed {
    /// All of it on the screen.
    pub(super) fn whole(&self) -> Rect {
        Rect::from_min_size(self.origin, vec2(self.size[0] as f32, self.size[1] as f32) * self.scale)
    }

    /// Its corner within the visible part, in pixels.
    pub(super) fn offset(&self, ui: &Ui) -> [f32; 2] {
        let offset = (self.origin - self.rect.min) * ui.pixels_per_point();
        [offset.x, offset.y]
    }

    /// The texel at a point.
    pub(super) fn texel(&self, at: Pos2) -> Option<[u32; 2]> {
        let texel = (at - self.origin) / self.scale;
        let [width, height] = self.size.map(|side| side as f32);
        let inside = texel.x >= 0.0 && texel.y >= 0.0 && texel.x < width && texel.y < height;
        inside.then_some([texel.x as u32, texel.y as u32])
    }

    /// The middle of a texel.
    pub(super) fn middle(&self, [x, y]: [u32; 2]) -> Pos2 {
        self.origin + vec2(x as f32 + 0.5, y as f32 + 0.5) * self.scale
    }

    /// A frame around a texel, of at least so many points.
    pub(super) fn mark(&self, ui: &Ui, texel: Option<[u32; 2]>, least: f32, stroke: Stroke) {
        let Some(texel) = texel else { return };
        let frame = Rect::from_center_size(self.middle(texel), Vec2::splat(self.scale.max(least)));
        ui.painter().with_clip_rect(self.rect).rect_stroke(frame, 0.0, stroke, StrokeKind::Outside);
    }

    /// A frame that is visible on any picture.
    pub(super) fn mark_clearly(&self, ui: &Ui, texel: Option<[u32; 2]>, color: Color32) {
        self.mark(ui, texel, 9.0, Stroke::new(3.0, Color32::from_black_alpha(160)));
        self.mark(ui, texel, 9.0, Stroke::new(1.5, color));
    }
}

fn fit(rect: Rect, size: Vec2) -> f32 {
    let scale = (rect.width() / size.x).min(rect.height() / size.y);
    if scale.is_finite() && scale > 0.0 { scale } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use egui::pos2;

    use super::*;

    #[test]
    fn a_picture_fits_until_it_is_zoomed_and_stays_finite() {
        let rect = Rect::from_min_size(pos2(10.0, 20.0), vec2(200.0, 100.0));
        let mut zoom = Zoom::default();
        assert_eq!(zoom.placement(rect, vec2(50.0, 50.0)), (2.0, pos2(60.0, 20.0)));
        zoom.show(4.0, vec2(25.0, 25.0));
        assert_eq!(zoom.placement(rect, vec2(50.0, 50.0)), (4.0, pos2(10.0, -30.0)));
        zoom.show(f32::NAN, Vec2::ZERO);
        assert!(!zoom.is_fit() && zoom.scale == Some(4.0));
        zoom.fit();
        assert_eq!(zoom.placement(rect, Vec2::ZERO).0, 1.0);
    }
}
