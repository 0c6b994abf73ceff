//! Bookmarks as flags: a click goes there, a menu renames or deletes.

use egui::{Align2, FontId, Key, Rect, Sense, Shape, Stroke, Ui, pos2, vec2};

use crate::ui::pane::Context;
use crate::ui::style::SMALLEST;

/// Height of their lane.
pub(super) const LANE: f32 = 15.0;
/// Width of a flag without its name.
const FLAG: f32 = 10.0;

/// The name that is being entered: of the bookmark at this place.
#[derive(Default)]
pub(super) struct Flags {
    entered: Option<(usize, String)>,
}

impl Flags {
    /// Shows the bookmarks of known places in a lane above the chart, with poles down to `bottom`.
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        cx: &mut Context<'_>,
        lane: Rect,
        bottom: f32,
        x: impl Fn(usize) -> f32,
    ) {
        let known = cx.model.passes.len();
        let at: Vec<(usize, f32)> = cx.bookmarks.list.iter().map(|b| (b.place, x(b.place))).collect();
        let mut deleted = None;
        for (i, &(place, left)) in at.iter().enumerate().filter(|(_, (place, _))| *place <= known) {
            let name = cx.bookmarks.list[i].name.clone();
            let next = at.get(i + 1).map_or(lane.right(), |next| next.1);
            let ink = ui.visuals().text_color();
            let galley = ui.painter().layout_no_wrap(name.clone(), FontId::proportional(SMALLEST), ink);
            let room = (next - left).max(FLAG);
            let wanted = FLAG + 2.0 + galley.size().x;
            let before = i.checked_sub(1).map_or(lane.left(), |before| at[before].1 + FLAG);
            // At the right edge, the name is on the other side of the pole.
            let is_left = wanted > lane.right() - left && wanted < left - before;
            let (has_room, width) = (is_left || wanted <= room, wanted.min(room).max(FLAG));
            let rect = match is_left {
                true => Rect::from_min_max(pos2(left - wanted, lane.top()), pos2(left, lane.bottom())),
                false => Rect::from_min_size(pos2(left, lane.top()), vec2(width, lane.height())),
            };
            let response = ui.interact(rect, ui.scope_id().with(("bookmark", place)), Sense::click());
            let color = ui.visuals().selection.stroke.color;
            let painter = ui.painter();
            painter.vline(left, rect.top()..=bottom, Stroke::new(1.0, color));
            let flag = [vec2(0.0, 1.0), vec2(8.0, 5.0), vec2(0.0, 9.0)].map(|corner| {
                let way = if is_left { -1.0 } else { 1.0 };
                pos2(left + way * corner.x, rect.top() + corner.y)
            });
            painter.add(Shape::convex_polygon(flag.to_vec(), color, Stroke::NONE));
            // A name that does not fit is in the hover text.
            if has_room {
                let from = if is_left { rect.left() } else { left + FLAG };
                let name = Align2::LEFT_CENTER.anchor_size(pos2(from, rect.center().y), galley.size());
                painter.galley(name.min, galley, ink);
            }
            if response.has_focus() || response.hovered() {
                let frame = Stroke::new(1.0, color);
                painter.rect_stroke(rect, 2.0, frame, egui::StrokeKind::Inside);
            }
            let ray = cx.bookmarks.list[i].pixel.map_or_else(String::new, |[x, y]| format!(", pixel {x},{y}"));
            let text = format!("bookmark {name}: after {}{ray}", raystep_lab::text::counted(place, "pass"));
            response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &text));
            if response.clicked() {
                cx.bookmarks.visit(i, cx.asks);
            }
            response.context_menu(|ui| {
                if self.menu(ui, cx, i, place) {
                    deleted = Some(place);
                }
            });
            if self.entered.as_ref().is_some_and(|entered| entered.0 == place) && !response.context_menu_opened() {
                self.entered = None;
            }
            response.on_hover_text(format!("{text}\nright-click: rename or delete"));
        }
        if let Some(place) = deleted {
            cx.bookmarks.toggle(place, cx.selection.pixel);
        }
    }

    /// Returns whether the bookmark is deleted.
    fn menu(&mut self, ui: &mut Ui, cx: &mut Context<'_>, index: usize, place: usize) -> bool {
        let name = cx.bookmarks.list.get(index).map(|bookmark| bookmark.name.clone()).unwrap_or_default();
        if self.entered.as_ref().is_none_or(|entered| entered.0 != place) {
            self.entered = Some((place, name));
        }
        let Some((_, text)) = &mut self.entered else { return false };
        let label = ui.label("name").id;
        let field = ui.text_edit_singleline(text).labelled_by(label);
        let is_done = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
        if ui.button("Rename").clicked() || is_done {
            cx.bookmarks.rename(index, text);
            self.entered = None;
            ui.close();
        }
        let is_deleted = ui.button("Delete").clicked();
        if is_deleted {
            self.entered = None;
            ui.close();
        }
        is_deleted
    }
}
