//! What the plan omits because the scene does not need it, and what putting back each item costs.

mod measure;

use std::cmp::Ordering;
use std::time::Duration;

use raystep_kernels::{Accelerator, Options, ScheduleKind};

pub use measure::{Cost, Costs, Measured, Ratio, Sizes};

use super::page::{Part, number};
use super::record::Record;
use super::words::compared;
use super::work::Work;
use crate::Error;
use crate::html::data;
use crate::human;
use crate::meter::Meter;
use crate::plots::{Axis, Forest, Mark, Scale, Series, Stroke};
use crate::reporter::Reporter;
use crate::statistics::Compared;
use crate::subject::Subject;
use crate::tidy::{KEYS, Row, count, joined};

const GROUPS: &[&[&str]] = &[
    KEYS,
    columns![
        accelerator schedule item because reason is_changed rays stream_bytes stream_bytes_with buffer_bytes
        buffer_bytes_with added_bytes first_start_s first_start_s_with start_s start_s_with start_ratio
        start_ratio_low start_ratio_high runs ratio_to time_ratio time_ratio_low time_ratio_high
        interval_method interval_level differing_hits clock
    ],
];
pub(super) const COLUMNS: &[&str] = &joined::<{ count(GROUPS) }>(GROUPS);

/// Why there are no times on the CPU.
pub const NO_TIMES: &str = "omitting saves memory only: kernels are compiled in advance, so no times are measured";

/// Structures and schedules, the most telling first: a quick report has the first two.
const COMPARED: [(Accelerator, ScheduleKind); 4] = [
    (Accelerator::Bvh, ScheduleKind::Fused),
    (Accelerator::Grid, ScheduleKind::Compact),
    (Accelerator::Grid, ScheduleKind::Fused),
    (Accelerator::Bvh, ScheduleKind::Compact),
];

/// The time for each of them, in a quick report and in a full one.
const EACH_TAKES: [Duration; 2] = [Duration::from_millis(2_500), Duration::from_secs(6)];
/// The seconds for `raystep plan` unless other ones are requested.
pub const ALONE_SECONDS: u32 = 25;

/// What putting back each item costs that this run's plan omits because the scene does not need it, in about this time.
///
/// # Errors
/// If the scene cannot be planned or run with these options, or a run takes too long.
pub fn costs(
    subject: &Subject,
    options: &Options,
    meter: &Meter,
    time: Duration,
    seed: u32,
    reporter: &dyn Reporter,
) -> Result<Costs, Error> {
    let record = Record::new(String::new(), seed, false);
    let work = Work { grid: options.grid, ..Work::alone(subject, meter, "left-out", &record, reporter) };
    measure::costs(&work, options, time)
}

pub(super) fn run(work: &Work<'_>, table: &mut crate::tidy::Table) -> Result<Part, Error> {
    let mut part = Part::default();
    let first = table.rows.len();
    let has_times = work.machine().gpu().is_some();
    if !has_times {
        part.prose.push(format!("On the CPU, {NO_TIMES}."));
    }
    let is_wanted = |one: &&(Accelerator, ScheduleKind)| work.only.has(one.0) && work.only.has_schedule(one.1);
    let mut left_out = Vec::new();
    for &(accelerator, schedule) in COMPARED[..work.either(2, COMPARED.len())].iter().filter(is_wanted) {
        if work.is_past(1.0) {
            left_out.push(format!("{accelerator} {schedule}"));
            continue;
        }
        work.stage(&format!("omitted items, {accelerator} {schedule}"));
        let options = Options { accelerator, schedule, ..Options::new(work.camera_rays()) };
        let time = work.at_most(work.either(EACH_TAKES[0], EACH_TAKES[1]));
        let (name, found) = (format!("{accelerator}, {schedule}"), measure::costs(work, &options, time));
        let Some(found) = work.noted(&mut part, &name, found)? else { continue };
        let rows: Vec<Row> = found.costs.iter().map(|cost| row(work, &options, cost)).collect();
        if part.prose.len() <= usize::from(!has_times) {
            part.prose.extend(reasons(&rows));
        }
        part.prose.extend(in_words(&rows));
        part.notes.extend(notes(work, &found).map(|note| format!("{name}: {note}")));
        table.rows.extend(rows);
    }
    part.notes.extend(work.left_out(&left_out));
    let rows = &table.rows[first..];
    if rows.is_empty() {
        part.prose.push("The scene needs everything that a plan can omit.".into());
    }
    part.figure(
        "time",
        plot(rows),
        format!(
            "Time with an item that the scene does not need, relative to the plan as it is. Bars are intervals of the \
             median ratio of runs of the same round, in random order; they are not corrected for their number. Times \
             are {}.",
            work.clock_in_words()
        ),
    );
    part.table(rows);
    if has_times && !rows.is_empty() {
        part.prose.push(
            "A start allocates, uploads and compiles, excluding planning. The first start has its own column, as the \
             driver caches kernels for later ones; it may already have compiled them for an earlier section or report."
                .into(),
        );
    }
    Ok(part)
}

/// What there was no time for, and hits that differ.
fn notes(work: &Work<'_>, found: &Costs) -> impl Iterator<Item = String> {
    let is_timed = work.machine().gpu().is_some();
    let unmeasured = found.costs.iter().filter(|cost| is_timed && cost.is_changed && cost.times.is_none());
    let names = unmeasured.map(Cost::name).chain(found.unplanned.iter().map(|item| item.name()));
    let names: Vec<&str> = names.collect();
    let unmeasured = (!names.is_empty()).then(|| format!("there was no time to measure {}", names.join(", ")));
    let differing = found.costs.iter().filter_map(|cost| {
        let rays = &cost.times.as_ref()?.differing;
        let first: Vec<String> = rays.iter().take(16).map(usize::to_string).collect();
        (!rays.is_empty()).then(|| {
            format!("with {}, {} hits differ in their bits: of rays {}, …", cost.name(), rays.len(), first.join(" "))
        })
    });
    unmeasured.into_iter().chain(differing.collect::<Vec<_>>())
}

fn row(work: &Work<'_>, options: &Options, cost: &Cost) -> Row {
    let names = [options.accelerator.name(), options.schedule.name(), cost.name()];
    let [without, with] = cost.bytes;
    let row = work
        .row(COLUMNS)
        .set("configuration", work.configuration(&names))
        .set("accelerator", names[0])
        .set("schedule", names[1])
        .set("item", cost.name())
        .set("because", cost.because.name())
        .set("reason", &*cost.reason)
        .set("is_changed", cost.is_changed)
        .set("rays", cost.rays)
        .set("stream_bytes", without.streams)
        .set("stream_bytes_with", with.streams)
        .set("buffer_bytes", without.buffers)
        .set("buffer_bytes_with", with.buffers)
        .set("added_bytes", with.total() as i64 - without.total() as i64);
    let Some(times) = &cost.times else { return row };
    row.set("first_start_s", times.first_start_s[0])
        .set("first_start_s_with", times.first_start_s[1])
        .set("start_s", times.start_s[0])
        .set("start_s_with", times.start_s[1])
        .median("start_ratio", times.start_ratio)
        .set("runs", times.runs)
        .set("ratio_to", &*times.without)
        .median("time_ratio", times.time_ratio)
        .method(times.time_ratio.and_then(|(_, interval)| interval))
        .set("differing_hits", times.differing.len())
        .set("clock", work.clock())
}

/// The items with their reasons, as HTML; `None` without items.
fn reasons(rows: &[Row]) -> Option<String> {
    let items = rows.iter().filter(|row| row.get("item") != "all" && row.get("is_changed") == "true");
    let items: Vec<String> = items.map(|row| format!("{} ({})", row.get("item"), row.get("reason"))).collect();
    (!items.is_empty()).then(|| format!("Not needed: {}.", items.join(", ")))
}

/// The rows of a structure and schedule in a paragraph, as HTML; `None` without rows.
fn in_words(rows: &[Row]) -> Option<String> {
    let (all, items) = rows.split_first()?;
    let name = format!("{}, {}", all.get("accelerator"), all.get("schedule"));
    let place = |row: &Row| compared("time_ratio", row);
    let ratio = |row: &Row| {
        let [median, low, high] = ["time_ratio", "time_ratio_low", "time_ratio_high"].map(|c| number(c, row));
        format!("{median} times as long ({low} to {high})")
    };
    let named = |is_wanted: &dyn Fn(&Row) -> bool, with_ratio: bool| -> Option<String> {
        let names = items.iter().filter(|row| is_wanted(row)).map(|row| match with_ratio {
            true => format!("{} {}", row.get("item"), ratio(row)),
            false => row.get("item").to_owned(),
        });
        Some(names.collect::<Vec<_>>().join(", ")).filter(|text| !text.is_empty())
    };
    let mut text = format!("<b>{name}</b>. ");
    text += &match place(all) {
        Compared::Unknown => format!("Everything put back: {}. ", added(all)),
        known => format!("With everything put back, a run takes {}: {}. ", ratio(all), known.words()),
    };
    let is_changed = |row: &Row| row.get("is_changed") == "true";
    let is = |row: &Row, order: Ordering| {
        is_changed(row) && row.number("added_bytes").is_some_and(|more| more.total_cmp(&0.0) == order)
    };
    let mut add = |before: &str, names: Option<String>| {
        text.extend(names.map(|names| format!("{before}: {names}. ")));
    };
    add("Slower with", named(&|row| place(row) == Compared::Slower, true));
    add("Faster with", named(&|row| place(row) == Compared::Faster, true));
    add("As fast", named(&|row| place(row) == Compared::AsFast, false));
    add("Not distinguishable", named(&|row| place(row) == Compared::NotDistinguishable, false));
    if place(all) == Compared::Unknown {
        add("More memory with", named(&|row| is(row, Ordering::Greater), false));
        add("Same memory with", named(&|row| is(row, Ordering::Equal), false));
        add("Less memory with", named(&|row| is(row, Ordering::Less), false));
    }
    add("Has no effect in this run", named(&|row| !is_changed(row), false));
    Some(text.trim_end().to_owned())
}

/// The memory that a row's item adds: "+2.05 kB".
fn added(row: &Row) -> String {
    let more = row.number("added_bytes").unwrap_or(0.0);
    let sign = if more < 0.0 { "−" } else { "+" };
    format!("<b>{}</b>", data(row.get("added_bytes"), &format!("{sign}{}", human::bytes(more.abs()))))
}

/// The ratio of times of each item that was measured.
fn plot(rows: &[Row]) -> Forest {
    let mut names: Vec<String> = Vec::new();
    for row in rows.iter().filter(|row| row.number("time_ratio").is_some()) {
        if !names.iter().any(|name| name == row.get("item")) {
            names.push(row.get("item").to_owned());
        }
    }
    let mut series = Vec::new();
    for (accelerator, schedule) in COMPARED {
        let wanted = [("accelerator", accelerator.name()), ("schedule", schedule.name())];
        let mut one = Series {
            name: format!("{accelerator}, {schedule}"),
            points: Vec::new(),
            whiskers: Vec::new(),
            color: usize::from(accelerator == Accelerator::Bvh),
            mark: match (accelerator, schedule) {
                (Accelerator::Bvh, ScheduleKind::Fused) => Mark::Down,
                (_, ScheduleKind::Fused) => Mark::Triangle,
                _ => Mark::Own,
            },
            stroke: Stroke::None,
        };
        for row in rows.iter().filter(|row| row.is(&wanted)) {
            let place = names.iter().position(|name| name == row.get("item"));
            if let (Some(ratio), Some(place)) = (row.number("time_ratio"), place) {
                let end = |column| row.number(column).unwrap_or(f64::NAN);
                one.points.push((ratio, place as f64));
                one.whiskers.push((end("time_ratio_low"), end("time_ratio_high")));
            }
        }
        series.extend((!one.points.is_empty()).then_some(one));
    }
    Forest {
        title: "Time with what the scene does not need".into(),
        x: Axis::new("ratio of times, with to without", Scale::Linear),
        names,
        neutral: 1.0,
        series,
    }
}
