//! The cost of rays, from the most expensive to the cheapest, and how many threads have a ray to process.

mod curve;
mod lanes;

use curve::Curve;
use egui::{ScrollArea, Ui};
use lanes::LanesView;
use raystep_lab::work::{CostOrder, Measure, costs};
use serde::{Deserialize, Serialize};

use super::table::{Head, Rows, Table, View, version};
use crate::session::Edit;
use crate::session::request::{JobContext, JobFuture, Request};
use crate::ui::command::Command;
use crate::ui::pane::{Context, NO_RAYS, PaneKind, Panel};

/// The engine's job, named while it runs.
const SORTING: &str = "sorting rays by cost";
/// Most rays in the list; the curve includes all.
const MOST_LISTED: usize = 1000;

/// The key of the order.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Of {
    generation: u64,
    /// Edits by hand: they change the cost of rays.
    edits: Vec<Edit>,
    measure: Measure,
}

/// The rays in order.
struct Sorted {
    order: CostOrder,
    curve: Curve,
    /// Fraction of the total cost in the most expensive 1% and 10%.
    dearest: [f64; 2],
}

/// Saved: what is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
enum Shown {
    #[default]
    Sum,
    Cells,
    Triangles,
}

impl Shown {
    fn measure(self) -> Measure {
        match self {
            Self::Sum => Measure::Sum,
            Self::Cells => Measure::Cells,
            Self::Triangles => Measure::Triangles,
        }
    }
}

/// The panel.
#[derive(Default)]
pub(in crate::ui) struct Cost {
    shown: Shown,
    asked: Option<Of>,
    sorted: Option<(Of, Sorted)>,
    table: Table,
    lanes: LanesView,
}

impl Panel for Cost {
    fn title(&self) -> String {
        "Cost".into()
    }

    fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        if cx.model.opened.is_none() {
            ui.weak("Open a scene to see the cost of its rays.");
            return;
        }
        if !cx.has_rays() {
            ui.weak(NO_RAYS);
            return;
        }
        let of = self.of(cx);
        self.take(cx, of.as_ref());
        let size = ui.available_size();
        if size.x > 700.0 {
            ui.horizontal_top(|ui| {
                let half = egui::vec2(size.x * 0.5, size.y);
                let down = egui::Layout::top_down(egui::Align::Min);
                ui.allocate_ui_with_layout(half, down, |ui| {
                    ScrollArea::vertical().id_salt("order").auto_shrink(false).show(ui, |ui| {
                        self.order(ui, cx, of.as_ref(), size.y * 0.4);
                        self.lanes.show(ui, cx);
                    });
                });
                ui.allocate_ui_with_layout(ui.available_size(), down, |ui| self.list(ui, cx));
            });
        } else {
            ScrollArea::vertical().id_salt("all").auto_shrink(false).show(ui, |ui| {
                self.order(ui, cx, of.as_ref(), 90.0);
                let list = egui::vec2(ui.available_width(), (size.y * 0.4).max(140.0));
                ui.allocate_ui(list, |ui| self.list(ui, cx));
                self.lanes.show(ui, cx);
            });
        }
    }

    fn save(&self) -> String {
        serde_json::to_string(&self.shown).unwrap_or_default()
    }

    fn load(&mut self, saved: &str) {
        self.shown = serde_json::from_str(saved).unwrap_or_default();
    }

    fn command(&mut self, command: Command, cx: &mut Context<'_>) -> bool {
        let is_dearer = match command {
            Command::PreviousRayByCost => true,
            Command::NextRayByCost => false,
            _ => return false,
        };
        let of = self.of(cx);
        self.take(cx, of.as_ref());
        let Some(width) = cx.model.opened.as_ref().map(|opened| opened.plan.width) else { return false };
        let Some(order) = self.sorted(of.as_ref()).map(|sorted| &sorted.order) else {
            cx.shared.say(false, "rays are not sorted by cost yet: run to the end, with counters enabled");
            return true;
        };
        if let Some(ray) = step(order, cx.shared.pixel.map(|pixel| ray_at(pixel, width)), is_dearer) {
            cx.shared.select = Some(pixel_of(ray, width));
        }
        true
    }
}

/// The next or previous ray in the order; the most expensive one without a selection. `None` at either end.
fn step(order: &CostOrder, ray: Option<usize>, is_dearer: bool) -> Option<usize> {
    match ray.filter(|&ray| order.rank(ray).is_some()) {
        Some(ray) if is_dearer => order.dearer(ray),
        Some(ray) => order.cheaper(ray),
        None => order.dearest(),
    }
}

fn ray_at([x, y]: [u32; 2], width: u32) -> usize {
    y as usize * width as usize + x as usize
}

fn pixel_of(ray: usize, width: u32) -> [u32; 2] {
    let width = width.max(1) as usize;
    [(ray % width) as u32, (ray / width) as u32]
}

impl Cost {
    /// The order to ask for; `None` while not all passes are known.
    fn of(&self, cx: &Context<'_>) -> Option<Of> {
        let model = &cx.model;
        let (generation, measure) = (model.generation, self.shown.measure());
        model.is_complete.then(|| Of { generation, edits: model.edits.clone(), measure })
    }

    fn sorted(&self, of: Option<&Of>) -> Option<&Sorted> {
        self.sorted.as_ref().filter(|(known, _)| Some(known) == of).map(|(_, sorted)| sorted)
    }

    /// Takes the answer; asks for it when the run is at its end.
    fn take(&mut self, cx: &mut Context<'_>, of: Option<&Of>) {
        while let Some(answer) = cx.model.take_answer::<(Of, Option<Sorted>)>(SORTING) {
            let (of, sorted) = *answer;
            match sorted {
                Some(sorted) => self.sorted = Some((of, sorted)),
                // The run left its end.
                None => self.asked = None,
            }
        }
        if self.sorted.as_ref().is_some_and(|(known, _)| of.is_none_or(|of| of.generation != known.generation)) {
            self.sorted = None;
        }
        let is_at_end = cx.model.next.is_none() && cx.model.place == cx.model.passes.len();
        let has_counters = cx.model.opened.as_ref().is_some_and(|opened| opened.plan.counters().is_some());
        if let Some(wanted) = of
            && is_at_end
            && has_counters
            && self.asked.as_ref() != of
            && self.sorted(of).is_none()
        {
            self.asked = Some(wanted.clone());
            let wanted = wanted.clone();
            cx.model.ask(Request::Job(SORTING, Box::new(move |job| sort(job, wanted))));
        }
    }

    /// Summary of the whole order.
    fn order(&mut self, ui: &mut Ui, cx: &mut Context<'_>, of: Option<&Of>, height: f32) {
        ui.horizontal_wrapped(|ui| {
            let label = ui.strong("cost").on_hover_text("what is counted as cost").id;
            for (shown, name, about) in [
                (
                    Shown::Sum,
                    "sum",
                    "cells or nodes visited plus triangles tested; with one step per pass, this is the number of \
                     passes of the walk",
                ),
                (Shown::Cells, "cells", "cells or nodes visited by the ray"),
                (Shown::Triangles, "triangles", "triangles tested against the ray"),
            ] {
                let choice = ui.selectable_label(self.shown == shown, name).labelled_by(label);
                if choice.on_hover_text(about).clicked() {
                    self.shown = shown;
                }
            }
        });
        if cx.model.opened.as_ref().is_none_or(|opened| opened.plan.counters().is_none()) {
            ui.label("This run has no counters. Enable them in the options to see the cost of rays.");
            if ui.button("Options").clicked() {
                cx.todo.push(Command::Show(PaneKind::Options));
            }
            return;
        }
        let Some(sorted) = self.sorted(of) else {
            if cx.model.is_busy() {
                ui.weak("…");
            } else {
                ui.label("Run to the end to sort rays by cost.");
                if ui.button("Run to the end").clicked() {
                    self.asked = None;
                    cx.todo.push(Command::End);
                }
            }
            return;
        };
        let (order, rays) = (&sorted.order, sorted.order.rays().len());
        let [one, ten] = sorted.dearest;
        ui.horizontal_wrapped(|ui| {
            ui.label(format!("total {}", order.total()));
            ui.label(format!("{:.2} per ray", order.total() as f64 / rays.max(1) as f64));
            ui.label(format!("top 1%: {:.1}%", one * 100.0))
                .on_hover_text("the most expensive 1% of rays, as a percentage of the total cost");
            ui.label(format!("top 10%: {:.1}%", ten * 100.0))
                .on_hover_text("the most expensive 10% of rays, as a percentage of the total cost");
        });
        let Some(width) = cx.model.opened.as_ref().map(|opened| opened.plan.width) else { return };
        let selected = cx.shared.pixel.map(|pixel| ray_at(pixel, width)).filter(|&ray| order.rank(ray).is_some());
        if let Some(rank) = sorted.curve.show(ui, height, order, selected.and_then(|ray| order.rank(ray)))
            && let Some(&ray) = order.rays().get(rank)
        {
            cx.shared.select = Some(pixel_of(ray as usize, width));
        }
        ui.horizontal_wrapped(|ui| {
            if let Some(ray) = selected {
                let [x, y] = pixel_of(ray, width);
                let (rank, cost) = (order.rank(ray).unwrap_or(0), order.cost(ray).unwrap_or(0));
                ui.label(format!("pixel {x},{y}: cost {cost}, {} of {rays}", rank + 1));
            }
            for (name, command) in [("costlier", Command::PreviousRayByCost), ("cheaper", Command::NextRayByCost)] {
                let key = command.key_text(ui.ctx());
                if ui.button(name).on_hover_text(format!("the neighbouring ray in the order  {key}")).clicked() {
                    cx.todo.push(command);
                }
            }
        });
    }

    /// The list of the most expensive rays.
    fn list(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        let of = self.of(cx);
        let Some((of, sorted)) = self.sorted.as_ref().filter(|(known, _)| Some(known) == of.as_ref()) else { return };
        let Some(width) = cx.model.opened.as_ref().map(|opened| opened.plan.width) else { return };
        let selected = cx.shared.pixel.map(|pixel| ray_at(pixel, width));
        let rows = Rays { order: &sorted.order, width, count: sorted.order.rays().len().min(MOST_LISTED) };
        let current = selected.and_then(|ray| sorted.order.rank(ray)).filter(|&rank| rank < rows.count);
        let version = version((of.generation, cx.model.edition, self.shown as u8, width, sorted.order.total()));
        let view = View { name: "rays by cost", heads: &HEADS, rows: &rows, version, current };
        ui.horizontal_wrapped(|ui| self.table.tools(ui, &view));
        if let Some(rank) = self.table.show(ui, &view) {
            cx.shared.select = rows.ray(rank).map(|ray| pixel_of(ray, width));
        }
    }
}

const HEADS: [Head<'_>; 4] = [
    Head::number("rank", "1 is the most expensive"),
    Head::text("pixel", "column and row; click to select the ray"),
    Head::number("cost", "cost of the ray"),
    Head::number("share", "percentage of the total cost"),
];

/// The most expensive rays as rows.
struct Rays<'a> {
    order: &'a CostOrder,
    width: u32,
    count: usize,
}

impl Rays<'_> {
    fn ray(&self, rank: usize) -> Option<usize> {
        self.order.rays().get(rank).map(|&ray| ray as usize)
    }

    fn cost(&self, rank: usize) -> f64 {
        self.ray(rank).and_then(|ray| self.order.cost(ray)).map_or(0.0, f64::from)
    }

    fn share(&self, rank: usize) -> f64 {
        self.cost(rank) / self.order.total().max(1) as f64 * 100.0
    }
}

impl Rows for Rays<'_> {
    fn count(&self) -> usize {
        self.count
    }

    fn text(&self, rank: usize, column: usize) -> String {
        match column {
            0 => (rank + 1).to_string(),
            1 => {
                let [x, y] = pixel_of(self.ray(rank).unwrap_or_default(), self.width);
                format!("{x},{y}")
            }
            2 => self.cost(rank).to_string(),
            _ => format!("{:.4}%", self.share(rank)),
        }
    }

    fn number(&self, rank: usize, column: usize) -> Option<f64> {
        match column {
            0 => Some((rank + 1) as f64),
            1 => self.ray(rank).map(|ray| ray as f64),
            2 => Some(self.cost(rank)),
            _ => Some(self.share(rank)),
        }
    }
}

/// Reads the cost of all rays, and sorts them. `None` if the run is not at its end.
fn sort(job: JobContext<'_>, of: Of) -> JobFuture<'_> {
    Box::pin(async move {
        let renderer = job.session.renderer();
        let rays = renderer.plan().rays as usize;
        if renderer.next_kernel().is_some() {
            return Ok(Box::new((of, None::<Sorted>)) as _);
        }
        let Some(counters) = renderer.plan().counters() else { return Ok(Box::new((of, None::<Sorted>)) as _) };
        let counters = job.session.stream(counters).await.map_err(|error| error.to_string())?;
        let sorted = costs(&counters, rays, of.measure).map(|costs| {
            let order = CostOrder::new(costs);
            let dearest = [0.01, 0.1].map(|share| order.share_of_dearest(share));
            Sorted { curve: Curve::new(&order), dearest, order }
        });
        Ok(Box::new((of, sorted)) as _)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_keys_walk_along_the_order_and_begin_at_the_dearest() {
        let order = CostOrder::new(vec![3, 9, 0, 9, 3, 4]);
        assert_eq!(step(&order, None, false), Some(1));
        assert_eq!((step(&order, Some(1), false), step(&order, Some(3), true)), (Some(3), Some(1)));
        assert_eq!((step(&order, Some(1), true), step(&order, Some(2), false)), (None, None));
        // A pixel of a different, larger run.
        assert_eq!(step(&order, Some(99), true), Some(1));
        assert_eq!((pixel_of(7, 3), ray_at([1, 2], 3)), ([1, 2], 7));
    }
}
