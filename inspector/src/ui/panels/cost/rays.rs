//! Rays from the most expensive to the cheapest: a curve and a list.

use egui::Ui;
use raystep_lab::work::CostOrder;

use super::source::Sorted;
use crate::command::Command;
use crate::ui::pane::Context;
use crate::ui::panels::table::{Head, Rows, Table, View, version};

/// Most rays in the list; the curve includes all.
const MOST_LISTED: usize = 1000;

/// The next or previous ray in the order; the most expensive one without a selection. `None` at either end.
pub(super) fn step(order: &CostOrder, ray: Option<usize>, is_dearer: bool) -> Option<usize> {
    match ray.filter(|&ray| order.rank(ray).is_some()) {
        Some(ray) if is_dearer => order.dearer(ray),
        Some(ray) => order.cheaper(ray),
        None => order.dearest(),
    }
}

pub(super) fn ray_at([x, y]: [u32; 2], width: u32) -> usize {
    y as usize * width as usize + x as usize
}

pub(super) fn pixel_of(ray: usize, width: u32) -> [u32; 2] {
    let width = width.max(1) as usize;
    [(ray % width) as u32, (ray / width) as u32]
}

/// Totals, the curve, and the selected ray's rank.
pub(super) fn summary(ui: &mut Ui, cx: &mut Context<'_>, sorted: &Sorted, width: u32, height: f32) {
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
    let selected = cx.selection.pixel.map(|pixel| ray_at(pixel, width)).filter(|&ray| order.rank(ray).is_some());
    if let Some(rank) = sorted.curve.show(ui, height, order, selected.and_then(|ray| order.rank(ray)))
        && let Some(&ray) = order.rays().get(rank)
    {
        cx.asks.select = Some(pixel_of(ray as usize, width));
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
                cx.asks.commands.push(command);
            }
        }
    });
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

/// The list of the most expensive rays. `of` changes with what their cost is.
pub(super) fn list(ui: &mut Ui, cx: &mut Context<'_>, sorted: &Sorted, width: u32, of: u64, table: &mut Table) {
    let order = &sorted.order;
    let rows = Rays { order, width, count: order.rays().len().min(MOST_LISTED) };
    let selected = cx.selection.pixel.map(|pixel| ray_at(pixel, width));
    let current = selected.and_then(|ray| order.rank(ray)).filter(|&rank| rank < rows.count);
    let version = version((of, width, order.total(), order.rays().first().copied()));
    let view = View { name: "rays by cost", heads: &HEADS, rows: &rows, version, current };
    ui.horizontal_wrapped(|ui| table.tools(ui, &view));
    if let Some(rank) = table.show(ui, &view) {
        cx.asks.select = rows.ray(rank).map(|ray| pixel_of(ray, width));
    }
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
