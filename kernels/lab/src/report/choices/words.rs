//! The answer in words: what to use, what cannot be told from it, and what the paper's rules would gain and lose.
//!
//! Every sentence on times follows from the ratio's interval by one rule ([`Compared`]); all ratios are to the
//! recommended choice.

use super::super::page::{Part, number};
use super::super::words::compared;
use super::super::work::Work;
use super::MOST_WRONG;
use crate::html::{cell, escaped};
use crate::statistics::{Compared, EQUIVALENT};
use crate::text::counted;
use crate::tidy::Row;

/// Most choices that a list names.
const MOST_NAMED: usize = 5;

/// A choice in words.
pub(super) fn name(row: &Row) -> String {
    if !row.get("method").is_empty() {
        return escaped(row.get("method"));
    }
    format!("{}, {}, {}", row.get("accelerator"), row.get("schedule"), row.get("numerics"))
}

/// The same in a sentence, where commas separate choices.
fn short(row: &Row) -> String {
    if is_own(row) { name(row) } else { format!("{} {}", row.get("accelerator"), row.get("schedule")) }
}

/// "bvh fused, grid compact and 3 more".
fn listed(rows: &[&Row]) -> String {
    let names: Vec<String> = rows.iter().take(MOST_NAMED).map(|row| short(row)).collect();
    let more = match rows.len().saturating_sub(MOST_NAMED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    names.join(", ") + &more
}

/// The verb for so many of them.
fn is(rows: &[&Row]) -> &'static str {
    if rows.len() == 1 { "is" } else { "are" }
}

/// Where it was measured, in words.
fn place(work: &Work<'_>) -> String {
    match work.machine().gpu() {
        Some(_) => work.machine().name(),
        None => counted(std::thread::available_parallelism().map_or(1, usize::from), "CPU core"),
    }
}

/// Adds the answer. `outside` says how many rays start outside the grid, if any: all, most or some.
pub(super) fn say(work: &Work<'_>, rows: &[Row], outside: Option<&str>, part: &mut Part) {
    let (scene, place) = (escaped(&work.subject.scene.name), escaped(&place(work)));
    part.lead.extend(answer(&format!("On {scene} with {place}"), rows, outside));
}

pub(super) fn is_accurate(row: &Row) -> bool {
    row.get("is_accurate") == "true"
}

/// Whether it is a method of another program.
pub(super) fn is_own(row: &Row) -> bool {
    !row.get("method").is_empty()
}

/// Whether it is robust: what can be recommended if it is accurate, too. Few of these rays meet edges, where the paper's
/// rules lose some.
pub(super) fn is_robust(row: &Row) -> bool {
    row.get("numerics") == "robust"
}

fn is_papers(row: &Row) -> bool {
    row.get("numerics") == "paper"
}

fn is_recommended(row: &&Row) -> bool {
    row.get("is_recommended") == "true"
}

/// The sentences.
fn answer(place: &str, rows: &[Row], outside: Option<&str>) -> Vec<String> {
    let best = rows.iter().find(is_recommended);
    let mut sentences = match best {
        Some(best) => vec![recommended(best), others(place, rows)],
        None => {
            vec![format!(
                "<strong>No choice can be recommended.</strong> {place}, no robust one was shown to be accurate."
            )]
        }
    };
    sentences.extend(inaccurate(rows));
    sentences.push(papers(rows, best) + &outside.map_or(String::new(), grid_misses));
    sentences.extend(limit(rows));
    sentences
}

/// What to use.
fn recommended(best: &Row) -> String {
    format!(
        "<strong>Use --accelerator {} --schedule {} ({}): {} per ray, {}.</strong>",
        best.get("accelerator"),
        best.get("schedule"),
        best.get("numerics"),
        cell("ns_per_ray", best.get("ns_per_ray")),
        wrong(best),
    )
}

/// "none of 36,864 rays wrong", "3 of 1,000 judged rays wrong (a sample of 36,864)".
fn wrong(row: &Row) -> String {
    let count = match row.get("wrong_rays") {
        "0" => "none".to_owned(),
        _ => number("wrong_rays", row),
    };
    let judged = number("judged_rays", row);
    match row.number("judged_rays").zip(row.number("rays")) {
        Some((some, all)) if some < all => {
            format!("{count} of {judged} judged rays wrong (a sample of {})", number("rays", row))
        }
        _ => format!("{count} of {judged} rays wrong"),
    }
}

/// What else is accurate: faster, as fast, or not to be told from the recommended choice.
fn others(place: &str, rows: &[Row]) -> String {
    let is_other = |row: &&Row| is_accurate(row) && !is_papers(row) && !is_recommended(row);
    let of = |wanted: Compared| -> Vec<&Row> {
        rows.iter().filter(is_other).filter(|row| compared("time_ratio", row) == wanted).collect()
    };
    let mut parts = Vec::new();
    let mut add = |those: Vec<&Row>, text: &dyn Fn(&[&Row]) -> String| {
        if !those.is_empty() {
            parts.push(format!("{} {}", listed(&those), text(&those)));
        }
    };
    add(of(Compared::Faster), &|those| format!("{} faster in the runs that are compared", is(those)));
    add(of(Compared::AsFast), &|those| format!("{} as fast, within {:.0}%", is(those), 100.0 * (EQUIVALENT - 1.0)));
    add(of(Compared::NotDistinguishable), &|_| "cannot be told from it in time".to_owned());
    add(of(Compared::Unknown), &|those| format!("{} not compared: too few runs, or no interval", is(those)));
    let (own, ours): (Vec<&Row>, Vec<&Row>) = of(Compared::Slower).into_iter().partition(|row| is_own(row));
    add(own, &|those| format!("{} slower", is(those)));
    let is_all = |row: &&Row| is_robust(row) && !is_recommended(row);
    let which = match rows.iter().filter(is_all).all(is_accurate) {
        true => "robust",
        false => "accurate robust",
    };
    parts.extend(match (ours.is_empty(), parts.is_empty()) {
        (true, true) => Some(format!("no other {which} choice was measured")),
        (true, false) => None,
        (false, true) => Some(format!("no other {which} choice is as fast")),
        (false, false) => Some(format!("every other {which} choice is slower")),
    });
    format!("{place}, {}.", parts.join("; "))
}

/// What is wrong too often although it is not by the paper's rules: what is faster, and other programs' methods.
fn inaccurate(rows: &[Row]) -> Option<String> {
    let is_named = |row: &&Row| {
        let is_faster = compared("time_ratio", row) == Compared::Faster;
        !is_accurate(row) && !is_papers(row) && (is_own(row) || is_faster)
    };
    let names = rows.iter().filter(is_named).map(|row| {
        let faster = if compared("time_ratio", row) == Compared::Faster { "faster, but " } else { "" };
        format!("{} ({faster}{} of {} wrong)", short(row), number("wrong_rays", row), number("judged_rays", row))
    });
    let names: Vec<String> = names.collect();
    (!names.is_empty()).then(|| format!("Not accurate: {}.", names.join(", ")))
}

/// The row with the shortest time among those with these fields.
pub(super) fn quickest<'a>(rows: &'a [Row], wanted: &[(&str, &str)]) -> Option<&'a Row> {
    let ns = |row: &Row| row.number("ns_per_ray").unwrap_or(f64::INFINITY);
    let of = rows.iter().filter(|row| row.is(wanted) && row.number("ns_per_ray").is_some());
    of.min_by(|a, b| ns(a).total_cmp(&ns(b)))
}

/// What the paper's rules would gain and lose: with the recommended structure and schedule, or where they are fastest.
fn papers(rows: &[Row], best: Option<&Row>) -> String {
    let alike = best.and_then(|best| {
        let same = ["accelerator", "schedule"].map(|column| (column, best.get(column)));
        rows.iter().find(|row| is_papers(row) && row.is(&same))
    });
    let Some(paper) = alike.or_else(|| quickest(rows, &[("numerics", "paper")])) else {
        return "The paper's rules were not measured.".to_owned();
    };
    let range = || {
        let [low, high] = ["time_ratio_low", "time_ratio_high"].map(|end| cell(end, paper.get(end)));
        format!("{low} to {high}, 95%")
    };
    let times = || cell("time_ratio", paper.get("time_ratio"));
    let gain = match best.map(|_| compared("time_ratio", paper)) {
        None => format!("take {} per ray", cell("ns_per_ray", paper.get("ns_per_ray"))),
        Some(Compared::Faster) => format!("take only {} times as long ({})", times(), range()),
        Some(Compared::Slower) => format!("take {} times as long ({})", times(), range()),
        Some(Compared::AsFast) => format!("are as fast (ratio {})", range()),
        Some(Compared::NotDistinguishable) => format!("are not distinguishable in time (ratio {})", range()),
        Some(Compared::Unknown) => "have too few runs to compare their time".to_owned(),
    };
    let loss = match paper.get("wrong_rays") {
        "0" => format!("get none of {} rays wrong, but can lose rays at edges", number("judged_rays", paper)),
        _ => format!("get {} of {} rays wrong", number("wrong_rays", paper), number("judged_rays", paper)),
    };
    format!("The paper's rules ({}) {gain}, and {loss}.", short(paper))
}

/// Why the paper's rules are wrong so often with a grid, if that is the reason.
fn grid_misses(share: &str) -> String {
    format!(" With a grid, they can lose rays that start outside it; here {share} rays start there.")
}

/// What "accurate" means here.
fn limit(rows: &[Row]) -> Option<String> {
    let row = rows.iter().find(|r| r.is(&[("method", ""), ("at_bound", "0")])).or(rows.first())?;
    let most = row.number("most_wrong_per_million")?;
    let why = match most > MOST_WRONG {
        true => format!("; {} judged rays cannot show less", number("judged_rays", row)),
        false => String::new(),
    };
    let most = number("most_wrong_per_million", row);
    Some(format!("Accurate means: at most {most} wrong rays per million, with 95% confidence{why}."))
}

#[cfg(test)]
mod tests;
