//! The cost of passes: per byte, and per pass.

use super::Measured;
use super::text::{columns, distinct, number, or_dash, percent, table, time};
use crate::fit::Line;
use crate::row::Probe;

type Size = (u32, u32);

fn size(probe: &Probe) -> Size {
    (probe.width_px, probe.height_px)
}

/// Fits the time of one dispatch against its bytes: fixed cost and nanoseconds per byte.
fn update(machine: &Measured, of: Size) -> Option<Line> {
    let probes = machine.probed("bytes", "update of textures").filter(|p| size(p) == of);
    let point = |p: &Probe| Some((p.bytes? as f64 / p.passes as f64, p.median_device_ns? / p.passes as f64));
    Line::through(&probes.filter_map(point).collect::<Vec<_>>())
}

/// Fits the time of a submission against its passes: the slope is the cost of an empty pass.
fn empty_pass(machine: &Measured, schedule: &str, of: Size) -> Option<Line> {
    let what = format!("empty pass, {schedule}");
    let probes = machine.probed("bytes", &what).filter(|p| size(p) == of);
    Line::through(&probes.filter_map(|p| Some((p.passes as f64, p.median_device_ns?))).collect::<Vec<_>>())
}

pub(super) fn bytes(machine: &Measured) -> String {
    let mut text = String::new();
    let per_s = |ns_a_byte: f64| format!("{} GB/s", number(1.0 / ns_a_byte));
    if let Some(copy) = machine.probed("bytes", "copy of a buffer").next()
        && let Some((bytes, ns)) = copy.bytes.zip(copy.median_device_ns)
    {
        text += &format!(
            "A copy from one buffer of {} MiB to another moves {}, counting reads and writes.\n\n",
            (bytes / copy.passes / 2) >> 20,
            per_s(ns / bytes as f64)
        );
    }
    let sizes = distinct(machine.probed("bytes", "update of textures").map(size));
    let rows = sizes.iter().map(|&of| {
        let pass = |schedule| or_dash(empty_pass(machine, schedule, of).map(|line| line.slope), time);
        vec![
            format!("{}×{}", of.0, of.1),
            update(machine, of).map_or("–".into(), |line| per_s(line.slope)),
            pass("compact"),
            pass("second"),
        ]
    });
    let names = ["", "update of textures in place", "empty pass, active rays only", "empty pass, all rays"];
    text += &table(&columns(&names), &rows.collect::<Vec<_>>());
    let mut rows = Vec::new();
    for run in machine.probed("bytes", "run of one step") {
        let Some((bytes, ns)) = run.bytes.zip(run.median_device_ns) else { continue };
        let moving = update(machine, size(run)).map(|line| bytes as f64 * line.slope);
        let passing = empty_pass(machine, "compact", size(run)).map(|line| run.passes as f64 * line.slope);
        let model = moving.zip(passing).map(|(a, b)| a + b);
        rows.push(vec![
            format!("{}, {}, {}×{}", run.scene, run.accelerator, run.width_px, run.height_px),
            run.passes.to_string(),
            number(bytes as f64 / 1e6),
            or_dash(moving, time),
            or_dash(passing, time),
            time(ns),
            or_dash(model.map(|model| ns / model), number),
        ]);
    }
    if rows.is_empty() {
        return String::new();
    }
    let names =
        ["run, one step per pass", "passes", "MB", "MB at that speed", "passes, if empty", "time", "time / their sum"];
    text + &table(&columns(&names), &rows)
}

pub(super) fn tdelta(machine: &Measured) -> String {
    let probes: Vec<&Probe> = machine.probed("tdelta", "").collect();
    let mut rows = Vec::new();
    for of in distinct(probes.iter().map(|p| size(p))) {
        let of_size: Vec<&Probe> = probes.iter().copied().filter(|p| size(p) == of).collect();
        let worked_out = of_size.first().and_then(|p| p.median_device_ns);
        for p in &of_size {
            let per_pass = p.median_device_ns.map(|ns| ns / p.passes as f64);
            let spread = p
                .low_device_ns
                .zip(p.high_device_ns)
                .map(|(a, b)| format!("{} – {}", time(a / p.passes as f64), time(b / p.passes as f64)));
            rows.push(vec![
                format!("{}×{}, {}", of.0, of.1, p.what),
                or_dash(p.bytes.map(|b| b as f64 / p.passes as f64 / f64::from(of.0 * of.1)), number),
                or_dash(per_pass, time),
                spread.unwrap_or("–".into()),
                or_dash(p.median_device_ns.zip(worked_out).map(|(a, b)| a / b), number),
                or_dash(p.value, percent),
            ]);
        }
    }
    if rows.is_empty() {
        return String::new();
    }
    let names = [
        "",
        "bytes per ray",
        "time per pass",
        "95% interval of the median",
        "/ worked out",
        "rays in a different cell at the end",
    ];
    table(&columns(&names), &rows)
}
