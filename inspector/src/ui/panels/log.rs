//! The log.

use egui::{Label, RichText};

use crate::ui::pane::{Context, Panel};
use crate::ui::shared::LogLine;

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
                ui.horizontal(|ui| {
                    let head = Label::new(RichText::new(head(line)).monospace().weak()).extend();
                    ui.add(head).on_hover_text("time since the start, and the number of passes that had run");
                    let error = ui.visuals().error_fg_color;
                    if line.is_error {
                        ui.colored_label(error, "error");
                    }
                    let text = RichText::new(&line.text);
                    let text = if line.is_error { text.color(error) } else { text };
                    ui.add(Label::new(text).selectable(true).truncate()).on_hover_text(&line.text);
                });
            }
        });
    }
}

/// Time and place of a message, in columns.
fn head(line: &LogLine) -> String {
    let time = line.at_ns.map_or_else(String::new, |ns| format!("{:>8.1} s", ns as f64 / 1e9));
    format!("{time} pass {:<4}", line.place)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_says_when_and_where() {
        let line = |at_ns, place| LogLine { is_error: false, text: "x".into(), at_ns, place };
        assert_eq!(head(&line(Some(12_340_000_000), 7)), "    12.3 s pass 7   ");
        assert_eq!(head(&line(None, 73)), " pass 73  ");
    }
}
