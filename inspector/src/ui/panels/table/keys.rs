//! Keys of the table that has the focus: up and down choose the row before and after the current one; in a tree, left
//! folds a row or goes to the one around it, and right unfolds it or goes into it.

use egui::{Context, EventFilter, Id, Key, Modifiers, Rect, Response, Sense, StrokeKind, Ui};

use super::{Table, View};

/// Keys that a table takes while it has the focus; all others stay commands.
const KEYS: [Key; 4] = [Key::ArrowUp, Key::ArrowDown, Key::PageUp, Key::PageDown];

/// Further keys of a tree.
const KEYS_OF_TREE: [Key; 2] = [Key::ArrowLeft, Key::ArrowRight];

fn slot() -> Id {
    Id::unique("the table with the focus")
}

/// Whether a table has the keyboard's focus, and whether it is a tree.
fn focused(ctx: &Context) -> Option<bool> {
    let (table, is_tree): (Id, bool) = ctx.data(|data| data.get_temp(slot()))?;
    (ctx.memory(egui::Memory::focused) == Some(table)).then_some(is_tree)
}

/// Whether a table has the keyboard's focus.
pub(in crate::ui) fn is_focused(ctx: &Context) -> bool {
    focused(ctx).is_some()
}

/// Whether a table has the focus that takes this key.
pub(in crate::ui) fn takes(ctx: &Context, modifiers: Modifiers, key: Key) -> bool {
    let is_taken = |is_tree| KEYS.contains(&key) || is_tree && KEYS_OF_TREE.contains(&key);
    modifiers.is_none() && focused(ctx).is_some_and(is_taken)
}

/// The area that has the focus for all rows.
pub(super) fn area(ui: &Ui, id: Id, rect: Rect, sentence: &str, is_tree: bool) -> Response {
    let response = ui.interact(rect, id, Sense::focusable_noninteractive());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Table, true, sentence));
    if response.has_focus() {
        let keys = EventFilter { vertical_arrows: true, horizontal_arrows: true, ..EventFilter::default() };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(id, keys));
        ui.data_mut(|data| data.insert_temp(slot(), (id, is_tree)));
        ui.painter().rect_stroke(rect, 2.0, ui.visuals().selection.stroke, StrokeKind::Inside);
    }
    response
}

impl Table {
    /// The row that the keys of this frame choose.
    pub(super) fn keys(&mut self, ui: &Ui, focus: &Response, view: &View<'_>, page: usize) -> Option<usize> {
        // A row that was chosen before is where the next key counts from until it is reached, also while the table shows
        // rows on the way to it.
        self.moved = self.moved.filter(|&(from, to)| match (from, view.current) {
            (Some(from), Some(row)) => row != to && (from.min(to)..=from.max(to)).contains(&row),
            (from, current) => from == current,
        });
        if !focus.has_focus() {
            return None;
        }
        let times = KEYS.map(|key| ui.input_mut(|input| input.count_and_consume_key(Modifiers::NONE, key)));
        if self.is_tree(view)
            && let Some(row) = self.turn_of_tree(ui, view)
        {
            return Some(row);
        }
        let [up, down, page_up, page_down] = times;
        let (back, on) = (up + page * page_up, down + page * page_down);
        if back == on {
            return None;
        }
        let from = self.moved.map(|(_, to)| to).or(view.current);
        let at = from.and_then(|row| self.position(row, view));
        let [shown, _] = self.counts();
        let to = at.map_or(0, |at| (at + on).saturating_sub(back)).min(shown.checked_sub(1)?);
        let row = self.row(to);
        self.moved = Some((self.moved.map_or(view.current, |(from, _)| from), row));
        Some(row)
    }

    /// Folds or unfolds the current row, or returns the row around it, or the first one in it.
    fn turn_of_tree(&mut self, ui: &Ui, view: &View<'_>) -> Option<usize> {
        let [left, right] = KEYS_OF_TREE.map(|key| ui.input_mut(|input| input.consume_key(Modifiers::NONE, key)));
        let row = view.current.filter(|_| left != right)?;
        let (at, depth) = (self.position(row, view)?, view.rows.depth(row));
        match view.rows.fold(row) {
            Some(fold) if right && fold.is_open => Some(self.row(at + 1)),
            Some(fold) if fold.is_open == left && !fold.is_fixed => {
                self.folded = Some(row);
                None
            }
            _ if left => (0..at).rev().map(|at| self.row(at)).find(|&other| view.rows.depth(other) < depth),
            _ => None,
        }
    }
}
