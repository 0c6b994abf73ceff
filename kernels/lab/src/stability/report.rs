//! All cases in all configurations, with their results.

use raystep_kernels::{Accelerator, Numerics, RaySource, ScheduleKind};

use super::picture::Picture;
use super::{Case, Place, Row, Variant, Workload, beside, drift, page, probe, run, table, write_rows};
use crate::judge::Judge;
use crate::reference::Verdict;
use crate::reporter::Reporter;
use crate::{Error, Machine};

/// The accelerators to compare, without `auto`.
pub const ACCELERATORS: &[Accelerator] = &[Accelerator::Grid, Accelerator::Bvh, Accelerator::None];

/// What to trace.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// The cases.
    pub cases: Vec<&'static Case>,
    /// Some of [`ACCELERATORS`].
    pub accelerators: Vec<Accelerator>,
    /// Whether to trace only an eighth of the rays.
    pub is_quick: bool,
    /// Whether to compare pipelines, too.
    pub pipelines: bool,
}

/// The results of a case.
pub struct Outcome {
    /// The case.
    pub case: &'static Case,
    /// One per configuration.
    pub rows: Vec<Row>,
    /// Pictures of its errors.
    pub(super) pictures: Vec<Picture>,
    /// The first ray with an error in robust numerics, as text: a starting point for finding the cause.
    pub first_wrong_ray: Option<String>,
}

/// All results.
pub struct Report {
    /// One per case.
    pub outcomes: Vec<Outcome>,
    /// The long walk, if that case was requested.
    pub walks: Vec<drift::Walked>,
    /// Comparisons of pipelines, if requested.
    pub pipelines: Vec<probe::Row>,
}

/// One row per case and configuration.
const CSV: &str = "stability.csv";
/// The error of tMax along a walk.
const DRIFT: &str = "tmax.csv";
/// Differences between pipelines.
const PROBE: &str = "pipelines.csv";
/// The same results with pictures.
const PAGE: &str = "stability.html";

/// Names of a report's files; the one with all rows is first.
pub const FILES: [&str; 4] = [CSV, DRIFT, PROBE, PAGE];

/// Traces everything requested.
///
/// # Errors
/// If a device fails.
pub fn measure(wanted: &Wanted, places: &[(Place, Machine)], reporter: &dyn Reporter) -> Result<Report, Error> {
    let Wanted { cases, accelerators, is_quick, pipelines } = wanted;
    let mut outcomes = Vec::new();
    for (i, case) in cases.iter().enumerate() {
        reporter.stage(&format!("case {} of {}: {}", i + 1, cases.len(), case.name));
        let of_case = |error| Error::Case { name: case.name, error: Box::new(error) };
        outcomes.push(one(wanted, case, places).map_err(of_case)?);
    }
    let has_walk = cases.iter().any(|case| case.name == "long-walk") && accelerators.contains(&Accelerator::Grid);
    let walks = if has_walk { beside::walks(*is_quick, places, reporter)? } else { Vec::new() };
    let pipelines = if *pipelines { beside::pipelines(*is_quick, places, reporter)? } else { Vec::new() };
    Ok(Report { outcomes, walks, pipelines })
}

/// Traces a case in every requested configuration.
fn one(wanted: &Wanted, case: &'static Case, places: &[(Place, Machine)]) -> Result<Outcome, Error> {
    let rays = if wanted.is_quick { (case.rays / 8).max(1) } else { case.rays };
    let workload = (case.make)(rays)?;
    let mut outcome = Outcome { case, rows: Vec::new(), pictures: Vec::new(), first_wrong_ray: None };
    let mut judge = Judge::default();
    for (place, machine) in places {
        for &accelerator in ACCELERATORS.iter().filter(|a| wanted.accelerators.contains(a)) {
            for variant in Variant::of(accelerator) {
                // In f64, fused or contracted runs would add nothing to the stepped ones.
                if (variant.schedule == ScheduleKind::Fused || variant.contracted) && place.device == "cpu_f64" {
                    continue;
                }
                let run = machine.wait(run(case, &workload, variant, &machine.device, &mut judge))?;
                let row = Row::new(case, workload.scene.triangles.len(), variant, place, &run);
                if let Some(([ox, oy, oz], [dx, dy, dz])) = run.score.first_error
                    && variant.numerics == Numerics::Robust
                {
                    outcome.first_wrong_ray.get_or_insert_with(|| {
                        let name = table::name(&row);
                        format!("{name}: first wrong ray, in traced units: {ox:?},{oy:?},{oz:?},{dx:?},{dy:?},{dz:?}")
                    });
                }
                add_picture(&mut outcome.pictures, &row, &workload, &run.score.verdicts, &judge);
                outcome.rows.push(row);
            }
        }
    }
    Ok(outcome)
}

/// Keeps a picture of the errors; configurations with the same errors share one.
fn add_picture(pictures: &mut Vec<Picture>, row: &Row, workload: &Workload, verdicts: &[Verdict], judge: &Judge) {
    let size = match &workload.rays {
        RaySource::Camera { width, height, .. } => Some([*width, *height]),
        RaySource::Given(_) => None,
    };
    let directions = || (0..judge.sample().len()).map(|place| judge.ray(place)[1]).collect();
    let Some(mut picture) = Picture::of(verdicts, size, directions) else { return };
    match pictures.iter_mut().find(|p| p.is_same(&picture)) {
        Some(same) => same.ways.push(table::way(row)),
        None => {
            picture.ways.push(table::way(row));
            pictures.push(picture);
        }
    }
}

impl Report {
    /// What is not as expected, in one line.
    #[must_use]
    pub fn unexpected(&self) -> Option<String> {
        let rows = || self.outcomes.iter().flat_map(|o| &o.rows);
        let wrong: Vec<&Row> = rows().filter(|row| !row.is_as_expected()).collect();
        let Some(first) = wrong.first() else {
            let walked = self.walks.iter().find(|walked| !walked.is_as_expected())?;
            return Some(format!("tMax along a walk is not as expected: {}", beside::told(walked)));
        };
        Some(format!(
            "{} of {} runs are not as expected, the first of them {}: expected to {}",
            wrong.len(),
            rows().count(),
            table::name(first),
            first.field("expected")
        ))
    }

    /// The report's files, by [name](FILES).
    ///
    /// # Errors
    /// If a plot or picture cannot be drawn, or there is not enough memory for a file.
    pub fn files(&self) -> Result<Vec<(&'static str, Vec<u8>)>, Error> {
        let mut files = [CSV, DRIFT, PROBE].map(|name| (name, Vec::new()));
        write_rows(&mut files[0].1, self.outcomes.iter().flat_map(|o| &o.rows))?;
        drift::write_rows(&mut files[1].1, &self.walks)?;
        probe::write_rows(&mut files[2].1, &self.pipelines)?;
        let page = (PAGE, page::html(self)?.into_bytes());
        Ok(files.into_iter().chain([page]).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stability::{CASES, Expected};

    #[test]
    fn a_report_is_unexpected_where_a_row_is_not_as_expected_and_only_there() {
        let row = |expected: Expected, has_errors: bool| {
            let variant = Variant::of(Accelerator::Grid)[0];
            let case = CASES[0].name;
            Row { case, variant, device: "gpu", expected, passed: !has_errors, has_errors, fields: Default::default() }
        };
        let unexpected = |rows: Vec<Row>| {
            let outcome = Outcome { case: &CASES[0], rows, pictures: Vec::new(), first_wrong_ray: None };
            Report { outcomes: vec![outcome], walks: Vec::new(), pipelines: Vec::new() }.unexpected()
        };
        let right = [row(Expected::Pass, false), row(Expected::Fail, true), row(Expected::Any, true)];
        assert_eq!(unexpected(right.to_vec()), None);
        for wrong in [row(Expected::Pass, true), row(Expected::Fail, false)] {
            let line = unexpected([&right[..], &[wrong]].concat());
            assert!(line.is_some_and(|line| line.starts_with("1 of 4 runs are not as expected")));
        }
    }
}
