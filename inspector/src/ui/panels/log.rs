//! The log.

use egui::Ui;

use super::table::{Head, Look, Rows, Table, View};
use crate::ui::pane::{Context, Panel};
use crate::ui::shared::LogLine;

/// The log panel.
#[derive(Default)]
pub(in crate::ui) struct Log {
    table: Table,
}

const HEADS: [Head<'_>; 2] =
    [Head::text("kind", "errors, and messages about what was done"), Head::prose("message", "oldest first")];

struct Lines<'a>(&'a [LogLine]);

impl Rows for Lines<'_> {
    fn count(&self) -> usize {
        self.0.len()
    }

    fn text(&self, row: usize, column: usize) -> String {
        let Some(line) = self.0.get(row) else { return String::new() };
        match (column, line.is_error) {
            (0, true) => "error".into(),
            (0, false) => "message".into(),
            _ => line.text.clone(),
        }
    }

    fn about(&self, row: usize, column: usize) -> Option<String> {
        (column == 1).then(|| self.text(row, column))
    }

    fn look(&self, ui: &Ui, row: usize, column: usize) -> Look {
        let color = match self.0.get(row).is_some_and(|line| line.is_error) {
            true => Some(ui.visuals().error_fg_color),
            false => (column == 0).then(|| ui.visuals().weak_text_color()),
        };
        Look { color, ..Look::default() }
    }
}

impl Panel for Log {
    fn title(&self) -> String {
        "Log".into()
    }

    fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        let lines = &cx.shared.log;
        if lines.is_empty() {
            ui.weak("No messages yet.");
            return;
        }
        // The oldest lines are dropped from a full log.
        let version = cx.shared.dropped;
        let view = View { name: "log", heads: &HEADS, rows: &Lines(lines), version, current: None };
        ui.horizontal_wrapped(|ui| self.table.tools(ui, &view));
        self.table.follow(ui, &view);
    }
}
