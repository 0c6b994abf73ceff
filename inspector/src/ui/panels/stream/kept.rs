//! A kept run in place of the current stream, with a label that says so.

use egui::{Align2, Color32, FontId, Rect, vec2};
use raystep_kernels::Stream;

use super::StreamView;
use super::numbers::Whose;
use crate::ui::pane::Context;

impl StreamView {
    /// The kept run that is shown in place of the stream, if any.
    pub(super) fn take_kept(&mut self, cx: &mut Context<'_>, stream: Stream) {
        let opened = cx.model.opened.as_ref().filter(|_| self.pinned.is_none());
        self.kept = opened.and_then(|opened| cx.runs.shown(cx.canvas, opened, stream));
    }

    /// Whether the stream of a kept run is shown.
    pub(super) fn is_kept(&self) -> bool {
        self.kept.as_ref().is_some_and(|kept| kept.texture.is_some())
    }

    /// Draws the label of the kept run that is shown; returns it as the beginning of a sentence.
    pub(super) fn kept_label(&self, ui: &egui::Ui, rect: Rect) -> String {
        let Some(kept) = &self.kept else { return String::new() };
        let font = FontId::proportional(13.0);
        let painter = ui.painter().with_clip_rect(rect);
        let width = (rect.width() - 20.0).max(20.0);
        let text = painter.layout(kept.label.clone(), font, Color32::WHITE, width);
        let label = Align2::LEFT_TOP.anchor_size(rect.min + vec2(8.0, 6.0), text.size());
        painter.rect_filled(label.expand2(vec2(5.0, 3.0)), 3.0, Color32::from_black_alpha(215));
        painter.galley(label.min, text, Color32::WHITE);
        format!("{}: ", kept.label)
    }

    /// Whose values texels show.
    pub(super) fn whose(&self, stream: Stream) -> Whose<'_> {
        match &self.kept {
            _ if self.pinned.is_some() => Whose::Nobody,
            Some(kept) => kept.values(stream).map_or(Whose::Run, Whose::Kept),
            None => Whose::Run,
        }
    }
}
