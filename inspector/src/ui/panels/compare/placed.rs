//! Where a picture is.

use egui::{Color32, Rect, Ui, vec2};

/// Where a picture is in its panel.
pub(super) struct Placed {
    pub(super) origin: egui::Pos2,
    pub(super) scale: f32,
}

impl Placed {
    pub(super) fn texel(&self, at: egui::Pos2, [width, height]: [u32; 2]) -> Option<[u32; 2]> {
        let texel = (at - self.origin) / self.scale;
        let inside = texel.x >= 0.0 && texel.y >= 0.0 && texel.x < width as f32 && texel.y < height as f32;
        inside.then_some([texel.x as u32, texel.y as u32])
    }

    pub(super) fn mark(&self, ui: &Ui, rect: Rect, texel: Option<[u32; 2]>, color: Color32) {
        let Some([x, y]) = texel else { return };
        let middle = self.origin + vec2(x as f32 + 0.5, y as f32 + 0.5) * self.scale;
        let frame = Rect::from_center_size(middle, egui::Vec2::splat(self.scale.max(7.0)));
        let stroke = egui::Stroke::new(1.5, color);
        ui.painter().with_clip_rect(rect).rect_stroke(frame, 0.0, stroke, egui::StrokeKind::Outside);
    }
}
