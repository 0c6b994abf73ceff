//! The log.
//!
//! Touches: log.

use egui::Ui;

use super::table::{Head, Look, Rows, Table, View};
use crate::ui::pane::{Context, Panel};
use crate::ui::state::LogLine;

/// The log panel.
#[derive(Default)]
pub(in crate::ui) struct Log {
    table: Table,
}

const HEADS: [Head<'_>; 4] = [
    Head::number("s", "time since the start, in seconds"),
    Head::number("pass", "the number of passes that had run"),
    Head::text("kind", "errors, and messages about what was done"),
    Head::prose("message", "oldest first"),
];

struct Lines<'a>(&'a [LogLine]);

impl Rows for Lines<'_> {
    fn count(&self) -> usize {
        self.0.len()
    }

    fn text(&self, row: usize, column: usize) -> String {
        let Some(line) = self.0.get(row) else { return String::new() };
        match (column, line.is_error) {
            (0, _) => line.at_ns.map_or_else(String::new, |ns| format!("{:.1}", ns as f64 / 1e9)),
            (1, _) => line.place.to_string(),
            (2, true) => "error".into(),
            (2, false) => "message".into(),
            _ => line.text.clone(),
        }
    }

    fn number(&self, row: usize, column: usize) -> Option<f64> {
        let line = self.0.get(row)?;
        match column {
            0 => line.at_ns.map(|ns| ns as f64),
            1 => Some(line.place as f64),
            _ => None,
        }
    }

    fn about(&self, row: usize, column: usize) -> Option<String> {
        (column == 3).then(|| self.text(row, column))
    }

    fn look(&self, ui: &Ui, row: usize, column: usize) -> Look {
        let color = match self.0.get(row).is_some_and(|line| line.is_error) {
            true => Some(ui.visuals().error_fg_color),
            false => (column < 3).then(|| ui.visuals().weak_text_color()),
        };
        Look { color, ..Look::default() }
    }
}

impl Panel for Log {
    fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        let lines = &cx.log.lines;
        if lines.is_empty() {
            ui.weak("No messages yet.");
            return;
        }
        // The oldest lines are dropped from a full log.
        let version = cx.log.dropped;
        let view = View { name: "log", heads: &HEADS, rows: &Lines(lines), version, current: None };
        ui.horizontal_wrapped(|ui| self.table.tools(ui, &view));
        self.table.follow(ui, &view);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_of_the_log_has_its_time_and_its_place() {
        let line = |at_ns, place| LogLine { is_error: false, text: "x".into(), at_ns, place };
        let lines = [line(Some(12_340_000_000), 7), line(None, 73)];
        let texts = |row| [0, 1].map(|column| Lines(&lines).text(row, column));
        assert_eq!((texts(0), texts(1)), (["12.3".into(), "7".into()], [String::new(), "73".into()]));
    }
}
