//! The paper's Tables 2 and 3 beside ours.

use std::path::Path;

use raystep_lab::paper::SECONDS as PAPER;

use super::Measured;
use super::plot::{self, Axes, Series};
use super::text::{columns, number, or_dash, percent, table, time};
use crate::row::Row;

/// Identifies a configuration of the section: accelerator, schedule, numerics, grid, steps per pass.
type Key = (&'static str, &'static str, &'static str, &'static str, u32);

const FIRST: Key = ("grid", "first", "paper", "20x20x20", 1);
const SECOND: Key = ("grid", "second", "paper", "20x20x20", 1);
const NONE: Key = ("none", "second", "paper", "", 1);

fn find(machine: &Measured, side: u32, (accelerator, schedule, numerics, grid, steps): Key) -> Option<&Row> {
    machine.timed("paper").find(|r| {
        (r.accelerator.as_str(), r.schedule.as_str(), r.numerics.as_str()) == (accelerator, schedule, numerics)
            && (r.grid.as_str(), r.steps_per_pass, r.width_px) == (grid, steps, side)
            && r.skip != "on"
    })
}

fn ns(row: Option<&Row>) -> Option<f64> {
    row.and_then(|r| r.median_device_ns)
}

/// The largest side at which these were measured.
fn largest(machine: &Measured, keys: &[Key]) -> Option<u32> {
    PAPER.iter().rev().map(|p| p.0).find(|&side| keys.iter().all(|&key| find(machine, side, key).is_some()))
}

pub(super) fn tables(machine: &Measured) -> String {
    let Some(side) = largest(machine, &[SECOND, NONE]) else { return String::new() };
    let mut rows = Vec::new();
    for (side, [first, second, none]) in PAPER {
        let ours = [FIRST, SECOND, NONE].map(|key| ns(find(machine, side, key)));
        let ratio = |second: f64, none: f64| number(second / none);
        rows.push(vec![
            format!("{side}×{side}"),
            time(first * 1e9),
            time(second * 1e9),
            time(none * 1e9),
            ratio(second, none),
            or_dash(ours[0], time),
            or_dash(ours[1], time),
            or_dash(ours[2], time),
            ours[1].zip(ours[2]).map_or("–".into(), |(second, none)| ratio(second, none)),
        ]);
    }
    let names = [
        "",
        "2004: first",
        "second",
        "no grid",
        "second / no grid",
        "here: first",
        "second",
        "no grid",
        "second / no grid",
    ];
    let compared = table(&columns(&names), &rows);

    let plot = format!("{compared}![The paper's tables and ours](performance/{}/paper.svg)\n\n", machine.name);
    if machine.about.kind == "processor" {
        // The CPU has no workgroups, and its rays do the same steps.
        return plot;
    }
    let of_side = machine.timed("paper").filter(|r| r.width_px == side);
    let ways = of_side.map(|r| {
        let per_ray = |n: Option<u64>| or_dash(n.map(|n| n as f64 / r.rays as f64), number);
        let grid = if r.grid.is_empty() { String::new() } else { format!(", {}", r.cells.replace('x', "×")) };
        vec![
            format!("{}{grid}, {} rules", r.way(), r.numerics),
            or_dash(r.passes.map(|n| n as f64), number),
            per_ray(r.threads_launched),
            or_dash(r.share_with_ray(), percent),
            or_dash(r.cells_per_ray, number),
            or_dash(r.tests_per_ray, number),
            or_dash(r.useful_steps_per_thread, number),
            or_dash(r.median_device_ns, time),
            or_dash(r.mray_per_s(), number),
        ]
    });
    let names = [
        "",
        "passes",
        "threads launched per ray",
        "share with a ray",
        "cells or nodes per ray",
        "tests per ray",
        "useful steps per thread",
        "time",
        "Mray/s",
    ];
    let names = columns(&names);
    let ways = table(&names, &ways.collect::<Vec<_>>());
    format!("{plot}All configurations at {side}×{side}:\n\n{ways}")
}

pub(super) fn why(machine: &Measured) -> String {
    let keys = [SECOND, NONE];
    let Some(side) = largest(machine, &keys) else { return String::new() };
    let [Some(second), Some(none)] = keys.map(|key| find(machine, side, key)) else { return String::new() };
    let Some(&(_, [_, second_s, none_s])) = PAPER.iter().find(|p| p.0 == side) else { return String::new() };
    let steps = |r: &Row| r.cells_per_ray.unwrap_or(0.0) + r.tests_per_ray.unwrap_or(0.0);
    let verdict = if steps(second) < steps(none) { "fewer" } else { "more" };
    let mut text = format!(
        "At {side}×{side} a ray takes {} cells and {} tests through the grid, {} steps, {verdict} than the {} tests \
         without it. But second takes {} passes, each over every pixel, compared with {} without a grid; {} of the \
         threads that it launches have a ray to process, compared with {}. A thread takes {} useful steps with the \
         grid, and {} without: {} times as many. The paper's time with the grid was {} times that without, ours is {} \
         times. The same rays with each schedule:\n",
        or_dash(second.cells_per_ray, number),
        or_dash(second.tests_per_ray, number),
        number(steps(second)),
        number(steps(none)),
        or_dash(second.passes.map(|n| n as f64), number),
        or_dash(none.passes.map(|n| n as f64), number),
        or_dash(second.share_with_ray(), percent),
        or_dash(none.share_with_ray(), percent),
        or_dash(second.useful_steps_per_thread, number),
        or_dash(none.useful_steps_per_thread, number),
        or_dash(none.useful_steps_per_thread.zip(second.useful_steps_per_thread).map(|(a, b)| a / b), number),
        number(second_s / none_s),
        or_dash(ns(Some(second)).zip(ns(Some(none))).map(|(a, b)| a / b), number),
    );
    let schedules = [
        ("compact", 1, "one step per pass, active rays only"),
        ("compact", 8, "eight steps per pass"),
        ("fused", 1, "all steps in one kernel"),
    ];
    for (schedule, steps, words) in schedules {
        let row = |accelerator, grid| find(machine, side, (accelerator, schedule, "robust", grid, steps));
        let (same, auto, bvh, none) = (row("grid", "20x20x20"), row("grid", "auto"), row("bvh", ""), row("none", ""));
        let Some(without) = ns(none) else { continue };
        let times = |r: Option<&Row>| or_dash(ns(r).map(|t| t / without), number);
        text += &format!(
            "\n- {words}: {} times the time without a grid for 20×20×20 cells, {} for the automatic {}, {} for the \
             BVH; without a structure, {}.",
            times(same),
            times(auto),
            auto.map(|r| r.cells.replace('x', "×")).unwrap_or_default(),
            times(bvh),
            time(without),
        );
    }
    text
}

pub(super) fn plot(machine: &Measured, folder: &Path) -> Result<(), String> {
    let mut series = Vec::new();
    let theirs = ["2004: first, grid", "2004: second, grid", "2004: no grid"];
    for (i, name) in theirs.into_iter().enumerate() {
        let points = PAPER.map(|(side, seconds)| (f64::from(side * side), seconds[i] * 1e9)).to_vec();
        series.push(Series { name: name.into(), points, color: [1, 0, 2][i], is_dashed: true });
    }
    let ours: [(&str, Key, usize); 6] = [
        ("first, grid 20³", FIRST, 1),
        ("second, grid 20³", SECOND, 0),
        ("second, no grid", NONE, 2),
        ("compact K=8, automatic grid", ("grid", "compact", "robust", "auto", 8), 3),
        ("fused, automatic grid", ("grid", "fused", "robust", "auto", 1), 4),
        ("fused, no grid", ("none", "fused", "robust", "", 1), 5),
    ];
    for (name, key, color) in ours {
        let at = |&(side, _): &(u32, [f64; 3])| Some((f64::from(side * side), ns(find(machine, side, key))?));
        let points = PAPER.iter().filter_map(at).collect();
        series.push(Series { name: name.into(), points, color, is_dashed: false });
    }
    series.retain(|s| !s.points.is_empty());
    let title = format!("The Cornell box, {}", machine.title());
    let axes = Axes { title, x: "rays", y: "time", y_text: time };
    plot::write(&folder.join("paper.svg"), &axes, &series)
}
