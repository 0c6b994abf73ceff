//! The rows of the choices: how they are compared, which is recommended, and which are on the front.

use std::time::Duration;

use raystep_kernels::Ray;
use raystep_kernels::export::structure::structure_bytes;

use super::super::judge::Judge;
use super::super::methods::Method;
use super::super::work::{Work, id};
use super::strata::ALL;
use super::{COLUMNS, MOST_WRONG, Measured, options, words};
use crate::portions::Portions;
use crate::statistics::interval;
use crate::statistics::proportion::at_most;
use crate::tidy::Row;
use crate::tidy::fill::{self, Drawn};

/// Hits whose t is compared with rational arithmetic.
const WITNESSED: usize = 256;

/// The share of wrong rays up to which a choice is called accurate: [`MOST_WRONG`], or what the judged rays can show.
pub(super) fn limit(measured: &[Measured]) -> f64 {
    // A run that was stopped has fewer judged rays, and is not accurate in any case.
    let is_over = |m: &&Measured| m.judged.at_bound == 0;
    let shown = |m: &Measured| at_most(0, m.judged.counts.rays()).map(|high| 1e6 * high);
    measured.iter().filter(is_over).filter_map(shown).fold(MOST_WRONG, f64::max)
}

/// Fewest rounds of which one half chooses the fastest and the other compares: both have an interval.
pub(super) const FEWEST_TO_HALVE: usize = 2 * interval::FEWEST;

/// Two of four rounds, of which one is the reverse of the other: the fastest choice is found in these.
fn is_for_choosing(round: usize) -> bool {
    round % 4 < 2
}

/// Whether a choice has enough rounds to be chosen in one half and compared in the other.
pub(super) fn is_halved(m: &Measured) -> bool {
    m.times.rounds() >= FEWEST_TO_HALVE
}

/// The rows, with their comparisons.
pub(super) async fn all_rows(
    work: &Work<'_>,
    rays: &[Ray],
    judge: &Judge,
    measured: &[Measured],
    limit: f64,
) -> Vec<Row> {
    let mut rows = Vec::new();
    for m in measured {
        rows.push(row(work, rays, judge, m, limit).await);
    }
    // With fewer rounds, all of them serve both.
    let choosing = |m: &Measured| m.times.in_rounds(|round| !is_halved(m) || is_for_choosing(round));
    let chosen_by = |i: usize| choosing(&measured[i]).median().filter(|_| measured[i].times.is_timed());
    let can_be = |i: usize| words::is_robust(&rows[i]) && words::is_accurate(&rows[i]);
    let times = (0..rows.len()).filter(|&i| can_be(i)).filter_map(|i| Some((i, chosen_by(i)?)));
    let best = times.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i);
    if let Some(best) = best {
        let to = &measured[best];
        let name = id(work, &to.configuration);
        let mut portions = Portions::new();
        for (i, (row, m)) in rows.iter_mut().zip(measured).enumerate() {
            portions.rest().await;
            if m.times.is_timed() {
                let are_halved = is_halved(m) && is_halved(to);
                let compared = m.times.in_rounds(|round| !are_halved || !is_for_choosing(round));
                *row = compared.fill_ratio(&to.times, &name, row.clone(), work.seed());
            }
            *row = row.clone().set("is_recommended", i == best);
        }
    }
    rows
}

/// The row of a method of another program.
pub(super) fn own_row(work: &Work<'_>, method: &Method, limit: f64) -> Row {
    let row = work
        .row(COLUMNS)
        .set("configuration", work.configuration(&["own", &method.method]))
        .set("method", &*method.method)
        .set("stratum", ALL)
        .set("ns_per_ray", method.ns_per_ray)
        .set("ns_per_ray_low", method.ns_per_ray_low)
        .set("ns_per_ray_high", method.ns_per_ray_high)
        .set("undecided", method.undecided)
        .set("undecided_per_million", fill::per_million(method.undecided, method.judged_rays))
        .set("most_wrong_per_million", limit)
        .set("is_recommended", false);
    let row = fill::shares(row, method.wrong_rays, method.judged_rays, Drawn::AtRandom);
    let is_accurate = is_within_limit(&row);
    row.set("is_accurate", is_accurate)
}

/// Whether the upper bound of wrong rays is at most the limit: both as they are written, with the same digits.
fn is_within_limit(row: &Row) -> bool {
    let ends = row.number("wrong_per_million_high").zip(row.number("most_wrong_per_million"));
    ends.is_some_and(|(high, most)| high <= most)
}

/// Fills the ratios of other programs' methods to the recommended choice. Their runs have no pairs: the ratio is that of
/// the times, and its interval what both intervals allow.
pub(super) fn compare_own(rows: &mut [Row]) {
    const TIMES: [&str; 3] = ["ns_per_ray", "ns_per_ray_low", "ns_per_ray_high"];
    let Some(best) = rows.iter().find(|row| row.get("is_recommended") == "true").cloned() else { return };
    let of_best = TIMES.map(|column| best.number(column).filter(|ns| *ns > 0.0));
    for row in rows.iter_mut().filter(|row| words::is_own(row)) {
        let of_own = TIMES.map(|column| row.number(column));
        let ratio = |own: usize, ours: usize| Some(of_own[own]? / of_best[ours]?);
        // An interval needs all four ends.
        let ends = ratio(1, 2).zip(ratio(2, 1));
        *row = row
            .clone()
            .set("ratio_to", best.get("configuration"))
            .set("time_ratio", ratio(0, 0))
            .ends("time_ratio", ends.map(|(low, high)| [low, high]));
    }
}

/// Marks the fastest of all accurate choices, and the front.
pub(super) fn mark(rows: &mut [Row]) {
    let front = front(rows);
    let fastest = words::quickest(rows, &[("is_accurate", "true")]).map(|row| row.get("configuration").to_owned());
    for (row, is_front) in rows.iter_mut().zip(front) {
        let is_fastest = fastest.as_deref() == Some(row.get("configuration"));
        *row = row.clone().set("is_front", is_front).set("is_fastest", is_fastest);
    }
}

/// Whether no other choice is faster and not more often wrong, or as fast and less often wrong.
fn front(rows: &[Row]) -> Vec<bool> {
    let at = |row: &Row| Some((row.number("ns_per_ray")?, row.number("wrong_per_million")?));
    let is_front = |row: &Row| {
        at(row).is_some_and(|(ns, wrong)| {
            !rows.iter().filter_map(at).any(|(n, w)| n <= ns && w <= wrong && (n < ns || w < wrong))
        })
    };
    rows.iter().map(is_front).collect()
}

async fn row(work: &Work<'_>, rays: &[Ray], judge: &Judge, m: &Measured, limit: f64) -> Row {
    let Measured { configuration, built, times, judged } = m;
    let plan = built.renderer.plan();
    let sums = work.machine().counts(&work.subject.scene, &options(*configuration, rays), Duration::MAX).await;
    let per_ray = |sum: u64| (plan.rays > 0).then(|| sum as f64 / plan.rays as f64);
    let row = work
        .row(COLUMNS)
        .set("configuration", id(work, configuration))
        .configured(configuration)
        .set("stratum", ALL)
        .set("rays", plan.rays)
        .set("clock", work.clock())
        .set("passes", built.renderer.pass_count())
        .set("cells_per_ray", sums.as_ref().and_then(|sums| per_ray(sums.cells_visited)))
        .set("tests_per_ray", sums.as_ref().and_then(|sums| per_ray(sums.triangles_tested)))
        .set("structure_bytes", structure_bytes(plan))
        .set("build_s", built.build_s)
        .set("most_wrong_per_million", limit);
    let row = judged.fill(times.fill(row, work.seed()), Drawn::AtRandom);
    let undecided = fill::per_million(judged.counts.ties, judged.counts.rays());
    let of_ray = |column: &str| row.number(column).filter(|_| plan.rays > 0).map(|ns| ns / plan.rays as f64);
    let (ns, low, high) = (of_ray("median_ns"), of_ray("low_ns"), of_ray("high_ns"));
    let is_accurate = judged.at_bound == 0 && is_within_limit(&row);
    let witness = judge.witness(judged, &built.renderer, WITNESSED).await;
    row.set("ns_per_ray", ns)
        .set("ns_per_ray_low", low)
        .set("ns_per_ray_high", high)
        .set("undecided_per_million", undecided)
        .set("is_accurate", is_accurate)
        .set("witness_rays", witness.rays)
        .set("witness_error_by_bound", witness.error_by_bound)
        .set("witness_reference_error_by_bound", witness.reference_error_by_bound)
}
