//! Time against triangles, rays, and steps per pass.

use std::path::Path;

use super::Measured;
use super::plot::{self, Axes, Series};
use super::text::{columns, count, distinct, number, or_dash, percent, table, time};
use crate::fit::{Line, crossover};
use crate::row::Row;

/// The configurations with their rows, one list per configuration.
fn ways<'a>(machine: &'a Measured, section: &'a str, scene: &str) -> Vec<(String, Vec<&'a Row>)> {
    let rows: Vec<&Row> = machine.timed(section).filter(|r| r.scene == scene).collect();
    let names = distinct(rows.iter().map(|r| r.way()));
    let of = |name: &String| rows.iter().copied().filter(|r| r.way() == *name).collect();
    names.into_iter().map(|name| (name.clone(), of(&name))).collect()
}

fn scenes(machine: &Measured, section: &str) -> Vec<String> {
    distinct(machine.timed(section).map(|r| r.scene.clone()))
}

fn curve(rows: &[&Row], x: fn(&Row) -> f64, y: fn(&Row) -> Option<f64>) -> Vec<(f64, f64)> {
    rows.iter().filter_map(|r| Some((x(r), y(r)?))).collect()
}

fn with_build(row: &Row) -> Option<f64> {
    Some(row.median_device_ns? + row.build_s? * 1e9)
}

pub(super) fn triangles(machine: &Measured) -> String {
    let mut text = String::new();
    for scene in scenes(machine, "triangles") {
        let ways = ways(machine, "triangles", &scene);
        let counts = distinct(machine.timed("triangles").filter(|r| r.scene == scene).map(|r| r.triangles));
        let mut names = vec!["triangles".to_owned()];
        names.extend(ways.iter().map(|(name, _)| name.clone()));
        names.extend(
            ["grid built in", "irregular grid built in", "BVH built in (wide)", "BVH built in (binary)"]
                .map(String::from),
        );
        let rows = counts.iter().map(|&triangles| {
            let at = |rows: &[&Row]| rows.iter().find(|r| r.triangles == triangles).and_then(|r| r.median_device_ns);
            let built = |way: &str| {
                let row = ways.iter().find(|(name, _)| name == way)?.1.iter().find(|r| r.triangles == triangles)?;
                row.build_s.map(|s| s * 1e9)
            };
            let mut cells = vec![count(triangles as f64)];
            cells.extend(ways.iter().map(|(_, rows)| or_dash(at(rows), time)));
            cells.extend(
                ["grid, fused", "irregular, fused", "bvh, fused", "bvh, compact K=8"]
                    .map(|way| or_dash(built(way), time)),
            );
            cells
        });
        text += &table(&names, &rows.collect::<Vec<_>>());
        text += &format!("![Time against triangles, {scene}](performance/{}/triangles-{scene}.svg)\n\n", machine.name);
        for (a, b) in [("none", "grid"), ("none", "bvh"), ("grid", "irregular"), ("grid", "bvh"), ("irregular", "bvh")]
        {
            text += &crossing(&ways, a, b, &scene);
        }
        text.push('\n');
    }
    text
}

/// Where the fused `b` overtakes the fused `a`, with and without the time to build it.
fn crossing(ways: &[(String, Vec<&Row>)], a: &str, b: &str, scene: &str) -> String {
    let find = |name: &str| ways.iter().find(|(way, _)| *way == format!("{name}, fused")).map(|(_, rows)| rows);
    let Some((first, second)) = find(a).zip(find(b)) else { return String::new() };
    let at = |y: fn(&Row) -> Option<f64>| {
        // Compare only as far as both were measured.
        let both = |a: &&Row| {
            let b = second.iter().find(|b| b.triangles == a.triangles)?;
            Some([a.triangles as f64, y(a)?, y(b)?])
        };
        let points: Vec<[f64; 3]> = first.iter().filter_map(both).collect();
        let ends_below = points.last().map(|[_, a, b]| b < a);
        match (crossover(&points), ends_below) {
            (Some(triangles), _) => format!("from {} triangles on", count(triangles)),
            (None, Some(true)) => "at every count measured".into(),
            _ => "at none measured".into(),
        }
    };
    let name = |name| match name {
        "none" => "no structure",
        "bvh" => "the BVH",
        "irregular" => "the irregular grid",
        _ => "the grid",
    };
    format!(
        "- {scene}: fused, {} is faster than {} {}; for a single image including building, {}.\n",
        name(b),
        name(a),
        at(|r| r.median_device_ns),
        at(with_build)
    )
}

pub(super) fn resolution(machine: &Measured) -> String {
    let mut rows = Vec::new();
    for scene in scenes(machine, "resolution") {
        for (way, of_way) in ways(machine, "resolution", &scene) {
            let points = curve(&of_way, |r| r.rays as f64, |r| r.median_device_ns);
            let (Some(first), Some(last)) = (points.first(), points.last()) else { continue };
            // Times that are not on a line have no rate.
            let line = Line::through(&points);
            let interval = line.and_then(|line| line.slope_interval);
            rows.push(vec![
                scene.clone(),
                way,
                format!("{} to {}", count(first.0), count(last.0)),
                or_dash(line.map(|line| line.intercept), time),
                or_dash(line.map(|line| line.slope), number),
                interval.map_or("–".into(), |[low, high]| format!("{} – {}", number(low), number(high))),
                or_dash(line.map(|line| 1e3 / line.slope), number),
                or_dash(line.map(|line| line.worst), percent),
            ]);
        }
    }
    if rows.is_empty() {
        return String::new();
    }
    let names = [
        "scene",
        "configuration",
        "rays",
        "intercept",
        "ns per ray",
        "95% interval",
        "Mray/s without the intercept",
        "farthest from the line",
    ];
    let mut text = table(&columns(&names), &rows);
    for scene in scenes(machine, "resolution") {
        text += &format!("![Time against rays, {scene}](performance/{}/resolution-{scene}.svg)\n", machine.name);
    }
    text
}

pub(super) fn steps(machine: &Measured) -> String {
    let rows: Vec<&Row> = machine.timed("steps").collect();
    let groups = distinct(rows.iter().map(|r| (r.scene.clone(), r.accelerator.clone())));
    let steps = distinct(rows.iter().filter(|r| r.schedule == "compact").map(|r| r.steps_per_pass));
    if groups.is_empty() {
        return String::new();
    }
    let find = |(scene, accelerator): &(String, String), schedule: &str, steps: u32| {
        let is_wanted = |r: &&&Row| {
            (&r.scene, &r.accelerator, r.schedule.as_str(), r.steps_per_pass) == (scene, accelerator, schedule, steps)
        };
        rows.iter().find(is_wanted).copied()
    };
    let mut names = vec!["steps per pass".to_owned()];
    names.extend(groups.iter().map(|(scene, accelerator)| format!("{scene}, {accelerator}")));
    let cell = |group: &(String, String), row: Option<&Row>| {
        let fused = find(group, "fused", 1).and_then(|r| r.median_device_ns);
        let text = row.zip(fused).and_then(|(r, fused)| {
            let ns = r.median_device_ns?;
            Some(format!("{}, {} passes, {} × fused", time(ns), r.passes?, number(ns / fused)))
        });
        text.unwrap_or("–".into())
    };
    let mut lines: Vec<Vec<String>> = steps
        .iter()
        .map(|&steps| {
            let cells = groups.iter().map(|group| cell(group, find(group, "compact", steps)));
            std::iter::once(steps.to_string()).chain(cells).collect()
        })
        .collect();
    let fused = groups.iter().map(|g| or_dash(find(g, "fused", 1).and_then(|r| r.median_device_ns), time));
    lines.push(std::iter::once("fused".to_owned()).chain(fused).collect());
    let size = rows.first().map(|r| format!("{}×{} pixels.\n\n", r.width_px, r.height_px)).unwrap_or_default();
    format!("{size}{}![Time against steps per pass](performance/{}/steps.svg)\n", table(&names, &lines), machine.name)
}

/// Colour by accelerator, dashes by schedule.
fn series(name: String, points: Vec<(f64, f64)>) -> Series {
    let color = ["bvh", "grid", "none", "irregular"].iter().position(|a| name.starts_with(a)).unwrap_or(4);
    Series { is_dashed: name.contains("compact"), name, points, color }
}

pub(super) fn plots(machine: &Measured, folder: &Path) -> Result<(), String> {
    type Count = fn(&Row) -> f64;
    let sections: [(&str, &str, Count); 2] =
        [("triangles", "triangles", |r| r.triangles as f64), ("resolution", "rays", |r| r.rays as f64)];
    for (section, x, count) in sections {
        for scene in scenes(machine, section) {
            let ways = ways(machine, section, &scene).into_iter();
            let lines = ways.map(|(name, rows)| series(name, curve(&rows, count, |r| r.median_device_ns)));
            let axes = Axes { title: format!("{scene}, {}", machine.title()), x, y: "time", y_text: time };
            plot::write(&folder.join(format!("{section}-{scene}.svg")), &axes, &lines.collect::<Vec<_>>())?;
        }
    }
    let mut lines = Vec::new();
    for (i, scene) in scenes(machine, "steps").into_iter().enumerate() {
        for accelerator in ["grid", "bvh"] {
            let rows: Vec<&Row> =
                machine.timed("steps").filter(|r| r.scene == scene && r.accelerator == accelerator).collect();
            let compact: Vec<&Row> = rows.iter().copied().filter(|r| r.schedule == "compact").collect();
            let points = curve(&compact, |r| f64::from(r.steps_per_pass), |r| r.median_device_ns);
            let color = 3 * i + usize::from(accelerator == "grid");
            if let Some(fused) = rows.iter().find(|r| r.schedule == "fused").and_then(|r| r.median_device_ns) {
                let ends = points.first().zip(points.last()).map(|(a, b)| vec![(a.0, fused), (b.0, fused)]);
                let name = format!("{scene}, {accelerator}: fused");
                lines.push(Series { name, points: ends.unwrap_or_default(), color, is_dashed: true });
            }
            let name = format!("{scene}, {accelerator}");
            lines.push(Series { name, points, color, is_dashed: false });
        }
    }
    let axes = Axes { title: format!("Compact, {}", machine.title()), x: "steps per pass", y: "time", y_text: time };
    plot::write(&folder.join("steps.svg"), &axes, &lines)
}
