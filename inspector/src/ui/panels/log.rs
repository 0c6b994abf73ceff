//! The log.

use crate::ui::pane::{Context, Panel};

/// The log panel.
#[derive(Default)]
pub(in crate::ui) struct Log;

impl Panel for Log {
    fn title(&self) -> String {
        "Log".into()
    }

    fn show(&mut self, ui: &mut egui::Ui, cx: &mut Context<'_>) {
        let lines = &cx.shared.log;
        if lines.is_empty() {
            ui.weak("No messages yet.");
        }
        let height = ui.text_style_height(&egui::TextStyle::Body);
        let area = egui::ScrollArea::vertical().auto_shrink(false).stick_to_bottom(true);
        area.show_rows(ui, height, lines.len(), |ui, rows| {
            for line in &lines[rows] {
                let text = egui::RichText::new(&line.text);
                let text = if line.is_error { text.color(ui.visuals().error_fg_color) } else { text };
                ui.add(egui::Label::new(text).selectable(true).truncate()).on_hover_text(&line.text);
            }
        });
    }
}
