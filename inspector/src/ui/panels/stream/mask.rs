//! The mask of a branch over a stream's picture, and its legend.

use crate::ui::canvas::WHOLE;
use crate::ui::panels::zoom::Placed;
use std::sync::Arc;

use egui::{Color32, ColorImage, TextureHandle, TextureOptions};

use super::super::legend::{Entry, line};
use crate::ui::mask::{Mask, Outcome};
use crate::ui::pane::Context;
use crate::ui::style::strong;

/// The picture of a mask.
#[derive(Default)]
pub(super) struct Overlay {
    drawn: Option<(Arc<Mask>, TextureHandle)>,
}

/// The mask, if it is of this run and this place.
fn current(cx: &Context<'_>) -> Option<Arc<Mask>> {
    let now = (cx.model.generation, cx.model.place);
    cx.display.mask.clone().filter(|mask| (mask.generation, mask.place) == now)
}

/// A line about the mask, with a button that removes it.
pub(super) fn legend(ui: &mut egui::Ui, cx: &mut Context<'_>) {
    let Some(mask) = current(cx) else { return };
    strong(ui, mask.sentence());
    ui.horizontal_wrapped(|ui| {
        ui.small(&mask.what);
        let drawn = Outcome::DRAWN.into_iter().zip(mask.counts).filter(|(_, count)| *count > 0);
        let entries = drawn.map(|(outcome, count)| {
            let [name, meaning] = mask.words(outcome);
            Entry::new(outcome.color(), format!("{name} {count}"), meaning)
        });
        line(ui, &entries.collect::<Vec<_>>());
        if ui.small_button("Remove mask").clicked() {
            cx.display.mask = None;
        }
    });
}

impl Overlay {
    /// Draws the mask over the picture of a stream of this size.
    pub(super) fn draw(&mut self, ui: &egui::Ui, cx: &Context<'_>, placed: &Placed) {
        let Some(mask) = current(cx).filter(|mask| mask.size == placed.size) else {
            self.drawn = None;
            return;
        };
        if self.drawn.as_ref().is_none_or(|(drawn, _)| !Arc::ptr_eq(drawn, &mask)) {
            let pixels = mask.rays.iter().map(|ray| ray.over_picture()).collect::<Vec<_>>();
            let sides = mask.size.map(|side| side as usize);
            if pixels.len() != sides[0] * sides[1] {
                return;
            }
            let texture = ui.ctx().load_texture("mask", ColorImage::new(sides, pixels), TextureOptions::NEAREST);
            self.drawn = Some((mask, texture));
        }
        let Some((_, texture)) = &self.drawn else { return };
        ui.painter().with_clip_rect(placed.rect).image(texture.id(), placed.whole(), WHOLE, Color32::WHITE);
    }
}
