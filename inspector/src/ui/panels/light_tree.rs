//! The light tree of the selected pixel: a row for each vertex that its rays end in. A click goes to the pass that decided
//! it.
//!
//! Touches: selection, display, asks.

mod precision;
mod strategies;

use std::sync::Arc;

use egui::{Color32, Ui, Vec2, vec2};
use raystep_kernels::export::light_tree::{Fate, LightTree, Line, Step, Vertex, VertexKind};
use raystep_kernels::export::trace::Trace;
use raystep_kernels::program::paths::Technique;
use raystep_kernels::scene_data::linear_to_srgb;
use serde::{Deserialize, Serialize};

use super::table::{Head, Look, Rows, Table, View, version};
use crate::session::request::Opened;
use crate::ui::pane::{Context, NO_RAYS, Panel, saves};
use crate::ui::state::Picked;
use crate::ui::style::strong;
use crate::ui::units::{self, Units};
use crate::walk::row_after_passes;
use precision::Precision;
use strategies::Strategies;

/// The light tree.
#[derive(Default)]
pub(in crate::ui) struct LightTreeView {
    table: Table,
    shown: Option<Shown>,
    compared: Compared,
    strategies: Strategies,
    precision: Precision,
}

/// What is shown above the table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
struct Compared {
    strategies: bool,
    precision: bool,
}

/// A tree, and what it was made from.
struct Shown {
    history: Arc<Trace>,
    rows: usize,
    units: Units,
    tree: Option<LightTree>,
    lines: Vec<Line>,
    /// Every line: none is folded.
    all: Vec<usize>,
    branches: Vec<[f64; 3]>,
}

impl Shown {
    fn new(history: &Arc<Trace>, rows: usize, units: Units, opened: &Opened) -> Self {
        let tree = LightTree::of(&history.rows[..rows], opened.plan.program, &opened.data);
        let lines = tree.as_ref().map_or_else(Vec::new, |tree| tree.lines(history, units));
        let branches = tree.as_ref().map_or_else(Vec::new, LightTree::branches);
        let all = (0..lines.len()).collect();
        Self { history: history.clone(), rows, units, tree, lines, all, branches }
    }

    fn is_of(&self, history: &Arc<Trace>, rows: usize, units: Units) -> bool {
        Arc::ptr_eq(&self.history, history) && (self.rows, self.units) == (rows, units)
    }
}

/// The last three are of paths alone.
const HEADS: [Head<'static>; 9] = [
    Head::tree("vertex", "what a ray ended in, below the vertex that the ray left"),
    Head::text("passes", "from the pass that cast the ray to the one that decided what it ends in"),
    Head::prose("why it ends", "why the branch ends here, or goes no further"),
    Head::text("arrives", "linear r g b that the ray brings to where it began, or would if nothing were in its way"),
    Head::text("adds", "linear r g b that the vertex and all below it add to the pixel"),
    Head::text("point", "where it is; of what is infinitely far away, the direction").minor(),
    Head::text(
        "throughput",
        "linear r g b of the share of the light along the ray to the surface that reaches the pixel",
    )
    .minor(),
    Head::number(
        "pdf",
        "of the light's direction by the technique that found it, per steradian; empty without a choice",
    ),
    Head::number(
        "weight",
        "of the technique that found the light, among all that could have (multiple importance sampling)",
    ),
];
const PLACE: usize = 5;
const THROUGHPUT: usize = 6;
const PDF: usize = 7;
const WEIGHT: usize = 8;
const ARRIVES: usize = 3;
const ADDS: usize = 4;

impl Panel for LightTreeView {
    saves!(compared);
    fn least(&self) -> Vec2 {
        vec2(240.0, 140.0)
    }

    fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        if !cx.has_rays() {
            ui.weak(NO_RAYS);
            return;
        }
        let Some(opened) = cx.model.opened.clone() else {
            ui.weak("Open a scene and click a pixel to see where its light comes from.");
            return;
        };
        if let Some(why) = why_none(&opened) {
            ui.weak(why);
            return;
        }
        let Some(history) = cx.model.history.clone() else {
            ui.weak("Click a pixel to see where its light comes from.");
            return;
        };
        let current = row_after_passes(&history, cx.model.place);
        // A lesson asks for what comes next.
        let rows = if cx.display.hides_next { current.map_or(0, |row| row + 1) } else { history.rows.len() };
        let mut units = cx.display.units;
        let shown = match self.shown.take().filter(|shown| shown.is_of(&history, rows, units)) {
            Some(shown) => shown,
            None => Shown::new(&history, rows, units, &opened),
        };
        let shown = self.shown.insert(shown);
        let Some(tree) = &shown.tree else {
            ui.weak("No pass has processed this ray yet.");
            return;
        };
        go_to_wanted(cx, &history, tree);
        let at = current.and_then(|row| tree.at_row(row));
        let list = List { shown, tree, current };
        let now = at.and_then(|at| shown.lines.iter().position(|line| line.vertex == at));
        let of = (Arc::as_ptr(&history) as usize, rows, units);
        let heads = if opened.data.features.path { &HEADS[..] } else { &HEADS[..THROUGHPUT] };
        let view = View { name: "light tree", heads, rows: &list, version: version(of), current: now };
        let sample = at.map_or(0, |at| tree.vertices[at].sample);
        ui.horizontal_wrapped(|ui| {
            strong(ui, history.name());
            ui.label(tree.sentence(sample));
        });
        ui.horizontal_wrapped(|ui| {
            self.table.tools(ui, &view);
            units::choose(ui, &mut units, history.scene_units_per_stream_unit);
            if ui.button("Copy as text").clicked() {
                ui.ctx().copy_text(tree.table(&history, units));
            }
            if opened.data.features.path {
                ui.checkbox(&mut self.compared.strategies, "strategies")
                    .on_hover_text("the pixel by each strategy, with the error of its mean");
            }
            ui.checkbox(&mut self.compared.precision, "precision")
                .on_hover_text("the first bounce in which the GPU, f32 and f64 differ by more than rounding");
        });
        if self.compared.strategies && opened.data.features.path {
            self.strategies.show(ui, cx, history.pixel);
        }
        let mut wanted = None;
        if self.compared.precision && !cx.display.hides_next {
            wanted = self.precision.show(ui, cx, &history).and_then(|vertex| tree.vertices.get(vertex));
        }
        let chosen = self.table.show(ui, &view).and_then(|row| list.vertex(row)).or(wanted);
        cx.display.units = units;
        if let Some(vertex) = chosen {
            cx.asks.go_to = place(vertex.decided.unwrap_or(vertex.cast)).or(cx.asks.go_to);
            cx.selection.picked = triangle(vertex).map(Picked::Triangle);
        }
    }
}

/// Goes to a vertex that another panel asked for, as a click on its row does. Its pass may be known only once it has run.
fn go_to_wanted(cx: &mut Context<'_>, history: &Trace, tree: &LightTree) {
    let Some(wanted) = cx.selection.vertex.filter(|wanted| wanted.pixel == history.pixel) else { return };
    let is_it = |vertex: &&Vertex| {
        let kind = match wanted.technique {
            Technique::EmitterHit => VertexKind::Surface,
            Technique::LightSample => VertexKind::Light,
            Technique::Background => VertexKind::Background,
        };
        (vertex.sample, vertex.depth, vertex.kind) == (wanted.sample, wanted.depth, kind)
    };
    let vertex = tree.vertices.iter().find(is_it);
    match vertex.and_then(|vertex| place(vertex.decided?)) {
        Some(known) => {
            cx.asks.go_to = Some(known);
            cx.selection.picked = vertex.and_then(triangle).map(Picked::Triangle);
            cx.selection.vertex = None;
        }
        None if cx.model.place < wanted.place && !cx.model.is_busy() => cx.asks.go_to = Some(wanted.place),
        None if cx.model.is_busy() => {}
        None => cx.selection.vertex = None,
    }
}

/// Why a run has no light tree, and how to get one.
fn why_none(opened: &Opened) -> Option<&'static str> {
    if opened.plan.program.rays.is_none_or(|rays| rays.tree.is_none()) {
        return Some(
            "No ray leaves a hit in this run. With --integrator shadows, rays go on to the lights; with whitted, mirrors and glass send on rays, too; with path, all surfaces do. With photons, the ray's history tells which photons bring the light of a pixel.",
        );
    }
    if opened.data.features.whole_paths {
        return Some(
            "One kernel follows whole paths with --schedule fused, so their vertices are not seen. With compact, second or first, they are.",
        );
    }
    let is_lit = opened.data.features.shadows || opened.data.features.path;
    (!is_lit).then_some(
        "No ray leaves a hit: the scene has no light but a headlight at the eye, from where every hit is visible.",
    )
}

/// The number of passes up to a step and including it, if that is known.
fn place(step: Step) -> Option<usize> {
    step.pass.map(|pass| pass + 1)
}

/// The triangle that a vertex is about: its own, or what is in the way.
fn triangle(vertex: &Vertex) -> Option<u32> {
    match vertex.fate {
        Fate::Occluded { triangle, .. } => Some(triangle),
        _ => vertex.triangle,
    }
}

/// The tree as rows.
struct List<'a> {
    shown: &'a Shown,
    tree: &'a LightTree,
    /// The row of the history that the run is at.
    current: Option<usize>,
}

impl List<'_> {
    fn line(&self, row: usize) -> Option<&Line> {
        self.shown.lines.get(row)
    }

    fn vertex(&self, row: usize) -> Option<&Vertex> {
        self.tree.vertices.get(self.line(row)?.vertex)
    }

    /// The light of a cell.
    fn light(&self, row: usize, column: usize) -> Option<[f64; 3]> {
        match column {
            ARRIVES => Some(self.vertex(row)?.arrives?.map(f64::from)),
            ADDS => self.shown.branches.get(self.line(row)?.vertex).copied(),
            _ => None,
        }
    }
}

impl Rows for List<'_> {
    fn count(&self) -> usize {
        self.shown.lines.len()
    }

    fn unfolded(&self) -> Option<(u64, &[usize])> {
        Some((0, &self.shown.all))
    }

    fn depth(&self, row: usize) -> usize {
        self.line(row).map_or(0, |line| line.level)
    }

    fn text(&self, row: usize, column: usize) -> String {
        let Some(line) = self.line(row) else { return String::new() };
        let text = match column {
            0 => &line.name,
            1 => &line.passes,
            ARRIVES => &line.arrives,
            ADDS => &line.adds,
            2 => &line.why,
            PLACE => &line.place,
            THROUGHPUT => {
                let throughput = self.vertex(row).filter(|v| v.kind != VertexKind::Light).and_then(|v| v.throughput);
                return throughput.map_or_else(String::new, |rgb| rgb.map(|c| format!("{c:.3}")).join(" "));
            }
            _ => return self.number(row, column).map_or_else(String::new, |number| format!("{number:.4}")),
        };
        text.clone()
    }

    /// Of light, the mean of the components.
    fn number(&self, row: usize, column: usize) -> Option<f64> {
        match column {
            PDF => return self.vertex(row)?.density?.pdf,
            WEIGHT => return self.vertex(row)?.density.map(|density| density.weight),
            _ => {}
        }
        self.light(row, column).map(|rgb| rgb.iter().sum::<f64>() / 3.0)
    }

    fn about(&self, row: usize, column: usize) -> Option<String> {
        let all = |rgb: [f64; 3]| rgb.map(|c| c.to_string()).join(" ");
        match column {
            ARRIVES | ADDS => self.light(row, column).map(all),
            2 => self.line(row).map(|line| line.why.clone()),
            PDF | WEIGHT => self.number(row, column).map(|number| number.to_string()),
            _ => None,
        }
    }

    fn has_swatches(&self, column: usize) -> bool {
        matches!(column, ARRIVES | ADDS)
    }

    fn look(&self, ui: &Ui, row: usize, column: usize) -> Look {
        let Some(vertex) = self.vertex(row) else { return Look::default() };
        let is_ahead = self.current.is_none_or(|current| vertex.cast.row > current);
        let swatch = self.light(row, column).map(|rgb| {
            let [r, g, b] = rgb.map(|c| (linear_to_srgb((c as f32).clamp(0.0, 1.0)) * 255.0).round() as u8);
            Color32::from_rgb(r, g, b)
        });
        Look { color: is_ahead.then(|| ui.visuals().weak_text_color()), swatch, ..Look::default() }
    }
}
