//! Time against triangles, rays, and steps per pass.

use std::path::Path;

use raystep_lab::human::{digits, time};
use raystep_lab::plots::Series;
use raystep_lab::statistics::Line;
use raystep_lab::tidy::Row;

use super::meshes::size;
use super::{Measured, distinct, line, name, or_dash, over, percent, table};

/// The configurations of a scene with their rows.
fn by_configuration<'a>(machine: &'a Measured, section: &'a str, scene: &str) -> Vec<(String, Vec<&'a Row>)> {
    let rows: Vec<&Row> = machine.of(section).filter(|row| row.get("scene") == scene).collect();
    let of = |of: &String| rows.iter().copied().filter(|row| name(row) == *of).collect();
    distinct(rows.iter().map(|row| name(row))).into_iter().map(|name| (name.clone(), of(&name))).collect()
}

fn curve(rows: &[&Row], x: &str) -> Vec<(f64, f64)> {
    rows.iter().filter_map(|row| Some((row.number(x)?, row.number("median_ns")?))).collect()
}

/// Colour by accelerator, dashes by schedule.
fn series((name, rows): &(String, Vec<&Row>), x: &str) -> Series {
    const COLORS: [(&str, usize); 4] = [("bvh", 0), ("grid", 1), ("none", 6), ("irregular", 2)];
    let color = COLORS.iter().find(|(accelerator, _)| name.starts_with(accelerator)).map_or(3, |(_, color)| *color);
    line(name.clone(), color, name.contains("compact"), curve(rows, x))
}

/// Time over a count in a scene.
fn plot(machine: &Measured, folder: &Path, section: &str, scene: &str, x: &str) -> Result<String, String> {
    let series = by_configuration(machine, section, scene).iter().map(|one| series(one, x)).collect();
    let plot = over(format!("{scene}, {}", machine.title()), x, series);
    machine.plot(folder, &format!("{section}-{scene}"), &format!("Time against {x}, {scene}"), plot)
}

pub(super) fn triangles(machine: &Measured, folder: &Path) -> Result<String, String> {
    let mut text = String::new();
    for scene in machine.fields("triangles", "scene") {
        let all = by_configuration(machine, "triangles", scene);
        let counts = distinct(all.iter().flat_map(|(_, rows)| rows).map(|row| row.get("triangles")));
        let built = [
            ("grid, fused", "grid built in"),
            ("irregular, fused", "irregular grid built in"),
            ("bvh, fused", "BVH built in (wide)"),
            ("bvh, compact K=8", "BVH built in (binary)"),
        ];
        let mut names = vec!["triangles"];
        names.extend(all.iter().map(|(name, _)| name.as_str()));
        names.extend(built.map(|(_, heading)| heading));
        let lines = counts.iter().map(|count| {
            let at = |rows: &[&Row], column| {
                rows.iter().find(|row| row.get("triangles") == *count).and_then(|row| row.number(column))
            };
            let times = all.iter().map(|(_, rows)| or_dash(at(rows, "median_ns"), time));
            let build = |of: &str| all.iter().find(|(name, _)| name == of).and_then(|(_, rows)| at(rows, "build_s"));
            let builds = built.iter().map(|(of, _)| or_dash(build(of).map(|s| s * 1e9), time));
            std::iter::once(or_dash(count.parse().ok(), digits)).chain(times).chain(builds).collect()
        });
        text += &table(&names, &lines.collect::<Vec<_>>());
        text += &plot(machine, folder, "triangles", scene, "triangles")?;
        text.push('\n');
        for (a, b) in [("none", "grid"), ("none", "bvh"), ("grid", "irregular"), ("grid", "bvh"), ("irregular", "bvh")]
        {
            text += &crossing(&all, a, b, scene);
        }
        text.push('\n');
    }
    Ok(text)
}

/// Where the fused `b` overtakes the fused `a`, with and without the time to build it.
fn crossing(all: &[(String, Vec<&Row>)], a: &str, b: &str, scene: &str) -> String {
    let find = |of: &str| all.iter().find(|(name, _)| *name == format!("{of}, fused")).map(|(_, rows)| rows);
    let Some((first, second)) = find(a).zip(find(b)) else { return String::new() };
    let at = |with_build: f64| {
        let ns = |row: &Row| Some(row.number("median_ns")? + with_build * row.number("build_s").unwrap_or(0.0) * 1e9);
        // Compare only as far as both were measured.
        let both = |a: &&Row| {
            let b = second.iter().find(|b| b.get("triangles") == a.get("triangles"))?;
            Some([a.number("triangles")?, ns(a)?, ns(b)?])
        };
        let points: Vec<[f64; 3]> = first.iter().filter_map(both).collect();
        let ends_below = points.last().map(|[_, a, b]| b < a);
        match (crossover(&points), ends_below) {
            (Some(triangles), _) => format!("from {} triangles on", digits(triangles)),
            (None, Some(true)) => "at every count measured".into(),
            _ => "at none measured".into(),
        }
    };
    let words = |accelerator| match accelerator {
        "none" => "no structure",
        "bvh" => "the BVH",
        "irregular" => "the irregular grid",
        _ => "the grid",
    };
    let (a, b) = (words(a), words(b));
    let (traced, built) = (at(0.0), at(1.0));
    format!("- {scene}: fused, {b} is faster than {a} {traced}; for a single image including building, {built}.\n")
}

/// The x from which `b` stays below `a`, by linear interpolation on logarithmic axes between points `[x, a, b]`,
/// x ascending. `None` if `b` is not below at the end, or was never above.
fn crossover(points: &[[f64; 3]]) -> Option<f64> {
    let last = points.iter().rposition(|[_, a, b]| b >= a)?;
    let [p, q] = [*points.get(last)?, *points.get(last + 1)?].map(|point| point.map(f64::ln));
    let (before, after) = (p[2] - p[1], q[2] - q[1]);
    Some((p[0] + (q[0] - p[0]) * before / (before - after)).exp())
}

pub(super) fn resolution(machine: &Measured, folder: &Path) -> Result<String, String> {
    let (mut lines, mut plots) = (Vec::new(), String::new());
    for scene in machine.fields("resolution", "scene") {
        plots += &plot(machine, folder, "resolution", scene, "rays")?;
        for (name, rows) in by_configuration(machine, "resolution", scene) {
            let points = curve(&rows, "rays");
            let (Some(first), Some(last)) = (points.first(), points.last()) else { continue };
            // Times that are not on a line have no rate.
            let line = Line::through(&points);
            let interval = line.and_then(|line| line.slope_interval);
            lines.push(vec![
                scene.to_owned(),
                name,
                format!("{} to {}", digits(first.0), digits(last.0)),
                or_dash(line.map(|line| line.intercept), time),
                or_dash(line.map(|line| line.slope), digits),
                interval.map_or("–".into(), |[low, high]| format!("{} – {}", digits(low), digits(high))),
                or_dash(line.map(|line| 1e3 / line.slope), digits),
                or_dash(line.map(|line| line.worst), percent),
            ]);
        }
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
    Ok(table(&names, &lines) + &plots)
}

pub(super) fn steps(machine: &Measured, folder: &Path) -> Result<String, String> {
    let rows: Vec<&Row> = machine.of("steps").collect();
    let Some(first) = rows.first() else { return Ok(String::new()) };
    let groups = distinct(rows.iter().map(|row| [row.get("scene"), row.get("accelerator")]));
    let of = |[scene, accelerator]: [&str; 2]| {
        let key = [("scene", scene), ("accelerator", accelerator)].map(|(column, field)| (column, field.to_owned()));
        rows.iter().copied().filter(move |row| key.iter().all(|(column, field)| row.get(column) == field))
    };
    let fused = |group| of(group).find(|row| row.get("schedule") == "fused").and_then(|row| row.number("median_ns"));
    let cell = |group, steps: &str| {
        let row = of(group).find(|row| row.get("steps_per_pass") == steps)?;
        let (ns, passes) = (row.number("median_ns")?, row.get("passes"));
        Some(format!("{}, {passes} passes, {} × fused", time(ns), digits(ns / fused(group)?)))
    };
    let steps = distinct(rows.iter().map(|row| row.get("steps_per_pass")).filter(|steps| !steps.is_empty()));
    let mut lines: Vec<Vec<String>> = steps
        .iter()
        .map(|&steps| {
            let cells = groups.iter().map(|&group| cell(group, steps).unwrap_or("–".into()));
            std::iter::once(steps.to_owned()).chain(cells).collect()
        })
        .collect();
    let of_fused = groups.iter().map(|&group| or_dash(fused(group), time));
    lines.push(std::iter::once("fused".to_owned()).chain(of_fused).collect());
    let names = groups.iter().map(|group| group.join(", "));
    let names: Vec<String> = std::iter::once("steps per pass".to_owned()).chain(names).collect();

    let mut series = Vec::new();
    for (i, &group) in groups.iter().enumerate() {
        // Vermilion and blue, purple and green.
        let (color, name) = ([1, 0, 3, 2][i % 4], group.join(", "));
        let compact: Vec<&Row> = of(group).filter(|row| row.get("schedule") == "compact").collect();
        let points = curve(&compact, "steps_per_pass");
        if let (Some(ns), [first, .., last]) = (fused(group), &points[..]) {
            series.push(line(format!("{name}: fused"), color, true, vec![(first.0, ns), (last.0, ns)]));
        }
        series.push(line(name, color, false, points));
    }
    let plot = over(format!("Compact, {}", machine.title()), "steps per pass", series);
    let plot = machine.plot(folder, "steps", "Time against steps per pass", plot)?;
    Ok(format!("{} pixels.\n\n{}{plot}", size(first), table(&names, &lines)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_cross_where_logarithms_say() {
        // a = x, b = 100 / x cross at 10, and log-log interpolation is exact for powers.
        let x = [1.0, 4.0, 40.0, 1000.0];
        let at = crossover(&x.map(|x| [x, x, 100.0 / x])).expect("they cross");
        assert!((at - 10.0).abs() < 1e-9, "{at}");
        assert_eq!(crossover(&x.map(|x| [x, 100.0 / x, x])), None, "a ends above");
        // If b is below from the start, nothing crosses; of several crossings, the last one counts.
        assert_eq!(crossover(&x.map(|x| [x, x, x / 2.0])), None);
        let wavy = [[1.0, 1.0, 0.5], [4.0, 4.0, 8.0], [40.0, 40.0, 20.0], [1000.0, 1000.0, 10.0]];
        let at = crossover(&wavy).expect("they cross");
        assert!(at > 4.0 && at < 40.0, "{at}");
        // b ends above a, so it has not crossed for good.
        assert!(crossover(&wavy[..2]).is_none() && crossover(&[]).is_none());
    }
}
