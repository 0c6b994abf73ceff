//! Tables 2 and 3: render times.

use std::time::Duration;

use raystep_kernels::options::Integrator;
use raystep_kernels::options::mapping::Mapping;
use raystep_kernels::{Accelerator, Numerics, Options, RaySource, ScheduleKind, Traversal};

use super::{GRID, cells, titled};
use crate::bench::{self, SEED, SummaryRow, Wanted};
use crate::meter::{Meter, Turns};
use crate::reporter::Reporter;
use crate::statistics::Compared;
use crate::tidy::{Row, Table};
use crate::{Error, RayKind, Size, Subject};

/// The side of each image, and the seconds that it took by the first strategy, by the second, and without a grid.
pub const SECONDS: [(u32, [f64; 3]); 4] =
    [(100, [5.5, 3.0, 1.3]), (256, [22.0, 12.5, 4.3]), (512, [79.0, 46.0, 15.0]), (756, [170.0, 100.0, 31.0])];

/// The paper's strategies and what they are here; the last is that of Table 3.
const STRATEGIES: [(&str, Accelerator, ScheduleKind); 3] = [
    ("First", Accelerator::Grid, ScheduleKind::First),
    ("Second", Accelerator::Grid, ScheduleKind::Second),
    ("", Accelerator::None, ScheduleKind::First),
];

pub(super) const COLUMNS: &[&str] = columns![
    schema_version run_id scene adapter strategy accelerator schedule numerics grid width_px height_px paper_s
    clock runs median_ns low_ns high_ns paper_by_here passes cells_per_ray tests_per_ray
];

/// The measured tables.
#[derive(Clone, Debug)]
pub struct Times {
    device: String,
    /// Side, strategy, and what was measured.
    rows: Vec<(u32, usize, SummaryRow)>,
}

/// Measures both tables.
///
/// # Errors
/// If the device fails.
pub fn times(
    subject: &Subject,
    repeats: u32,
    run_id: String,
    meter: &Meter,
    reporter: &dyn Reporter,
) -> Result<Times, Error> {
    let tuning = Options { numerics: Numerics::Paper, grid: GRID, ..Options::new(RaySource::Given(Vec::new())) };
    let wanted = Wanted {
        configurations: bench::combinations(
            &[Accelerator::Grid, Accelerator::None],
            &[ScheduleKind::First, ScheduleKind::Second],
            &[Mapping::Compute],
            &[Traversal::AmanatidesWoo],
            &[Integrator::default()],
            &tuning,
        ),
        sizes: SECONDS.iter().map(|&(side, _)| Size { width: side, height: side }).collect(),
        rays: vec![RayKind::Primary],
        file: None,
        turns: Turns { seed: u64::from(SEED), ..Turns::of(1, repeats as usize) },
        longest_run: Duration::MAX,
        until: None,
        is_counted: |_| true,
        is_replayed: |_| true,
        seed: SEED,
        tuning,
    };
    let measured = bench::measure(&wanted, std::slice::from_ref(subject), run_id, meter, reporter)?;
    let rows = measured.rows.into_iter().filter_map(|row| {
        let is_of = |(_, accelerator, schedule): &(&str, Accelerator, ScheduleKind)| {
            (row.accelerator.as_str(), row.schedule.as_str()) == (accelerator.name(), schedule.name())
        };
        Some((row.width_px?, STRATEGIES.iter().position(is_of)?, row))
    });
    Ok(Times { device: meter.machine.name(), rows: rows.collect() })
}

/// What the paper concludes from: the ratios of two strategies' times.
const RATIOS: [(&str, usize, usize); 2] = [("first / second", 0, 1), ("second / no grid", 1, 2)];

/// Why the numbers differ, and which of them are comparable.
const WHY: &str = "\
Times differ by device; the ratios are what the paper concludes from. Both strategies launch a thread for every ray in
every pass, so a GPU pays for idle rays; a CPU hardly does, and its ratios are smaller. The lesson 'grid-2004' shows the
idle threads: raystep inspect --lesson grid-2004. A note on different hits is expected: in the grid, the paper's rules
lose rays at voxel faces.
";

impl Times {
    fn row(&self, side: u32, strategy: usize) -> Option<&SummaryRow> {
        self.rows.iter().find(|(of, which, _)| (*of, *which) == (side, strategy)).map(|(_, _, row)| row)
    }

    /// Both tables, and the ratios that the paper concludes from.
    #[must_use]
    pub fn text(&self) -> String {
        let device = &self.device;
        let about = "median of a run without shading [95% interval]";
        let heads = ["Resolution", "2004, s", "here, ms", "low", "high", "2004 / here", "passes"];
        let table = |strategies: &[usize], has_names: bool| {
            let mut lines = vec![[if has_names { cells(["Strategy"]) } else { Vec::new() }, cells(heads)].concat()];
            for &strategy in strategies {
                lines.extend(SECONDS.iter().map(|&(side, seconds)| {
                    let name = if has_names { cells([STRATEGIES[strategy].0]) } else { Vec::new() };
                    [name, line(side, seconds[strategy], self.row(side, strategy))].concat()
                }));
            }
            lines
        };
        let second = format!("Table 2: render times, grid of 20x20x20 cells; here on {device}: {about}");
        let third = format!("Table 3: render times without a grid; here on {device}");
        format!(
            "{}\n{}\n{}\n{WHY}",
            titled(&second, &table(&[0, 1], true), 2),
            titled(&third, &table(&[2], false), 1),
            titled("Ratios of these times", &self.ratios(), 2) + &self.not_told_apart()
        )
    }

    /// The ratios by which neither time is told to be shorter: for each, the intervals of its times overlap.
    fn not_told_apart(&self) -> String {
        let is_open = |side, of, to| {
            let ends = |strategy| self.row(side, strategy).and_then(|row| row.low_ns.zip(row.high_ns));
            let ends = ends(of).zip(ends(to)).map(|((low, high), (least, most))| [low / most, high / least]);
            matches!(Compared::of(ends), Compared::NotDistinguishable | Compared::AsFast)
        };
        let all = RATIOS.iter().flat_map(|&(name, of, to)| SECONDS.iter().map(move |&(side, _)| (name, side, of, to)));
        let open = all.filter(|&(_, side, of, to)| is_open(side, of, to));
        let open: Vec<String> = open.map(|(name, side, ..)| format!("{name} at {side}x{side}")).collect();
        if open.is_empty() {
            String::new()
        } else {
            format!("  Not distinguishable from 1 here: {}.\n", open.join(", "))
        }
    }

    /// First to second, and second to none: in the paper, and here.
    fn ratios(&self) -> Vec<Vec<String>> {
        let sides = SECONDS.iter().map(|(side, _)| format!("{side}x{side}"));
        let mut lines = vec![["", ""].map(str::to_owned).into_iter().chain(sides).collect::<Vec<_>>()];
        for (name, of, to) in RATIOS {
            let paper = SECONDS.iter().map(|(_, seconds)| format!("{:.2}", seconds[of] / seconds[to]));
            lines.push(cells([name, "2004"]).into_iter().chain(paper).collect());
            let here = SECONDS.iter().map(|&(side, _)| {
                let of = self.row(side, of).and_then(|row| row.median_ns);
                let to = self.row(side, to).and_then(|row| row.median_ns);
                of.zip(to).map_or("-".into(), |(of, to)| format!("{:.2}", of / to))
            });
            lines.push(cells(["", "here"]).into_iter().chain(here).collect());
        }
        lines
    }

    /// The CSV file.
    ///
    /// # Errors
    /// If memory is short.
    pub fn csv(&self) -> Result<Vec<u8>, Error> {
        let mut table = Table::new(COLUMNS);
        for (strategy, (name, ..)) in STRATEGIES.iter().enumerate() {
            for (side, seconds) in SECONDS {
                let Some(row) = self.row(side, strategy) else { continue };
                let paper_s = seconds[strategy];
                table.rows.push(
                    Row::new(COLUMNS)
                        .with(row)
                        .set("strategy", *name)
                        .set("paper_s", paper_s)
                        .set("paper_by_here", row.median_ns.map(|ns| paper_s * 1e9 / ns)),
                );
            }
        }
        Ok(table.csv()?)
    }
}

/// A row of one of the tables, from the resolution on.
fn line(side: u32, paper_s: f64, row: Option<&SummaryRow>) -> Vec<String> {
    let ms =
        |ns: fn(&SummaryRow) -> Option<f64>| row.and_then(ns).map_or("-".to_owned(), |ns| format!("{:.3}", ns / 1e6));
    let ratio = row.and_then(|row| row.median_ns).map(|ns| paper_s * 1e9 / ns);
    vec![
        format!("{side}x{side}"),
        paper_s.to_string(),
        ms(|row| row.median_ns),
        ms(|row| row.low_ns),
        ms(|row| row.high_ns),
        ratio.map_or("-".into(), |ratio| format!("{ratio:.0}")),
        row.map_or("-".into(), |row| row.passes.to_string()),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_whose_intervals_overlap_are_named_and_no_others() {
        let row = |low_ns, high_ns| SummaryRow {
            median_ns: Some(f64::midpoint(low_ns, high_ns)),
            low_ns: Some(low_ns),
            high_ns: Some(high_ns),
            ..SummaryRow::default()
        };
        let times = |second| Times {
            device: String::new(),
            rows: vec![(512, 0, row(10.0, 12.0)), (512, 1, second), (512, 2, row(30.0, 31.0))],
        };
        let said = "Not distinguishable from 1 here: first / second at 512x512.\n";
        assert!(times(row(11.0, 14.0)).text().contains(said));
        assert!(!times(row(12.5, 14.0)).text().contains("distinguishable"));
    }
}
