//! The history as rows of a table.

use egui::{Color32, Ui};
use raystep_kernels::export::trace::{RayState, Trace, TraceRow};
use raystep_kernels::tables::state::States;

use super::super::picked::touches;
use super::changed_color;
use crate::draw::stream::state_color;
use crate::session::{HistorySource, Model};
use crate::ui::panels::table::{Head, Look, Rows};
use crate::ui::state::Picked;
use crate::ui::units::Scale;

const PASS: usize = 0;
const STATE: usize = 2;
const WHY: usize = 3;
const CELL: usize = 4;
const TMAX: usize = 5;
const T: usize = 8;
const HIT: usize = 9;
const ITEM: usize = 10;

/// The heads, for rays in a grid or in a tree; in a grid that is walked by a 3D-DDA.
pub(super) const fn heads(is_grid: bool, is_dda: bool) -> [Head<'static>; 11] {
    let cell = match is_grid {
        true => Head::text("cell", "cell x,y,z that the ray is in after the pass"),
        false => Head::number("node", "BVH node that the ray is at after the pass"),
    };
    let [x, y, z] = match is_dda {
        true => [
            Head::number(
                "control.x",
                "how far the ray is past its next face along x, in cells, at that of its driving axis",
            ),
            Head::number(
                "control.y",
                "how far the ray is past its next face along y, in cells, at that of its driving axis",
            ),
            Head::number(
                "control.z",
                "how far the ray is past its next face along z, in cells, at that of its driving axis",
            ),
        ],
        false => [
            Head::number("tmax.x", "t at which the ray leaves its cell along x"),
            Head::number("tmax.y", "t at which the ray leaves its cell along y"),
            Head::number("tmax.z", "t at which the ray leaves its cell along z"),
        ],
    };
    [
        Head::number("pass", "index in the run"),
        Head::text("kernel", "kernel").minor(),
        Head::text("state", "the ray's state after the pass"),
        Head::prose("why", "why the pass left the ray in this state"),
        cell,
        x,
        y,
        z,
        Head::number("t", "nearest t so far"),
        Head::number("hit", "nearest triangle so far"),
        Head::number("item", "position in the cell's or leaf's list").minor(),
    ]
}

/// The rows, in the units of the panel.
pub(super) struct RayRows<'a> {
    pub(super) history: &'a Trace,
    pub(super) model: &'a Model,
    pub(super) states: States,
    pub(super) scale: Scale,
    /// Decimals of tmax.x, tmax.y, tmax.z and t; all digits are in the tooltips.
    pub(super) decimals: [usize; 4],
    pub(super) current: Option<usize>,
    /// How many rows are shown: while a lesson asks what comes next, only what has come.
    pub(super) shown: usize,
    /// What is selected in any panel.
    pub(super) picked: Option<Picked>,
}

impl RayRows<'_> {
    fn row(&self, row: usize) -> Option<&TraceRow> {
        self.history.rows.get(row)
    }

    fn number_text(&self, number: Option<f64>, column: usize) -> String {
        let decimals = self.decimals.get(column - TMAX).copied().unwrap_or_default();
        number.map_or_else(|| "–".into(), |number| format!("{number:.decimals$}"))
    }

    /// tMax along an axis, or the control term, which is in cells.
    fn along(&self, after: &RayState, axis: usize) -> Option<f64> {
        match after.control {
            Some(control) => Some(f64::from(control[axis])),
            None => after.tmax[axis].map(|t| self.scale.t(t)),
        }
    }

    fn exact(&self, t: Option<f32>) -> String {
        t.map_or_else(
            || "never".into(),
            |t| format!("{} {} (0x{:08x} traced)", self.scale.exact_t(t), self.scale.units.name(), t.to_bits()),
        )
    }

    /// The cell or node that the ray is in after a pass; none before and after its walk.
    fn cell(row: &TraceRow) -> Option<String> {
        let cell = row.cell_after.map(|cell| cell.map(|c| c.to_string()).join(","));
        cell.or_else(|| row.index_after.map(|index| index.to_string()))
    }

    /// What a ray does in the state after a pass.
    pub(super) fn meaning(&self, row: &TraceRow) -> Option<&'static str> {
        self.states.0.get(row.after.tag as usize).map(|state| state.meaning)
    }

    /// The reason, in the panel's units.
    pub(super) fn why(&self, row: &TraceRow) -> String {
        self.scale.reason(&row.why) + &row.noted()
    }

    fn of(&self, row: &TraceRow, column: usize) -> String {
        let after = &row.after;
        match column {
            PASS => row.number(),
            1 => row.kernel.into(),
            STATE => after.state.into(),
            WHY => self.why(row),
            CELL => Self::cell(row).unwrap_or_else(|| "–".into()),
            TMAX..T => self.number_text(self.along(after, column - TMAX), column),
            T => self.number_text(after.t.map(|t| self.scale.t(t)), column),
            HIT => after.triangle.map_or_else(|| "–".into(), |triangle| triangle.to_string()),
            _ => after.item.to_string(),
        }
    }

    /// Whether the pass has changed this.
    fn is_changed(&self, index: usize, column: usize) -> bool {
        let before = index.checked_sub(1).and_then(|before| self.row(before));
        let (Some(row), Some(before)) = (self.row(index), before) else { return false };
        (STATE..=ITEM).contains(&column) && column != WHY && self.of(row, column) != self.of(before, column)
    }

    /// What the pass has changed, with the values before; `None` for the first row.
    pub(super) fn changes(&self, index: usize, heads: &[Head<'_>]) -> Option<String> {
        let (row, before) = (self.row(index)?, self.row(index.checked_sub(1)?)?);
        let changed = heads.iter().enumerate().filter(|(column, _)| self.is_changed(index, *column));
        let changed = changed
            .map(|(column, head)| format!("{} {} (was {})", head.name, self.of(row, column), self.of(before, column)));
        let changed: Vec<String> = changed.collect();
        Some(if changed.is_empty() { "nothing changed".into() } else { changed.join(", ") })
    }

    /// Whether the device's row differs from the CPU reference's.
    fn differs(&self, index: usize) -> bool {
        matches!(&self.model.history_source, HistorySource::Compared { differing } if differing.contains(&index))
    }

    /// What to know about a row: that it is predicted, or how the device's differs from the CPU reference's.
    fn note(&self, index: usize, row: &TraceRow) -> Option<String> {
        if self.differs(index) {
            let reference = self.model.reference_history.as_ref().and_then(|history| history.rows.get(index));
            return Some(reference.map_or_else(
                || "the CPU reference kernels have no such row".into(),
                |row| format!("CPU reference kernels: {}, {}", row.kernel, row.why),
            ));
        }
        self.model.is_predicted(row).then(|| "this pass has not run yet: the row is predicted".into())
    }
}

impl Rows for RayRows<'_> {
    fn count(&self) -> usize {
        self.shown
    }

    fn text(&self, index: usize, column: usize) -> String {
        let Some(row) = self.row(index) else { return String::new() };
        let text = self.of(row, column);
        if column == PASS && self.differs(index) { text + "≠" } else { text }
    }

    fn number(&self, index: usize, column: usize) -> Option<f64> {
        let row = self.row(index)?;
        let after = &row.after;
        match column {
            // Passes whose index is not known come last.
            PASS => Some(row.pass.map_or(f64::MAX, |pass| pass as f64)),
            CELL => row.index_after.map(f64::from),
            TMAX..T => self.along(after, column - TMAX),
            T => after.t.map(|t| self.scale.t(t)),
            HIT => after.triangle.map(f64::from),
            ITEM => Some(f64::from(after.item)),
            _ => None,
        }
    }

    fn about(&self, index: usize, column: usize) -> Option<String> {
        let row = self.row(index)?;
        let after = &row.after;
        match column {
            PASS => self.note(index, row),
            STATE => {
                let text = format!("{} before the pass, {} after it", row.state_before, after.state);
                let meaning = self.meaning(row);
                Some(meaning.map_or(text.clone(), |meaning| format!("{text}\n{}: {meaning}", after.state)))
            }
            WHY => Some(self.why(row)),
            CELL => row.cell_after.and(row.index_after).map(|index| format!("cell index {index}")),
            TMAX..T => Some(match after.control.map(|control| control[column - TMAX]) {
                Some(term) => format!("{term} cells (0x{:08x})", term.to_bits()),
                None => self.exact(after.tmax[column - TMAX]),
            }),
            T => Some(self.exact(after.t)),
            HIT => Some(match (after.triangle, after.barycentric) {
                (Some(triangle), Some([u, v])) => format!("triangle {triangle}, u {u}, v {v}"),
                _ => "no triangle".into(),
            }),
            _ => None,
        }
    }

    fn has_swatches(&self, column: usize) -> bool {
        column == STATE
    }

    fn look(&self, ui: &Ui, index: usize, column: usize) -> Look {
        let Some(row) = self.row(index) else { return Look::default() };
        let is_ahead = self.current.is_none_or(|current| index > current);
        let color = match self.is_changed(index, column) || column == PASS && self.differs(index) {
            true => Some(changed_color(ui)),
            false => is_ahead.then(|| ui.visuals().weak_text_color()),
        };
        let swatch = (column == STATE).then(|| {
            let [r, g, b] = state_color(self.states, row.after.tag);
            Color32::from_rgb(r, g, b)
        });
        let is_picked = self.picked.is_some_and(|picked| touches(row, picked));
        let bar = is_picked.then(|| (1.0, ui.visuals().widgets.hovered.weak_bg_fill));
        Look { color, is_italic: !self.differs(index) && self.model.is_predicted(row), swatch, bar }
    }
}

#[cfg(test)]
mod tests {
    use raystep_kernels::export::trace::RunSoFar;
    use raystep_kernels::plan::Plan;
    use raystep_kernels::programs::closest_hit::states::STATES;
    use raystep_kernels::{Accelerator, Limits, Options, RaySource, ScheduleKind};
    use raystep_scenes::generate;

    use super::*;
    use crate::ui::units::Units;

    /// Every row of a ray's history, told with the given units.
    fn with_rows(accelerator: Accelerator, units: Units, look: impl Fn(&RayRows<'_>)) {
        let scene = generate::cornell_box();
        let source = RaySource::Camera { camera: scene.cameras[0].clone(), width: 16, height: 16 };
        let options = Options { accelerator, schedule: ScheduleKind::Second, ..Options::new(source) };
        let (plan, data) = Plan::new(&scene, &options, &Limits::CPU).expect("a small scene");
        let run = RunSoFar { plan: &plan, data: &data, passes: &[], is_complete: false };
        let history = run.follow::<f32>([9, 11]).expect("a ray");
        let (model, task) = Model::new(|engine| Box::pin(async move { drop(engine) }));
        std::mem::forget(task);
        let scale = Scale::of(units, &history);
        let current = Some(history.rows.len());
        look(&RayRows {
            history: &history,
            model: &model,
            states: STATES,
            scale,
            decimals: [5; 4],
            current,
            shown: history.rows.len(),
            picked: None,
        });
    }

    #[test]
    fn a_cell_has_one_notation_and_changes_in_the_row_of_its_step() {
        with_rows(Accelerator::Grid, Units::Traced, |rows| {
            let mut steps = 0;
            for (i, row) in rows.history.rows.iter().enumerate() {
                let cell = rows.text(i, CELL);
                assert!(cell == "–" || cell.split(',').count() == 3, "{cell}");
                if let Some(to) = row.why.split(" to cell (").nth(1).and_then(|rest| rest.split(')').next()) {
                    assert_eq!(cell, to.replace(", ", ","), "{}", row.why);
                    assert!(rows.is_changed(i, CELL), "row {i}: {}", row.why);
                    steps += 1;
                }
                if row.kernel == "intersect" && cell != "–" {
                    assert!(!rows.is_changed(i, CELL), "row {i}: {}", row.why);
                }
            }
            assert!(steps > 2, "{steps}");
        });
        with_rows(Accelerator::Bvh, Units::Traced, |rows| {
            let nodes = (0..rows.count()).filter(|&row| rows.text(row, CELL).parse::<u32>().is_ok()).count();
            assert!(nodes > 2, "{nodes}");
        });
    }

    #[test]
    fn all_lengths_of_a_row_are_in_the_same_units() {
        let mut texts = [Vec::new(), Vec::new()];
        for (units, texts) in [Units::Traced, Units::Scene].into_iter().zip(&mut texts) {
            let found = std::cell::RefCell::new(Vec::new());
            with_rows(Accelerator::Grid, units, |rows| {
                for row in 0..rows.count() {
                    found.borrow_mut().push([TMAX, T].map(|column| rows.number(row, column)));
                }
                // The reason quotes the hit's t as the row has it.
                let hits =
                    rows.history.rows.iter().filter(|row| row.why.contains(": hit at t ") && row.after.t.is_some());
                for row in hits.filter(|row| row.why.contains(", u ")) {
                    let t = rows.scale.exact_t(row.after.t.unwrap_or_default());
                    assert!(rows.why(row).contains(&format!("hit at t {t}, u ")), "{}", rows.why(row));
                }
            });
            *texts = found.into_inner();
        }
        let scale = texts[1].iter().flatten().flatten().zip(texts[0].iter().flatten().flatten());
        let scales: Vec<f64> = scale.filter(|(_, traced)| **traced != 0.0).map(|(s, traced)| s / traced).collect();
        // A power of two, so that no bit is lost.
        assert!(scales.len() > 4 && scales.iter().all(|&by| by == scales[0] && by != 1.0), "{scales:?}");
    }
}
