//! Measurements other than cases: tMax along a walk, and differences between pipelines.

use std::fmt::Write as _;

use super::{Place, Report, drift, probe};
use crate::reporter::Reporter;
use crate::{Error, Machine};

/// Number of rays in the long walk.
const WALKING: usize = 256;
/// Number of rays in the probe.
const PROBED: usize = 16_384;

/// Walks with every rule, on devices that compute in f32.
pub(super) fn walks(
    quick: bool,
    places: &[(Place, Machine)],
    reporter: &dyn Reporter,
) -> Result<Vec<drift::Walked>, Error> {
    let mut all = Vec::new();
    for (place, machine) in places.iter().filter(|(place, _)| place.device != "cpu_f64") {
        for rules in drift::RULES {
            reporter.stage(&format!("tMax along a walk, {}: {}", place.device, rules.name));
            let walking = drift::walk(rules, if quick { WALKING / 8 } else { WALKING }, &machine.device);
            all.push(drift::Walked { place: place.clone(), rules, samples: machine.wait(walking)? });
        }
    }
    Ok(all)
}

/// Traces the same pairs through every pipeline of every f32 device. All pipelines with the same rays are compared with
/// the first such pipeline of the first device.
pub(super) fn pipelines(
    run_id: &str,
    quick: bool,
    places: &[(Place, Machine)],
    reporter: &dyn Reporter,
) -> Result<Vec<probe::Row>, Error> {
    let workloads = probe::workloads(if quick { PROBED / 8 } else { PROBED })?;
    let mut rows = Vec::new();
    let mut bases: [Option<(String, probe::Bits)>; 2] = [None, None];
    for (place, machine) in places.iter().filter(|(place, _)| place.device != "cpu_f64") {
        for pipeline in probe::pipelines(&workloads) {
            reporter.stage(&format!("pipelines, {}: {}", place.device, pipeline.name));
            let bits = machine.wait(probe::run(&pipeline, &workloads, &machine.device))?;
            let (name, base) = bases[usize::from(pipeline.is_camera)]
                .get_or_insert_with(|| (format!("{}: {}", place.device, pipeline.name), bits.clone()));
            rows.push(probe::Row::new(run_id, place, &pipeline, name, bits.difference(base)));
        }
    }
    Ok(rows)
}

/// A walk's result as text.
pub(super) fn told(walked: &drift::Walked) -> String {
    let last = walked.samples.last().map_or(0, |sample| sample.cells);
    let bound = if walked.is_bounded() { format!(", bound {}", drift::BOUND) } else { String::new() };
    format!(
        "{} {}: error at most {:.1} units of 2^-24 over {last} cells{bound}",
        walked.place.device,
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
        let _ = writeln!(text, "tMax, {}", told(walked));
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
