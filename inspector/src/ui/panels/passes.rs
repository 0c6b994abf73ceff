//! The list of passes: kernel, duration, rays. A click goes there.
//!
//! Touches: asks, bookmarks.

use egui::{Ui, Vec2, vec2};
use raystep_kernels::{Pass, Rounding};
use raystep_lab::text::counted;

use super::table::{Head, Look, Rows, Table, View, version};
use crate::session_file::Bookmark;
use crate::ui::pane::{Context, Panel};
use crate::ui::units::TimeUnit;

/// The list of passes.
#[derive(Default)]
pub(in crate::ui) struct Passes {
    table: Table,
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
        if cx.model.opened.is_none() {
            ui.weak("No run yet.");
            return;
        }
        let (has_rays, passes) = (cx.has_rays(), &cx.model.passes);
        let unit = TimeUnit::of(self.longest(cx.model.edition, passes));
        let history = cx.model.history.as_ref().filter(|_| self.only_ray && has_rays);
        let shown: Option<Vec<usize>> = history.map(|history| {
            let of_ray = history.rows.iter().filter_map(|row| row.pass);
            of_ray.filter(|&pass| pass < passes.len()).collect()
        });
        let place = cx.model.place;
        // Row 0 is before the first pass.
        let current = shown.as_ref().map_or(place.min(passes.len()), |shown| shown.partition_point(|&i| i < place));
        let about_times = match cx.model.opened.as_ref().and_then(|opened| opened.why_no_times.as_deref()) {
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
        let mut heads = vec![
            Head::number("pass", "index in the run"),
            Head::text("kernel", "kernel"),
            Head::number(unit.name(), &about_times),
            rays,
        ];
        if cx.model.opened.as_ref().is_some_and(|opened| opened.plan.schedule.has_counted_loops()) {
            heads.push(Head::text(
                "loops",
                "turns of the schedule's loops that the pass is in, from 0, outermost first",
            ));
        }
        let history = history.map(|history| (history.pixel, history.rows.len()));
        let bookmarks = &cx.bookmarks.list;
        let marked: Vec<usize> = bookmarks.iter().map(|bookmark| bookmark.place).collect();
        let version = version((cx.model.generation, cx.model.edition, unit, has_rays, history, marked));
        let list = List { passes, shown: shown.as_deref(), current, unit, bookmarks };
        let view = View { name: "passes", heads: &heads, rows: &list, version, current: Some(current) };
        ui.horizontal_wrapped(|ui| {
            self.table.tools(ui, &view);
            if has_rays {
                ui.checkbox(&mut self.only_ray, "only the selected ray")
                    .on_hover_text("show only passes that processed the selected ray");
            }
        });
        if let Some(row) = self.table.show(ui, &view) {
            cx.asks.go_to = Some(list.pass(row).map_or(0, |pass| pass.index + 1));
        }
    }
}

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

/// The passes as rows.
struct List<'a> {
    passes: &'a [Pass],
    /// The indices of those that are listed; `None` for all.
    shown: Option<&'a [usize]>,
    current: usize,
    unit: TimeUnit,
    bookmarks: &'a [Bookmark],
}

impl List<'_> {
    /// The pass of a row; none for the start.
    fn pass(&self, row: usize) -> Option<&Pass> {
        let at = row.checked_sub(1)?;
        self.passes.get(self.shown.map_or(Some(at), |shown| shown.get(at).copied())?)
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
        1 + self.shown.map_or(self.passes.len(), <[usize]>::len)
    }

    fn text(&self, row: usize, column: usize) -> String {
        let is_marked = |place: usize| self.bookmarks.iter().any(|bookmark| bookmark.place == place);
        match (self.pass(row), column) {
            (None, 0) if is_marked(0) => "– •".into(),
            (None, 0) => "–".into(),
            (None, 1) => "start".into(),
            (None, _) => String::new(),
            (Some(pass), 0) if is_marked(pass.index + 1) => format!("{} •", pass.index),
            (Some(pass), 0) => pass.index.to_string(),
            (Some(pass), 1) => pass.kernel.name().into(),
            (Some(pass), 2) => match (pass.duration_ns, pass.below_ns()) {
                (Some(ns), _) => self.unit.text(ns),
                (None, Some(below)) => format!("< {}", self.unit.text_above(below)),
                (None, None) => String::new(),
            },
            (Some(pass), 3) => pass.rays_in.to_string(),
            (Some(pass), _) => pass.loops_text(),
        }
    }

    fn number(&self, row: usize, column: usize) -> Option<f64> {
        let Some(pass) = self.pass(row) else { return (column == 0).then_some(-1.0) };
        match column {
            0 => Some(pass.index as f64),
            // Compared in the unit of the head.
            2 => pass.duration_ns.and_then(|ns| self.unit.text(ns).parse().ok()),
            3 => Some(f64::from(pass.rays_in)),
            _ => None,
        }
    }

    fn about(&self, row: usize, column: usize) -> Option<String> {
        let pass = self.pass(row)?;
        match column {
            1 => Some(pass.kernel.info().summary.into()),
            2 => Some(about_time(pass)),
            _ => None,
        }
    }

    fn look(&self, ui: &Ui, row: usize, _column: usize) -> Look {
        // Passes ahead are known from an earlier run.
        Look { color: (row > self.current).then(|| ui.visuals().weak_text_color()), ..Look::default() }
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
        let list = List { passes: &passes, shown: None, current: 0, unit: TimeUnit::Micros, bookmarks: &[] };
        let rows =
            |column: fn(&List<'_>, usize) -> Option<String>| (1..=4).map(|row| column(&list, row)).collect::<Vec<_>>();
        let known = |text: &str| Some(text.to_owned());
        assert_eq!(rows(|list, row| Some(list.text(row, 2))), ["< 67.6", "20.0", "", "20.0"].map(known));
        assert_eq!(
            rows(|list, row| list.about(row, 2)),
            [
                "less than 67584 ns: too short to tell by the device's clock in 256 runs",
                "20000 ± 2048 ns: the mean of 40 runs",
                "duration unknown",
                "20000 ns"
            ]
            .map(known)
        );
        let numbers: Vec<_> = (1..=4).map(|row| list.number(row, 2)).collect();
        assert_eq!(numbers, [None, Some(20.0), None, Some(20.0)], "a bound is no time to sort by");
    }
}
