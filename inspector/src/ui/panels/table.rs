//! Tables: sorted by a click on a head, filtered by words, with columns that fit their contents, and keys.
//!
//! Rows are painted directly: only those in view are laid out, and a cell is no widget of its own. What depends on all
//! rows (order, widths, heights) is kept until they change.

mod keys;
mod measure;
mod order;
mod paint;
mod rows;
mod tools;

use std::hash::{DefaultHasher, Hash, Hasher};

use egui::{Align, Id, Rect, ScrollArea, Sense, TextStyle, Ui, pos2, vec2};

use super::scroll::Scroll;
pub(in crate::ui) use keys::{is_focused, takes};
use measure::{Columns, GAP, PADDING, Widths};
use order::Sort;
pub(super) use rows::{Fold, Head, Listed, ListedCell, Look, Rows};

/// What a table shows in a frame.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    /// Its name, for screen readers.
    pub(super) name: &'a str,
    /// Its columns.
    pub(super) heads: &'a [Head<'a>],
    /// Its rows.
    pub(super) rows: &'a dyn Rows,
    /// Changes whenever the texts do, unless only rows are added at the end.
    pub(super) version: u64,
    /// The row that is highlighted, and kept in view.
    pub(super) current: Option<usize>,
}

/// A version of what texts depend on.
pub(super) fn version(of: impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    of.hash(&mut hasher);
    hasher.finish()
}

/// What the order of rows depends on.
type Question = (u64, usize, Option<u64>, Option<Sort>, String);

/// What the heights of rows depend on.
type Layout = (u64, u64, Columns, f32);

/// A table, between frames.
#[derive(Default)]
pub(super) struct Table {
    sort: Option<Sort>,
    pub(super) filter: String,
    question: Option<Question>,
    /// The rows that are shown; `None` for all in their natural order.
    order: Option<Vec<usize>>,
    /// How many rows there are to sort and filter.
    all: usize,
    /// Incremented with the order.
    ordered: u64,
    widths: Widths,
    layout: Option<Layout>,
    tops: Vec<f32>,
    scroll: Scroll,
    /// Whether to scroll to the first row.
    rewinds: bool,
    /// Where it is on the screen: in another place or size, the current row may be out of view.
    seen: Option<(Id, [u32; 2])>,
    /// The current row, and the row that was chosen by a key since: keys may come faster than rows change.
    moved: Option<(Option<usize>, usize)>,
    /// A row of a tree that is to be folded or unfolded.
    folded: Option<usize>,
}

impl Table {
    /// Shows the table in the space that is left, scrolling. Returns a row that was clicked, or chosen by a key.
    pub(super) fn show(&mut self, ui: &mut Ui, view: &View<'_>) -> Option<usize> {
        self.scrolled(ui, view, false)
    }

    /// As [`show`](Self::show), and stays at the last row while rows are added, unless the user scrolls away.
    pub(super) fn follow(&mut self, ui: &mut Ui, view: &View<'_>) -> Option<usize> {
        self.scrolled(ui, view, true)
    }

    fn scrolled(&mut self, ui: &mut Ui, view: &View<'_>, sticks: bool) -> Option<usize> {
        self.update(ui, view);
        let id = ui.scope_id().with(view.name);
        let area = ui.available_rect_before_wrap();
        let seen = Some((id, [area.width(), area.height()].map(|side| side as u32)));
        if std::mem::replace(&mut self.seen, seen) != seen {
            self.scroll = Scroll::default();
        }
        let focus = keys::area(ui, id, area, &self.sentence(view), self.is_tree(view));
        let mut chosen = None;
        let mut area_of_rows = ScrollArea::both().id_salt(view.name).auto_shrink(false).animated(false);
        if std::mem::take(&mut self.rewinds) {
            area_of_rows = area_of_rows.vertical_scroll_offset(0.0);
        }
        area_of_rows.stick_to_bottom(sticks).show_viewport(ui, |ui, _| {
            let (columns, line) = self.place(ui, view, ui.clip_rect().width() - GAP);
            let head = line + PADDING;
            let (rect, _) = ui.allocate_exact_size(vec2(columns.width, head + self.height()), Sense::hover());
            let body = Rect::from_min_max(pos2(rect.left(), rect.top() + head), rect.max);
            self.keep_in_view(ui, view, body, head);
            let whole = ui.clip_rect();
            ui.set_clip_rect(Rect::from_min_max(pos2(whole.left(), whole.top() + head), whole.max));
            chosen = self.paint_rows(ui, view, &columns, body, line);
            ui.set_clip_rect(whole);
            let heads = Rect::from_min_size(pos2(rect.left(), whole.top().max(rect.top())), vec2(columns.width, head));
            self.paint_heads(ui, view, &columns, heads);
        });
        if chosen.is_some() {
            focus.request_focus();
            self.moved = None;
        }
        let page = (area.height() / (ui.text_style_height(&TextStyle::Body) + PADDING)).max(2.0) as usize - 1;
        chosen.or_else(|| self.keys(ui, &focus, view, page))
    }

    /// Shows the whole table: for few rows, in a panel that scrolls itself.
    pub(super) fn show_all(&mut self, ui: &mut Ui, view: &View<'_>) -> Option<usize> {
        self.update(ui, view);
        let (columns, line) = self.place(ui, view, ui.available_width());
        let head = line + PADDING;
        let (rect, _) = ui.allocate_exact_size(vec2(columns.width, head + self.height()), Sense::hover());
        let body = Rect::from_min_max(pos2(rect.left(), rect.top() + head), rect.max);
        let chosen = self.paint_rows(ui, view, &columns, body, line);
        let heads = Rect::from_min_size(rect.min, vec2(columns.width, head));
        self.paint_heads(ui, view, &columns, heads);
        chosen
    }

    /// Scrolls to the first row in the next frame that shows the table.
    pub(super) fn rewind(&mut self) {
        self.rewinds = true;
    }

    /// The rows that are shown, and how many there are.
    fn counts(&self) -> [usize; 2] {
        [self.order.as_ref().map_or(self.all, Vec::len), self.all]
    }

    fn sentence(&self, view: &View<'_>) -> String {
        let [shown, all] = self.counts();
        let which = if shown == all { format!("{all} rows") } else { format!("{shown} of {all} rows") };
        format!("{}: {which}", view.name)
    }

    /// The row at a position of the order.
    fn row(&self, at: usize) -> usize {
        self.order.as_ref().map_or(at, |order| order.get(at).copied().unwrap_or_default())
    }

    /// The position of a row in the order.
    fn position(&self, row: usize, view: &View<'_>) -> Option<usize> {
        match &self.order {
            Some(order) => order.iter().position(|&other| other == row),
            None => (row < view.rows.count()).then_some(row),
        }
    }

    /// Whether all rows are shown in their natural order, as far as they are unfolded.
    pub(super) fn is_plain(&self) -> bool {
        self.sort.is_none() && self.filter.trim().is_empty()
    }

    /// Whether rows are shown as a tree: sorted or filtered, they are a list.
    fn is_tree(&self, view: &View<'_>) -> bool {
        self.is_plain() && view.rows.unfolded().is_some()
    }

    fn fold_in_tree(&self, view: &View<'_>, row: usize) -> Option<Fold> {
        view.rows.fold(row).filter(|_| self.is_tree(view))
    }

    /// A row that the user has folded or unfolded, once.
    pub(super) fn take_folded(&mut self) -> Option<usize> {
        self.folded.take()
    }

    /// Sorts, filters and measures what has changed.
    fn update(&mut self, ui: &Ui, view: &View<'_>) {
        let is_plain = self.is_plain();
        let tree = view.rows.unfolded().filter(|_| is_plain);
        let (count, unfolded) = (view.rows.count(), tree.map(|(version, _)| version));
        let is_same = self.question.as_ref().is_some_and(|question| {
            let (version, rows, folds, sort, filter) = question;
            let is_asked = (*sort, filter.as_str()) == (self.sort, self.filter.as_str());
            is_asked && (*version, *rows, *folds) == (view.version, count, unfolded)
        });
        if !is_same {
            let was_plain = self.question.as_ref().is_none_or(|(.., sort, filter)| sort.is_none() && filter.is_empty());
            self.question = Some((view.version, count, unfolded, self.sort, self.filter.clone()));
            self.order = match tree {
                Some((_, rows)) => Some(rows.to_vec()),
                None => order::order(view.rows, view.heads, self.sort, &self.filter),
            };
            // What is folded is not left out.
            self.all = tree.map_or_else(
                || (0..count).filter(|&row| view.rows.fold(row).is_none()).count(),
                |(_, rows)| rows.len(),
            );
            self.ordered += 1;
            if !(is_plain && was_plain) {
                // The current row is elsewhere now.
                self.scroll = Scroll::default();
            }
        }
        self.widths.update(ui, view.heads, view.rows, view.version);
    }

    /// Where columns are, and the height of a line.
    fn place(&mut self, ui: &Ui, view: &View<'_>, available: f32) -> (Columns, f32) {
        let line = ui.text_style_height(&TextStyle::Body).max(ui.text_style_height(&TextStyle::Monospace));
        let columns = measure::place(view.heads, &self.widths, available);
        let layout = (self.ordered, self.widths.edition, columns.clone(), line);
        if self.layout.as_ref() != Some(&layout) {
            let [shown, _] = self.counts();
            self.tops = measure::tops((0..shown).map(|at| self.row(at)), &self.widths, &columns, line);
            self.layout = Some(layout);
        }
        (columns, line)
    }

    fn height(&self) -> f32 {
        self.tops.last().copied().unwrap_or(0.0)
    }

    /// Top and bottom of a position of the order, below the head.
    fn span(&self, at: usize) -> Option<[f32; 2]> {
        Some([*self.tops.get(at)?, *self.tops.get(at + 1)?])
    }

    /// Scrolls to the current row when it has changed, if it is out of view.
    fn keep_in_view(&mut self, ui: &Ui, view: &View<'_>, body: Rect, head: f32) {
        let Some(row) = self.scroll.to(ui, view.current) else { return };
        let Some([top, bottom]) = self.position(row, view).and_then(|at| self.span(at)) else { return };
        let clip = ui.clip_rect();
        let (top, bottom) = (body.top() + top, body.top() + bottom);
        if top >= clip.top() + head && bottom <= clip.bottom() {
            return;
        }
        // In the middle, below a whole row.
        let above = top - 0.5 * (clip.height() - head - (bottom - top)).max(0.0) - body.top();
        let first = self.tops.partition_point(|&at| at < above);
        let first = body.top() + self.tops.get(first).copied().unwrap_or(0.0).min(top - body.top());
        let shown = Rect::from_min_max(pos2(clip.left(), first - head), pos2(clip.left(), bottom));
        ui.scroll_to_rect_animation(shown, Some(Align::Min), egui::style::ScrollAnimation::none());
    }
}
