//! The cost of passes: per byte, and per pass.

use raystep_lab::human::{digits, time};
use raystep_lab::statistics::Line;
use raystep_lab::tidy::Row;

use super::meshes::size;
use super::{Measured, distinct, or_dash, percent, ratio, table};

/// The rows of a section whose measurement begins like this.
fn rows<'a>(machine: &'a Measured, section: &'a str, what: &'a str) -> impl Iterator<Item = &'a Row> {
    machine.of(section).filter(move |row| row.get("what").starts_with(what))
}

/// Fits the time of one dispatch against its bytes: fixed cost and nanoseconds per byte.
fn update(machine: &Measured, of: &str) -> Option<Line> {
    let rows = rows(machine, "bytes", "update of textures").filter(|row| size(row) == of);
    let points = rows.filter_map(|row| Some((ratio(row, "bytes", "passes")?, ratio(row, "median_ns", "passes")?)));
    Line::through(&points.collect::<Vec<_>>())
}

/// Fits the time of a submission against its passes: the slope is the cost of an empty pass.
fn empty_pass(machine: &Measured, schedule: &str, of: &str) -> Option<Line> {
    let what = format!("empty pass, {schedule}");
    let rows = rows(machine, "bytes", &what).filter(|row| size(row) == of);
    Line::through(&rows.filter_map(|row| Some((row.number("passes")?, row.number("median_ns")?))).collect::<Vec<_>>())
}

pub(super) fn bytes(machine: &Measured) -> String {
    let mut text = String::new();
    let per_s = |ns_per_byte: f64| format!("{} GB/s", digits(1.0 / ns_per_byte));
    for copy in rows(machine, "bytes", "copy of a buffer") {
        let mib = ratio(copy, "bytes", "passes").map(|bytes| bytes / 2.0 / f64::from(1 << 20));
        text += &format!(
            "A copy from one buffer of {} MiB to another moves {}, counting reads and writes.\n\n",
            or_dash(mib, digits),
            ratio(copy, "median_ns", "bytes").map_or("–".into(), per_s)
        );
    }
    let sizes = distinct(rows(machine, "bytes", "update of textures").map(size));
    let line = |of: &String| {
        let pass = |schedule| or_dash(empty_pass(machine, schedule, of).map(|line| line.slope), time);
        let speed = update(machine, of).map_or("–".into(), |line| per_s(line.slope));
        vec![of.clone(), speed, pass("compact"), pass("second")]
    };
    let names = ["", "update of textures in place", "empty pass, active rays only", "empty pass, all rays"];
    text += &table(&names, &sizes.iter().map(line).collect::<Vec<_>>());
    let run = |row: &Row| {
        let (bytes, passes, ns) = (row.number("bytes")?, row.number("passes")?, row.number("median_ns")?);
        let moving = update(machine, &size(row)).map(|line| bytes * line.slope);
        let passing = empty_pass(machine, "compact", &size(row)).map(|line| passes * line.slope);
        let model = moving.zip(passing).map(|(a, b)| a + b);
        Some(vec![
            format!("{}, {}, {}", row.get("scene"), row.get("accelerator"), size(row)),
            digits(passes),
            digits(bytes / 1e6),
            or_dash(moving, time),
            or_dash(passing, time),
            time(ns),
            or_dash(model.map(|model| ns / model), digits),
        ])
    };
    let names =
        ["run, one step per pass", "passes", "MB", "MB at that speed", "passes, if empty", "time", "time / their sum"];
    text + &table(&names, &rows(machine, "bytes", "run of one step").filter_map(run).collect::<Vec<_>>())
}

pub(super) fn tdelta(machine: &Measured) -> String {
    let rows: Vec<&Row> = machine.of("tdelta").collect();
    let line = |row: &&Row| {
        let first = rows.iter().find(|first| size(first) == size(row)).and_then(|first| first.number("median_ns"));
        let [per_pass, low, high] = ["median_ns", "low_ns", "high_ns"].map(|column| ratio(row, column, "passes"));
        let spread = low.zip(high).map(|(low, high)| format!("{} – {}", time(low), time(high)));
        let pixels = row.number("width_px").zip(row.number("height_px")).map(|(width, height)| width * height);
        let bytes = ratio(row, "bytes", "passes").zip(pixels).map(|(bytes, pixels)| bytes / pixels);
        vec![
            format!("{}, {}", size(row), row.get("what")),
            or_dash(bytes, digits),
            or_dash(per_pass, time),
            spread.unwrap_or("–".into()),
            or_dash(row.number("median_ns").zip(first).map(|(ns, first)| ns / first), digits),
            or_dash(row.number("value"), percent),
        ]
    };
    let names = [
        "",
        "bytes per ray",
        "time per pass",
        "95% interval of the median",
        "/ worked out",
        "rays in a different cell at the end",
    ];
    table(&names, &rows.iter().map(line).collect::<Vec<_>>())
}
