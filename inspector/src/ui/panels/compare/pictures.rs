//! The pictures of two runs and their difference: side by side, or one of them in all of the panel.

use egui::{Color32, Rect, Sense, Stroke, Ui, vec2};
use raystep_kernels::Stream;
use raystep_kernels::tables::state::States;
use serde::{Deserialize, Serialize};

use super::Compare;
use crate::command::Command;
use crate::draw::stream::{self, Colors, Meaning};
use crate::session::Model;
use crate::ui::canvas::{Canvas, Moment};
use crate::ui::choice::Choices as _;
use crate::ui::pane::Context;
use crate::ui::panels::zoom::{Placed, Zoom};
use crate::ui::state::Asks;

/// What a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Side {
    A,
    B,
    Difference,
}

const SIDES: [Side; 3] = [Side::A, Side::B, Side::Difference];

/// How the runs are shown.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct Look {
    /// The picture that has all of the panel; all three side by side if there is none.
    pub(super) one: Option<Side>,
    /// The same for all pictures.
    pub(super) zoom: Zoom,
}

/// The inputs that the pictures were drawn from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Drawn {
    runs: [Moment; 2],
    stream: Stream,
    layer: usize,
    range: [f32; 2],
    size: [u32; 2],
    shown: Side,
    /// The picture's corner in pixels, and pixels per texel.
    placed: ([f32; 2], f32),
}

impl Compare {
    /// Which pictures are shown.
    pub(super) fn views(&mut self, ui: &mut Ui, asks: &mut Asks) {
        ui.horizontal_wrapped(|ui| {
            let views = [
                (None, "side by side"),
                (Some(Side::A), "A"),
                (Some(Side::B), "B"),
                (Some(Side::Difference), "difference"),
            ];
            for (one, name) in views {
                ui.choice_of(&mut self.look.one, one, name).on_hover_text("Shift shows the other run meanwhile");
            }
            let can = self.found.as_ref().is_some_and(|found| !found.rays.is_empty());
            let next = egui::Button::new(Command::NextDifferingRay.name());
            let about = Command::NextDifferingRay.key_text(ui.ctx());
            let response = ui.add_enabled(can, next).on_hover_text(about).on_disabled_hover_text("no ray differs");
            if response.clicked() {
                asks.commands.push(Command::NextDifferingRay);
            }
            if !self.look.zoom.is_fit() && ui.button("fit").clicked() {
                self.look.zoom.fit();
            }
        });
    }

    /// The pictures, in what is left of the panel.
    pub(super) fn pictures(&mut self, ui: &mut Ui, cx: &mut Context<'_>, names: &[String; 2], size: [u32; 2]) {
        const GAP: f32 = 6.0;
        const NAME: f32 = 18.0;
        let is_swapped = ui.input(|input| input.modifiers.shift) && ui.rect_contains_pointer(ui.max_rect());
        let room = ui.available_size();
        let shown: Vec<Side> = SIDES.into_iter().filter(|side| self.look.one.is_none_or(|one| one == *side)).collect();
        let count = shown.len() as f32;
        let width = ((room.x - GAP * (count - 1.0)) / count).max(16.0);
        let room = vec2(width, (room.y - NAME).max(16.0));
        ui.horizontal_top(|ui| {
            ui.spacing_mut().item_spacing.x = GAP;
            for (slot, side) in shown.into_iter().enumerate() {
                ui.vertical(|ui| {
                    ui.set_width(width);
                    let side = match (side, is_swapped) {
                        (Side::A, true) => Side::B,
                        (Side::B, true) => Side::A,
                        (side, _) => side,
                    };
                    let name = match side {
                        Side::A => format!("A: {}", names[0]),
                        Side::B => format!("B: {}", names[1]),
                        Side::Difference => self.legend(),
                    };
                    ui.small(name).on_hover_text("hold Shift to show the other run here");
                    let (rect, response) = ui.allocate_exact_size(room, Sense::click_and_drag());
                    self.look.zoom.follow(ui, &response, rect, vec2(size[0] as f32, size[1] as f32));
                    let placed = self.draw(ui, cx, side, slot, rect, size);
                    let texel = response.hover_pos().and_then(|at| placed.texel(at));
                    if let Some(texel) = texel {
                        cx.selection.hovered = Some(texel);
                        if response.clicked() {
                            cx.asks.select = Some(texel);
                        }
                    }
                    placed.mark(ui, cx.selection.hovered, 7.0, Stroke::new(1.5, Color32::from_white_alpha(140)));
                    placed.mark(ui, cx.selection.pixel, 7.0, Stroke::new(1.5, Color32::WHITE));
                    let what = match side {
                        Side::A => "run A",
                        Side::B => "run B",
                        Side::Difference => "difference",
                    };
                    let text = format!("{} of {what}", self.stream.name());
                    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &text));
                });
            }
        });
    }

    /// The range shared by both pictures.
    fn range(&self) -> [f32; 2] {
        self.found.as_ref().map_or([0.0, 1.0], |found| found.range)
    }

    /// The meaning of the difference's colours.
    fn legend(&self) -> String {
        match Meaning::of(self.stream, Some(self.layer)) {
            Meaning::Scalar | Meaning::Count => format!("A − B, from −{0:.1e} to {0:.1e}", self.spread()),
            _ => "where A and B differ".into(),
        }
    }

    /// The largest difference with a colour of its own: for counts a tenth of their range, for floats a thousandth.
    fn spread(&self) -> f32 {
        let part = if Meaning::of(self.stream, Some(self.layer)) == Meaning::Count { 0.1 } else { 1e-3 };
        let [lo, hi] = self.range();
        (hi - lo).abs().max(f32::MIN_POSITIVE) * part
    }

    fn draw(&mut self, ui: &Ui, cx: &Context<'_>, side: Side, slot: usize, rect: Rect, plan: [u32; 2]) -> Placed {
        let placed = self.look.zoom.place(rect, plan);
        let (Some(other), model, canvas) = (cx.other.as_deref(), &*cx.model, cx.canvas) else { return placed };
        let size = crate::ui::canvas::Picture::pixels(ui, rect);
        let now = [(model.edition, model.place), (other.edition, other.place)];
        self.hold(canvas, [model, other]);
        let of = |i: usize| self.stills[i].of(self.stream).filter(|(moment, _)| moment.0 == now[i].0);
        let stills = of(0).zip(of(1));
        let drawn = Drawn {
            runs: stills.map_or(now, |(a, b)| [a.0, b.0]),
            stream: self.stream,
            layer: self.layer,
            range: self.range(),
            size,
            shown: side,
            placed: (placed.offset(ui), placed.scale * ui.pixels_per_point()),
        };
        if stills.is_none() || drawn.runs != now {
            ui.ctx().request_repaint();
        }
        let largest = self.spread();
        let target = self.pictures[slot].target(canvas, size, self.drawn[slot] != Some(drawn));
        if let Some((((_, a), (_, b)), target)) = stills.zip(target) {
            let is_difference = side == Side::Difference;
            let states = model.opened.as_ref().map_or(States(&[]), |opened| opened.plan.program.states);
            let picture = stream::Picture {
                stream: self.stream,
                states,
                texture: if side == Side::B { b } else { a },
                minus: is_difference.then_some(b),
                layer: self.layer,
                meaning: Meaning::of(self.stream, Some(self.layer)),
                range: if is_difference { [-largest, largest] } else { drawn.range },
                exposure: 1.0,
                colors: if is_difference { Colors::Diverging } else { Colors::Viridis },
                offset: drawn.placed.0,
                scale: drawn.placed.1,
            };
            canvas.streams.draw(&picture, target);
            self.drawn[slot] = Some(drawn);
        }
        self.pictures[slot].show(ui, rect);
        placed
    }

    /// Holds the streams of both runs, so that they are drawn together.
    fn hold(&mut self, canvas: &std::sync::Arc<Canvas>, runs: [&Model; 2]) {
        for (still, run) in self.stills.iter_mut().zip(runs) {
            if let Some(texture) = run.drawn(self.stream) {
                still.take(canvas, (run.edition, run.place), self.stream, texture);
            }
        }
    }
}
