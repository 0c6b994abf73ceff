//! The picked node: its box, its costs, and its triangles.

use egui::{RichText, Ui};
use raystep_kernels::scene_data::SceneData;
use raystep_lab::structure_stats::Nodes;
use raystep_lab::text::counted;

use crate::ui::choice::Choice;
use crate::ui::pane::Context;
use crate::ui::state::Picked;
use crate::ui::style::strong;
use crate::ui::units::{Scale, Units};
use crate::walk::AXES;

/// Most triangles shown of a leaf.
const MOST_CHIPS: usize = 64;

/// Shows it; returns another node that was clicked.
pub(super) fn show(ui: &mut Ui, cx: &mut Context<'_>, nodes: &Nodes, data: &SceneData, index: u32) -> Option<u32> {
    let node = nodes.get(index)?;
    let mut clicked = None;
    ui.horizontal_wrapped(|ui| {
        strong(ui, format!("node {index}"));
        ui.label(match node.is_leaf() {
            true => format!("leaf of {}", counted(node.listed, "triangle")),
            false => format!("{} in {}", counted(node.below, "triangle"), counted(node.leaves, "leaf")),
        });
        let mut link = |ui: &mut Ui, name: &str, to: u32| {
            if ui.link(format!("{name} {to}")).clicked() {
                clicked = Some(to);
            }
        };
        if let Some(parent) = node.parent {
            link(ui, "parent", parent);
        }
        node.children().for_each(|child| link(ui, "child", child));
    });
    let unit = data.units.scene_units_per_stream_unit();
    egui::Grid::new("box").num_columns(4).show(ui, |ui| {
        ui.label("box").on_hover_text("in scene units; grown by the bound on rounding errors");
        AXES.into_iter().for_each(|axis| drop(strong(ui, axis)));
        ui.end_row();
        let size = [0, 1, 2].map(|axis| f64::from(node.max[axis]) - f64::from(node.min[axis]));
        let scale = Scale::new(Units::Scene, unit, data.units.offset.to_array(), unit);
        let rows =
            [("from", scale.point(node.min)), ("to", scale.point(node.max)), ("size", size.map(|s| number(s * unit)))];
        for (name, values) in rows {
            ui.label(name);
            values.into_iter().for_each(|value| drop(ui.monospace(format!("{value:>11}"))));
            ui.end_row();
        }
    });
    ui.horizontal_wrapped(|ui| {
        ui.label(format!("surface {}", number(2.0 * node.half_area() * unit * unit)))
            .on_hover_text("scene units squared");
        if let Some(share) = nodes.probability(index) {
            ui.label(format!("{:.3}% of the root's", share * 100.0));
        }
        if let Some(cost) = nodes.own_cost(index) {
            ui.label(format!("cost {cost:.3} alone, {:.3} with all below", node.cost))
                .on_hover_text("expected triangle tests of a ray that hits the root; a visit counts as one");
        }
    });
    if let Some(filling) = nodes.filling(index) {
        let overlap = nodes.overlap(index).map_or_else(String::new, |share| {
            format!("; their overlap has {:.3}% of the root's surface area", share * 100.0)
        });
        ui.label(format!(
            "{:.2}% of its volume is in no child, {:.2}% in several{overlap}",
            filling.empty * 100.0,
            filling.overlapping * 100.0
        ));
    }
    // The leaves of a wide BVH list entries of another buffer.
    if node.is_leaf() && !nodes.is_wide() {
        ui.horizontal_wrapped(|ui| {
            for triangle in crate::walk::listed(data, index).take(MOST_CHIPS) {
                let is_picked = cx.selection.picked == Some(Picked::Triangle(triangle));
                let chip = Choice::new(is_picked, RichText::new(triangle.to_string()).monospace());
                if ui.add(chip).on_hover_text(format!("triangle {triangle}; click to show it")).clicked() {
                    cx.selection.picked = Some(Picked::Triangle(triangle));
                }
            }
        });
    }
    ui.separator();
    clicked
}

/// Five significant digits.
fn number(value: f64) -> String {
    let size = value.abs();
    match size {
        _ if value == 0.0 => "0".into(),
        _ if !(1e-4..1e6).contains(&size) => format!("{value:.4e}"),
        _ => format!("{value:.*}", (4 - size.log10().floor() as i32).max(0) as usize),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_five_digits() {
        let texts = [0.0, 1.0, -12.3456, 0.000_123_456, 123_456.7, 1e9, f64::INFINITY].map(number);
        assert_eq!(texts, ["0", "1.0000", "-12.346", "0.00012346", "123457", "1.0000e9", "inf"]);
    }
}
