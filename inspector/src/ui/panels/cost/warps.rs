//! Warps: how many of the lanes that run in lockstep had work, pass by pass, and which warps took longest, and why.

mod chart;
mod survey;
mod table;

use std::sync::Arc;

use egui::{Ui, vec2};
use raystep_kernels::{Gpu, Kernel};
use raystep_lab::work::{WIDTHS, Warp};
use serde::{Deserialize, Serialize};
use smart_default::SmartDefault;

use super::lanes::LanesView;
use crate::session::request::Request;
use crate::settings::DeviceKind;
use crate::ui::choice::Choices as _;
use crate::ui::pane::Context;
use crate::ui::panels::chart::kernel_color;
use crate::ui::style::strong;
use chart::Bar;
pub(super) use survey::{SURVEYING, Surveyed};

/// The saved part: lanes per warp.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, SmartDefault)]
pub(super) struct Width(#[default(32)] usize);

impl Width {
    /// As saved, if it is possible.
    pub(super) fn checked(self) -> Self {
        if WIDTHS.contains(&self.0) { self } else { Self::default() }
    }
}

/// This section of the panel.
#[derive(Default)]
pub(super) struct WarpsView {
    known: Option<Arc<Surveyed>>,
    /// The bars, and what they were made from.
    bars: Option<((u64, usize, bool), Vec<Bar>)>,
    /// The kernel shown alone.
    only: Option<Kernel>,
    selected: Option<usize>,
    lanes: LanesView,
}

impl WarpsView {
    /// Takes an answer, and forgets what is of another run.
    pub(super) fn update(&mut self, cx: &mut Context<'_>, width: Width) {
        while let Some(answer) = cx.model.take_answer::<Surveyed>(SURVEYING) {
            (self.known, self.bars, self.selected) = (Some(Arc::from(answer)), None, None);
        }
        let is_of = |known: &Arc<Surveyed>| (known.edition, known.lanes) == (cx.model.edition, width.0);
        if !self.known.as_ref().is_some_and(is_of) && self.known.take().is_some() {
            (self.bars, self.only, self.selected) = (None, None, None);
        }
    }

    /// What is known of all passes.
    pub(super) fn surveyed(&self) -> Option<&Arc<Surveyed>> {
        self.known.as_ref()
    }

    /// The warp that was clicked.
    pub(super) fn warp(&self) -> Option<&Warp> {
        self.known.as_ref()?.slowest.get(self.selected?)
    }

    /// Asks for a second run.
    pub(super) fn ask(cx: &mut Context<'_>, width: Width) {
        let (edition, lanes) = (cx.model.edition, width.0);
        cx.model.ask(Request::Job(SURVEYING, survey::survey(edition, lanes)));
    }

    pub(super) fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>, width: &mut Width) {
        let Some((plan, device)) = cx.model.opened.as_ref().map(|o| (o.plan.clone(), o.settings.device)) else {
            return;
        };
        ui.horizontal_wrapped(|ui| {
            ui.label("lanes per warp").on_hover_text("threads that run in lockstep");
            for choice in WIDTHS {
                if ui.choice(width.0 == choice, choice.to_string()).clicked() {
                    width.0 = choice;
                }
            }
        });
        ui.label(mapping(&cx.canvas.gpu, device, width.0, plan.features.live_lists));
        let key = (cx.model.edition, cx.model.passes.len(), self.known.is_some());
        if self.bars.as_ref().is_none_or(|(known, _)| *known != key) {
            let bars = match &self.known {
                Some(known) => chart::bars_of_lanes(&known.passes, known.lanes),
                None => chart::bars_of_passes(&cx.model.passes, &plan),
            };
            self.bars = Some((key, bars));
        }
        let bars = self.bars.as_ref().map_or(&[][..], |(_, bars)| bars);
        if bars.is_empty() {
            ui.weak("No pass has run yet.");
        } else {
            kernels(ui, bars, &mut self.only);
            if let Some(pass) = chart::show(ui, bars, self.only, cx.model.place, 110.0) {
                cx.asks.go_to = Some(pass + 1);
            }
        }
        let Some(known) = self.known.clone() else {
            ui.horizontal_wrapped(|ui| {
                let button = egui::Button::new("Analyse the warps of all passes");
                let about = "Runs all passes again, in a run of its own, and reads the states of all rays after each.";
                if ui.add_enabled(!cx.model.is_busy(), button).on_hover_text(about).clicked() {
                    Self::ask(cx, *width);
                }
                ui.label("to see how full the busy warps are, and which are slowest.");
            });
            self.lanes.show(ui, cx);
            return;
        };
        ui.separator();
        strong(ui, "slowest warps");
        ui.label(match known.is_listed {
            true => {
                "Lists are rebuilt in every pass, so warps are full and rays move between warps. Here rays stay grouped \
                 with their first neighbours, to show what the longest walk would hold up without lists."
            }
            false => {
                "Every pass launches all pixels, so a warp keeps the same rays, and ends when its longest walk does."
            }
        });
        if let Some(warp) = self.warp() {
            strong(ui, table::reason(warp, known.counts.as_ref(), plan.width));
        }
        let room = vec2(ui.available_width(), ui.available_height().clamp(150.0, 320.0));
        let clicked = ui.allocate_ui(room, |ui| table::show(ui, &known.slowest, self.selected, plan.width)).inner;
        if let Some(warp) = clicked.and_then(|at| known.slowest.get(at)) {
            self.selected = clicked;
            cx.asks.select = Some(super::rays::pixel_of(warp.slowest as usize, plan.width));
        }
        self.lanes.show(ui, cx);
    }
}

/// Which threads are taken to run together, in a sentence or two.
fn mapping(gpu: &Gpu, device: DeviceKind, lanes: usize, is_listed: bool) -> String {
    let order = match is_listed {
        true => "in the lists, as if workgroups finished in the order of their indices",
        false => "by their local index in the workgroup",
    };
    let [least, most] = [gpu.info.subgroup_min_size, gpu.info.subgroup_max_size];
    let own = match device {
        DeviceKind::Cpu | DeviceKind::CpuF64 => {
            "The CPU has no warps: these are the warps that a GPU would run.".into()
        }
        _ if least == most => format!("This adapter's subgroups have {most} threads."),
        _ => format!("This adapter's subgroups have {least} to {most} threads."),
    };
    format!("Assumed: a warp is {lanes} neighbouring threads {order}; no stream records the real subgroups. {own}")
}

/// Kernels with their mean shares; a click shows one alone.
fn kernels(ui: &mut Ui, bars: &[Bar], only: &mut Option<Kernel>) {
    egui::Grid::new("kernels").num_columns(5).min_col_width(10.0).spacing(vec2(14.0, 2.0)).show(ui, |ui| {
        let heads = [
            ("", ""),
            ("kernel", "click to show one alone"),
            ("passes", "passes with rays to work on"),
            ("of busy warps", "share of lanes with work, of the warps with any work: the pale bars"),
            ("of all", "share of lanes with work, of all that are launched: the full bars"),
        ];
        heads.into_iter().for_each(|(head, about)| drop(strong(ui, head).on_hover_text(about)));
        ui.end_row();
        for of in chart::by_kernel(bars) {
            let (patch, _) = ui.allocate_exact_size(vec2(10.0, 10.0), egui::Sense::hover());
            ui.painter().rect_filled(patch, 2.0, kernel_color(of.kernel));
            let is_chosen = *only == Some(of.kernel);
            if ui.choice(is_chosen, of.kernel.name()).clicked() {
                *only = (!is_chosen).then_some(of.kernel);
            }
            let percent = |share: f64| format!("{:.1}%", share * 100.0);
            let useful = of.useful.map_or_else(|| "not counted".into(), percent);
            for cell in [of.passes.to_string(), useful, percent(of.of_all)] {
                ui.monospace(format!("{cell:>11}"));
            }
            ui.end_row();
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_widths_that_divide_a_workgroup_are_loaded() {
        assert_eq!((Width(64).checked(), Width(0).checked(), Width(33).checked()), (Width(64), Width(32), Width(32)));
    }
}
