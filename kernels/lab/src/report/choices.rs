//! The answer of a report: every structure, schedule and set of rules on the same rays, time against wrong rays.
//!
//! The rays are a random sample of what the camera sees, so that shares of wrong rays have exact bounds. Runs are
//! interleaved. Recommended is the fastest of the robust choices that are accurate. It is found in half of the rounds and
//! compared with the others in the other half, so that luck which made it the fastest does not enter the comparison; with
//! fewer than twelve rounds, all of them serve both. Where time is short, what is clearly slower than the fastest robust
//! choice gets fewer rounds, so that those that are close can be told apart.

mod configurations;
mod figure;
mod rows;
mod strata;
mod table;
mod words;

use configurations::configurations;
use raystep_kernels::plan::Plan;
use raystep_kernels::{Accelerator, Numerics, Options, Ray, RaySource, Renderer};
use rows::{FEWEST_TO_HALVE, all_rows, compare_own, is_halved, limit, mark, own_row};
use strata::Strata;

use super::judge::{Judge, Judged};
use super::page::Part;
use super::times::{self, Amount, First, Race, Times};
use super::work::{Built, Work, id, in_words};
use crate::Error;
use crate::configuration::Configuration;
use crate::html::escaped;
use crate::human;
use crate::outside::{MISSES_OUTSIDE, share_outside};
use crate::rays::view;
use crate::statistics::interval;
use crate::tidy::{KEYS, RATIO, TIMES, Table, VERDICTS, count, joined};

const GROUPS: &[&[&str]] = &[
    KEYS,
    columns![method accelerator schedule numerics stratum rays ns_per_ray ns_per_ray_low ns_per_ray_high],
    TIMES,
    RATIO,
    columns![is_recommended is_fastest is_front most_wrong_per_million is_accurate],
    VERDICTS,
    columns![undecided_per_million passes cells_per_ray tests_per_ray structure_bytes build_s],
    &["witness_rays", "witness_error_by_bound", "witness_reference_error_by_bound"],
];

pub(super) const COLUMNS: &[&str] = &joined::<{ count(GROUPS) }>(GROUPS);

/// Maximum number of tests in a run without an accelerator, in a quick report and in a full one.
const MOST_TESTS: [u64; 2] = [1 << 26, 1 << 28];

/// Most bytes of all choices together: they are timed in turn. A browser's module has 4 GiB for everything.
const MOST_BYTES: u64 = if cfg!(target_pointer_width = "32") { 1 << 30 } else { 4 << 30 };

/// Share of wrong rays, per million, up to which a choice is called accurate.
pub(super) const MOST_WRONG: f64 = 100.0;

/// A choice that was built and timed.
struct Measured {
    configuration: Configuration,
    built: Built,
    times: Times,
    judged: Judged,
}

pub(super) async fn run(work: &Work<'_>, table: &mut Table) -> Result<Part, Error> {
    let mut part = Part::default();
    if work.subject.scene.triangles.is_empty() {
        let name = escaped(&work.subject.scene.name);
        part.lead.push(format!("{name}: the scene has no triangles, so there is nothing to compare."));
        return Ok(part);
    }
    let begin = table.rows.len();
    let rays = match work.rays {
        Some(file) => file.in_scene(&work.subject.scene),
        None => view(&work.subject.camera, work.size.width, work.size.height, work.seed()),
    };
    let strata = Strata::new(work);
    let mut ready = first_runs(work, &rays, &mut part).await?;
    let is_of_paper = |one: &&Ready| {
        (one.configuration.accelerator, one.configuration.numerics) == (Accelerator::Grid, Numerics::Paper)
    };
    let outside = ready.iter().find(is_of_paper).and_then(|one| share_outside(&rays, one.built.renderer.data()));
    part.notes.extend(outside.map(|share| format!("{MISSES_OUTSIDE}; here {share} rays start there")));
    work.stage("timing choices");
    let names: Vec<String> = ready.iter().map(|one| id(work, &one.configuration)).collect();
    let firsts: Vec<First> = ready.iter().map(|one| one.first).collect();
    let can_win: Vec<bool> = ready.iter().map(|one| one.configuration.numerics == Numerics::Robust).collect();
    let mut renderers: Vec<&mut Renderer> = ready.iter_mut().map(|one| &mut one.built.renderer).collect();
    let race = Some(Race { can_win: &can_win, fewest: FEWEST_TO_HALVE });
    let amount = Amount { fewest: interval::FEWEST, repeats: work.either(12, 24), race };
    let times = work.time_after(&firsts, &names, &mut renderers, amount).await?;
    part.notes.extend(times::notes(work, ready.iter().map(|one| in_words(&one.configuration)).zip(&times)));
    work.stage("judging choices");
    let mut judge = Judge::default();
    let (mut measured, of) = (Vec::new(), ready.len() as u64);
    for (Ready { configuration, built, .. }, times) in ready.into_iter().zip(times) {
        work.reporter.part("choices judged", measured.len() as u64, of);
        let judged = judge.judge(work, &built.renderer).await?;
        part.notes.extend(times.is_given_up().then(|| format!("{}: {}", in_words(&configuration), judged.given_up())));
        judge.record(work, &built.renderer, &judged, &id(work, &configuration), |ray| strata.of(ray));
        measured.push(Measured { configuration, built, times, judged });
    }
    let limit = limit(&measured);
    table.rows.extend(all_rows(work, &rays, &judge, &measured, limit).await);
    let scene = &work.subject.scene.name;
    let own = work.methods.iter().filter(|m| m.scene.is_empty() || m.scene == *scene);
    table.rows.extend(own.map(|method| own_row(work, method, limit)));
    compare_own(&mut table.rows[begin..]);
    mark(&mut table.rows[begin..]);
    let last = table.rows.len();
    for m in &measured {
        table.rows.extend(strata.rows(work, &judge, m));
    }
    let (rows, of_strata) = (&table.rows[begin..last], &table.rows[last..]);
    words::say(work, rows, outside, &mut part);
    let is_file = work.rays.is_some();
    part.lead_figure("precision", figure::of(rows, is_file), figure::caption(rows, is_file));
    table::add(rows, measured.iter().any(is_halved), &mut part);
    part.table(rows);
    part.table(of_strata);
    Ok(part)
}

/// A choice that has run once.
struct Ready {
    configuration: Configuration,
    built: Built,
    first: First,
}

/// Shows the choices so far, with the time of one run each.
fn show(work: &Work<'_>, ready: &[Ready]) {
    let row = |one: &Ready| {
        let rays = one.built.renderer.plan().rays.max(1) as f64;
        let time = match one.first.time().and_then(|time| work.ns(time)) {
            Some(ns) => human::time(ns / rays),
            None => "stopped".into(),
        };
        vec![in_words(&one.configuration), time]
    };
    work.reporter.rows(&["choice", "time per ray, one run"], &ready.iter().map(row).collect::<Vec<_>>());
}

/// Builds and runs every choice once, as long as there is time.
async fn first_runs(work: &Work<'_>, rays: &[Ray], part: &mut Part) -> Result<Vec<Ready>, Error> {
    let (mut ready, mut left_out): (Vec<Ready>, Vec<String>) = (Vec::new(), Vec::new());
    let all = configurations(work.is_quick, work.only);
    for (done, &configuration) in (0..).zip(&all) {
        let name = in_words(&configuration);
        if work.is_past(times::FOR_FIRST_RUNS) {
            left_out.push(name);
            continue;
        }
        work.stage(&format!("building {name}"));
        work.reporter.part("choices built and run", done, all.len() as u64);
        let built = build(work, configuration, rays, &ready, part).await;
        let Some(mut built) = work.noted(part, &name, built)?.flatten() else { continue };
        let first = work.first_run(&mut built.renderer).await?;
        if first.is_missing() {
            left_out.push(name);
        } else {
            ready.push(Ready { configuration, built, first });
            show(work, &ready);
        }
    }
    part.notes.extend(work.left_out(&left_out));
    Ok(ready)
}

/// Builds a choice, unless it would take too long or too much memory beside those that are already `built`.
async fn build(
    work: &Work<'_>,
    configuration: Configuration,
    rays: &[Ray],
    built: &[Ready],
    part: &mut Part,
) -> Result<Option<Built>, Error> {
    let mut note = |text: String| {
        if !part.notes.contains(&text) {
            part.notes.push(text);
        }
    };
    let tests = work.subject.scene.triangles.len().saturating_mul(rays.len()) as u64;
    if configuration.accelerator == Accelerator::None && tests > work.either(MOST_TESTS[0], MOST_TESTS[1]) {
        note(format!("none, left out: testing every triangle for each of {} rays takes too long", rays.len()));
        return Ok(None);
    }
    let options = options(configuration, rays);
    let planned = work.plan(&options)?;
    let bytes = |plan: &Plan| plan.bytes() + size_of_val(rays) as u64;
    let before: u64 = built.iter().map(|one| bytes(one.built.renderer.plan())).sum();
    if before + bytes(&planned.plan) > MOST_BYTES && !built.is_empty() {
        note(format!(
            "{}: the choices together would take more than {} GiB",
            in_words(&configuration),
            MOST_BYTES >> 30
        ));
        return Ok(None);
    }
    Ok(Some(work.start(&planned, &options).await?))
}

/// The options of a choice.
fn options(configuration: Configuration, rays: &[Ray]) -> Options {
    configuration.of(&Options { shade: false, ..Options::new(RaySource::Given(rays.to_vec())) })
}
