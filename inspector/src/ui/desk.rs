//! The arrangement of panels: tiles, keyboard focus, and a panel that has the whole window.

pub(super) mod arranged;
mod focus;
pub(super) mod layout;
mod maximise;

use egui::Rect;
use egui_tiles::{Tile, TileId, Tree};
use smart_default::SmartDefault;

use super::pane::Context;
use super::panes::Pane;
use crate::command::{Command, Layout, PaneKind};
use arranged::Arranged;
use focus::Focus;
use layout::Panes;
use maximise::Maximised;

/// The arrangement of panels.
#[derive(SmartDefault)]
pub(super) struct Desk {
    #[default(layout::tree(Layout::default()))]
    pub(super) tree: Tree<Pane>,
    pub(super) arranged: Arranged,
    focus: Focus,
    maximised: Option<Maximised>,
    /// Whether something that Escape leaves had keyboard focus at the end of the last frame.
    had_focus: bool,
}

impl Desk {
    /// Before a frame: what got keyboard focus in the last one comes into view.
    pub(super) fn begin(&mut self, ctx: &egui::Context) {
        focus::reveal(ctx, &mut self.focus);
    }

    /// Shows the panels.
    pub(super) fn show(&mut self, ui: &mut egui::Ui, cx: Context<'_>) {
        self.focus.begin();
        self.follow_layout();
        let mut focus = std::mem::take(&mut self.focus);
        let mut panes = Panes { cx, focus: &mut focus, maximise: None };
        if !self.show_maximised(ui, &mut panes) {
            self.tree.ui(&mut panes, ui);
        }
        let maximise = panes.maximise;
        self.focus = focus;
        if let Some(pane) = maximise {
            self.maximise(pane);
        }
    }

    /// After a frame: what has keyboard focus is outlined.
    pub(super) fn end(&mut self, ctx: &egui::Context) {
        focus::outline(ctx, &mut self.focus);
    }

    /// Notes whether something has focus that Escape leaves.
    pub(super) fn note_focus(&mut self, ctx: &egui::Context) {
        self.had_focus = self.has_focus(ctx);
    }

    /// Shows or hides a panel. Commands about a view go to one that is shown, until the cursor moves.
    pub(super) fn toggle(&mut self, kind: PaneKind) {
        layout::toggle(&mut self.tree, kind);
        let is_kind = |id: &TileId| self.tree.tiles.get_pane(id).is_some_and(|pane| pane.kind == kind);
        self.focus.under = self.tree.active_tiles().into_iter().find(is_kind).or(self.focus.under);
    }

    /// Whether something had it at the end of the last frame.
    pub(super) fn had_focus(&self) -> bool {
        self.had_focus
    }

    /// Passes a command about a view to the panels until one handles it: first the one under the cursor, then streams.
    /// A panel that does its work is shown first.
    pub(super) fn ask(&mut self, command: Command, cx: &mut Context<'_>) {
        if let Some(kind) = shown_by(command) {
            layout::show(&mut self.tree, kind);
        }
        let (active, under) = (self.tree.active_tiles(), self.focus.under);
        let panes = self.tree.tiles.iter_mut().filter_map(|(id, tile)| match tile {
            Tile::Pane(pane) => {
                Some(((!active.contains(id), Some(*id) != under, pane.kind != PaneKind::Stream, id.0), pane))
            }
            Tile::Container(_) => None,
        });
        let mut panes: Vec<_> = panes.collect();
        panes.sort_by_key(|(order, _)| *order);
        let _handled = panes.into_iter().any(|(_, pane)| pane.panel.command(command, cx));
    }

    /// The visible panels, excluding those behind other tabs.
    pub(super) fn in_view(&self) -> Vec<PaneKind> {
        let panes = self.maximised().map_or_else(|| self.active_panes(), |pane| vec![pane]);
        panes.into_iter().filter_map(|id| self.tree.tiles.get_pane(&id)).map(|pane| pane.kind).collect()
    }

    /// The place of the first visible panel of a kind, in points.
    pub(super) fn rect_of(&self, kind: PaneKind) -> Option<Rect> {
        let mut active = self.tree.active_tiles().into_iter();
        let is_kind = |id: &egui_tiles::TileId| self.tree.tiles.get_pane(id).is_some_and(|pane| pane.kind == kind);
        active.find(is_kind).and_then(|id| self.tree.tiles.rect(id))
    }
}

/// The panel that a command shows to do its work.
fn shown_by(command: Command) -> Option<PaneKind> {
    use Command as C;
    Some(match command {
        C::Compare => PaneKind::Compare,
        C::Divergence => PaneKind::Divergence,
        C::Judge => PaneKind::Error,
        C::Measure => PaneKind::Choices,
        C::PreviousRayByCost | C::NextRayByCost => PaneKind::Cost,
        C::NextBranch | C::PreviousBranch | C::MaskBranch => PaneKind::Kernel,
        C::ExportWalk | C::SecondWalk => PaneKind::Walk2d,
        C::FrameWalk | C::PaintScene => PaneKind::Walk3d,
        C::ExportDataflow => PaneKind::Dataflow,
        C::NextSlice | C::PreviousSlice | C::SliceAxis => PaneKind::Structure,
        _ => return None,
    })
}
