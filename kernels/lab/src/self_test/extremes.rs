//! The extreme cases on this device, and pipelines compiled from one source.

use super::{Bench, Check, Finding, Found, Group, Step, Verdict};
use crate::reporter::Silent;
use crate::stability::{ACCELERATORS, CASES, Case, DeviceName, Report, Row, Wanted, measure, probe, text, text_beside};
use raystep_kernels::Numerics;

const ROBUST: &str = "robust rules";
const PAPER: &str = "paper's rules";
const WALK: &str = "tMax along a walk";
const PIPELINES: &str = "bits";

/// Rays through each pipeline.
const PROBED: usize = 1024;

pub(super) fn checks_of_cases() -> Vec<Check> {
    let check = |name, shows| Check { group: Group::Extremes, name, shows };
    vec![
        check(ROBUST, "robust rules make no error in any extreme case, with any structure"),
        check(PAPER, "the paper's rules fail where theory says that they must"),
        check(WALK, "tMax is within its bound along a walk of 3,000 cells"),
    ]
}

pub(super) fn checks_of_pipelines() -> Vec<Check> {
    let shows = "whether pipelines that contain the same triangle test compute the same bits";
    vec![Check { group: Group::Pipelines, name: PIPELINES, shows }]
}

/// A step a case.
pub(super) fn cases() -> Vec<Step> {
    let step = |case: &'static Case| {
        let all = [ROBUST, PAPER, WALK];
        let checks = if case.name == "long-walk" { &all[..] } else { &all[..2] };
        Step::new(Group::Extremes, case.name, checks, move |bench| of_case(bench, case))
    };
    CASES.iter().map(step).collect()
}

fn device_name(bench: &Bench) -> DeviceName {
    DeviceName { kind: "gpu", adapter: bench.machine.name() }
}

fn of_case(bench: &mut Bench, case: &'static Case) -> Found {
    let wanted = Wanted {
        cases: vec![case],
        accelerators: ACCELERATORS.to_vec(),
        is_quick: true,
        pipelines: false,
        cost: None,
        run_id: bench.run_id.clone(),
    };
    let report = measure(&wanted, &[(device_name(bench), bench.machine.clone())], &Silent)?;
    let rows = || report.outcomes.iter().flat_map(|outcome| &outcome.rows);
    let of = |check, numerics: Numerics| {
        let rows = || rows().filter(|row| row.configuration.numerics == numerics);
        let unexpected = rows().filter(|row| !row.is_as_expected()).map(Row::result);
        Finding::new(Group::Extremes, check, Verdict::Right, "")
            .counting(&[("cases", 1), ("runs", rows().count() as u64)])
            .wrong_by(unexpected.collect())
    };
    let mut findings = vec![of(ROBUST, Numerics::Robust), of(PAPER, Numerics::Paper)];
    findings.extend(of_walk(&report));
    if let Some(robust) = findings.first_mut().filter(|robust| robust.verdict == Verdict::Wrong) {
        robust
            .details
            .extend(text(&report.outcomes).lines().filter(|line| line.contains("first wrong ray")).map(str::to_owned));
    }
    let text_of = |(name, bytes): (&str, Vec<u8>)| (name.to_owned(), String::from_utf8_lossy(&bytes).into_owned());
    Ok((findings, report.csv_files()?.into_iter().map(text_of).collect()))
}

fn of_walk(report: &Report) -> Option<Finding> {
    if report.walks.is_empty() {
        return None;
    }
    let is_wrong = report.walks.iter().any(|walked| !walked.is_as_expected());
    let lines: Vec<String> = text_beside(report).lines().map(str::to_owned).collect();
    let says = lines.first().cloned().unwrap_or_default();
    let details = if is_wrong { lines } else { Vec::new() };
    Some(Finding::new(Group::Extremes, WALK, Verdict::Right, says).wrong_by(details))
}

/// A step a pipeline.
pub(super) fn pipelines() -> Vec<Step> {
    // Scenes of any size have the same pipelines.
    let Ok(comparison) = probe::Comparison::new(1) else { return Vec::new() };
    let step = |(index, pipeline): (usize, probe::Pipeline)| {
        Step::new(Group::Pipelines, pipeline.name, &[PIPELINES], move |bench| of_pipeline(bench, index))
    };
    comparison.pipelines().into_iter().enumerate().map(step).collect()
}

fn of_pipeline(bench: &mut Bench, index: usize) -> Found {
    let (name, device) = (device_name(bench), &bench.machine.device);
    let comparison = match &mut bench.pipelines {
        Some(comparison) => comparison,
        none => none.insert(probe::Comparison::new(PROBED)?),
    };
    let all = comparison.pipelines();
    let Some(pipeline) = all.get(index) else { return Ok(Default::default()) };
    // The first that traces the same rays, which the others are compared with, has run, unless this is another process.
    let first = all.iter().find(|first| first.is_camera == pipeline.is_camera).unwrap_or(pipeline);
    if first != pipeline && !comparison.has_base(pipeline) {
        bench.machine.wait(comparison.run(&bench.run_id, &name, first, device))?;
    }
    let row = bench.machine.wait(comparison.run(&bench.run_id, &name, pipeline, device))?;
    let differs = row.difference.differing != [0; 3] || row.difference.other_triangle > 0;
    let finding = Finding::new(Group::Pipelines, PIPELINES, Verdict::Information, "");
    let counts = [("pipelines", 1), ("differing", u64::from(differs))];
    let csv = String::from_utf8_lossy(&probe::table(std::slice::from_ref(&row)).csv()?).into_owned();
    let mut finding = finding.counting(&counts);
    if differs {
        let [t, ..] = row.difference.largest;
        finding.details.push(format!("{}: t differs by up to {t} ulp", pipeline.name));
    }
    Ok((vec![finding], vec![(probe::FILE.to_owned(), csv)]))
}
