//! All cases in all configurations, with their results.

use std::sync::Arc;

use raystep_kernels::{Accelerator, Numerics, RaySource};

use super::picture::Picture;
use super::row::{self, Traced};
use super::{Case, DeviceName, Row, Workload, beside, configurations, drift, page, probe, run, table};
use crate::judge::Judge;
use crate::meter::Meter;
use crate::reference::Verdict;
use crate::reporter::Reporter;
use crate::stiff::{self, Cost, Start};
use crate::tidy::Table;
use crate::tidy::package::{self, Resource};
use crate::{Error, Hash, Machine};

/// The accelerators to compare, without `auto`.
pub const ACCELERATORS: &[Accelerator] =
    &[Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh, Accelerator::None];

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
    /// The cost of stiff scenes, if wanted, on the first device.
    pub cost: Option<Arc<Start>>,
    /// Identifies this invocation, in all files.
    pub run_id: String,
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
    /// What stiff scenes cost, if wanted.
    pub cost: Option<Cost>,
    /// Identifies the invocation.
    pub run_id: String,
}

/// One row per case and configuration.
const CSV: &str = "stability.csv";
/// The error of tMax along a walk.
const DRIFT: &str = "tmax.csv";
/// The same results with pictures.
const PAGE: &str = "stability.html";

/// Names of a report's files, those of an optional part included; the one with all rows is first.
pub const FILES: [&str; 7] = [CSV, DRIFT, probe::FILE, stiff::CSV, stiff::RUNS, package::FILE, PAGE];

/// Traces everything requested.
///
/// # Errors
/// If a device fails.
pub fn measure(wanted: &Wanted, devices: &[(DeviceName, Machine)], reporter: &dyn Reporter) -> Result<Report, Error> {
    let Wanted { cases, accelerators, is_quick, pipelines, cost, run_id } = wanted;
    let mut outcomes = Vec::new();
    for (i, case) in cases.iter().enumerate() {
        reporter.stage(&format!("case {} of {}: {}", i + 1, cases.len(), case.name));
        let of_case = |error| Error::Case { name: case.name, error: Box::new(error) };
        outcomes.push(one(wanted, case, devices).map_err(of_case)?);
    }
    let has_walk = cases.iter().any(|case| case.name == "long-walk") && accelerators.contains(&Accelerator::Grid);
    let walks = if has_walk { beside::walks(*is_quick, devices, reporter)? } else { Vec::new() };
    let pipelines = if *pipelines { beside::pipelines(run_id, *is_quick, devices, reporter)? } else { Vec::new() };
    let cost = match (cost, devices.first()) {
        (Some(start), Some((_, machine))) => Some(start.cost(&Meter::new(machine.clone()), reporter)?),
        _ => None,
    };
    Ok(Report { outcomes, walks, pipelines, cost, run_id: run_id.clone() })
}

/// Traces a case in every requested configuration.
fn one(wanted: &Wanted, case: &'static Case, devices: &[(DeviceName, Machine)]) -> Result<Outcome, Error> {
    let rays = if wanted.is_quick { (case.rays / 8).max(1) } else { case.rays };
    let workload = (case.make)(rays)?;
    let mut outcome = Outcome { case, rows: Vec::new(), pictures: Vec::new(), first_wrong_ray: None };
    let triangles = &workload.scene.triangles;
    let scene_hash = Hash::of_triangles(triangles);
    let traced = Traced { case, scene_hash, triangles: triangles.len() };
    let mut judge = Judge::default();
    for (device, machine) in devices {
        for &accelerator in ACCELERATORS.iter().filter(|a| wanted.accelerators.contains(a)) {
            for configuration in configurations(accelerator) {
                // In f64, fused or contracted runs would add nothing to the stepped ones, and integers hold only f32.
                let is_of_f64 = configuration.is_stepped() && !configuration.contracted && !configuration.is_exact();
                if !is_of_f64 && device.kind == "cpu_f64" {
                    continue;
                }
                let run = machine.wait(run(case, &workload, configuration, &machine.device, &mut judge))?;
                let row = Row::new(&wanted.run_id, traced, configuration, device, &run);
                if let Some(([ox, oy, oz], [dx, dy, dz])) = run.score.first_error
                    && configuration.numerics == Numerics::Robust
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
        Some(same) => same.runs.push(table::in_words(row)),
        None => {
            picture.runs.push(table::in_words(row));
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
            return Some(format!("tMax along a walk is not as expected: {}", beside::in_words(walked)));
        };
        Some(format!(
            "{} of {} runs are not as expected, the first of them {}: expected to {}",
            wrong.len(),
            rows().count(),
            table::name(first),
            first.field("expected")
        ))
    }

    /// The tables of cases, walks and pipelines: the name of each one's file, and what a row of it is.
    fn tables(&self) -> [(&'static str, &'static str, Table); 3] {
        [
            (CSV, "a case in a configuration", row::table(self.outcomes.iter().flat_map(|o| &o.rows))),
            (DRIFT, "a sample of a walk", drift::table(&self.run_id, &self.walks)),
            (probe::FILE, "a pipeline", probe::table(&self.pipelines)),
        ]
    }

    /// The files of these tables that have rows.
    ///
    /// # Errors
    /// If there is not enough memory for a file.
    pub fn csv_files(&self) -> Result<Vec<(&'static str, Vec<u8>)>, Error> {
        let has_rows = |(_, _, table): &(_, _, Table)| !table.rows.is_empty();
        let file = |(file, _, table): (_, _, Table)| Ok((file, table.csv()?));
        self.tables().into_iter().filter(has_rows).map(file).collect()
    }

    /// The report's files, by [name](FILES).
    ///
    /// # Errors
    /// If a plot or picture cannot be drawn, or there is not enough memory for a file.
    pub fn files(&self) -> Result<Vec<(&'static str, Vec<u8>)>, Error> {
        let (mut files, mut resources) = (Vec::new(), Vec::new());
        for (file, what, table) in &self.tables() {
            files.push((*file, table.csv()?));
            resources.push(Resource { file, what, columns: table.columns });
        }
        if let Some(cost) = &self.cost {
            files.extend(cost.files()?);
            resources.extend(stiff::resources());
        }
        let schema = package::describe("raystep-stability", "raystep: stability", &resources);
        files.push((package::FILE, format!("{schema:#}\n").into_bytes()));
        files.push((PAGE, page::html(self)?.into_bytes()));
        Ok(files)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::{BTreeMap, BTreeSet};

    use raystep_kernels::Device;

    use crate::machine::now_ns;
    use crate::reporter::Silent;
    use crate::stability::{CASES, COLUMNS, Expected};
    use crate::stiff::{FAMILIES, Kept};
    use crate::tidy;

    #[test]
    fn a_report_is_unexpected_where_a_row_is_not_as_expected_and_only_there() {
        let row = |expected: Expected, has_errors: bool| {
            let configuration = configurations(Accelerator::Grid)[0];
            let case = CASES[0].name;
            Row {
                case,
                configuration,
                device: "gpu",
                expected,
                passed: !has_errors,
                has_errors,
                fields: tidy::Row::new(COLUMNS),
            }
        };
        let unexpected = |rows: Vec<Row>| {
            let outcome = Outcome { case: &CASES[0], rows, pictures: Vec::new(), first_wrong_ray: None };
            let (walks, pipelines) = (Vec::new(), Vec::new());
            Report { outcomes: vec![outcome], walks, pipelines, cost: None, run_id: String::new() }.unexpected()
        };
        let right = [row(Expected::Pass, false), row(Expected::Fail, true), row(Expected::Any, true)];
        assert_eq!(unexpected(right.to_vec()), None);
        for wrong in [row(Expected::Pass, true), row(Expected::Fail, false)] {
            let line = unexpected([&right[..], &[wrong]].concat());
            assert!(line.is_some_and(|line| line.starts_with("1 of 4 runs are not as expected")));
        }
    }

    #[test]
    fn files_match_their_schema_and_every_column_is_described() {
        let machine = Machine { device: Device::Cpu(Some(now_ns)), reason: String::new() };
        let families = FAMILIES.iter().filter(|family| family.name == "t-junctions").collect();
        let budget = std::time::Duration::ZERO;
        let stiff = stiff::Wanted { families, budget, ..stiff::Wanted::new("1-2".into(), true) };
        let cases = CASES.iter().filter(|case| ["corners", "long-walk"].contains(&case.name)).collect();
        let wanted = Wanted {
            cases,
            accelerators: vec![Accelerator::Grid],
            is_quick: true,
            pipelines: true,
            cost: Some(Arc::new(Start::new(stiff, Kept::default(), |_, _| Ok(())))),
            run_id: "1-2".into(),
        };
        let devices = [(DeviceName { kind: "cpu_f32", adapter: "cpu".into() }, machine)];
        let report = measure(&wanted, &devices, &Silent).expect("no error");
        let files: BTreeMap<&str, Vec<u8>> = report.files().expect("memory").into_iter().collect();
        assert_eq!(files.keys().copied().collect::<BTreeSet<_>>(), BTreeSet::from(FILES));
        assert_eq!(package::check(&files[package::FILE], |name| files.get(name).cloned()), Ok(()));
        for (name, file) in files.iter().filter(|(name, _)| name.ends_with(".csv")) {
            let mut reader = ::csv::Reader::from_reader(&file[..]);
            for name in reader.headers().expect("names") {
                assert!(crate::tidy::columns::column(name).is_some(), "{name}");
            }
            let rows: Vec<_> = reader.into_records().map(|row| row.expect("as many fields as names")).collect();
            assert!(!rows.is_empty() && rows.iter().all(|row| &row[0] == "2" && &row[1] == "1-2"), "{name}");
        }
    }
}
