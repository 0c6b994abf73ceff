//! The passes, with kernel, duration and rays, below the turns of the schedule's loops. A click goes there.
//!
//! Touches: asks, bookmarks.

mod tree;

use egui::{Ui, Vec2, vec2};
use raystep_kernels::program::schedule::Schedule;
use raystep_kernels::{Pass, Rounding};
use raystep_lab::text::counted;

use super::table::{Fold, Head, Look, Rows, Table, View, version};
use super::turns::{names, range};
use crate::session_file::Bookmark;
use crate::ui::pane::{Context, Panel};
use crate::ui::units::TimeUnit;
use tree::{Node, Time, Tree};

/// The list of passes.
#[derive(Default)]
pub(in crate::ui) struct Passes {
    table: Table,
    tree: Tree,
    /// The turn that keys have gone to, and the place meanwhile.
    at_turn: Option<(usize, usize)>,
    /// Show only the passes that processed the selected ray.
    only_ray: bool,
    /// The longest duration: of which passes, and how many of them were looked at.
    longest: Option<(u64, usize, u64)>,
}

impl Panel for Passes {
    fn least(&self) -> Vec2 {
        // A strip below other panels has room for the current row.
        vec2(240.0, 84.0)
    }

    fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        let Some(opened) = &cx.model.opened else {
            ui.weak("No run yet.");
            return;
        };
        let (has_rays, passes) = (cx.has_rays(), &cx.model.passes);
        let unit = TimeUnit::of(self.longest(cx.model.edition, passes));
        let history = cx.model.history.as_ref().filter(|_| self.only_ray && has_rays);
        let only: Option<Vec<usize>> = history.map(|history| {
            let of_ray = history.rows.iter().filter_map(|row| row.pass);
            of_ray.filter(|&pass| pass < passes.len()).collect()
        });
        let (place, schedule) = (cx.model.place, &opened.plan.schedule);
        self.tree.update([cx.model.generation, cx.model.edition], passes, schedule, place);
        let is_tree = only.is_none() && self.table.is_plain() && !self.tree.is_list();
        self.at_turn = self.at_turn.filter(|&(_, at)| is_tree && at == place);
        // Row 0 is before the first pass.
        let current = match (&only, self.at_turn) {
            (Some(only), _) => only.partition_point(|&i| i < place),
            (None, Some((row, _))) => row,
            (None, None) => self.tree.row_at(place),
        };
        let about_times = match opened.why_no_times.as_deref() {
            Some(why) => format!("duration of the pass by the device's clock: unknown, because {why}"),
            None => "duration of the pass by the device's clock".into(),
        };
        let rays = match has_rays {
            true => Head::number("rays", "rays processed by the pass"),
            false => Head::number(
                "elements",
                "elements that the pass works on: triangles, spans, references, cells or blocks",
            ),
        };
        let columns: Vec<(Column, Head<'_>)> = [
            (Column::Pass, Head::number("pass", "index in the run")),
            (Column::Kernel, if is_tree { Head::tree("kernel", ABOUT_TREE) } else { Head::text("kernel", "kernel") }),
            (Column::Time, Head::number(unit.name(), &about_times)),
            (Column::Rays, rays),
            // The last one, so that a column is the same in the tree and in the list.
            (Column::Loops, Head::text("loops", "turns of the schedule's loops that the pass is in, outermost first")),
        ]
        .into_iter()
        .filter(|(column, _)| *column != Column::Loops || !is_tree && !self.tree.is_list())
        .collect();
        let (columns, heads): (Vec<Column>, Vec<Head<'_>>) = columns.into_iter().unzip();
        let history = history.map(|history| (history.pixel, history.element, history.rows.len()));
        let bookmarks = &cx.bookmarks.list;
        let marked: Vec<usize> = bookmarks.iter().map(|bookmark| bookmark.place).collect();
        let of = (cx.model.generation, cx.model.edition, self.tree.is_list(), is_tree);
        let version = version((of, unit, has_rays, history, marked));
        let list = List {
            passes,
            schedule,
            tree: &self.tree,
            is_tree,
            only: only.as_deref(),
            place,
            columns: &columns,
            unit,
            bookmarks,
        };
        let view = View { name: "passes", heads: &heads, rows: &list, version, current: Some(current) };
        ui.horizontal_wrapped(|ui| {
            self.table.tools(ui, &view);
            if has_rays {
                ui.checkbox(&mut self.only_ray, "only the selected ray")
                    .on_hover_text("show only passes that processed the selected ray");
            }
        });
        let chosen = self.table.show(ui, &view).map(|row| (row, list.node(row)));
        match chosen {
            Some((row, Node::Turn(..))) => self.at_turn = Some((row, place)),
            Some((_, node)) => {
                self.at_turn = None;
                cx.asks.go_to = Some(if let Node::Pass(pass) = node { pass + 1 } else { 0 });
            }
            None => {}
        }
        if let Some(row) = self.table.take_folded() {
            self.tree.toggle(row);
            ui.ctx().request_repaint();
        }
    }
}

const ABOUT_TREE: &str = "Kernel, below the turns of the schedule's loops that the pass is in, counted from 0. An arrow or \
                          a double click folds and unfolds a turn; that of the current pass is unfolded.";

impl Passes {
    /// The longest duration so far. It only grows, so that the unit does not change to and fro.
    fn longest(&mut self, edition: u64, passes: &[Pass]) -> u64 {
        let (from, longest) = match self.longest {
            Some((of, looked_at, longest)) if of == edition && looked_at <= passes.len() => (looked_at, longest),
            _ => (0, 0),
        };
        let longest = passes[from..].iter().filter_map(|pass| pass.duration_ns).fold(longest, u64::max);
        self.longest = Some((edition, passes.len(), longest));
        longest
    }
}

/// A column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Column {
    Pass,
    Kernel,
    Loops,
    Time,
    Rays,
}

/// The passes as rows.
struct List<'a> {
    passes: &'a [Pass],
    schedule: &'a Schedule,
    tree: &'a Tree,
    /// Whether turns have rows.
    is_tree: bool,
    /// The indices of those that are listed; `None` for all.
    only: Option<&'a [usize]>,
    place: usize,
    columns: &'a [Column],
    unit: TimeUnit,
    bookmarks: &'a [Bookmark],
}

impl List<'_> {
    fn node(&self, row: usize) -> Node {
        match (self.only, row.checked_sub(1)) {
            (None, _) => self.tree.node(row).0,
            (Some(only), Some(at)) => only.get(at).map_or(Node::Start, |&pass| Node::Pass(pass)),
            (Some(_), None) => Node::Start,
        }
    }

    /// The pass of a row; none for the start, and for turns.
    fn pass(&self, row: usize) -> Option<&Pass> {
        if let Node::Pass(pass) = self.node(row) { self.passes.get(pass) } else { None }
    }

    fn column(&self, column: usize) -> Column {
        self.columns.get(column).copied().unwrap_or(Column::Pass)
    }

    /// The names of the turns around a pass from the outermost level to this one.
    fn names(&self, first: usize, level: usize) -> Vec<String> {
        let mut names = self.passes.get(first).map_or_else(Vec::new, |pass| names(self.schedule, pass));
        names.truncate(level + 1);
        names
    }

    /// A cell of a turn.
    fn of_turn(&self, level: usize, first: usize, column: Column) -> String {
        let turn = self.tree.turn(level, first);
        match column {
            Column::Pass => range(turn),
            Column::Kernel => self.names(first, level).pop().unwrap_or_default(),
            Column::Time => match self.tree.time(turn) {
                Time::Known(ns) => self.unit.text(ns),
                Time::Below(ns) => format!("< {}", self.unit.text_above(ns)),
                Time::Unknown => String::new(),
            },
            Column::Loops | Column::Rays => String::new(),
        }
    }

    /// A pass's kernel; in a tree, after the turns that have no row.
    fn kernel(&self, row: usize, pass: &Pass) -> String {
        let turns = if self.is_tree { names(self.schedule, pass) } else { Vec::new() };
        let own = turns.into_iter().skip(self.depth(row)).map(|name| name + ": ");
        own.collect::<String>() + pass.kernel.name()
    }
}

/// A pass's duration in ns, and how well it is known by a coarse clock.
fn about_time(pass: &Pass) -> String {
    match (pass.duration_ns, pass.rounding) {
        (Some(ns), None) => format!("{ns} ns"),
        (Some(ns), Some(Rounding { runs: 1, error_ns, .. })) => format!("{ns} ± {error_ns} ns"),
        (Some(ns), Some(Rounding { runs, error_ns, .. })) => format!("{ns} ± {error_ns} ns: the mean of {runs} runs"),
        (None, Some(Rounding { runs, below_ns, .. })) => {
            format!("less than {below_ns} ns: too short to tell by the device's clock in {}", counted(runs, "run"))
        }
        (None, None) => "duration unknown".into(),
    }
}

impl Rows for List<'_> {
    fn count(&self) -> usize {
        self.only.map_or(self.tree.len(), |only| 1 + only.len())
    }

    fn unfolded(&self) -> Option<(u64, &[usize])> {
        self.is_tree.then(|| self.tree.unfolded())
    }

    fn depth(&self, row: usize) -> usize {
        if self.is_tree { self.tree.node(row).1 } else { 0 }
    }

    fn fold(&self, row: usize) -> Option<Fold> {
        let is_open = self.tree.is_open(row).filter(|_| self.only.is_none())?;
        Some(Fold { is_open, is_fixed: self.tree.is_current(row) })
    }

    fn fold_name(&self, row: usize) -> String {
        let Node::Turn(level, first) = self.node(row) else { return String::new() };
        self.names(first, level).join(", ")
    }

    fn text(&self, row: usize, column: usize) -> String {
        let is_marked = |place: usize| self.bookmarks.iter().any(|bookmark| bookmark.place == place);
        let column = self.column(column);
        let pass = match self.node(row) {
            Node::Turn(level, first) => return self.of_turn(level, first, column),
            Node::Pass(pass) => self.passes.get(pass),
            Node::Start => None,
        };
        match (pass, column) {
            (None, Column::Pass) if is_marked(0) => "– •".into(),
            (None, Column::Pass) => "–".into(),
            (None, Column::Kernel) => "start".into(),
            (None, _) => String::new(),
            (Some(pass), Column::Pass) if is_marked(pass.index + 1) => format!("{} •", pass.index),
            (Some(pass), Column::Pass) => pass.index.to_string(),
            (Some(pass), Column::Kernel) => self.kernel(row, pass),
            (Some(pass), Column::Loops) => names(self.schedule, pass).join(", "),
            (Some(pass), Column::Time) => match (pass.duration_ns, pass.below_ns()) {
                (Some(ns), _) => self.unit.text(ns),
                (None, Some(below)) => format!("< {}", self.unit.text_above(below)),
                (None, None) => String::new(),
            },
            (Some(pass), Column::Rays) => pass.rays_in.to_string(),
        }
    }

    fn number(&self, row: usize, column: usize) -> Option<f64> {
        let column = self.column(column);
        let Some(pass) = self.pass(row) else { return (column == Column::Pass).then_some(-1.0) };
        match column {
            Column::Pass => Some(pass.index as f64),
            // Compared in the unit of the head.
            Column::Time => pass.duration_ns.and_then(|ns| self.unit.text(ns).parse().ok()),
            Column::Rays => Some(f64::from(pass.rays_in)),
            Column::Kernel | Column::Loops => None,
        }
    }

    fn about(&self, row: usize, column: usize) -> Option<String> {
        let pass = self.pass(row)?;
        match self.column(column) {
            Column::Kernel => Some(pass.kernel.info().summary.into()),
            Column::Time => Some(about_time(pass)),
            _ => None,
        }
    }

    fn look(&self, ui: &Ui, row: usize, _column: usize) -> Look {
        // Passes ahead are known from an earlier run.
        let is_ahead = match self.node(row) {
            Node::Start => false,
            Node::Turn(_, pass) | Node::Pass(pass) => pass >= self.place,
        };
        Look { color: is_ahead.then(|| ui.visuals().weak_text_color()), ..Look::default() }
    }
}

#[cfg(test)]
mod tests {
    use raystep_kernels::programs::closest_hit::kernels::INTERSECT;

    use super::*;

    fn pass(index: usize, duration_ns: Option<u64>, rounding: Option<Rounding>) -> Pass {
        Pass { index, rays_in: 1, duration_ns, rounding, ..Pass::of(INTERSECT) }
    }

    #[test]
    fn a_pass_shorter_than_the_clocks_tick_is_below_a_bound() {
        let rounded = |runs| Some(Rounding { runs, error_ns: 2048, below_ns: 67_584 });
        let passes = [
            pass(0, None, rounded(256)),
            pass(1, Some(20_000), rounded(40)),
            pass(2, None, None),
            pass(3, Some(20_000), None),
        ];
        let schedule = Schedule { steps: Vec::new() };
        let mut tree = Tree::default();
        tree.update([1, 1], &passes, &schedule, 0);
        let list = List {
            passes: &passes,
            schedule: &schedule,
            tree: &tree,
            is_tree: false,
            only: None,
            place: 0,
            columns: &[Column::Pass, Column::Time],
            unit: TimeUnit::Micros,
            bookmarks: &[],
        };
        let rows =
            |column: fn(&List<'_>, usize) -> Option<String>| (1..=4).map(|row| column(&list, row)).collect::<Vec<_>>();
        let known = |text: &str| Some(text.to_owned());
        assert_eq!(rows(|list, row| Some(list.text(row, 1))), ["< 67.6", "20.0", "", "20.0"].map(known));
        assert_eq!(
            rows(|list, row| list.about(row, 1)),
            [
                "less than 67584 ns: too short to tell by the device's clock in 256 runs",
                "20000 ± 2048 ns: the mean of 40 runs",
                "duration unknown",
                "20000 ns"
            ]
            .map(known)
        );
        let numbers: Vec<_> = (1..=4).map(|row| list.number(row, 1)).collect();
        assert_eq!(numbers, [None, Some(20.0), None, Some(20.0)], "a bound is no time to sort by");
    }
}
