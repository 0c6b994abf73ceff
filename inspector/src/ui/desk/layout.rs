//! The arrangement of panels.

use egui::Vec2;
use egui_tiles::{Behavior, Linear, LinearDir, SimplificationOptions, Tile, TileId, Tiles, Tree, UiResponse};

use super::focus::{self, Focus};
use crate::command::{Layout, PaneKind};
use crate::ui::pane::Context;
use crate::ui::panes::Pane;

/// A part of a layout.
enum Part {
    /// Panels one behind the other.
    Tabs(&'static [PaneKind]),
    /// Parts from left to right, with their shares of the width.
    Columns(&'static [(f32, Self)]),
    /// Parts from top to bottom, with their shares of the height.
    Rows(&'static [(f32, Self)]),
}

use PaneKind as P;
use Part::{Columns, Rows, Tabs};

const OVERVIEW: Part = Rows(&[
    (1.0, Columns(&[(0.85, Tabs(&[P::Stream])), (1.15, Rows(&[(1.1, Tabs(&[P::Walk2d])), (0.9, Tabs(&[P::Ray]))]))])),
    (0.23, Tabs(&[P::Timeline, P::Passes])),
]);

const STEP: Part = Rows(&[
    (
        1.0,
        Columns(&[
            (0.56, Tabs(&[P::Passes, P::Options, P::Watches])),
            (1.0, Tabs(&[P::Stream])),
            (0.85, Tabs(&[P::Kernel, P::Ray])),
        ]),
    ),
    (0.3, Tabs(&[P::Timeline, P::Timings, P::Dataflow, P::Plan, P::Log])),
]);

const RAY: Part = Columns(&[
    (1.15, Rows(&[(1.0, Tabs(&[P::Walk3d, P::Structure])), (0.75, Tabs(&[P::Walk2d]))])),
    (1.0, Rows(&[(1.0, Tabs(&[P::Ray, P::LightTree, P::Bounces])), (0.9, Tabs(&[P::Stream, P::Kernel]))])),
]);

const COMPARE: Part =
    Rows(&[(1.0, Tabs(&[P::Compare, P::Divergence])), (0.36, Tabs(&[P::Runs, P::Error, P::Choices]))]);

const COST: Part = Rows(&[
    (1.0, Columns(&[(1.15, Tabs(&[P::Cost])), (0.85, Tabs(&[P::Timings, P::Structure, P::Walk3d, P::Plan]))])),
    (0.3, Tabs(&[P::Timeline, P::Choices])),
]);

const LEARN: Part = Rows(&[
    (
        1.0,
        Columns(&[
            (0.7, Tabs(&[P::Lessons])),
            (1.0, Tabs(&[P::Stream])),
            (1.2, Rows(&[(1.1, Tabs(&[P::Walk2d])), (0.9, Tabs(&[P::Ray]))])),
        ]),
    ),
    (0.23, Tabs(&[P::Timeline])),
]);

/// The arrangement of a layout.
pub(in crate::ui) fn tree(layout: Layout) -> Tree<Pane> {
    let part = match layout {
        Layout::Overview => OVERVIEW,
        Layout::Step => STEP,
        Layout::Ray => RAY,
        Layout::Compare => COMPARE,
        Layout::Cost => COST,
        Layout::Learn => LEARN,
    };
    let mut tiles = Tiles::default();
    let root = insert(&mut tiles, &part);
    Tree::new(egui::Id::unique("panes"), root, tiles)
}

fn insert(tiles: &mut Tiles<Pane>, part: &Part) -> TileId {
    let (parts, dir) = match part {
        Tabs(kinds) => {
            let panes = kinds.iter().map(|&kind| tiles.insert_pane(Pane::new(kind))).collect();
            return tiles.insert_tab_tile(panes);
        }
        Columns(parts) => (parts, LinearDir::Horizontal),
        Rows(parts) => (parts, LinearDir::Vertical),
    };
    let children: Vec<TileId> = parts.iter().map(|(_, part)| insert(tiles, part)).collect();
    let mut linear = Linear::new(dir, children.clone());
    children.iter().zip(*parts).for_each(|(&child, &(share, _))| linear.shares.set_share(child, share));
    tiles.insert_container(linear)
}

/// Toggles a panel.
pub(in crate::ui) fn toggle(tree: &mut Tree<Pane>, kind: PaneKind) {
    let is_kind = |tile: &Tile<Pane>| matches!(tile, Tile::Pane(pane) if pane.kind == kind);
    let found = tree.tiles.iter().find(|(_, tile)| is_kind(tile)).map(|(&id, _)| id);
    match found {
        Some(id) if tree.active_tiles().contains(&id) => drop(tree.remove_recursively(id)),
        Some(id) => drop(tree.make_active(|other, _| other == id)),
        None => add(tree, Pane::new(kind)),
    }
}

/// Shows a panel if it is hidden.
pub(in crate::ui) fn show(tree: &mut Tree<Pane>, kind: PaneKind) {
    let is_shown = tree.active_tiles().into_iter().any(|id| tree.tiles.get_pane(&id).is_some_and(|p| p.kind == kind));
    if !is_shown {
        toggle(tree, kind);
    }
}

/// Adds a panel: as a tab beside another of its kind, otherwise in the largest tile.
pub(in crate::ui) fn add(tree: &mut Tree<Pane>, pane: Pane) {
    let is_kind = |tile: &Tile<Pane>| matches!(tile, Tile::Pane(other) if other.kind == pane.kind);
    let beside = tree.tiles.iter().find(|(_, tile)| is_kind(tile)).map(|(&id, _)| id);
    let widest = || {
        let area = |id: &TileId| tree.tiles.rect(*id).map_or(0.0, |rect| rect.area());
        let panes = tree.tiles.iter().filter(|(_, tile)| matches!(tile, Tile::Pane(_))).map(|(&id, _)| id);
        panes.max_by(|a, b| area(a).total_cmp(&area(b)))
    };
    let Some(beside) = beside.or_else(widest) else {
        let mut tiles = Tiles::default();
        let id = tiles.insert_pane(pane);
        let root = tiles.insert_tab_tile(vec![id]);
        *tree = Tree::new(egui::Id::unique("panes"), root, tiles);
        return;
    };
    let id = tree.tiles.insert_pane(pane);
    let parent = tree.tiles.parent_of(beside);
    match parent.and_then(|parent| tree.tiles.get_mut(parent)) {
        Some(Tile::Container(container)) => {
            container.add_child(id);
            tree.make_active(|other, _| other == id);
        }
        _ => {
            let root = tree.tiles.insert_tab_tile(vec![beside, id]);
            tree.root = Some(root);
            tree.make_active(|other, _| other == id);
        }
    }
}

/// Shows panels in their tiles.
pub(super) struct Panes<'a> {
    pub(super) cx: Context<'a>,
    pub(super) focus: &'a mut Focus,
    /// The panel whose tab was double-clicked.
    pub(super) maximise: Option<TileId>,
}

impl Behavior<Pane> for Panes<'_> {
    fn pane_ui(&mut self, ui: &mut egui::Ui, id: TileId, pane: &mut Pane) -> UiResponse {
        focus::stop(ui, id, &pane.title(), self.focus);
        // A panel that got keyboard focus keeps such commands until the cursor moves.
        let is_moving = ui.input(|input| input.pointer.delta() != Vec2::ZERO || input.pointer.any_down());
        if ui.rect_contains_pointer(ui.max_rect()) && (is_moving || self.focus.under.is_none()) {
            self.focus.under = Some(id);
        }
        // The same id whatever is above: keyboard focus stays where it is when a line of the window goes. With the kind,
        // since ids restart with every layout: a list would otherwise inherit another panel's scroll position.
        let own = egui::UiBuilder::new().scope_id(egui::Id::unique(("contents of a panel", id, pane.kind)));
        ui.scope_builder(own, |ui| {
            egui::Frame::NONE.inner_margin(6.0).show(ui, |ui| {
                ui.set_min_size(ui.available_size());
                let (size, wanted) = (ui.available_size(), ui.available_size().max(pane.panel.least()));
                if size == wanted {
                    pane.panel.show(ui, &mut self.cx);
                    return;
                }
                let area = egui::ScrollArea::both().auto_shrink(false).min_scrolled_width(0.0).min_scrolled_height(0.0);
                area.show(ui, |ui| {
                    let room = egui::Rect::from_min_size(ui.cursor().min, wanted);
                    ui.scope_builder(egui::UiBuilder::new().max_rect(room), |ui| pane.panel.show(ui, &mut self.cx));
                    ui.advance_cursor_after_rect(room);
                });
            });
        });
        UiResponse::None
    }

    fn tab_title_for_pane(&mut self, pane: &Pane) -> egui::WidgetText {
        pane.title().into()
    }

    fn on_tab_button(&mut self, tiles: &mut Tiles<Pane>, id: TileId, tab: egui::Response) -> egui::Response {
        // Commands about a view go to the panel whose tab was clicked.
        if tab.clicked() && tiles.get_pane(&id).is_some() {
            self.focus.under = Some(id);
        }
        if tab.double_clicked() && tiles.get_pane(&id).is_some() {
            self.maximise = Some(id);
        }
        tab.on_hover_text("double-click or F12: maximise")
    }

    fn is_tab_closable(&self, _tiles: &Tiles<Pane>, _id: TileId) -> bool {
        true
    }

    fn simplification_options(&self) -> SimplificationOptions {
        SimplificationOptions { all_panes_must_have_tabs: true, ..SimplificationOptions::default() }
    }

    fn gap_width(&self, _style: &egui::Style) -> f32 {
        4.0
    }

    fn min_size(&self) -> f32 {
        60.0
    }
}
