//! The answer in words, and in a table of a few rows.

use super::super::page::{Part, number};
use super::super::words::{Compared, compared};
use super::super::work::Work;
use crate::html::escaped;
use crate::human::{cell, data, field};
use crate::tidy::Row;

/// A choice in words.
fn name(row: &Row) -> String {
    if !row.get("method").is_empty() {
        return escaped(row.get("method"));
    }
    format!("{}, {}, {}", row.get("accelerator"), row.get("schedule"), row.get("numerics"))
}

/// Where it was measured, in words.
fn place(work: &Work<'_>) -> String {
    match work.machine().gpu() {
        Some(_) => work.machine().name(),
        None => {
            let cores = std::thread::available_parallelism().map_or(1, usize::from);
            format!("CPU, {}", crate::text::counted(cores, "core"))
        }
    }
}

/// "0 of 36,864 rays wrong (at most 81 per million)".
fn wrong(row: &Row) -> String {
    let (count, of) = (number("wrong_rays", row), number("judged_rays", row));
    let high = cell("wrong_per_million_high", row.get("wrong_per_million_high"));
    format!("{count} of {of} rays wrong (at most {high} per million)")
}

fn listed(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [all @ .., last] => format!("{} and {last}", all.join("; ")),
    }
}

/// Adds the sentence on the fastest choice, what is as fast, and what is faster but wrong.
pub(super) fn say(work: &Work<'_>, rows: &[Row], part: &mut Part) {
    let scene = escaped(&work.subject.scene.name);
    let limit = rows.first().map_or(String::new(), |row| number("most_wrong_per_million", row));
    let Some(fastest) = rows.iter().find(|r| r.get("is_fastest") == "true") else {
        let text = format!(
            "{scene}, {}: no choice could be shown to be within the limit of {limit} wrong rays per million.",
            escaped(&place(work))
        );
        part.lead.push(text);
        return;
    };
    let mut text = format!(
        "<strong>{scene}, {}: {} is fastest: {} a ray, {}.</strong>",
        escaped(&place(work)),
        name(fastest),
        cell("ns_per_ray", fastest.get("ns_per_ray")),
        wrong(fastest),
    );
    let others = || rows.iter().filter(|r| r.get("is_fastest") != "true" && r.get("method").is_empty());
    let is_accurate = |r: &&Row| r.get("is_accurate") == "true";
    let alike: Vec<String> = others()
        .filter(is_accurate)
        .filter(|r| matches!(compared("time_ratio", r), Compared::NotDistinguishable | Compared::Unknown))
        .map(name)
        .collect();
    text += &match alike.as_slice() {
        [] => " Nothing else that accurate is as fast.".to_owned(),
        names => format!(" Not distinguishable in time: {}.", listed(names)),
    };
    let inaccurate = |r: &&Row| !is_accurate(r) && compared("time_ratio", r) == Compared::Faster;
    let faster: Vec<&Row> = others().filter(inaccurate).collect();
    if let Some(worst) = faster.iter().max_by_key(|r| r.number("wrong_rays").unwrap_or(0.0) as u64) {
        let names: Vec<String> = faster.iter().map(|r| name(r)).collect();
        let (count, of) = (number("wrong_rays", worst), number("judged_rays", worst));
        text += &format!(
            " Faster, but not within the limit of {limit} wrong per million: {} (up to {count} of {of} wrong).",
            listed(&names)
        );
    }
    text += &match fastest.get("numerics") {
        "paper" => robust(rows),
        _ => papers(rows, fastest),
    };
    part.lead.push(text);
}

/// The fastest robust choice, where the fastest of all is not robust.
fn robust(rows: &[Row]) -> String {
    let Some(row) = quickest(rows, &[("numerics", "robust")]) else { return String::new() };
    let ratio = match compared("time_ratio", row) {
        Compared::NotDistinguishable => "not distinguishable".to_owned(),
        _ => format!("{} times as long", cell("time_ratio", row.get("time_ratio"))),
    };
    format!(
        " The fastest with robust numerics, which is right at edges too: {}, {}: {} a ray ({ratio}), {} wrong.",
        row.get("accelerator"),
        row.get("schedule"),
        cell("ns_per_ray", row.get("ns_per_ray")),
        number("wrong_rays", row)
    )
}

/// The row with the shortest median time among those with these fields.
fn quickest<'a>(rows: &'a [Row], wanted: &[(&str, &str)]) -> Option<&'a Row> {
    let ns = |row: &Row| row.number("median_ns").unwrap_or(f64::INFINITY);
    let of = rows.iter().filter(|row| row.is(wanted) && row.number("median_ns").is_some());
    of.min_by(|a, b| ns(a).total_cmp(&ns(b)))
}

/// What the paper's rules gain and lose with the structure and schedule of the fastest choice.
fn papers(rows: &[Row], fastest: &Row) -> String {
    let same =
        [("accelerator", fastest.get("accelerator")), ("schedule", fastest.get("schedule")), ("numerics", "paper")];
    let Some(paper) = rows.iter().find(|r| r.is(&same)).filter(|_| fastest.get("numerics") == "robust") else {
        return String::new();
    };
    let errors = match paper.get("wrong_rays") {
        "0" => "none wrong either".to_owned(),
        _ => format!("{} of {} wrong", number("wrong_rays", paper), number("judged_rays", paper)),
    };
    let ratio = cell("time_ratio", paper.get("time_ratio"));
    let gain = match compared("time_ratio", paper) {
        Compared::Faster => format!("take {ratio} of the time here"),
        Compared::NotDistinguishable => "are no faster here".to_owned(),
        Compared::Slower => format!("take {ratio} times as long here"),
        Compared::Unknown => "were not timed often enough to compare".to_owned(),
    };
    format!(" The paper's rules {gain}: {errors}.")
}

/// Adds the table of at most six choices: the fastest, the fastest of every structure, the default, and the paper's.
pub(super) fn table(rows: &[Row], part: &mut Part) {
    let of = |accelerator| quickest(rows, &[("accelerator", accelerator), ("numerics", "robust")]);
    let wanted = [
        rows.iter().find(|r| r.get("is_fastest") == "true"),
        of("bvh"),
        of("grid"),
        of("none"),
        quickest(rows, &[("accelerator", "grid"), ("schedule", "compact"), ("numerics", "robust")]),
        quickest(rows, &[("numerics", "paper")]),
    ];
    let mut chosen: Vec<&Row> = Vec::new();
    for row in wanted.into_iter().flatten() {
        if !chosen.iter().any(|c| c.get("configuration") == row.get("configuration")) {
            chosen.push(row);
        }
    }
    chosen.sort_by(|a, b| a.number("median_ns").unwrap_or(0.0).total_cmp(&b.number("median_ns").unwrap_or(0.0)));
    let cells = |row: &&Row| {
        let ratio = match (row.get("is_fastest"), compared("time_ratio", row)) {
            ("true", _) => "1".to_owned(),
            // What is wrong too often is not ranked.
            _ if row.get("is_accurate") != "true" => "wrong too often".to_owned(),
            (_, Compared::Unknown) => cell("time_ratio", row.get("time_ratio")),
            _ => format!(
                "{} ({} to {})",
                cell("time_ratio", row.get("time_ratio")),
                cell("time_ratio", row.get("time_ratio_low")),
                cell("time_ratio", row.get("time_ratio_high"))
            ),
        };
        let wrong = row.get("wrong_per_million_high");
        let least = row.number("wrong_per_million_high").map_or(String::new(), |high| {
            data(wrong, &format!("≤ {}", field("wrong_per_million_high", &high.to_string())))
        });
        vec![
            name(row),
            cell("ns_per_ray", row.get("ns_per_ray")),
            ratio,
            format!("{} of {}", cell("wrong_rays", row.get("wrong_rays")), cell("judged_rays", row.get("judged_rays"))),
            least,
            cell("undecided", row.get("undecided")),
            cell("structure_bytes", row.get("structure_bytes")),
            cell("build_s", row.get("build_s")),
        ]
    };
    let names =
        vec!["choice", "time a ray", "to the fastest", "wrong", "per million", "undecided", "structure", "build"];
    part.lead_table = Some((names, chosen.iter().map(cells).collect()));
}
