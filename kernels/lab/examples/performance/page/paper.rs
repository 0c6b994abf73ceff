//! The paper's Tables 2 and 3 beside ours.

use std::path::Path;

use raystep_lab::human::{digits, time};
use raystep_lab::paper::SECONDS as PAPER;
use raystep_lab::tidy::Row;

use super::{Measured, line, mray_per_s, name, or_dash, over, percent, ratio, table};

/// Identifies a configuration of the section: accelerator, schedule, numerics, grid, steps per pass.
type Key = [&'static str; 5];

const FIRST: Key = ["grid", "first", "paper", "20,20,20", ""];
const SECOND: Key = ["grid", "second", "paper", "20,20,20", ""];
const NONE: Key = ["none", "second", "paper", "auto", ""];

fn find(machine: &Measured, side: u32, key: Key) -> Option<&Row> {
    let columns = ["accelerator", "schedule", "numerics", "grid", "steps_per_pass"];
    let is_of = |row: &&Row| columns.map(|column| row.get(column)) == key && row.get("skip") != "on";
    machine.of("paper").filter(is_of).find(|row| row.number("width_px") == Some(f64::from(side)))
}

fn ns(row: Option<&Row>) -> Option<f64> {
    row.and_then(|row| row.number("median_ns"))
}

/// The largest side at which these were measured.
fn largest(machine: &Measured, keys: &[Key]) -> Option<u32> {
    PAPER.iter().rev().map(|p| p.0).find(|&side| keys.iter().all(|&key| find(machine, side, key).is_some()))
}

/// Cells or nodes visited and triangles tested.
fn steps(row: &Row) -> f64 {
    ["cells_per_ray", "tests_per_ray"].map(|column| row.number(column).unwrap_or(0.0)).iter().sum()
}

fn steps_per_thread(row: &Row) -> Option<f64> {
    row.number("tests_per_ray")?;
    Some(steps(row) * ratio(row, "rays", "threads_launched")?)
}

/// Cells of its grid: "4×4×9".
fn cells(row: &Row) -> String {
    row.get("cells").replace('x', "×")
}

pub(super) fn tables(machine: &Measured, folder: &Path) -> Result<String, String> {
    let Some(side) = largest(machine, &[SECOND, NONE]) else { return Ok(String::new()) };
    let compared = PAPER.map(|(side, [first, second, none])| {
        let [of_first, of_second, of_none] = [FIRST, SECOND, NONE].map(|key| ns(find(machine, side, key)));
        let there = [first, second, none].map(|seconds| time(seconds * 1e9));
        let here = [of_first, of_second, of_none].map(|ns| or_dash(ns, time));
        let by_none = of_second.zip(of_none).map(|(second, none)| second / none);
        let ratios = [digits(second / none), or_dash(by_none, digits)];
        [&[format!("{side}×{side}")], &there[..], &ratios[..1], &here, &ratios[1..]].concat()
    });
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
    let plot = plot(machine, folder)?;
    let text = format!("{}{plot}\n", table(&names, &compared));
    if machine.is_cpu() {
        // The CPU has no workgroups, and its rays do the same steps.
        return Ok(text);
    }
    let all = machine.of("paper").filter(|row| row.number("width_px") == Some(f64::from(side))).map(|row| {
        let number = |column| or_dash(row.number(column), digits);
        let grid = if row.get("accelerator") == "grid" { format!(", {}", cells(row)) } else { String::new() };
        let cells = if row.get("accelerator") == "none" { "–".into() } else { number("cells_per_ray") };
        vec![
            format!("{}{grid}, {} rules", name(row), row.get("numerics")),
            number("passes"),
            or_dash(ratio(row, "threads_launched", "rays"), digits),
            or_dash(ratio(row, "threads_with_ray", "threads_launched"), percent),
            cells,
            number("tests_per_ray"),
            or_dash(steps_per_thread(row), digits),
            or_dash(ns(Some(row)), time),
            or_dash(mray_per_s(row), digits),
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
    Ok(format!("{text}All configurations at {side}×{side}:\n\n{}", table(&names, &all.collect::<Vec<_>>())))
}

pub(super) fn why(machine: &Measured) -> String {
    let keys = [SECOND, NONE];
    let Some(side) = largest(machine, &keys) else { return String::new() };
    let [Some(second), Some(none)] = keys.map(|key| find(machine, side, key)) else { return String::new() };
    let Some(&(_, [_, second_s, none_s])) = PAPER.iter().find(|p| p.0 == side) else { return String::new() };
    let verdict = if steps(second) < steps(none) { "fewer" } else { "more" };
    let number = |row: &Row, column| or_dash(row.number(column), digits);
    let share = |row| or_dash(ratio(row, "threads_with_ray", "threads_launched"), percent);
    let [of_second, of_none] = [second, none].map(steps_per_thread);
    let mut text = format!(
        "At {side}×{side} a ray takes {} cells and {} tests through the grid, {} steps, {verdict} than the {} tests \
         without it. But second takes {} passes, each over every pixel, compared with {} without a grid; {} of the \
         threads that it launches have a ray to process, compared with {}. A thread takes {} useful steps with the \
         grid, and {} without: {} times as many. The paper's time with the grid was {} times that without, ours is {} \
         times. The same rays with each schedule:\n",
        number(second, "cells_per_ray"),
        number(second, "tests_per_ray"),
        digits(steps(second)),
        number(none, "tests_per_ray"),
        number(second, "passes"),
        number(none, "passes"),
        share(second),
        share(none),
        or_dash(of_second, digits),
        or_dash(of_none, digits),
        or_dash(of_none.zip(of_second).map(|(none, second)| none / second), digits),
        digits(second_s / none_s),
        or_dash(ns(Some(second)).zip(ns(Some(none))).map(|(second, none)| second / none), digits),
    );
    let schedules = [
        ("compact", "1", "one step per pass, active rays only"),
        ("compact", "8", "eight steps per pass"),
        ("fused", "", "all steps in one kernel"),
    ];
    for (schedule, steps, words) in schedules {
        let row = |accelerator, grid| find(machine, side, [accelerator, schedule, "robust", grid, steps]);
        let Some(without) = ns(row("none", "auto")) else { continue };
        let times = |row| or_dash(ns(row).map(|ns| ns / without), digits);
        text += &format!(
            "\n- {words}: {} times the time without a grid for 20×20×20 cells, {} for the automatic {}, {} for the \
             BVH; without a structure, {}.",
            times(row("grid", "20,20,20")),
            times(row("grid", "auto")),
            row("grid", "auto").map(cells).unwrap_or_default(),
            times(row("bvh", "auto")),
            time(without),
        );
    }
    text
}

fn plot(machine: &Measured, folder: &Path) -> Result<String, String> {
    let theirs = [("2004: first, grid", 1), ("2004: second, grid", 0), ("2004: no grid", 6)];
    let theirs = theirs.into_iter().enumerate().map(|(i, (name, color))| {
        let points = PAPER.map(|(side, seconds)| (f64::from(side * side), seconds[i] * 1e9));
        line(name.into(), color, true, points.into())
    });
    let ours: [(&str, Key, usize); 6] = [
        ("first, grid 20³", FIRST, 1),
        ("second, grid 20³", SECOND, 0),
        ("second, no grid", NONE, 6),
        ("compact K=8, automatic grid", ["grid", "compact", "robust", "auto", "8"], 2),
        ("fused, automatic grid", ["grid", "fused", "robust", "auto", ""], 3),
        ("fused, no grid", ["none", "fused", "robust", "auto", ""], 4),
    ];
    let ours = ours.into_iter().map(|(name, key, color)| {
        let at = |&(side, _): &(u32, [f64; 3])| Some((f64::from(side * side), ns(find(machine, side, key))?));
        line(name.into(), color, false, PAPER.iter().filter_map(at).collect())
    });
    let series = theirs.chain(ours).filter(|series| !series.points.is_empty()).collect();
    let plot = over(format!("The Cornell box, {}", machine.title()), "rays", series);
    machine.plot(folder, "paper", "The paper's tables and ours", plot)
}
