//! Measurements other than cases: tMax along a walk, and differences between pipelines.

use std::fmt::Write as _;

use super::{DeviceName, Report, drift, probe};
use crate::reporter::Reporter;
use crate::{Error, Machine};

/// Number of rays in the long walk.
const WALKING: usize = 256;
/// Number of rays in the probe.
const PROBED: usize = 16_384;

/// Walks with every rule, on devices that compute in f32.
pub(super) fn walks(
    quick: bool,
    devices: &[(DeviceName, Machine)],
    reporter: &dyn Reporter,
) -> Result<Vec<drift::Walked>, Error> {
    let mut all = Vec::new();
    for (device, machine) in devices.iter().filter(|(device, _)| device.kind != "cpu_f64") {
        for rules in drift::RULES {
            reporter.stage(&format!("tMax along a walk, {}: {}", device.kind, rules.name));
            let walking = drift::walk(rules, if quick { WALKING / 8 } else { WALKING }, &machine.device);
            all.push(drift::Walked { device: device.clone(), rules, samples: machine.wait(walking)? });
        }
    }
    Ok(all)
}

/// Traces the same pairs through every pipeline of every f32 device. All pipelines with the same rays are compared with
/// the first such pipeline of the first device.
pub(super) fn pipelines(
    run_id: &str,
    quick: bool,
    devices: &[(DeviceName, Machine)],
    reporter: &dyn Reporter,
) -> Result<Vec<probe::Row>, Error> {
    let mut comparison = probe::Comparison::new(if quick { PROBED / 8 } else { PROBED })?;
    let mut rows = Vec::new();
    for (device, machine) in devices.iter().filter(|(device, _)| device.kind != "cpu_f64") {
        for pipeline in comparison.pipelines() {
            reporter.stage(&format!("pipelines, {}: {}", device.kind, pipeline.name));
            rows.push(machine.wait(comparison.run(run_id, device, &pipeline, &machine.device))?);
        }
    }
    Ok(rows)
}

/// A walk's result as text.
pub(super) fn in_words(walked: &drift::Walked) -> String {
    let last = walked.samples.last().map_or(0, |sample| sample.cells);
    let bound = if walked.is_bounded() { format!(", bound {}", drift::BOUND) } else { String::new() };
    format!(
        "{} {}: error at most {:.1} units of 2^-24 over {last} cells{bound}",
        walked.device.kind,
        walked.rules.name,
        walked.largest(),
    )
}

/// The results of both as text.
#[must_use]
pub fn text(report: &Report) -> String {
    let mut text = String::new();
    for walked in &report.walks {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "tMax, {}", in_words(walked));
    }
    let all = &report.pipelines;
    let differing: Vec<_> = all.iter().filter(|row| row.difference.differing != [0; 3]).collect();
    if !all.is_empty() {
        let _ = match differing.len() {
            0 => writeln!(text, "all {} pipelines give results with the same bits", all.len()),
            some => writeln!(text, "{some} of {} pipelines give results that differ in some bit", all.len()),
        };
    }
    text
}
