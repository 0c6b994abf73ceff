//! The fastest configurations, and the machines.

use super::Measured;
use super::text::{columns, distinct, number, percent, table, time};
use crate::row::Row;

/// The fastest configurations for each scene and kind of ray.
pub(super) fn answer(machine: &Measured) -> String {
    let rows: Vec<&Row> = machine.timed("meshes").collect();
    let key = |row: &Row| (row.scene.clone(), row.triangles, row.rays_kind.clone(), row.width_px, row.height_px);
    let mut lines = Vec::new();
    for group in distinct(rows.iter().map(|row| key(row))) {
        let of_group = || rows.iter().copied().filter(|row| key(row) == group);
        let fastest = |wanted: &dyn Fn(&Row) -> bool| {
            let best = of_group().filter(|row| wanted(row));
            best.min_by(|a, b| {
                a.median_device_ns.unwrap_or(f64::MAX).total_cmp(&b.median_device_ns.unwrap_or(f64::MAX))
            })
        };
        let cell = |row: Option<&Row>| {
            row.and_then(|r| Some(format!("{}: {}", r.way(), number(r.mray_per_s()?)))).unwrap_or("–".into())
        };
        lines.push(vec![
            format!("{}, {} triangles", group.0, group.1),
            group.2.clone(),
            cell(fastest(&|_| true)),
            cell(fastest(&|r| r.accelerator == "irregular")),
            cell(fastest(&|r| r.accelerator == "grid")),
            cell(fastest(&|r| r.schedule != "fused")),
            cell(fastest(&|r| r.schedule != "fused" && r.steps_per_pass == 1)),
        ]);
    }
    if lines.is_empty() {
        return String::new();
    }
    let size = rows.first().map(|r| format!("{}×{}", r.width_px, r.height_px)).unwrap_or_default();
    let names = [
        "scene",
        "rays",
        "fastest",
        "with the irregular grid",
        "with the uniform grid",
        "fastest in steps",
        "fastest, one step per pass",
    ];
    format!("Million rays per second, {size} pixels.\n\n{}", table(&columns(&names), &lines))
}

/// Describes the machine, how often it ran, and the spread of its times.
pub(super) fn machine(machine: &Measured) -> String {
    let about = &machine.about;
    let width = |r: &Row| Some((r.high_device_ns? - r.low_device_ns?) / r.median_device_ns?);
    let mut widths: Vec<f64> = machine.rows.iter().filter_map(width).collect();
    widths.sort_by(f64::total_cmp);
    let at = |share: f64| widths.get((share * widths.len().saturating_sub(1) as f64) as usize).copied();
    let timed: Vec<&Row> = machine.rows.iter().filter(|row| row.n > 0).collect();
    let left_out = machine.rows.len() - timed.len();
    let invalid: usize = machine.rows.iter().map(|row| row.invalid).sum::<usize>()
        + machine.probes.iter().map(|probe| probe.invalid).sum::<usize>();
    let (least, most) = (timed.iter().map(|r| r.n).min(), timed.iter().map(|r| r.n).max());
    let clock = match about.timestamp_period_ns {
        Some(period) => format!("timestamps of {} each", time(period)),
        None => "timed by the processor's clock".into(),
    };
    let mut text = format!("**{}**: ", machine.title());
    if about.kind != "processor" {
        text += &format!("{} ({}, {}), ", about.adapter, about.backend, about.driver);
    }
    text += &format!("{}, {} cores; {clock}; raystep {}.", about.processor, about.cores, about.raystep_version);
    let seconds: f64 = about.seconds.iter().map(|(_, s)| s).sum();
    text += &format!(
        "\n`performance measure {}`, {} s: {} configurations with {} to {} runs each, {left_out} omitted with the \
         reason in the CSV, {invalid} invalid times not counted.",
        about.arguments,
        number(seconds.round()),
        timed.len(),
        least.unwrap_or(0),
        most.unwrap_or(0),
    );
    if let (Some(half), Some(most)) = (at(0.5), at(0.95)) {
        text += &format!(
            " The 95% interval of the median is {} of it wide in half of the configurations with at least 6 runs, and below \
             {} in 19 of 20.",
            percent(half),
            percent(most)
        );
    }
    text += &agreement(machine);
    if about.quick {
        text += " **A quick run with three repeats on small images, to try the page out.**";
    }
    text
}

/// Whether configurations that must find the same hits did so.
fn agreement(machine: &Measured) -> String {
    let robust: Vec<&Row> = machine.rows.iter().filter(|r| r.hits.is_some() && r.numerics == "robust").collect();
    let key = |r: &Row| (r.section.clone(), r.scene.clone(), r.triangles, r.rays_kind.clone(), r.width_px, r.height_px);
    let groups = distinct(robust.iter().map(|r| key(r)));
    let differ =
        groups.iter().filter(|group| distinct(robust.iter().filter(|r| key(r) == **group).map(|r| r.hits)).len() > 1);
    match differ.count() {
        0 => format!(
            " In each of the {} groups, all configurations with robust numerics hit the same number of rays.",
            groups.len()
        ),
        n => format!(
            " **In {n} of the {} groups, configurations with robust numerics hit different numbers of rays.**",
            groups.len()
        ),
    }
}
