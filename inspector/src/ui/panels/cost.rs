//! Where the cost is: every ray's as a heatmap, their distribution, the most expensive rays, and the use of lanes.
//!
//! Touches: selection, asks, log.

mod curve;
mod heat;
mod histogram;
mod known;
mod lanes;
mod rays;
pub(super) mod scale;
mod source;
mod spread;
mod warps;

use egui::{ScrollArea, Slider, Ui, vec2};
use serde::{Deserialize, Serialize};
use smart_default::SmartDefault;

use super::table::{Table, version};
use crate::command::{Command, PaneKind};
use crate::draw::stream::Colors;
use crate::ui::choice::Choices as _;
use crate::ui::pane::{Context, NO_RAYS, Panel};
use crate::ui::style::strong;
use heat::{Heat, HeatView};
use histogram::Histogram;
use known::Known;
use rays::{pixel_of, ray_at, step};
use scale::Scale;
use source::Shown;
use warps::{WarpsView, Width};

/// What is beside the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
enum Section {
    #[default]
    Histogram,
    Rays,
    Warps,
}

/// Saved: what is shown.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, SmartDefault)]
#[serde(default)]
struct Look {
    shown: Shown,
    section: Section,
    scale: Scale,
    /// Of the colours over the picture.
    #[default(1.0)]
    opacity: f32,
    /// Even if the costs of the whole run are known.
    is_up_to_here: bool,
    width: Width,
}

/// The panel.
#[derive(Default)]
pub(in crate::ui) struct Cost {
    look: Look,
    known: Known,
    heat: HeatView,
    /// The bar of the histogram whose rays are shown alone.
    bin: Option<(Shown, bool, usize)>,
    table: Table,
    warps: WarpsView,
}

impl Panel for Cost {
    fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        let Some(opened) = &cx.model.opened else {
            ui.weak("Open a scene to see the cost of its rays.");
            return;
        };
        let width = opened.plan.width;
        if !cx.has_rays() {
            ui.weak(NO_RAYS);
            return;
        }
        self.update(cx);
        if let Some((of, sorted)) = self.known.shown(cx, &self.look, &self.warps) {
            strong(ui, sorted.spread.sentence(of.shown.unit()));
        }
        let size = ui.available_size();
        if size.x > 700.0 {
            ui.horizontal_top(|ui| {
                let down = egui::Layout::top_down(egui::Align::Min);
                ui.allocate_ui_with_layout(vec2(size.x * 0.48, size.y), down, |ui| {
                    self.tools(ui, cx);
                    let height = ui.available_height();
                    self.picture(ui, cx, height);
                });
                ui.allocate_ui_with_layout(ui.available_size(), down, |ui| {
                    self.sections(ui);
                    ScrollArea::vertical()
                        .id_salt("beside")
                        .auto_shrink(false)
                        .show(ui, |ui| self.section(ui, cx, width));
                });
            });
        } else {
            ScrollArea::vertical().id_salt("all").auto_shrink(false).show(ui, |ui| {
                self.tools(ui, cx);
                self.picture(ui, cx, (size.y * 0.6).max(140.0));
                self.sections(ui);
                self.section(ui, cx, width);
            });
        }
    }

    fn save(&self) -> String {
        serde_json::to_string(&self.look).unwrap_or_default()
    }

    fn load(&mut self, saved: &str) {
        let look: Look = serde_json::from_str(saved).unwrap_or_default();
        let opacity = if look.opacity.is_finite() { look.opacity.clamp(0.0, 1.0) } else { Look::default().opacity };
        self.look = Look { opacity, width: look.width.checked(), ..look };
    }

    fn command(&mut self, command: Command, cx: &mut Context<'_>) -> bool {
        let is_dearer = match command {
            Command::PreviousRayByCost => true,
            Command::NextRayByCost => false,
            _ => return false,
        };
        self.update(cx);
        let Some(width) = cx.model.opened.as_ref().map(|opened| opened.plan.width) else { return false };
        let Some((_, sorted)) = self.known.shown(cx, &self.look, &self.warps) else {
            cx.log.say(false, "rays are not sorted by cost yet: the run needs counters");
            return true;
        };
        let selected = cx.selection.pixel.map(|pixel| ray_at(pixel, width));
        if let Some(ray) = step(&sorted.order, selected, is_dearer) {
            cx.asks.select = Some(pixel_of(ray, width));
        }
        true
    }
}

impl Cost {
    fn update(&mut self, cx: &mut Context<'_>) {
        self.warps.update(cx, self.look.width);
        self.known.update(cx, &self.look);
        if self.bin.is_some_and(|(shown, is_log, _)| (shown, is_log) != (self.look.shown, self.look.scale.is_log)) {
            self.bin = None;
        }
    }

    fn tools(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        ui.horizontal_wrapped(|ui| {
            strong(ui, "cost").on_hover_text("what counts as the cost of a ray");
            for (shown, name, about) in Shown::ALL {
                let choice = ui.choice(self.look.shown == shown, name);
                if choice.on_hover_text(about).clicked() {
                    self.look.shown = shown;
                }
            }
            ui.separator();
            for colors in [Colors::Viridis, Colors::Cividis] {
                ui.choice_of(&mut self.look.scale.colors, colors, colors.name());
            }
            ui.checkbox(&mut self.look.scale.is_log, "log").on_hover_text("logarithmic colours and bars");
            let label = ui.label("overlay").on_hover_text("how much of the picture the colours cover").id;
            ui.spacing_mut().slider_width = 70.0;
            let slider = Slider::new(&mut self.look.opacity, 0.0..=1.0).show_value(false);
            ui.add(slider).labelled_by(label);
            if !self.heat.zoom.is_fit()
                && ui.button("fit").on_hover_text("show the whole picture (double click)").clicked()
            {
                self.heat.zoom.fit();
            }
        });
        self.known.tools(ui, cx, &mut self.look, &self.warps);
    }

    fn picture(&mut self, ui: &mut Ui, cx: &mut Context<'_>, height: f32) {
        let marked = match self.look.section {
            Section::Warps => self.warps.warp().map_or(&[][..], |warp| &warp.rays),
            Section::Histogram | Section::Rays => &[],
        };
        let shown = self.known.shown(cx, &self.look, &self.warps);
        let heat = shown.as_ref().map(|(of, sorted)| {
            let most = sorted.spread.most;
            let only = self.bin.and_then(|(_, is_log, bin)| sorted.spread.bins(is_log).range(bin, most));
            Heat { of: *of, sorted, scale: self.look.scale, opacity: self.look.opacity, only }
        });
        let mut height = height;
        if let Some(heat) = &heat {
            let (rect, response) = ui.allocate_exact_size(vec2(seen_width(ui), scale::HEIGHT), egui::Sense::hover());
            let painter = ui.painter_at(rect);
            self.look.scale.paint(ui, &painter, rect, heat.sorted.spread.most);
            let text = format!("colours from 0 to {} {}", heat.sorted.spread.most, self.look.shown.unit());
            response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &text));
            response.on_hover_text(text);
            height -= scale::HEIGHT + ui.spacing().item_spacing.y;
        }
        self.heat.show(ui, cx, heat.as_ref(), marked, height.max(60.0));
    }

    fn sections(&mut self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            for (section, name, about) in [
                (Section::Histogram, "Distribution", "number of rays at each cost"),
                (Section::Rays, "Rays", "rays from the most expensive to the cheapest"),
                (Section::Warps, "Warps", "useful lanes of every pass, and the slowest warps"),
            ] {
                if ui.choice(self.look.section == section, name).on_hover_text(about).clicked() {
                    self.look.section = section;
                }
            }
        });
    }

    fn section(&mut self, ui: &mut Ui, cx: &mut Context<'_>, width: u32) {
        if self.look.section == Section::Warps {
            self.warps.show(ui, cx, &mut self.look.width);
            return;
        }
        let Some((of, sorted)) = self.known.shown(cx, &self.look, &self.warps) else { return };
        let of = version((cx.model.generation, cx.model.edition, format!("{of:?}")));
        match self.look.section {
            Section::Histogram => {
                let is_log = self.look.scale.is_log;
                let selected = cx.selection.pixel.and_then(|pixel| sorted.order.cost(ray_at(pixel, width)));
                let picked = self.bin.map(|(.., bin)| bin);
                let (spread, scale, unit) = (&sorted.spread, self.look.scale, self.look.shown.unit());
                let histogram = Histogram { spread, scale, unit, picked, selected };
                let clicked = histogram.show(ui, ui.available_height().clamp(140.0, 420.0));
                if let Some(bin) = clicked {
                    self.bin = (picked != Some(bin)).then_some((self.look.shown, is_log, bin));
                }
                match self.bin.map(|(.., bin)| (sorted.spread.bins(is_log), bin)) {
                    Some((bins, bin)) => {
                        let [from, to] = bins.range(bin, sorted.spread.most).unwrap_or_default();
                        let rays = bins.counts.get(bin).copied().unwrap_or(0);
                        ui.horizontal_wrapped(|ui| {
                            ui.label(format!("Shown alone: {rays} rays with {from} to {to} {unit}."));
                            if ui.button("Show all").clicked() {
                                self.bin = None;
                            }
                        });
                    }
                    None => drop(ui.weak("Click a bar to show its rays alone, a pixel to select its ray.")),
                }
            }
            Section::Rays => {
                rays::summary(ui, cx, &sorted, width, (ui.available_height() * 0.35).clamp(80.0, 160.0));
                let room = vec2(seen_width(ui), ui.available_height().max(180.0));
                ui.allocate_ui(room, |ui| rays::list(ui, cx, &sorted, width, of, &mut self.table));
            }
            Section::Warps => {}
        }
    }
}

/// The width that is left and seen: what is above may be wider than the panel.
fn seen_width(ui: &Ui) -> f32 {
    ui.available_width().min(ui.clip_rect().right() - ui.cursor().left() - 2.0).max(80.0)
}

/// A button that shows the options.
fn to_options(ui: &mut Ui, cx: &mut Context<'_>) {
    if ui.button("Options").clicked() {
        cx.asks.commands.push(Command::Show(PaneKind::Options));
    }
}
