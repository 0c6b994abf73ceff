//! A panel that has the whole window for a while. The layout underneath stays as it is, and is what is saved.

use egui_tiles::{Behavior as _, Tile, TileId};

use super::layout::{self, Panes};
use super::{Desk, shown_by};
use crate::command::{Command, PaneKind};
use crate::ui::panes::Pane;
use crate::ui::style::in_strong;

/// The maximised panel.
pub(super) struct Maximised {
    pane: TileId,
    /// The panels that the layout showed when this was last checked.
    active: Vec<TileId>,
}

impl Desk {
    /// The panel that has the whole window.
    pub(in crate::ui) fn maximised(&self) -> Option<TileId> {
        self.maximised.as_ref().map(|maximised| maximised.pane)
    }

    /// The panels of the layout in view, excluding those behind other tabs.
    pub(in crate::ui) fn active_panes(&self) -> Vec<TileId> {
        let is_pane = |id: &TileId| self.tree.tiles.get_pane(id).is_some();
        self.tree.active_tiles().into_iter().filter(is_pane).collect()
    }

    pub(super) fn maximise(&mut self, pane: TileId) {
        if self.tree.tiles.get_pane(&pane).is_some() {
            self.maximised = Some(Maximised { pane, active: self.active_panes() });
            self.focus.under = Some(pane);
        }
    }

    /// Maximises the panel with keyboard focus or under the cursor, or restores the layout.
    pub(in crate::ui) fn toggle_maximised(&mut self, ctx: &egui::Context) {
        if self.maximised.take().is_none()
            && let Some(pane) = self.current_pane(ctx)
        {
            self.maximise(pane);
        }
    }

    /// Called before every command; returns whether it has thereby been performed. A command that shows a panel shows
    /// it in place of the maximised one.
    pub(in crate::ui) fn adapt_maximised(&mut self, command: Command) -> bool {
        let Some(now) = self.maximised() else { return false };
        match command {
            Command::Arrange(_) | Command::ArrangeOwn(_) | Command::ResetLayout => self.maximised = None,
            Command::Cancel => {
                self.maximised = None;
                return true;
            }
            Command::Show(kind) => {
                if self.kind_of(now) == Some(kind) {
                    self.maximised = None;
                } else {
                    self.maximise_kind(kind);
                }
                return true;
            }
            _ => {
                // An export changes nothing that is seen, and rays of a branch are seen over a stream.
                use Command::{ExportDataflow, ExportWalk, MaskBranch};
                let is_elsewhere = matches!(command, ExportWalk | ExportDataflow | MaskBranch);
                if let Some(kind) = shown_by(command).filter(|_| !is_elsewhere)
                    && self.kind_of(now) != Some(kind)
                {
                    self.maximise_kind(kind);
                }
            }
        }
        false
    }

    fn kind_of(&self, id: TileId) -> Option<PaneKind> {
        self.tree.tiles.get_pane(&id).map(|pane| pane.kind)
    }

    fn maximise_kind(&mut self, kind: PaneKind) {
        layout::show(&mut self.tree, kind);
        if let Some(pane) = self.active_panes().into_iter().find(|id| self.kind_of(*id) == Some(kind)) {
            self.maximise(pane);
        }
    }

    /// Follows changes of the layout: a panel that was closed is no longer maximised, and one that was opened is.
    pub(super) fn follow_layout(&mut self) {
        let active = self.active_panes();
        let Some(maximised) = &mut self.maximised else { return };
        if maximised.active != active {
            let opened = active.iter().find(|id| !maximised.active.contains(id));
            maximised.pane = opened.copied().unwrap_or(maximised.pane);
            maximised.active = active;
        }
        if self.tree.tiles.get_pane(&maximised.pane).is_none() {
            self.maximised = None;
        }
    }

    /// Shows the maximised panel, and how to restore the layout. Returns whether there is one.
    pub(super) fn show_maximised(&mut self, ui: &mut egui::Ui, panes: &mut Panes<'_>) -> bool {
        let Some(id) = self.maximised() else { return false };
        let Some(Tile::Pane(pane)) = self.tree.tiles.get_mut(id) else { return false };
        if head(ui, pane) {
            self.maximised = None;
            ui.ctx().request_discard("the layout was restored");
        }
        let _no_drag = panes.pane_ui(ui, id, pane);
        true
    }
}

/// The title; returns whether the layout is to be restored.
fn head(ui: &mut egui::Ui, pane: &Pane) -> bool {
    let title = pane.title();
    let mut is_over = false;
    egui::Frame::NONE.inner_margin(egui::Margin::symmetric(6, 3)).show(ui, |ui| {
        ui.horizontal_wrapped(|ui| {
            let label = egui::Label::new(in_strong(&title)).sense(egui::Sense::click());
            is_over |= ui.add(label).on_hover_text("double-click: restore the layout").double_clicked();
            is_over |= ui.button("Restore layout").clicked();
            ui.weak("or F12, Escape, or double-click the title");
        });
        ui.separator();
    });
    is_over
}
