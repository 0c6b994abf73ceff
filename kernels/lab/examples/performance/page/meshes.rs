//! Rays per second by kind of ray, what rays do, the fastest configurations, and the machines.

use raystep_lab::human::{digits, thousands, time};
use raystep_lab::tidy::Row;

use super::{Measured, distinct, mray_per_s, name, or_dash, percent, ratio, table};

/// The fastest configurations for each scene and kind of ray.
pub(super) fn answer(machine: &Measured) -> String {
    let rows: Vec<&Row> = machine.of("meshes").collect();
    let key = |row: &Row| ["scene", "triangles", "rays_kind"].map(|column| row.get(column).to_owned());
    let mut lines = Vec::new();
    for group in distinct(rows.iter().map(|row| key(row))) {
        let cell = |is_wanted: &dyn Fn(&Row) -> bool| {
            let of_group = rows.iter().filter(|row| key(row) == group && is_wanted(row));
            let rates = of_group.filter_map(|row| Some((name(row), mray_per_s(row)?)));
            let best = rates.max_by(|a, b| a.1.total_cmp(&b.1));
            best.map_or("–".into(), |(name, rate)| format!("{name}: {}", digits(rate)))
        };
        let is_stepped = |row: &Row| row.get("schedule") != "fused";
        let [scene, triangles, kind] = &group;
        lines.push(vec![
            format!("{scene}, {} triangles", triangles.parse().map_or_else(|_| triangles.clone(), thousands)),
            kind.clone(),
            cell(&|_| true),
            cell(&|row| row.get("accelerator") == "irregular"),
            cell(&|row| row.get("accelerator") == "grid"),
            cell(&is_stepped),
            cell(&|row| is_stepped(row) && matches!(row.get("steps_per_pass"), "" | "1")),
        ]);
    }
    let Some(first) = rows.first() else { return String::new() };
    let names = [
        "scene",
        "rays",
        "fastest",
        "with the irregular grid",
        "with the uniform grid",
        "fastest in steps",
        "fastest, one step per pass",
    ];
    format!("Million rays per second, {} pixels.\n\n{}", size(first), table(&names, &lines))
}

/// The size of a row's image.
pub(super) fn size(row: &Row) -> String {
    format!("{}×{}", row.get("width_px"), row.get("height_px"))
}

pub(super) fn tables(machine: &Measured) -> String {
    let mut text = String::new();
    for scene in machine.fields("meshes", "scene") {
        let rows: Vec<&Row> = machine.of("meshes").filter(|row| row.get("scene") == scene).collect();
        let Some(first) = rows.first() else { continue };
        let kinds = distinct(rows.iter().map(|row| row.get("rays_kind")));
        let line = |of: String| {
            let rate = |kind| rows.iter().find(|row| name(row) == of && row.get("rays_kind") == kind);
            let cells = kinds.iter().map(|&kind| or_dash(rate(kind).and_then(|row| mray_per_s(row)), digits));
            std::iter::once(of.clone()).chain(cells).collect()
        };
        let lines: Vec<Vec<String>> = distinct(rows.iter().map(|row| name(row))).into_iter().map(line).collect();
        text += &format!(
            "{scene}, {} triangles, {} pixels, million rays per second:\n\n{}",
            or_dash(first.number("triangles"), thousands),
            size(first),
            table(&[&["configuration"], &kinds[..]].concat(), &lines)
        );
    }
    text
}

/// What rays do in each scene. It is the same on every machine except for the number of rays counted, so the first
/// machine that has the scene is used.
pub(super) fn work(machines: &[Measured]) -> String {
    let mut text = String::new();
    for scene in distinct(machines.iter().flat_map(|machine| machine.fields("meshes", "scene"))) {
        let is_of = |row: &&Row| row.get("scene") == scene;
        let Some(machine) = machines.iter().find(|machine| machine.of("meshes").any(|row| is_of(&row))) else {
            continue;
        };
        // The number of steps per pass does not change what a ray does.
        let is_wanted = |row: &&Row| {
            let is_single = row.get("steps_per_pass") == "1" && row.get("accelerator") != "irregular";
            is_of(row) && (row.get("schedule") == "fused" || is_single)
        };
        let rows: Vec<&Row> = machine.of("meshes").filter(is_wanted).collect();
        let kinds = distinct(rows.iter().map(|row| row.get("rays_kind")));
        let cell = |row: &Row| {
            let [cells, tests] = ["cells_per_ray", "tests_per_ray"].map(|column| row.number(column));
            let share = ratio(row, "repeated_per_ray", "tests_per_ray").filter(|_| row.get("accelerator") == "grid");
            let share = share.map_or(String::new(), |share| format!(" ({} repeated)", percent(share)));
            Some(format!("{} + {}{share}", digits(cells?), digits(tests?)))
        };
        let line = |of: String| {
            let rows: Vec<&&Row> = rows.iter().filter(|row| name(row) == of).collect();
            let of_kind = |kind: &&str| rows.iter().find(|row| row.get("rays_kind") == *kind).and_then(|row| cell(row));
            let cells = kinds.iter().map(|kind| of_kind(kind).unwrap_or("–".into()));
            let bytes = rows.first().and_then(|row| ratio(row, "structure_bytes", "triangles"));
            [vec![of.clone()], cells.collect(), vec![or_dash(bytes, digits)]].concat()
        };
        let lines: Vec<Vec<String>> = distinct(rows.iter().map(|row| name(row))).into_iter().map(line).collect();
        text += &table(&[&[scene], &kinds[..], &["bytes per triangle"]].concat(), &lines);
    }
    text
}

/// Describes the machine, how often it ran, and the spread of its times.
pub(super) fn machine(machine: &Measured) -> String {
    let about = &machine.about;
    let word = |value: &serde_json::Value| value.as_str().unwrap_or_default().to_owned();
    let runs = machine.rows.iter().filter_map(|row| row.get("runs").parse().ok());
    // One without a valid time is not measured.
    let runs: Vec<u64> = runs.filter(|&runs| runs > 0).collect();
    let invalid: u64 = machine.rows.iter().filter_map(|row| row.get("invalid_runs").parse::<u64>().ok()).sum();
    let clock = match about["timestamp_period_ns"].as_f64() {
        Some(period) => format!("timestamps of {} each", time(period)),
        None => "timed by the processor's clock".into(),
    };
    let mut text = format!("**{}**: ", machine.title());
    if !machine.is_cpu() {
        let [name, backend, driver] = ["name", "backend", "driver"].map(|key| word(&about["adapter"][key]));
        text += &format!("{name} ({backend}, {driver}), ");
    }
    let [processor, version, arguments] = ["processor", "raystep_version", "arguments"].map(|key| word(&about[key]));
    let seconds = about["seconds"].as_object().into_iter().flatten().filter_map(|(_, seconds)| seconds.as_f64());
    text += &format!(
        "{processor}, {} cores; {clock}; raystep {version}.\n`performance measure {arguments}`, {} s: {} measurements with {} \
         to {} runs each, {} notes in `machine.json`, {invalid} invalid times not counted.",
        about["cores"],
        digits(seconds.sum::<f64>().round()),
        runs.len(),
        runs.iter().min().unwrap_or(&0),
        runs.iter().max().unwrap_or(&0),
        about["notes"].as_array().map_or(0, Vec::len),
    );
    let width = |row: &Row| Some((row.number("high_ns")? - row.number("low_ns")?) / row.number("median_ns")?);
    let widths: Vec<f64> = machine.rows.iter().filter_map(width).collect();
    let [half, most] = [0.5, 0.95].map(|share| raystep_lab::statistics::quantile(&widths, share));
    if let (Some(half), Some(most)) = (half, most) {
        text += &format!(
            " The 95% interval of the median is {} of it wide in half of the configurations with at least 6 runs, and below \
             {} in 19 of 20.",
            percent(half),
            percent(most)
        );
    }
    text += &agreement(machine);
    if about["quick"] == true {
        text += " **A quick run with three repeats on small images, to try the page out.**";
    }
    text
}

/// Whether configurations that must find the same hits did so.
fn agreement(machine: &Measured) -> String {
    let is_traced = |row: &&Row| {
        let is_probe = ["bytes", "tdelta"].contains(&row.get("section"));
        !is_probe && row.get("numerics") == "robust" && !row.get("hits").is_empty()
    };
    let key = |row: &Row| {
        ["section", "scene", "triangles", "rays_kind", "width_px", "height_px"].map(|column| row.get(column).to_owned())
    };
    let rows: Vec<&Row> = machine.rows.iter().filter(is_traced).collect();
    let groups = distinct(rows.iter().map(|row| key(row)));
    let hits = |group: &[String; 6]| distinct(rows.iter().filter(|row| key(row) == *group).map(|row| row.get("hits")));
    match groups.iter().filter(|group| hits(group).len() > 1).count() {
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
