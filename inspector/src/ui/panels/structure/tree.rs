//! The nodes of the BVH as a tree: only rows of expanded nodes are built.

mod details;
mod rows;
mod visits;

use std::sync::Arc;

use egui::{Align, Button, Label, Layout, RichText, Ui, Vec2};
use egui_extras::{Column, TableBuilder};
use raystep_kernels::scene_data::SceneData;
use raystep_lab::structure_stats::{Nodes, RankBy};

use crate::ui::choice::Choices as _;
use crate::ui::pane::Context;
use crate::ui::panels::scroll::Scroll;
use crate::ui::state::Picked;
use crate::ui::style::strong;
use rows::{Order, Rows};
use visits::{Visit, Visits};

/// Nodes to go to, of each kind.
const MOST_RANKED: usize = 100;
/// Points of indentation per level.
const INDENT: f32 = 12.0;
/// Most points of indentation.
const MOST_INDENT: f32 = 240.0;

/// Heads of the columns.
const HEADS: [(&str, &str); 8] = [
    ("node", "index, as in the streams; click to pick it, double click to expand it"),
    ("level", "the root is level 0"),
    ("triangles", "triangles listed in all leaves below"),
    ("area", "surface of its box as a share of the root's: the probability that a ray which hits the root visits it"),
    (
        "cost",
        "its subtree's share of the expected cost of a ray (surface area heuristic: Goldsmith and Salmon, 1987; \
         MacDonald and Booth, 1990)",
    ),
    ("overlap", "share of its volume that is in several children"),
    ("empty", "share of its volume that is in no child"),
    ("ray", "whether the selected ray met the box, missed it, or has not reached it yet"),
];

/// A tree, and nodes worth a look.
pub(super) struct Explored {
    pub(super) nodes: Nodes,
    ranked: [Vec<u32>; 4],
}

/// What to go to, with the name of the button.
const RANKS: [(RankBy, &str, &str); 4] = [
    (RankBy::Overlap, "most overlap", "the node whose children overlap in the largest area; again for the next"),
    (RankBy::Empty, "most empty", "the node with the largest empty part, weighted by its area; again for the next"),
    (RankBy::Listed, "largest leaf", "the leaf that lists the most triangles; again for the next"),
    (RankBy::Level, "deepest leaf", "the leaf farthest below the root; again for the next"),
];

impl Explored {
    /// Takes a while for a large tree: for the engine.
    pub(super) fn of(data: &SceneData) -> Option<Self> {
        let nodes = Nodes::of(data)?;
        let ranked = RANKS.map(|(by, ..)| nodes.ranked(by, MOST_RANKED));
        Some(Self { nodes, ranked })
    }
}

/// The explorer.
#[derive(Default)]
pub(super) struct TreeView {
    rows: Rows,
    picked: Option<u32>,
    /// What was picked in any panel when it was last looked at.
    seen: Option<Picked>,
    /// Whether the way to the selected ray's nodes was shown once.
    has_begun: bool,
    visits: Visits,
    /// The place in each ranking that the next click goes to.
    next: [usize; 4],
    scroll: Scroll,
}

impl TreeView {
    /// Shows tools and table in this size.
    pub(super) fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>, tree: &Arc<Explored>, data: &SceneData) {
        let nodes = &tree.nodes;
        if cx.selection.picked != self.seen {
            self.seen = cx.selection.picked;
            if let Some(Picked::Node(node)) = self.seen.filter(|_| !nodes.is_wide()) {
                self.reveal(nodes, node);
            }
        }
        self.visits.update(cx, data);
        if !self.has_begun && !nodes.is_wide() {
            // A closed root alone says nothing.
            let met: Vec<u32> = self.visits.met().collect();
            self.has_begun = !met.is_empty();
            met.iter().filter_map(|&node| nodes.get(node)?.parent).for_each(|above| self.rows.expand(nodes, above));
        }
        self.tools(ui, cx, tree);
        self.rows.build(nodes);
        self.table(ui, cx, nodes);
    }

    /// The picked node.
    pub(super) fn picked(&self) -> Option<u32> {
        self.picked
    }

    /// Details of the picked node.
    pub(super) fn details(&mut self, ui: &mut Ui, cx: &mut Context<'_>, tree: &Explored, data: &SceneData) {
        let Some(node) = self.picked else {
            ui.weak("Click a node to see its box and its triangles.");
            return;
        };
        if let Some(to) = details::show(ui, cx, &tree.nodes, data, node) {
            self.pick(cx, &tree.nodes, to);
        }
    }

    /// Expands the nodes above, and scrolls there.
    fn reveal(&mut self, nodes: &Nodes, node: u32) {
        if nodes.get(node).is_some() {
            self.rows.reveal(nodes, node);
            self.picked = Some(node);
        }
    }

    fn pick(&mut self, cx: &mut Context<'_>, nodes: &Nodes, node: u32) {
        self.reveal(nodes, node);
        // The nodes of a wide BVH have other indices than those of the walk.
        if !nodes.is_wide() {
            cx.selection.picked = Some(Picked::Node(node));
            self.seen = cx.selection.picked;
        }
    }

    fn tools(&mut self, ui: &mut Ui, cx: &mut Context<'_>, tree: &Explored) {
        ui.horizontal_wrapped(|ui| {
            ui.label("go to");
            for (i, (_, name, about)) in RANKS.into_iter().enumerate() {
                let ranked = &tree.ranked[i];
                let button = ui.add_enabled(!ranked.is_empty(), Button::new(name)).on_hover_text(about);
                if button.clicked()
                    && let Some(&node) = ranked.get(self.next[i] % ranked.len().max(1))
                {
                    self.next[i] = (self.next[i] + 1) % ranked.len().max(1);
                    self.pick(cx, &tree.nodes, node);
                }
            }
            let met: Vec<u32> = self.visits.met().collect();
            let about = "expands every node whose box the selected ray meets";
            if ui.add_enabled(!met.is_empty(), Button::new("the ray's nodes")).on_hover_text(about).clicked() {
                met.iter().for_each(|&node| self.rows.expand(&tree.nodes, node));
            }
            if ui.button("collapse all").clicked() {
                self.rows.collapse();
            }
            ui.separator();
            ui.label("children").on_hover_text("the order of the children of a node");
            for (order, name, about) in Order::ALL {
                let choice = ui.choice(self.rows.order() == order, name);
                if choice.on_hover_text(about).clicked() {
                    self.rows.set_order(order);
                }
            }
        });
    }

    fn table(&mut self, ui: &mut Ui, cx: &mut Context<'_>, nodes: &Nodes) {
        let height = ui.text_style_height(&egui::TextStyle::Body) + 4.0;
        let scroll_to = self.scroll.to(ui, self.picked.map(|node| node as usize));
        let rows = self.rows.rows();
        let deepest = rows.iter().filter_map(|&node| nodes.get(node)).map(|node| node.level).max().unwrap_or(0);
        let first = 90.0 + (deepest as f32 * INDENT).min(MOST_INDENT);
        let mut table = TableBuilder::new(ui)
            .id_salt("nodes")
            .striped(true)
            .sense(egui::Sense::click())
            .auto_shrink(false)
            .animate_scrolling(false)
            .cell_layout(Layout::right_to_left(Align::Center))
            .column(Column::exact(first))
            .columns(Column::auto().at_least(46.0), HEADS.len() - 2)
            .column(Column::remainder().at_least(54.0));
        if let Some(row) = scroll_to.and_then(|node| rows.iter().position(|&row| row as usize == node)) {
            table = table.scroll_to_row(row, None);
        }
        let (mut toggled, mut clicked) = (None, None);
        let whole = nodes.get(0).map_or(0.0, |root| root.cost);
        table
            .header(height, |mut header| {
                for (i, (head, about)) in HEADS.into_iter().enumerate() {
                    let show = |ui: &mut Ui| drop(strong(ui, head).on_hover_text(about));
                    header.col(|ui| match i {
                        0 => drop(ui.with_layout(Layout::left_to_right(Align::Center), show)),
                        _ => show(ui),
                    });
                }
            })
            .body(|body| {
                body.rows(height, rows.len(), |mut row| {
                    let index = rows[row.index()];
                    let Some(node) = nodes.get(index) else { return };
                    row.set_selected(self.picked == Some(index));
                    let is_open = self.rows.is_open(index);
                    row.col(|ui| {
                        ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                            ui.add_space((node.level as f32 * INDENT).min(MOST_INDENT));
                            if !node.is_leaf() {
                                let does = if is_open { "collapse" } else { "expand" };
                                let button = ui.allocate_response(Vec2::splat(16.0), egui::Sense::click());
                                let openness = if is_open { 1.0 } else { 0.0 };
                                egui::collapsing_header::paint_default_icon(ui, openness, &button);
                                let text = format!("{does} node {index}");
                                button.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &text));
                                if button.clicked() {
                                    toggled = Some(index);
                                }
                            } else {
                                ui.add_space(16.0 + ui.spacing().item_spacing.x);
                            }
                            let text = if node.is_leaf() { format!("{index} leaf") } else { index.to_string() };
                            ui.add(Label::new(RichText::new(text).monospace()).selectable(false).extend());
                        });
                    });
                    let percent =
                        |share: Option<f64>| share.map_or_else(|| "–".into(), |s| format!("{:.1}%", s * 100.0));
                    let filling = nodes.filling(index);
                    let cells = [
                        node.level.to_string(),
                        node.below.to_string(),
                        percent(nodes.probability(index)),
                        percent((whole > 0.0).then(|| f64::from(node.cost / whole))),
                        percent(filling.map(|f| f.overlapping)),
                        percent(filling.map(|f| f.empty)),
                        self.visits.of(index).map_or_else(String::new, |visit| visit.text().into()),
                    ];
                    for cell in cells {
                        row.col(|ui| {
                            let text = RichText::new(cell).monospace();
                            let text =
                                if self.visits.of(index).is_some_and(Visit::is_met) { text.strong() } else { text };
                            ui.add(Label::new(text).selectable(false).extend());
                        });
                    }
                    let response = row.response();
                    if response.double_clicked() && !node.is_leaf() {
                        toggled = Some(index);
                    } else if response.clicked() {
                        clicked = Some(index);
                    }
                });
            });
        if let Some(node) = toggled {
            self.rows.toggle(node);
        }
        if let Some(node) = clicked {
            self.pick(cx, nodes, node);
        }
    }
}
