//! The error of tMax along a walk of 3,000 cells. If tMax is computed from the cell's coordinates, its error is no
//! larger at the end than at the beginning; if it is accumulated, the error grows at worst with the square of the
//! number of cells.

use std::ops::ControlFlow;

use raystep_kernels::options::{Accelerator, Numerics, Options, Rule, STEPS_PER_PASS, ScheduleKind};
use raystep_kernels::programs::closest_hit::states::{ISECT_HIT, ISECT_NO_HIT, TRAV};
use raystep_kernels::programs::closest_hit::streams;
use raystep_kernels::programs::closest_hit::streams::STATE_CELL;
use raystep_kernels::renderer::{Device, RenderError, Renderer};
use raystep_kernels::shared::constants::INF;
use raystep_kernels::tables::stream::{STATE_TAG, StreamData};

use crate::Error;
use crate::configuration::Configuration;
use crate::stability::make;
use crate::stability::row::DeviceName;
use crate::tidy;

/// The error bound of robust numerics, in the unit of [`Sample::error`], half units in the last place: one rounding of
/// the origin relative to the grid's corner, one of the difference, at most 5 of WGSL's division, one of the product.
/// Relative to the corner, plane and origin have the same sign, so that their difference is no larger than the larger of
/// them.
pub const BOUND: f64 = 8.0;

/// Cells between two samples.
const EVERY: usize = 50;

/// Cells of the walk. Rays that pass through the wall at its end, as they may with the paper's numerics, soon leave the
/// grid; their cells are meaningless then.
const CELLS: u32 = 3000;

/// How tMax is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rules {
    /// Their name in reports.
    pub name: &'static str,
    numerics: Numerics,
    without: Option<Rule>,
}

impl Rules {
    /// The walk that is measured.
    fn configuration(self) -> Configuration {
        let Self { numerics, without, .. } = self;
        Configuration {
            numerics,
            without,
            ..Configuration::new(Accelerator::Grid, ScheduleKind::Second, STEPS_PER_PASS)
        }
    }
}

/// The rules to compare.
pub const RULES: [Rules; 3] = [
    Rules { name: "robust", numerics: Numerics::Robust, without: None },
    Rules { name: "robust, tMax accumulated", numerics: Numerics::Robust, without: Some(Rule::TMax) },
    Rules { name: "paper", numerics: Numerics::Paper, without: None },
];

/// The rays still walking after this many cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Cells visited by the farthest ray.
    pub cells: u32,
    /// Rays still walking.
    pub rays: u64,
    /// The largest error of tMax, in units of 2⁻²⁴ · max(|plane|, |origin|) / |direction| along its axis, relative to the
    /// grid's corner.
    pub error: f64,
    /// The largest error, as t.
    pub error_t: f64,
}

/// Walks, and samples the error every 50 cells.
///
/// # Errors
/// If the device fails.
pub async fn walk(rules: Rules, rays: usize, device: &Device) -> Result<Vec<Sample>, Error> {
    let workload = make::long_walk(rays)?;
    let options = Options {
        grid: workload.grid,
        counters: true,
        shade: false,
        keep_passes: false,
        ..Options::new(workload.rays)
    };
    let options = rules.configuration().of(&options);
    let mut renderer = Renderer::new(&workload.scene, &options, device).await?;
    let mut samples = Vec::new();
    loop {
        // All cells of this walk except the last have empty lists: one pass to find that out, and one to step.
        let until = renderer.pass_count() + 2 * EVERY;
        match renderer.run_to(until, |_| ControlFlow::Continue(())).await {
            Ok(()) | Err(RenderError::Cancelled { .. }) => {}
            Err(error) => return Err(error.into()),
        }
        match sample(&renderer).await? {
            Some(sample) if sample.cells <= CELLS => samples.push(sample),
            _ => return Ok(samples),
        }
        if renderer.next_kernel().is_none() {
            return Ok(samples);
        }
    }
}

/// `None` if no ray is walking.
async fn sample(renderer: &Renderer) -> Result<Option<Sample>, Error> {
    let [origin, direction, state, tmax, counters] =
        [streams::RAY_ORIGIN, streams::RAY_DIRECTION, streams::STATE, streams::TMAX, streams::COUNTERS];
    let (origin, direction) = (renderer.values(origin).await?, renderer.values(direction).await?);
    let (state, tmax) = (renderer.values(state).await?, renderer.values(tmax).await?);
    let counters = renderer.values(counters).await?;
    let grid = &renderer.data().grid;
    let mut all = Sample { cells: 0, rays: 0, error: 0.0, error_t: 0.0 };
    for ray in 0..renderer.plan().rays as usize {
        if ![TRAV, ISECT_NO_HIT, ISECT_HIT].contains(&state.get(STATE_TAG, ray)) {
            continue;
        }
        all.rays += 1;
        all.cells = all.cells.max(counters.get(0, ray));
        let cell = grid.cell_of_index(state.get(STATE_CELL, ray));
        for (axis, index) in cell.into_iter().enumerate() {
            let number = |stream: &StreamData| f64::from(stream.get_f32(axis, ray));
            let (o, d, t) = (number(&origin), number(&direction), number(&tmax));
            if d == 0.0 || t >= f64::from(INF) {
                continue;
            }
            let ahead = index + i32::from(d > 0.0);
            let plane = f64::from(grid.width[axis]) * f64::from(ahead);
            let o = o - f64::from(grid.corner[axis]);
            let error = (t - (plane - o) / d).abs();
            let unit = plane.abs().max(o.abs()) / d.abs() / f64::from(1 << 24);
            all.error_t = all.error_t.max(error);
            all.error = all.error.max(error / unit);
        }
    }
    Ok((all.rays > 0).then_some(all))
}

/// Columns of `tmax.csv`: one row a sample. `rule` is the rule without which tMax was computed, `cells_visited` those of
/// the farthest ray, and `rays` those still walking.
pub const COLUMNS: &[&str] = columns![
    schema_version run_id configuration device adapter accelerator schedule numerics rule cells_visited rays
    error_units error_t bound_units
];

/// Samples of a walk, with device and rules.
#[derive(Clone, Debug)]
pub struct Walked {
    /// The device.
    pub device: DeviceName,
    /// The rules.
    pub rules: Rules,
    /// Samples from the first to the last cell.
    pub samples: Vec<Sample>,
}

impl Walked {
    /// Whether these rules must stay within [`BOUND`].
    #[must_use]
    pub fn is_bounded(&self) -> bool {
        self.rules.numerics == Numerics::Robust && self.rules.without.is_none()
    }

    /// The largest error, in the unit of [`Sample::error`].
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.samples.iter().fold(0.0, |most, sample| most.max(sample.error))
    }

    /// Whether it is as expected: robust rules within the bound, others beyond it.
    #[must_use]
    pub fn is_as_expected(&self) -> bool {
        !self.samples.is_empty() && (self.largest() <= BOUND) == self.is_bounded()
    }
}

/// The rows of `tmax.csv`.
pub(super) fn table(run_id: &str, all: &[Walked]) -> tidy::Table {
    let mut table = tidy::Table::new(COLUMNS);
    for walked in all {
        let (configuration, name) = (walked.rules.configuration(), walked.rules.configuration().rules());
        for sample in &walked.samples {
            let row = tidy::Row::new(COLUMNS)
                .set("run_id", run_id)
                .set("configuration", format!("long-walk/{}/{name}", walked.device.kind))
                .with(&walked.device)
                .configured(&configuration)
                .set("cells_visited", sample.cells)
                .set("rays", sample.rays)
                .set("error_units", sample.error)
                .set("error_t", sample.error_t)
                .set("bound_units", walked.is_bounded().then_some(BOUND));
            table.rows.push(row);
        }
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    fn walked(rules: Rules) -> Walked {
        let samples = pollster::block_on(walk(rules, 16, &Device::Cpu(None))).expect("a walk");
        Walked { device: DeviceName { kind: "cpu_f32", adapter: String::new() }, rules, samples }
    }

    #[test]
    fn tmax_from_the_cell_stays_within_its_bound_over_3000_cells_and_accumulated_it_does_not() {
        for rules in RULES {
            let walked = walked(rules);
            let (first, last) = (walked.samples[0], walked.samples[walked.samples.len() - 1]);
            assert!(last.cells > 2900, "{}: {} cells", rules.name, last.cells);
            assert!(walked.is_as_expected(), "{}: {}", rules.name, walked.largest());
            let growth = last.error / first.error.max(1.0);
            assert!(if walked.is_bounded() { growth <= 2.0 } else { growth > 10.0 }, "{}: {growth}", rules.name);
        }
    }
}
