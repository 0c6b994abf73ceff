//! Rays from the most expensive to the cheapest: a curve and a list.

use egui::{Align, Label, Layout, RichText, Ui};
use egui_extras::{Column, TableBuilder};
use raystep_lab::work::CostOrder;

use super::source::Sorted;
use crate::ui::command::Command;
use crate::ui::pane::Context;
use crate::ui::panels::scroll::Scroll;

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
pub(super) fn list(ui: &mut Ui, cx: &mut Context<'_>, sorted: &Sorted, width: u32, scroll: &mut Scroll) {
    let (order, total) = (&sorted.order, sorted.order.total().max(1));
    let count = order.rays().len().min(MOST_LISTED);
    let selected = cx.shared.pixel.map(|pixel| ray_at(pixel, width));
    let height = ui.text_style_height(&egui::TextStyle::Body) + 4.0;
    let scroll_to = scroll.to(ui, selected);
    let mut table = TableBuilder::new(ui)
        .id_salt("dearest")
        .striped(true)
        .sense(egui::Sense::click())
        .auto_shrink(false)
        // Where it is now matters, not the way there.
        .animate_scrolling(false)
        .cell_layout(Layout::right_to_left(Align::Center))
        .columns(Column::auto().at_least(40.0), 3)
        .column(Column::remainder().at_least(60.0));
    if let Some(rank) = scroll_to.and_then(|ray| order.rank(ray)).filter(|&rank| rank < count) {
        table = table.scroll_to_row(rank, None);
    }
    table
        .header(height, |mut header| {
            for (head, about) in [
                ("rank", "1 is the most expensive"),
                ("pixel", "column and row; click to select the ray"),
                ("cost", "cost of the ray"),
                ("share", "percentage of the total cost"),
            ] {
                header.col(|ui| drop(ui.strong(head).on_hover_text(about)));
            }
        })
        .body(|body| {
            body.rows(height, count, |mut row| {
                let rank = row.index();
                let ray = order.rays()[rank] as usize;
                let ([x, y], cost) = (pixel_of(ray, width), order.cost(ray).unwrap_or(0));
                row.set_selected(selected == Some(ray));
                let share = f64::from(cost) / total as f64 * 100.0;
                let cells = [(rank + 1).to_string(), format!("{x},{y}"), cost.to_string(), format!("{share:.4}%")];
                for cell in cells {
                    row.col(|ui| drop(ui.add(Label::new(RichText::new(cell).monospace()).selectable(false).extend())));
                }
                if row.response().clicked() {
                    cx.shared.select = Some([x, y]);
                }
            });
        });
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
