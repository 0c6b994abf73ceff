//! The acceleration structure: the lists of the grid and a slice through them, or the nodes of the BVH as a tree.
//!
//! Touches: selection, display, log.

mod picture;
mod slice;
mod tree;

use std::sync::Arc;

use egui::{RichText, ScrollArea, Ui};
use raystep_kernels::Plan;
use raystep_kernels::export::structure::IrregularSummary;
use raystep_kernels::scene_data::SceneData;
use raystep_lab::structure_stats::{GridStats, LENGTHS, TreeStats, triangles_in};
use raystep_lab::text::counted;
use slice::SliceView;
use tree::{Explored, TreeView};

use super::chart::Histogram;
use super::picked;
use crate::command::Command;
use crate::session::request::{Job, Request, answered, job};
use crate::ui::choice::Choice;
use crate::ui::pane::{Context, Panel};
use crate::ui::state::{Picked, Selection};
use crate::ui::style::strong;
use crate::ui::units::{Scale, Units};

/// The engine's job, named while it runs.
const MEASURING: &str = "measuring the structure";
/// Most triangles shown of a list.
const MOST_CHIPS: usize = 400;
/// Height of a histogram, points.
const BARS: f32 = 86.0;

/// Statistics of a structure.
#[derive(Clone)]
enum Measured {
    Grid(Arc<GridStats>),
    Irregular(IrregularSummary),
    Tree(Arc<TreeStats>, Arc<Explored>),
    Nothing,
}

/// The panel.
#[derive(Default)]
pub(in crate::ui) struct Structure {
    asked: u64,
    measured: Option<(u64, Measured)>,
    slice: SliceView,
    about: picked::About,
    tree: TreeView,
}

impl Panel for Structure {
    fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        let Some(opened) = &cx.model.opened else {
            ui.weak("Open a scene to see its grid or BVH.");
            return;
        };
        let data = opened.data.clone();
        let plan = opened.plan.clone();
        self.measure(&data, &plan, cx);
        self.slice.mark(&data, cx.selection.picked);
        self.about.show(ui, cx.model, cx.selection, cx.display);
        match self.measured.clone() {
            Some((_, Measured::Grid(stats))) => self.grid(ui, cx, &data, &stats),
            Some((_, Measured::Irregular(summary))) => irregular_numbers(ui, &summary),
            Some((_, Measured::Tree(stats, explored))) => self.tree(ui, cx, &data, &stats, &explored),
            Some((_, Measured::Nothing)) if !cx.has_rays() => {
                ui.weak("This program traces through no grid or BVH. What it builds is in its streams.");
            }
            Some((_, Measured::Nothing)) => {
                ui.label(format!(
                    "No acceleration structure: every ray is tested against all {} triangles.",
                    data.info.triangles
                ));
            }
            None if cx.model.is_busy() => drop(ui.weak(format!("{MEASURING} …"))),
            None => {
                // The measurement was cancelled.
                if ui.button("Measure the grid or BVH").clicked() {
                    self.asked = 0;
                }
            }
        }
    }

    fn command(&mut self, command: Command, cx: &mut Context<'_>) -> bool {
        if !matches!(command, Command::NextSlice | Command::PreviousSlice | Command::SliceAxis) {
            return false;
        }
        let Some(data) = cx.model.opened.as_ref().map(|opened| opened.data.clone()) else { return false };
        if data.grid_cells.len() < 2 {
            cx.log.say(false, "this run has no grid");
            return true;
        }
        self.slice.command(command, &data);
        true
    }
}

impl Structure {
    /// Asks once per run, and takes the answer.
    fn measure(&mut self, data: &Arc<SceneData>, plan: &Arc<Plan>, cx: &mut Context<'_>) {
        let generation = cx.model.generation;
        if self.measured.as_ref().is_some_and(|(of, _)| *of != generation) {
            self.measured = None;
            self.slice.forget();
            self.tree = TreeView::default();
        }
        if let Some(answer) = cx.model.take_answer::<(u64, Measured)>(MEASURING)
            && answer.0 == generation
        {
            self.measured = Some(*answer);
        }
        if self.measured.is_none() && self.asked != generation {
            self.asked = generation;
            let (data, plan) = (data.clone(), plan.clone());
            cx.model.ask(Request::Job(MEASURING, measure(data, plan, generation)));
        }
    }

    fn grid(&mut self, ui: &mut Ui, cx: &mut Context<'_>, data: &SceneData, stats: &GridStats) {
        // Side by side if there is room.
        let is_wide = ui.available_width() > 640.0;
        let (size, units) = (ui.available_size(), cx.display.units);
        if is_wide {
            ui.horizontal_top(|ui| {
                let picture = egui::vec2((size.x * 0.55).min(size.x - 300.0), size.y);
                ui.allocate_ui_with_layout(picture, egui::Layout::top_down(egui::Align::Min), |ui| {
                    self.slice.show(ui, cx, data, stats.longest, picture.y);
                });
                ui.allocate_ui_with_layout(ui.available_size(), egui::Layout::top_down(egui::Align::Min), |ui| {
                    ScrollArea::vertical()
                        .id_salt("numbers")
                        .auto_shrink(false)
                        .show(ui, |ui| self.numbers(ui, cx.selection, units, data, stats));
                });
            });
        } else {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                // Part of what follows stays visible, so that it is clear that there is more.
                self.slice.show(ui, cx, data, stats.longest, (size.y * 0.6).max(140.0));
                self.numbers(ui, cx.selection, units, data, stats);
            });
        }
    }

    fn tree(&mut self, ui: &mut Ui, cx: &mut Context<'_>, data: &SceneData, stats: &TreeStats, tree: &Arc<Explored>) {
        let size = ui.available_size();
        if size.x > 900.0 {
            ui.horizontal_top(|ui| {
                let down = egui::Layout::top_down(egui::Align::Min);
                ui.allocate_ui_with_layout(egui::vec2(size.x * 0.6, size.y), down, |ui| {
                    self.tree.show(ui, cx, tree, data);
                });
                ui.allocate_ui_with_layout(ui.available_size(), down, |ui| {
                    ScrollArea::vertical().id_salt("details").auto_shrink(false).show(ui, |ui| {
                        self.tree.details(ui, cx, tree, data);
                        tree_numbers(ui, stats);
                    });
                });
            });
        } else {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                // Without a pick there is only one line below the table.
                let share = if self.tree.picked().is_some() { 0.55 } else { 0.7 };
                ui.allocate_ui(egui::vec2(size.x, (size.y * share).max(160.0)), |ui| {
                    self.tree.show(ui, cx, tree, data)
                });
                self.tree.details(ui, cx, tree, data);
                tree_numbers(ui, stats);
            });
        }
    }

    fn numbers(&mut self, ui: &mut Ui, selection: &mut Selection, units: Units, data: &SceneData, stats: &GridStats) {
        self.list(ui, selection, units, data);
        let [x, y, z] = stats.cells;
        ui.horizontal_wrapped(|ui| {
            strong(ui, format!("{x} × {y} × {z} cells")).on_hover_text(format!("{} in total", stats.cells_in_all()));
            ui.label(format!("{:.1}% list a triangle", stats.occupancy() * 100.0))
                .on_hover_text(counted(stats.occupied, "cell"));
            ui.label(format!("{:.2} triangles per list", stats.mean_length()))
                .on_hover_text("average over non-empty cells");
            ui.label(format!("{:.2} cells per triangle", stats.references_per_triangle()))
                .on_hover_text(format!("{} references in all lists", stats.references));
            let text = format!("longest list: {}", stats.longest);
            if ui.link(text).on_hover_text("select the first cell with such a list").clicked() && stats.longest > 0 {
                selection.picked = picked::cell(data.grid.cell_of_index(stats.longest_cell));
            }
            if let Some(triangle) = stats.most_listed_triangle {
                let text = format!("triangle {triangle} is in {}", counted(stats.most_listed, "list"));
                if ui
                    .link(text)
                    .on_hover_text("the most of any triangle; click to mark its cells in the slice")
                    .clicked()
                {
                    selection.picked = Some(Picked::Triangle(triangle));
                }
            }
        });
        ui.label("cells by list length").on_hover_text("logarithmic heights");
        let about = |length: usize, cells: u64| format!("length {length}{}: {}", open(length), counted(cells, "cell"));
        let is_open = true;
        Histogram { counts: &stats.lengths, name: "cells by list length", about: &about, is_open }.show(ui, BARS);
        ui.label("triangles by number of cells that list them").on_hover_text("logarithmic heights");
        let about = |cells: usize, triangles: u64| {
            format!("in {cells}{} lists: {}", open(cells), counted(triangles, "triangle"))
        };
        Histogram {
            counts: &stats.listings,
            name: "triangles by number of cells that list them",
            about: &about,
            is_open,
        }
        .show(ui, BARS);
    }

    /// The triangles of the selected cell.
    fn list(&mut self, ui: &mut Ui, selection: &mut Selection, units: Units, data: &SceneData) {
        let Some(cell) = self.slice.cell().filter(|&cell| data.grid.is_in_grid(cell)) else {
            ui.weak("Click a cell to see its list.");
            return;
        };
        let [x, y, z] = cell;
        let triangles = triangles_in(data, data.grid.cell_index(cell));
        ui.horizontal_wrapped(|ui| {
            strong(ui, format!("cell {x},{y},{z}")).on_hover_text(format!("index {}", data.grid.cell_index(cell)));
            ui.label(match triangles.len() {
                0 => "empty list".into(),
                n => counted(n, "triangle"),
            });
            for &triangle in triangles.iter().take(MOST_CHIPS) {
                let is_marked = self.slice.triangle() == Some(triangle);
                let chip = Choice::new(is_marked, RichText::new(triangle.to_string()).monospace());
                let chip = ui.add(chip);
                if chip.on_hover_ui(|ui| corners(ui, data, triangle, units)).clicked() {
                    picked::toggle(selection, Picked::Triangle(triangle));
                }
            }
            if triangles.len() > MOST_CHIPS {
                ui.weak(format!("and {} more", triangles.len() - MOST_CHIPS));
            }
        });
        ui.separator();
    }
}

/// Statistics of a grid or BVH. The session is only used to stay cancellable.
fn measure(data: Arc<SceneData>, plan: Arc<Plan>, generation: u64) -> Job {
    job!(_, {
        let tree = || Some(Measured::Tree(Arc::new(TreeStats::of(&data)?), Arc::new(Explored::of(&data)?)));
        let grid = GridStats::of(&data).map(|stats| Measured::Grid(Arc::new(stats)));
        let irregular = || IrregularSummary::of(&plan, &data).map(Measured::Irregular);
        let measured = grid.or_else(irregular).or_else(tree).unwrap_or(Measured::Nothing);
        answered((generation, measured))
    })
}

/// The last bar of a histogram of lengths also includes all longer ones.
fn open(length: usize) -> &'static str {
    if length + 1 == LENGTHS { " or more" } else { "" }
}

/// The position of a triangle.
fn corners(ui: &mut Ui, data: &SceneData, triangle: u32, units: Units) {
    let scale = Scale::in_scene(units, data);
    strong(ui, format!("triangle {triangle}"));
    let first = triangle as usize * 9;
    for corner in data.vertices.get(first..first + 9).unwrap_or_default().chunks_exact(3) {
        let [x, y, z] = scale.point([corner[0], corner[1], corner[2]]);
        ui.monospace(format!("{x:>10} {y:>10} {z:>10}"));
    }
    ui.weak(format!("{}; click to mark its cells in the slice", scale.units.name()));
}

fn irregular_numbers(ui: &mut Ui, summary: &IrregularSummary) {
    let [x, y, z] = summary.virtual_cells;
    let finest = 1u64 << summary.levels;
    let listing = summary.cells - summary.empty_cells;
    strong(ui, counted(summary.cells as usize, "cell"));
    ui.label(format!("{:.1}% list a triangle", listing as f64 / summary.cells.max(1) as f64 * 100.0));
    ui.label(format!("{:.2} triangles per list", summary.references as f64 / listing.max(1) as f64))
        .on_hover_text("average over non-empty cells");
    ui.label(format!("longest list: {}", summary.longest_list));
    ui.label(format!("virtual grid: {x} × {y} × {z} cells, {finest} along an axis of a top-level cell"))
        .on_hover_text("the planes on which the boxes of cells end");
}

fn tree_numbers(ui: &mut Ui, stats: &TreeStats) {
    let levels = stats.depths.len().saturating_sub(1);
    ui.label(match stats.width {
        2 => "The run steps through the binary BVH; only the fused schedule has the compressed eight-wide one.",
        _ => "The run has the compressed eight-wide BVH: a leaf is a slot of its node; the numbers of leaves exist only here.",
    });
    ui.horizontal_wrapped(|ui| {
        strong(ui, counted(stats.inner, "inner node"))
            .on_hover_text(format!("with at most {} children each", stats.width));
        ui.label(counted(stats.leaves, "leaf"));
        ui.label(format!("deepest leaf at level {levels}")).on_hover_text("the root is level 0");
        ui.label(counted(stats.references, "reference"))
            .on_hover_text("triangles in all leaves; large triangles are in several");
        match stats.sah_cost {
            Some(cost) => ui.label(format!("SAH cost {cost:.2}")),
            None => ui.label("SAH cost unknown: the scene's box has no area"),
        }
        .on_hover_text(
            "surface area heuristic (MacDonald and Booth, 1990): expected triangle tests and visits of a node, at the \
             cost of one test each, for a ray that hits the root's box",
        );
    });
    ui.label("leaves by level").on_hover_text("logarithmic heights");
    let about = |level: usize, leaves: u64| format!("{} at level {level}", counted(leaves, "leaf"));
    Histogram { counts: &stats.depths, name: "leaves by level", about: &about, is_open: false }.show(ui, BARS);
    ui.label("leaves by number of triangles").on_hover_text("logarithmic heights");
    let about = |size: usize, leaves: u64| format!("{} of {}", counted(leaves, "leaf"), counted(size, "triangle"));
    Histogram { counts: &stats.sizes, name: "leaves by number of triangles", about: &about, is_open: false }
        .show(ui, BARS);
}
