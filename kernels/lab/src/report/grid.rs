//! How fine a grid should be, and when building an accelerator pays off.

mod payoff;
mod plots;
mod words;

use raystep_kernels::export::json::GridSummary;
use raystep_kernels::export::structure::structure_bytes;
use raystep_kernels::plan::Plan;
use raystep_kernels::{Accelerator, GridSize, Options, RaySource, ScheduleKind};

use super::judge::Judge;
use super::page::Part;
use super::times::{self, Times};
use super::work::{Built, Work};
use crate::Error;
use crate::configuration::TESTS_PER_PASS;
use crate::statistics::interval;
use crate::tidy::fill::Drawn;
use crate::tidy::{KEYS, RATIO, Row, TIMES, Table, VERDICTS, count, joined};
use payoff::{builds, pays_off, saved};

const GROUPS: &[&[&str]] = &[
    KEYS,
    columns![
        accelerator resolution_factor is_automatic is_selected cells_x cells_y cells_z cells leaps
        references structure_bytes builds build_s build_s_low build_s_high build_s_min build_s_max rays
        passes ns_per_ray
    ],
    TIMES,
    RATIO,
    columns![
        held_out_rounds held_out_time_ratio held_out_time_ratio_low held_out_time_ratio_high paid_off_rays
        paid_off_rays_low paid_off_rays_high
    ],
    VERDICTS,
];

pub(super) const COLUMNS: &[&str] = &joined::<{ count(GROUPS) }>(GROUPS);

/// Maximum number of cells.
const MOST_CELLS: u64 = 1 << 25;

/// A configuration to build.
struct Candidate {
    options: Options,
    factor: Option<f64>,
}

impl Candidate {
    /// Part of a configuration's id.
    fn id(&self) -> String {
        match self.factor {
            Some(factor) => format!("grid-{factor:.3}"),
            None => self.options.accelerator.to_string(),
        }
    }

    fn is_automatic(&self) -> bool {
        self.factor.is_some() && self.options.grid == GridSize::Auto
    }

    fn name(&self) -> String {
        match self.factor {
            Some(factor) => format!("the grid at {factor:.3} times the automatic resolution"),
            None => self.options.accelerator.to_string(),
        }
    }
}

pub(super) fn run(work: &Work<'_>, table: &mut Table) -> Result<Part, Error> {
    let mut part = Part::default();
    work.stage("grid resolution");
    let (mut built, mut left_out): (Vec<(Candidate, Built)>, Vec<String>) = (Vec::new(), Vec::new());
    for one in candidates(work, &mut part)? {
        if work.is_past(times::FOR_BUILDING) {
            left_out.push(one.name());
            continue;
        }
        let ready = work.wait(work.build(&one.options));
        built.extend(work.noted(&mut part, &one.name(), ready)?.map(|ready| (one, ready)));
    }
    part.notes.extend(work.left_out(&left_out));
    let builds = builds(work, &built)?;
    let names: Vec<String> = built.iter().map(|(one, _)| work.configuration(&[&one.id()])).collect();
    let mut renderers: Vec<_> = built.iter_mut().map(|(_, b)| &mut b.renderer).collect();
    // Half of the rounds select a resolution; the others, enough for an interval, estimate it.
    let fewest = work.either(interval::FEWEST, 2 * interval::FEWEST);
    let times = work.wait(work.time_rounds(&names, &mut renderers, fewest, work.either(fewest, 24)))?;
    part.notes.extend(times::notes(work, built.iter().map(|(one, _)| one.name()).zip(&times)));
    let automatic = built.iter().position(|(one, _)| one.is_automatic());
    let none = built.iter().position(|(one, _)| one.options.accelerator == Accelerator::None);
    let selected = automatic.and_then(|automatic| select(&built, &times, automatic));
    let is_whole = |i: usize| built[i].1.renderer.plan().rays == view_rays(work);
    let mut judges = [Judge::default(), Judge::default()];
    let mut rows = Vec::new();
    for (i, ((one, ready), times_of)) in built.iter().zip(&times).enumerate() {
        if times_of.is_missing() {
            continue;
        }
        // Without an accelerator there may be fewer rays, and then the correct hits differ, too.
        let judge = &mut judges[usize::from(one.options.accelerator == Accelerator::None)];
        let judged = work.wait(judge.judge(work, &ready.renderer))?;
        judge.record(work, &ready.renderer, &judged, &work.configuration(&[&one.id()]), |_| "pixels");
        part.notes.extend(times_of.is_given_up().then(|| format!("{}: {}", one.name(), judged.given_up())));
        let mut row = builds[i].fill(times_of.fill(row(work, one, ready, times_of), work.seed()));
        if let Some(automatic) = automatic.filter(|_| is_whole(i)) {
            row = times_of.fill_ratio(&times[automatic], &names[automatic], row, work.seed());
            if selected == Some(i) {
                row = held_out(times_of, &times[automatic], row, work.seed());
            }
        }
        if let Some(none) = none.filter(|&none| none != i && is_whole(i) && is_whole(none)) {
            let rays = ready.renderer.plan().rays;
            let saved = saved(&times[none], times_of, rays, work.seed());
            row = saved.map_or(row.clone(), |saved| pays_off(&builds[i], &builds[none], saved).fill(row));
        }
        row = row.set("is_selected", one.factor.map(|_| selected == Some(i)));
        let (of, rays) = (judge.sample().len(), ready.renderer.plan().rays as usize);
        rows.push(judged.fill(row, Drawn::of_pixels(of, rays)));
    }
    part.figure("time", plots::times(&rows), plots::times_caption(&rows));
    part.figure("build", plots::builds(&rows), plots::builds_caption(&rows, true));
    part.figure("bytes", plots::bytes(&rows), "Memory of the grid: cells and lists of triangles.");
    part.figure("structures", plots::structure_times(&rows), plots::structures_caption(&rows));
    part.figure("structures-build", plots::structure_builds(&rows), plots::builds_caption(&rows, false));
    part.table(&rows);
    words::say(work, &rows, &mut part);
    table.rows.extend(rows);
    Ok(part)
}

/// Whether a round selects the resolution, rather than estimating its time: pairs of rounds, which have opposite orders,
/// take turns.
fn selects(round: usize) -> bool {
    (round / 2).is_multiple_of(2)
}

/// The grid with the least time in half of the rounds.
fn select(built: &[(Candidate, Built)], times: &[Times], automatic: usize) -> Option<usize> {
    let to = times[automatic].in_rounds(selects);
    let ratio = |i: usize| Some(times[i].in_rounds(selects).ratio(&to, 0)?.0);
    let grids = (0..built.len()).filter(|&i| built[i].0.factor.is_some());
    let ratios = grids.filter_map(|i| Some((i, ratio(i)?)));
    ratios.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
}

/// Fills the columns of the ratio in rounds that did not take part in the selection.
fn held_out(times: &Times, automatic: &Times, row: Row, seed: u32) -> Row {
    let [times, automatic] = [times, automatic].map(|times| times.in_rounds(|round| !selects(round)));
    row.set("held_out_rounds", times.runs()).median("held_out_time_ratio", times.ratio(&automatic, seed))
}

/// The automatic grid, coarser and finer ones, the BVH, and no accelerator, all with schedule `compact`.
fn candidates(work: &Work<'_>, part: &mut Part) -> Result<Vec<Candidate>, Error> {
    let options = Options { schedule: ScheduleKind::Compact, shade: false, ..Options::new(work.camera_rays()) };
    let (_, data) = Plan::new(&work.subject.scene, &options, &work.machine().limits())?;
    let automatic = data.grid.cells.map(|n| n.max(1) as u32);
    let steps = work.either(1.0, 0.5);
    let mut all: Vec<Candidate> = vec![Candidate { options: options.clone(), factor: Some(1.0) }];
    let mut seen = vec![automatic];
    let mut exponent = -2.0;
    while exponent <= 2.0 {
        let factor = 2f64.powf(exponent);
        exponent += steps;
        let cells =
            automatic.map(|n| if n > 1 { (f64::from(n) * factor).round().clamp(1.0, 4096.0) as u32 } else { 1 });
        if seen.contains(&cells) {
            continue;
        }
        if cells.iter().map(|&n| u64::from(n)).product::<u64>() > MOST_CELLS {
            part.notes
                .push(format!("the grid at {factor:.3} times the automatic resolution: more than {MOST_CELLS} cells"));
            continue;
        }
        seen.push(cells);
        all.push(Candidate {
            options: Options { grid: GridSize::Cells(cells), ..options.clone() },
            factor: Some(factor),
        });
    }
    all.sort_by(|a, b| a.factor.unwrap_or(0.0).total_cmp(&b.factor.unwrap_or(0.0)));
    all.push(Candidate { options: Options { accelerator: Accelerator::Bvh, ..options.clone() }, factor: None });
    let rays = fewer_rays(work);
    if rays_of(&rays) < view_rays(work) {
        part.notes.push(format!(
            "none was timed with only {} rays, because testing every triangle for {} takes too long; so its time is not \
             compared, and the number of rays after which a structure pays off is unknown",
            rays_of(&rays),
            view_rays(work)
        ));
    }
    let none = Options { accelerator: Accelerator::None, rays, steps_per_pass: TESTS_PER_PASS, ..options };
    all.push(Candidate { options: none, factor: None });
    Ok(all)
}

fn view_rays(work: &Work<'_>) -> u64 {
    u64::from(work.size.width) * u64::from(work.size.height)
}

fn rays_of(rays: &RaySource) -> u64 {
    match rays {
        RaySource::Camera { width, height, .. } => u64::from(*width) * u64::from(*height),
        RaySource::Given(rays) => rays.len() as u64,
    }
}

/// The rays of the view, with fewer pixels if testing every triangle would take too long.
fn fewer_rays(work: &Work<'_>) -> RaySource {
    let tests = work.either(1u64 << 24, 1 << 26);
    let most = (tests / (work.subject.scene.triangles.len() as u64).max(1)).max(64);
    let mut size = work.size;
    while u64::from(size.width) * u64::from(size.height) > most && size.width * size.height > 1 {
        size.width = (size.width / 2).max(1);
        size.height = (size.height / 2).max(1);
    }
    Work { size, ..*work }.camera_rays()
}

fn row(work: &Work<'_>, one: &Candidate, built: &Built, times: &Times) -> Row {
    let (plan, data) = (built.renderer.plan(), built.renderer.data());
    let grid = GridSummary::of(plan, data);
    let cell = |axis: usize| grid.map(|g| g.cells[axis]);
    let per_ray = times.median().filter(|_| plan.rays > 0).map(|ns| ns / plan.rays as f64);
    work.row(COLUMNS)
        .set("configuration", work.configuration(&[&one.id()]))
        .set("accelerator", one.options.accelerator.name())
        .set("resolution_factor", one.factor)
        .set("is_automatic", one.factor.map(|_| one.is_automatic()))
        .set("cells_x", cell(0))
        .set("cells_y", cell(1))
        .set("cells_z", cell(2))
        .set("cells", grid.map(|g| g.cells.iter().map(|&n| n as u64).product::<u64>()))
        .set("leaps", grid.map(|g| g.leaps))
        .set("references", grid.map(|g| g.references))
        .set("structure_bytes", structure_bytes(plan))
        .set("rays", plan.rays)
        .set("ns_per_ray", per_ray)
        .set("passes", built.renderer.pass_count())
        .set("clock", work.clock())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_that_select_come_in_pairs_and_are_half_of_all() {
        let of: Vec<bool> = (0..8).map(selects).collect();
        assert_eq!(of, [true, true, false, false, true, true, false, false]);
    }
}
