//! Paints heads and rows.

use std::sync::Arc;

use egui::text::{LayoutJob, TextFormat, TextWrapping};
use egui::{Color32, FontId, Galley, Painter, Pos2, Rect, Response, Sense, Shape, Stroke, Ui, pos2, vec2};

use super::measure::{ARROW, Columns, GAP, MARGIN, MOST_LINES, PADDING, SWATCH, font, indentation};
use super::order::Sort;
use super::rows::{Kind, Look};
use super::{Table, View};

impl Table {
    /// Paints the heads; a click on one sorts.
    pub(super) fn paint_heads(&mut self, ui: &Ui, view: &View<'_>, columns: &Columns, rect: Rect) {
        let painter = ui.painter();
        painter.rect_filled(rect, 0.0, ui.visuals().panel_fill);
        painter.hline(rect.x_range(), rect.bottom(), ui.visuals().widgets.noninteractive.bg_stroke);
        let font = font(ui, Kind::Text);
        let left_out: Vec<_> = columns.left_out.iter().rev().filter_map(|&i| Some(view.heads.get(i)?.name)).collect();
        let mut hidden =
            (!left_out.is_empty()).then(|| format!("no room for {}: widen the panel", left_out.join(", ")));
        for (i, head) in view.heads.iter().enumerate() {
            let [x, width] = columns.at.get(i).copied().unwrap_or_default();
            if width <= 0.0 {
                continue;
            }
            if is_cut(ui, rect.left(), [x, width], columns) {
                hidden = Some("more columns: scroll to the right (Shift and the wheel), or widen the panel".into());
                break;
            }
            let cell =
                Rect::from_min_size(pos2(rect.left() + x - 0.5 * GAP, rect.top()), vec2(width + GAP, rect.height()));
            let response = ui.interact(cell, ui.scope_id().with((view.name, "head", i)), Sense::CLICK);
            let name = format!("sort {} by {}", view.name, head.name);
            response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::ColumnHeader, true, &name));
            let sort = self.sort.filter(|sort| sort.column == i);
            let color = match (response.hovered(), sort) {
                (false, None) => ui.visuals().weak_text_color(),
                _ => ui.visuals().strong_text_color(),
            };
            let galley = painter.layout_no_wrap(head.name.to_owned(), font.clone(), color);
            let y = rect.center().y - 0.5 * galley.size().y;
            let left = cell.left() + 0.5 * GAP;
            let (text, arrow) = match head.kind {
                Kind::Number => (left + width - galley.size().x, left + width - galley.size().x - 7.0),
                Kind::Text | Kind::Tree | Kind::Prose => (left, left + galley.size().x + 7.0),
            };
            painter.galley(pos2(text, y), galley, color);
            if let Some(sort) = sort {
                self::arrow(painter, pos2(arrow, rect.center().y), sort, color);
            }
            if response.on_hover_text(head.about).clicked() {
                self.sort = Sort::clicked(self.sort, i);
                ui.ctx().request_repaint();
            }
        }
        if let Some(hidden) = hidden {
            more(ui, rect, &hidden);
        }
    }

    /// Paints the rows in view; returns the one that was clicked.
    pub(super) fn paint_rows(
        &mut self,
        ui: &Ui,
        view: &View<'_>,
        columns: &Columns,
        body: Rect,
        line: f32,
    ) -> Option<usize> {
        let clip = ui.clip_rect();
        let from = self.tops.partition_point(|top| body.top() + top < clip.top()).saturating_sub(1);
        let mut chosen = None;
        for at in from..self.tops.len().saturating_sub(1) {
            let Some([top, bottom]) = self.span(at).filter(|[top, _]| body.top() + top < clip.bottom()) else { break };
            let row = self.row(at);
            let rect = Rect::from_min_max(
                pos2(body.left(), body.top() + top),
                pos2(body.right().max(clip.right()), body.top() + bottom),
            );
            let response = ui.interact(rect, ui.scope_id().with((view.name, row)), Sense::CLICK);
            let visuals = ui.visuals();
            let is_current = view.current == Some(row);
            if is_current {
                ui.painter().rect_filled(rect, 0.0, visuals.selection.bg_fill);
            } else if response.hovered() {
                ui.painter().rect_filled(rect, 0.0, visuals.widgets.hovered.weak_bg_fill.gamma_multiply(0.5));
            } else if at % 2 == 1 {
                ui.painter().rect_filled(rect, 0.0, visuals.faint_bg_color);
            }
            for column in 0..view.heads.len() {
                self.paint_cell(ui, view, columns, rect, [row, column], line);
            }
            let response = self.tell(ui, view, columns, response, row);
            if response.clicked() {
                chosen = Some(row);
            }
            if let Some(fold) = self.fold_in_tree(view, row) {
                ui.ctx().accesskit_node_builder(response.id, |node| node.set_expanded(fold.is_open));
                if response.double_clicked() && !fold.is_fixed {
                    self.folded = Some(row);
                }
            }
            response.context_menu(|ui| self.menu(ui, view, row));
        }
        chosen
    }

    fn paint_cell(
        &mut self,
        ui: &Ui,
        view: &View<'_>,
        columns: &Columns,
        rect: Rect,
        [row, column]: [usize; 2],
        line: f32,
    ) {
        let (Some(head), Some([x, width])) = (view.heads.get(column), columns.at.get(column).copied()) else { return };
        let is_below = head.kind == Kind::Prose && columns.is_below;
        let clip = ui.clip_rect();
        let mut left = rect.left() + x;
        let is_out = left + width < clip.left() || left > clip.right();
        if !is_below && (width <= 0.0 || is_out || is_cut(ui, rect.left(), [x, width], columns)) {
            return;
        }
        let look = view.rows.look(ui, row, column);
        let strong = (view.current == Some(row)).then(|| ui.visuals().strong_text_color());
        let color = strong.or(look.color).unwrap_or(ui.visuals().text_color());
        let color = if strong.is_some() { look.color.unwrap_or(color) } else { color };
        if let Some((part, color)) = look.bar {
            let bar = vec2((width * part.clamp(0.0, 1.0)).max(1.0), line);
            ui.painter().rect_filled(Rect::from_min_size(pos2(left, rect.top() + 0.5 * PADDING), bar), 1.0, color);
        }
        if let Some(swatch) = look.swatch {
            let at = pos2(left, rect.top() + 0.5 * PADDING + 2.0);
            ui.painter().rect_filled(Rect::from_min_size(at, vec2(7.0, line - 4.0)), 1.0, swatch);
            left += SWATCH;
        }
        let before = left;
        if head.kind == Kind::Tree && self.is_tree(view) {
            left += indentation(view.rows, row);
            self.paint_fold(
                ui,
                view,
                row,
                Rect::from_min_size(pos2(left - ARROW, rect.top()), vec2(ARROW, rect.height())),
            );
        }
        let text = view.rows.text(row, column);
        let (wrap, lines) = match head.kind {
            Kind::Prose => (columns.prose, MOST_LINES),
            Kind::Text | Kind::Tree | Kind::Number => (f32::INFINITY, 1.0),
        };
        let galley = laid_out(ui, text, font(ui, head.kind), look, wrap, lines as usize);
        let size = galley.size();
        let top = rect.top() + 0.5 * PADDING;
        let at = match head.kind {
            // In view however far the other columns are scrolled.
            Kind::Prose if is_below => pos2(clip.left().max(rect.left()) + MARGIN + GAP, top + line),
            Kind::Prose | Kind::Text | Kind::Tree => pos2(left, top),
            Kind::Number => pos2(left + width - size.x, top),
        };
        ui.painter().galley(at, galley, color);
        let swatch = if look.swatch.is_some() { SWATCH } else { 0.0 };
        if head.kind != Kind::Prose && self.widths.grow(column, size.x + swatch + left - before) {
            ui.ctx().request_discard("a column of a table grows");
        }
    }

    /// The arrow that folds a row, if there are rows below it.
    fn paint_fold(&mut self, ui: &Ui, view: &View<'_>, row: usize, rect: Rect) {
        let Some(fold) = self.fold_in_tree(view, row) else { return };
        let sense = if fold.is_fixed { Sense::hover() } else { Sense::CLICK };
        let arrow = ui.interact(rect, ui.scope_id().with((view.name, "fold", row)), sense);
        let does = if fold.is_open { "fold" } else { "unfold" };
        let name = format!("{does} {}", view.rows.fold_name(row));
        arrow.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, !fold.is_fixed, &name));
        let color = match (fold.is_fixed, arrow.hovered()) {
            (true, _) => ui.visuals().weak_text_color(),
            (false, false) => ui.visuals().text_color(),
            (false, true) => ui.visuals().strong_text_color(),
        };
        let corners = [vec2(-2.5, -4.0), vec2(3.0, 0.0), vec2(-2.5, 4.0)];
        let turned = |corner: egui::Vec2| if fold.is_open { vec2(-corner.y, corner.x) } else { corner };
        let center = pos2(rect.left() + 5.0, rect.center().y);
        let corners = corners.map(|corner| center + turned(corner)).to_vec();
        ui.painter().add(Shape::convex_polygon(corners, color, Stroke::NONE));
        if arrow.clicked() {
            self.folded = Some(row);
        }
    }

    /// The row in words, for screen readers, and more about the cell under the cursor.
    fn tell(&self, ui: &Ui, view: &View<'_>, columns: &Columns, response: Response, row: usize) -> Response {
        let is_current = view.current == Some(row);
        response
            .widget_info(|| egui::WidgetInfo::selected(egui::Role::Row, true, is_current, line_of(view, row, ", ")));
        let Some(pointer) = response.hover_pos() else { return response };
        let left = response.rect.left();
        let is_at = |[x, width]: &[f32; 2]| {
            *width > 0.0 && (x - 0.5 * GAP..x + width + 0.5 * GAP).contains(&(pointer.x - left))
        };
        let is_below =
            columns.is_below && pointer.y > response.rect.top() + ui.text_style_height(&egui::TextStyle::Body);
        let prose = || view.heads.iter().position(|head| head.kind == Kind::Prose);
        let column = if is_below { prose() } else { columns.at.iter().position(is_at) };
        match column.and_then(|column| view.rows.about(row, column)) {
            Some(about) => response.on_hover_text(about),
            None => response,
        }
    }

    fn menu(&self, ui: &mut Ui, view: &View<'_>, row: usize) {
        if ui.button("Copy row").clicked() {
            ui.ctx().copy_text(line_of(view, row, "\t"));
        }
        let [shown, _] = self.counts();
        if ui.button(format!("Copy {shown} rows")).on_hover_text("with heads, separated by tabs").clicked() {
            let heads = view.heads.iter().map(|head| head.name).collect::<Vec<_>>().join("\t");
            let rows = (0..shown).map(|at| line_of(view, self.row(at), "\t"));
            ui.ctx().copy_text(std::iter::once(heads).chain(rows).collect::<Vec<_>>().join("\n"));
        }
    }
}

/// Width of the sign of more columns.
const SIGN: f32 = 10.0;

/// Whether a column does not fit into the panel: part of a number would be a wrong one. Once the user scrolls to the
/// right, all are shown.
fn is_cut(ui: &Ui, left: f32, [x, width]: [f32; 2], columns: &Columns) -> bool {
    let clip = ui.clip_rect();
    // Where a column is cut, the sign of more columns needs room.
    let sign = if left + columns.width > clip.right() + 0.5 { SIGN } else { 0.0 };
    clip.left() <= left + 1.0 && left + x + width > clip.right() - sign + 0.5
}

/// The sign of more columns at the end of the heads.
fn more(ui: &Ui, rect: Rect, about: &str) {
    let at = pos2(ui.clip_rect().right() - 2.0, rect.center().y);
    let font = font(ui, Kind::Text);
    let text = ui.painter().text(at, egui::Align2::RIGHT_CENTER, "»", font, ui.visuals().strong_text_color());
    let response = ui.interact(text.expand(3.0), ui.scope_id().with("more columns"), Sense::hover());
    response.on_hover_text(about);
}

fn line_of(view: &View<'_>, row: usize, between: &str) -> String {
    (0..view.heads.len()).map(|column| view.rows.text(row, column)).collect::<Vec<_>>().join(between)
}

fn laid_out(ui: &Ui, text: String, font: FontId, look: Look, wrap: f32, lines: usize) -> Arc<Galley> {
    let format = TextFormat { italics: look.is_italic, ..TextFormat::simple(font, Color32::PLACEHOLDER) };
    let mut job = LayoutJob::single_section(text, format);
    job.wrap = TextWrapping { max_width: wrap, max_rows: lines, ..TextWrapping::default() };
    ui.painter().layout_job(job)
}

/// A triangle that points up where values grow downwards.
fn arrow(painter: &Painter, at: Pos2, sort: Sort, color: Color32) {
    let down = if sort.is_descending { 1.0 } else { -1.0 };
    let corners = [vec2(-4.0, -2.5 * down), vec2(4.0, -2.5 * down), vec2(0.0, 3.0 * down)];
    painter.add(Shape::convex_polygon(corners.map(|corner| at + corner).to_vec(), color, Stroke::NONE));
}
