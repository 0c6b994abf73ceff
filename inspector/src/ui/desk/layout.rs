//! The arrangement of panels.

use egui::Vec2;
use egui_tiles::{Behavior, SimplificationOptions, Tile, TileId, Tiles, Tree, UiResponse};

use super::focus::{self, Focus};
use crate::command::PaneKind;
use crate::ui::pane::Context;
use crate::ui::panes::Pane;

/// Predefined layouts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::ui) enum Layout {
    /// One stream beside the ray's walk and history, with the passes folded to a strip below them.
    Simple,
    /// The panels for daily use.
    Full,
}

impl Layout {
    pub(in crate::ui) fn tree(self) -> Tree<Pane> {
        let mut tiles = Tiles::default();
        let pane = |tiles: &mut Tiles<Pane>, kind: PaneKind| tiles.insert_pane(Pane::new(kind));
        let tabs = |tiles: &mut Tiles<Pane>, kinds: &[PaneKind]| {
            let children = kinds.iter().map(|&kind| pane(tiles, kind)).collect();
            tiles.insert_tab_tile(children)
        };
        use PaneKind as P;
        let root = match self {
            Self::Simple => {
                let stream = tabs(&mut tiles, &[P::Stream]);
                let [walk, ray] = [P::Walk2d, P::Ray].map(|kind| tabs(&mut tiles, &[kind]));
                let right = vertical(&mut tiles, &[walk, ray], &[0.9, 1.1]);
                let upper = horizontal(&mut tiles, &[stream, right], &[0.85, 1.15]);
                let strip = tabs(&mut tiles, &[P::Timeline, P::Passes]);
                vertical(&mut tiles, &[upper, strip], &[1.0, 0.23])
            }
            Self::Full => {
                let left = tabs(&mut tiles, &[P::Passes, P::Options, P::Watches]);
                let stream = tabs(&mut tiles, &[P::Stream]);
                let walk = tabs(&mut tiles, &[P::Walk3d, P::Walk2d]);
                let center = vertical(&mut tiles, &[stream, walk], &[1.0, 0.8]);
                let right = tabs(&mut tiles, &[P::Ray, P::Kernel, P::Plan]);
                let upper = horizontal(&mut tiles, &[left, center, right], &[0.6, 1.0, 1.0]);
                let lower = tabs(&mut tiles, &[P::Timeline, P::Timings, P::Cost, P::Structure, P::Dataflow, P::Log]);
                vertical(&mut tiles, &[upper, lower], &[1.0, 0.3])
            }
        };
        Tree::new(egui::Id::unique("panes"), root, tiles)
    }
}

fn horizontal(tiles: &mut Tiles<Pane>, children: &[TileId], shares: &[f32]) -> TileId {
    let id = tiles.insert_horizontal_tile(children.to_vec());
    share(tiles, id, children, shares);
    id
}

fn vertical(tiles: &mut Tiles<Pane>, children: &[TileId], shares: &[f32]) -> TileId {
    let id = tiles.insert_vertical_tile(children.to_vec());
    share(tiles, id, children, shares);
    id
}

fn share(tiles: &mut Tiles<Pane>, id: TileId, children: &[TileId], shares: &[f32]) {
    if let Some(Tile::Container(egui_tiles::Container::Linear(linear))) = tiles.get_mut(id) {
        children.iter().zip(shares).for_each(|(&child, &part)| linear.shares.set_share(child, part));
    }
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
