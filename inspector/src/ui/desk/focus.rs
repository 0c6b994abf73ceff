//! Keyboard focus: which panel has it, how it moves between panels, and an outline that shows where it is.

use egui::{Color32, Id, Rect, Stroke, StrokeKind, Ui, accesskit};
use egui_tiles::{Container, Tile, TileId};

use super::Desk;
use crate::ui::keys::Holds;

/// Width of the outline, in points.
const WIDTH: f32 = 2.0;

/// Keyboard focus, as of the last frame.
#[derive(Default)]
pub(super) struct Focus {
    /// The panel that is to get it.
    pub(super) wanted: Option<TileId>,
    /// The panel that the cursor was over last: commands about a view go to it first.
    pub(super) under: Option<TileId>,
    /// The panels in view, and where they are.
    rects: Vec<(TileId, Rect)>,
    /// What had it.
    last: Option<Id>,
    /// What got it outside of the visible part of a list.
    to_reveal: Option<Id>,
}

impl Focus {
    /// Prepares the list of panels for a frame.
    pub(super) fn begin(&mut self) {
        self.rects.clear();
    }
}

/// The outline's colour: at least 3:1 against the panels and the fields of either theme.
pub(super) fn color(is_dark: bool) -> Color32 {
    if is_dark { Color32::from_rgb(110, 185, 255) } else { Color32::from_rgb(0, 95, 205) }
}

/// The id of a panel as a whole.
fn id_of(pane: TileId) -> Id {
    Id::unique(("panel", pane))
}

/// Makes a panel as a whole a stop of the Tab key, from which it goes on into the panel. Keys for commands still work.
pub(super) fn stop(ui: &Ui, pane: TileId, title: &str, focus: &mut Focus) {
    let (id, rect) = (id_of(pane), ui.max_rect());
    let response = ui.interact(rect, id, egui::Sense::focusable_noninteractive());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Pane, true, format!("{title} panel")));
    if focus.wanted == Some(pane) {
        focus.wanted = None;
        response.request_focus();
    }
    if response.has_focus() {
        // Arrow keys select a neighbouring pixel, not the next button.
        let filter = egui::EventFilter { horizontal_arrows: true, vertical_arrows: true, ..Default::default() };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(id, filter));
    }
    focus.rects.push((pane, rect));
}

/// Scrolls to what got keyboard focus in the last frame, as a screen reader would ask for it.
pub(super) fn reveal(ctx: &egui::Context, focus: &mut Focus) {
    if let Some(id) = focus.to_reveal.take() {
        let (action, target_node) = (accesskit::Action::ScrollIntoView, id.accesskit_id());
        let request =
            accesskit::ActionRequest { action, target_node, target_tree: accesskit::TreeId::ROOT, data: None };
        ctx.input_mut(|input| input.events.push(egui::Event::AccessKitActionRequest(request)));
    }
}

/// Outlines what has keyboard focus.
pub(super) fn outline(ctx: &egui::Context, focus: &mut Focus) {
    // To read the response of a widget takes its focus away if something else was clicked in this frame, even if the
    // click gave it that focus.
    if ctx.input(|input| input.pointer.any_click()) {
        ctx.request_repaint();
        return;
    }
    let focused = ctx.memory(|memory| memory.focused());
    let is_new = std::mem::replace(&mut focus.last, focused) != focused;
    let Some((id, response)) = focused.and_then(|id| Some((id, ctx.read_response(id)?))) else { return };
    let is_pane = focus.rects.iter().any(|(pane, _)| id_of(*pane) == id);
    let seen = response.interact_rect;
    if is_new && !is_pane && !seen.expand(1.0).contains_rect(response.rect) {
        focus.to_reveal = Some(id);
        ctx.request_repaint();
    }
    if !seen.is_positive() {
        return;
    }
    let (rect, clip) = match is_pane {
        true => (response.rect.shrink(1.0), seen),
        false => (response.rect.expand(WIDTH), seen.expand(2.0 * WIDTH)),
    };
    let style = ctx.global_style();
    let painter = ctx.layer_painter(response.layer_id).with_clip_rect(clip);
    // The outer line in the background's colour sets it off from pictures.
    let halo = Stroke::new(2.0 * WIDTH, style.visuals.panel_fill);
    painter.rect_stroke(rect, 2.0, halo, StrokeKind::Middle);
    painter.rect_stroke(rect, 2.0, Stroke::new(WIDTH, color(style.visuals.dark_mode)), StrokeKind::Middle);
}

impl Desk {
    /// Which keys belong to what has focus; `keeps_keys`: it uses keys that are commands elsewhere.
    pub(in crate::ui) fn keys_held(&self, ctx: &egui::Context, keeps_keys: bool) -> Holds {
        match ctx.memory(|memory| memory.focused()) {
            None => Holds::Nothing,
            Some(id) if self.is_pane(id) => Holds::Nothing,
            Some(_) if ctx.text_edit_focused() || keeps_keys => Holds::Text,
            Some(_) => Holds::Buttons,
        }
    }

    /// Whether something has focus that Escape leaves, other than a panel as a whole.
    pub(in crate::ui) fn has_focus(&self, ctx: &egui::Context) -> bool {
        ctx.memory(|memory| memory.focused()).is_some_and(|id| !self.is_pane(id))
    }

    fn is_pane(&self, id: Id) -> bool {
        self.focus.rects.iter().any(|(pane, _)| id_of(*pane) == id)
    }

    /// The panels in view, by columns, each from top to bottom.
    fn panes_in_order(&self) -> Vec<TileId> {
        let mut panes = self.focus.rects.clone();
        panes.retain(|(id, _)| self.tree.tiles.get_pane(id).is_some());
        panes.sort_by(|(_, a), (_, b)| a.left().total_cmp(&b.left()).then(a.top().total_cmp(&b.top())));
        panes.into_iter().map(|(id, _)| id).collect()
    }

    /// The panel with keyboard focus.
    pub(super) fn pane_with_focus(&self, ctx: &egui::Context) -> Option<TileId> {
        let id = ctx.memory(|memory| memory.focused())?;
        let own = self.focus.rects.iter().find(|(pane, _)| id_of(*pane) == id);
        let response = ctx.read_response(id)?;
        let at = response.rect.center();
        // Not a dialog over it.
        let is_in = |rect: &Rect| response.layer_id == egui::LayerId::background() && rect.contains(at);
        own.or_else(|| self.focus.rects.iter().find(|(_, rect)| is_in(rect))).map(|(pane, _)| *pane)
    }

    /// The panel with keyboard focus, otherwise the one that the cursor was over last.
    pub(super) fn current_pane(&self, ctx: &egui::Context) -> Option<TileId> {
        let in_view = self.panes_in_order();
        let under = || self.focus.under.filter(|under| in_view.contains(under));
        let largest = || {
            let area = |id: &TileId| self.tree.tiles.rect(*id).map_or(0.0, |rect| rect.area());
            in_view.iter().copied().max_by(|a, b| area(a).total_cmp(&area(b)))
        };
        self.pane_with_focus(ctx).or_else(under).or_else(largest)
    }

    /// Gives a panel keyboard focus; commands about a view then go to it.
    fn focus_pane(&mut self, pane: TileId) {
        self.focus.wanted = Some(pane);
        self.focus.under = Some(pane);
    }

    /// Moves focus to the next or previous panel in view; the first or last one if none has it. A maximised panel gives
    /// way to the next one.
    pub(in crate::ui) fn cycle_panels(&mut self, ctx: &egui::Context, is_forward: bool) {
        let is_maximised = self.maximised().is_some();
        let panes = if is_maximised { self.active_panes() } else { self.panes_in_order() };
        let now = if is_maximised { self.maximised() } else { self.pane_with_focus(ctx) };
        let at = now.and_then(|now| panes.iter().position(|pane| *pane == now));
        let Some(&next) = neighbour(&panes, at, is_forward) else { return };
        if is_maximised {
            self.maximise(next);
        }
        self.focus_pane(next);
    }

    /// Shows the next or previous tab beside the panel with focus or under the cursor, and focuses it.
    pub(in crate::ui) fn cycle_tabs(&mut self, ctx: &egui::Context, is_forward: bool) {
        let Some(now) = self.current_pane(ctx) else { return };
        let Some(parent) = self.tree.tiles.parent_of(now) else { return };
        let Some(Tile::Container(Container::Tabs(tabs))) = self.tree.tiles.get_mut(parent) else { return };
        let at = tabs.children.iter().position(|child| *child == now);
        let Some(&next) = neighbour(&tabs.children, at, is_forward) else { return };
        tabs.set_active(next);
        self.focus_pane(next);
    }
}

/// The element after or before a position, around the ends; the first or last one without a position.
fn neighbour<T>(all: &[T], at: Option<usize>, is_forward: bool) -> Option<&T> {
    let last = all.len().checked_sub(1)?;
    let index = match (at, is_forward) {
        (None, true) => 0,
        (None, false) => last,
        (Some(at), true) => (at + 1) % all.len(),
        (Some(at), false) => at.checked_sub(1).unwrap_or(last),
    };
    all.get(index)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ui::style::contrast;

    #[test]
    fn the_outline_is_seen_on_every_background_of_both_themes() {
        for theme in [egui::Theme::Dark, egui::Theme::Light] {
            let visuals = theme.default_visuals();
            for background in [visuals.panel_fill, visuals.extreme_bg_color, visuals.window_fill] {
                // WCAG 2.1, 1.4.11: 3:1 for parts of the user interface.
                let ratio = contrast(color(visuals.dark_mode), background);
                assert!(ratio >= 3.0, "{theme:?}: {ratio:.2}:1 on {background:?}");
            }
        }
    }

    #[test]
    fn the_neighbour_of_the_last_panel_is_the_first() {
        let all = ['a', 'b', 'c'];
        let step = |at, is_forward| neighbour(&all, at, is_forward).copied();
        assert_eq!([step(None, true), step(None, false)], [Some('a'), Some('c')]);
        assert_eq!([step(Some(2), true), step(Some(0), false), step(Some(0), true)], [Some('a'), Some('c'), Some('b')]);
        assert_eq!(neighbour::<char>(&[], None, true), None);
    }
}
