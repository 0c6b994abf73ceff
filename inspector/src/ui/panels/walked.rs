//! The walk of the selected ray, recomputed only when the ray or its row changes.

use std::sync::Arc;

use raystep_kernels::export::trace::Trace;
use raystep_lab::text::counted;

use crate::command::Command;
use crate::session::Model;
use crate::ui::state::Asks;
use crate::walk::{CellVisit, Structure, WalkGeometry, row_after_passes};

/// A walk up to the last pass that has run.
#[derive(Default)]
pub(super) struct Walked {
    /// The ray's history; `None` without a ray.
    pub(super) history: Option<Arc<Trace>>,
    /// The last row whose pass has run.
    pub(super) row: Option<usize>,
    /// The walk up to it; `None` before the ray's first pass.
    pub(super) walk: Option<WalkGeometry>,
    /// Incremented with every change.
    pub(super) version: u64,
}

impl Walked {
    /// Updates it from the model. Returns whether the ray is a different one.
    pub(super) fn update(&mut self, model: &Model) -> bool {
        let history = model.history.clone();
        let row = history.as_ref().and_then(|history| row_after_passes(history, model.place));
        let is_same = match (&history, &self.history) {
            (Some(now), Some(then)) => Arc::ptr_eq(now, then),
            (now, then) => now.is_none() && then.is_none(),
        };
        if is_same && row == self.row {
            return false;
        }
        let data = model.opened.as_ref().map(|opened| &opened.data);
        let all = history.as_ref().zip(row).zip(data);
        self.walk = all.map(|((history, row), data)| WalkGeometry::new(history, data, row));
        (self.history, self.row) = (history, row);
        self.version += 1;
        !is_same
    }
}

/// Buttons for the ray's previous and next event.
pub(super) fn event_buttons(ui: &mut egui::Ui, asks: &mut Asks) {
    for (command, text) in [(Command::PreviousEvent, "< event"), (Command::NextEvent, "event >")] {
        command_button(ui, asks, command, text);
    }
}

/// A button for a command.
pub(super) fn command_button(ui: &mut egui::Ui, asks: &mut Asks, command: Command, text: &str) {
    let key = command.key_text(ui.ctx());
    let button = ui.button(text).on_hover_text(format!("{} ({key})", command.name()));
    button.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, command.name()));
    if button.clicked() {
        asks.commands.push(command);
    }
}

/// The row of a ray's history, for what is under the cursor, and where a click goes.
pub(super) fn go_on(history: &Trace, row: usize) -> String {
    let Some(at) = history.rows.get(row) else { return String::new() };
    let rows = history.rows.len();
    match at.place() {
        Some(_) => format!("\nrow {} of {rows}; click: go to pass {}", row + 1, at.number()),
        None => format!("\nrow {} of {rows}", row + 1),
    }
}

/// A walk in one line: current position, progress, and what it tested or hit.
pub(super) fn describe(walk: &WalkGeometry) -> String {
    let mut parts = Vec::new();
    match walk.structure {
        Structure::Grid => {
            parts.push(walk.current_cell().map_or_else(|| "outside the grid".into(), CellVisit::name));
            parts.push(counted(walk.cells.len(), "cell") + " visited");
        }
        Structure::Tree => {
            parts.push(walk.current_node.map_or_else(|| "outside the BVH".into(), |node| format!("node {node}")));
            parts.push(counted(walk.nodes.len(), "node") + " visited");
        }
        Structure::Nothing => {
            parts.push(counted(walk.tested.len(), "triangle") + " tested");
        }
    }
    let now = walk.tested.last().filter(|tested| Some(tested.row) == walk.row);
    match (now, walk.hit) {
        (Some(tested), _) => parts.push(format!("triangle {} {}", tested.triangle, tested.outcome.name())),
        (None, Some(hit)) => parts.push(format!("triangle {} hit", hit.triangle)),
        (None, None) => parts.push(if walk.is_over { "nothing hit".into() } else { "nothing hit yet".into() }),
    }
    parts.join("; ")
}

/// A length or t with four significant digits.
pub(super) fn number(t: f64) -> String {
    // No minus before a zero.
    let (t, size) = (t + 0.0, t.abs());
    if size != 0.0 && !(1e-3..1e5).contains(&size) {
        return format!("{t:.3e}");
    }
    let before = if size >= 1.0 { size.log10() as usize + 1 } else { 1 };
    format!("{t:.*}", 4usize.saturating_sub(before))
}

#[cfg(test)]
pub(in crate::ui::panels) mod tests {
    use raystep_kernels::scene_data::SceneData;
    use raystep_kernels::{Accelerator, Options};

    use super::*;
    use crate::walk::tests::{CORNELL, options, scene, traced};

    /// A ray of the Cornell box that meets a box in it.
    pub(in super::super) fn history(accelerator: Accelerator) -> (Trace, SceneData) {
        let scene = scene(CORNELL);
        traced(&scene, &Options { accelerator, ..options(&scene) }, [44, 50])
    }

    #[test]
    fn a_walk_says_where_it_is() {
        let (history, data) = history(Accelerator::Grid);
        let whole = WalkGeometry::new(&history, &data, usize::MAX);
        let hit = whole.hit.expect("a hit").triangle;
        let cells = whole.cells.len();
        let text = describe(&whole);
        assert!(
            text.contains(&format!("{cells} cells visited")) && text.ends_with(&format!("triangle {hit} hit")),
            "{text}"
        );
        let missed = whole.tested.iter().find(|test| !test.outcome.is_hit()).expect("a miss");
        let text = describe(&WalkGeometry::new(&history, &data, missed.row));
        assert!(text.starts_with("cell ") && text.ends_with(&format!("triangle {} missed", missed.triangle)), "{text}");
    }

    #[test]
    fn numbers_have_four_digits() {
        let texts = [0.0, -0.0, 0.5, 1.0, 12.345_67, 1234.56, 54321.0, 1e-9, 2e9].map(number);
        assert_eq!(texts, ["0.000", "0.000", "0.500", "1.000", "12.35", "1235", "54321", "1.000e-9", "2.000e9"]);
    }
}
