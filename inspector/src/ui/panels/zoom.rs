//! Zoom and position of a picture in a panel.

use egui::{Pos2, Rect, Response, Ui, Vec2, vec2};
use serde::{Deserialize, Serialize};

/// The smallest and largest scale, relative to the one at which the picture fits its panel.
const RANGE: [f32; 2] = [0.25, 400.0];

/// The visible part of a picture; by default all of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct Zoom {
    /// Points per unit of the picture; `None` fits it to the panel.
    scale: Option<f32>,
    /// The point of the picture in the middle of the panel.
    center: [f32; 2],
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

    /// Follows wheel, pinch and drag; a double click fits the picture.
    pub(super) fn follow(&mut self, ui: &Ui, response: &Response, rect: Rect, size: Vec2) {
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
            let fit = fit(rect, size);
            let point = (at - origin) / scale;
            let scale = (scale * zoom).clamp(RANGE[0] * fit, RANGE[1] * fit);
            self.show(scale, point + (rect.center() - at) / scale);
        } else if response.dragged() && response.drag_delta() != Vec2::ZERO {
            self.show(scale, (rect.center() - origin - response.drag_delta()) / scale);
        }
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
