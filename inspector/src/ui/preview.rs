//! The preview of a scene that is being opened: shown in place of a stream, as what it is, until the run has a picture.

use super::canvas::WHOLE;
use egui::{Color32, ColorImage, Rect, Sense, TextureHandle, TextureOptions, Ui, vec2};

use crate::session::preview::Preview;
use crate::session::{Model, Work};
use crate::ui::style::strong;

/// A preview as a texture.
pub(super) struct PreviewTexture {
    texture: TextureHandle,
}

impl PreviewTexture {
    /// Of a preview.
    pub(super) fn new(ctx: &egui::Context, preview: &Preview) -> Self {
        let image = ColorImage::from_rgb(preview.size.map(|side| side as usize), &preview.rgb);
        Self { texture: ctx.load_texture("preview", image, TextureOptions::LINEAR) }
    }

    /// Shows the picture below a line that says what it is, and how far the run has got.
    pub(super) fn show(&self, ui: &mut Ui, model: &Model) {
        let [width, height] = self.texture.size();
        let progress = progress(model.work);
        ui.horizontal_wrapped(|ui| {
            strong(ui, "Preview");
            ui.label(format!("{width} × {height} pixels, without steps. The run: {progress}"));
        });
        let size = ui.available_size().max(vec2(16.0, 16.0));
        let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
        let side = self.texture.size_vec2();
        let scale = (rect.width() / side.x).min(rect.height() / side.y);
        let picture = Rect::from_center_size(rect.center(), side * scale);
        ui.painter().image(self.texture.id(), picture, WHOLE, Color32::WHITE);
        let about = format!("preview of {width} × {height} pixels; the run: {progress}");
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &about));
    }
}

/// What the run is doing, in a few words.
fn progress(work: Option<Work>) -> String {
    match work {
        Some(Work { what, done, of }) if of > 0 => format!("{what}, {} %", 100 * done.min(of) / of),
        Some(work) => work.what.into(),
        None => "waiting".into(),
    }
}
