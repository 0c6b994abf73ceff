//! The field that filters a table, and the number of rows.

use egui::{TextEdit, Ui};

use super::{Table, View};

const ABOUT: &str = "Shows the rows that contain every word. A column with numbers can be compared: t<0.7, rays>=100. \
                     A click on a head sorts by its column.";

impl Table {
    /// The filter, and how many rows it leaves. Before [`show`](Self::show), in the same frame.
    pub(in super::super) fn tools(&mut self, ui: &mut Ui, view: &View<'_>) {
        self.field(ui, view.name);
        self.update(ui, view);
        let [shown, all] = self.counts();
        let rows = if all == 1 { "row" } else { "rows" };
        ui.weak(if shown == all { format!("{all} {rows}") } else { format!("{shown} of {all} {rows}") });
    }

    /// The filter alone: of several tables, or of one that is shown [as a whole](Self::show_all).
    pub(in super::super) fn field(&mut self, ui: &mut Ui, name: &str) {
        let field = TextEdit::singleline(&mut self.filter).id_salt(("filter", name)).hint_text("filter");
        let response = ui.add(field.desired_width(96.0)).on_hover_text(ABOUT);
        let named = format!("filter {name}");
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::TextInput, true, &named));
        if !self.filter.is_empty() && ui.small_button("×").on_hover_text("show all rows").clicked() {
            self.filter.clear();
        }
    }
}
