//! Pixels, the one first to which a single vertex of its path adds the most.

use egui::Ui;
use raystep_lab::bounces::{Bounces, Brightest};

use super::Of;
use crate::command::PaneKind;
use crate::ui::pane::Context;
use crate::ui::panels::table::{Head, Rows, Table, View, version};
use crate::ui::state::OfPath;
use crate::ui::units::decimals;

/// Most pixels in the list.
const MOST_LISTED: usize = 1000;

const HEADS: [Head<'static>; 8] = [
    Head::number("rank", "1 is the brightest").minor(),
    Head::text("pixel", "column and row; click to select it, and its vertex in the light tree"),
    Head::number("adds", "luminance that the vertex adds to the pixel, of this sample"),
    Head::number("times mean", "the same, divided by the mean luminance of all pixels"),
    Head::number("depth", "surfaces that sent on the path before the vertex"),
    Head::text("found by", "how its light was found"),
    Head::number("pdf", "of its direction by the technique that found it, per steradian; empty without a choice"),
    Head::number("weight", "its weight among the techniques that could have found it (multiple importance sampling)"),
];

/// The brightest as rows.
struct List<'a> {
    all: &'a [Brightest],
    /// Mean luminance of all pixels.
    mean: f64,
    digits: usize,
}

impl List<'_> {
    fn pixel(&self, row: usize) -> [u32; 2] {
        self.all.get(row).map_or([0; 2], |vertex| vertex.pixel)
    }
}

impl Rows for List<'_> {
    fn count(&self) -> usize {
        self.all.len()
    }

    fn text(&self, row: usize, column: usize) -> String {
        let number = self.number(row, column);
        match column {
            1 => self.pixel(row).map(|at| at.to_string()).join(","),
            5 => self.all.get(row).map_or_else(String::new, |vertex| vertex.technique.name().into()),
            0 | 4 => number.map_or_else(String::new, |number| number.to_string()),
            2 => number.map_or_else(String::new, |number| format!("{number:.*}", self.digits)),
            3 => number.map_or_else(String::new, |number| format!("{number:.1}")),
            _ => number.map_or_else(String::new, |number| format!("{number:.4}")),
        }
    }

    fn number(&self, row: usize, column: usize) -> Option<f64> {
        let vertex = self.all.get(row)?;
        match column {
            0 => Some((row + 1) as f64),
            1 => Some(f64::from(vertex.pixel[1]) * 65_536.0 + f64::from(vertex.pixel[0])),
            2 => Some(vertex.luminance()),
            3 => Some(vertex.luminance() / self.mean),
            4 => Some(f64::from(vertex.depth)),
            5 => None,
            6 => vertex.density?.pdf,
            _ => Some(vertex.density?.weight),
        }
    }

    fn about(&self, row: usize, column: usize) -> Option<String> {
        let vertex = self.all.get(row)?;
        match column {
            2 => Some(format!("linear r g b: {}", vertex.light.map(|c| c.to_string()).join(" "))),
            6 | 7 => self.number(row, column).map(|number| number.to_string()),
            _ => None,
        }
    }
}

/// Shows the list; a click selects a pixel and shows the vertex in its light tree.
pub(super) fn show(ui: &mut Ui, cx: &mut Context<'_>, table: &mut Table, (of, found): (Of, &Bounces)) {
    let all = &found.brightest[..found.brightest.len().min(MOST_LISTED)];
    let largest = all.iter().map(Brightest::luminance).filter(|l| l.is_finite()).fold(0.0, f64::max);
    let list = List { all, mean: found.light(), digits: decimals(largest).saturating_sub(1) };
    let current = cx.selection.pixel.and_then(|pixel| all.iter().position(|vertex| vertex.pixel == pixel));
    let view = View { name: "brightest pixels", heads: &HEADS, rows: &list, version: version(of), current };
    ui.horizontal_wrapped(|ui| table.tools(ui, &view));
    if let Some(vertex) = table.show(ui, &view).and_then(|row| all.get(row)) {
        let Brightest { pixel, depth, technique, place, .. } = *vertex;
        cx.asks.select = Some(pixel);
        cx.asks.panel = Some(PaneKind::LightTree);
        cx.selection.vertex = Some(OfPath { pixel, sample: of.sample, depth, technique, place });
    }
}
