//! How fine a grid should be, and when building an accelerator pays off.

use std::time::Instant;

use raystep_kernels::export::json::GridSummary;
use raystep_kernels::export::structure::structure_bytes;
use raystep_kernels::plan::Plan;
use raystep_kernels::{Accelerator, GridSize, Options, RaySource};

use super::judge::{Drawn, Judge};
use super::page::{Part, number};
use super::work::{Built, TESTS_PER_PASS, Times, Work};
use crate::Error;
use crate::plots::{Axis, Bars, Plot, Scale, Series};
use crate::statistics::quantile;
use crate::tidy::{KEYS, Row, TIMES, Table, VERDICTS, count, joined};

const GROUPS: &[&[&str]] = &[
    KEYS,
    &[
        "accelerator",
        "resolution_factor",
        "is_automatic",
        "cells_x",
        "cells_y",
        "cells_z",
        "cells",
        "leaps",
        "references",
        "structure_bytes",
        "build_s",
        "rays",
        "ns_per_ray",
        "trace_ratio",
        "view_s",
        "view_with_build_s",
        "paid_off_rays",
        "passes",
    ],
    TIMES,
    VERDICTS,
];

pub(super) const COLUMNS: &[&str] = &joined::<{ count(GROUPS) }>(GROUPS);

const SHOWN: &[&str] = &[
    "accelerator",
    "resolution_factor",
    "is_automatic",
    "cells_x",
    "cells_y",
    "cells_z",
    "references",
    "structure_bytes",
    "build_s",
    "rays",
    "runs",
    "median_ns",
    "low_ns",
    "high_ns",
    "trace_ratio",
    "view_with_build_s",
    "paid_off_rays",
    "judged_rays",
    "wrong_rays",
    "at_bound",
];

/// Maximum number of cells.
const MOST_CELLS: u64 = 1 << 25;

/// A configuration to build.
struct Way {
    options: Options,
    factor: Option<f64>,
}

impl Way {
    /// Part of a configuration's id.
    fn id(&self) -> String {
        match self.factor {
            Some(factor) => format!("grid-{factor:.3}"),
            None => self.options.accelerator.to_string(),
        }
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
    let first = table.rows.len();
    let mut built: Vec<(Way, Built)> = Vec::new();
    for way in ways(work, &mut part)? {
        match build(work, &way.options) {
            Ok(ready) => built.push((way, ready)),
            Err(error) => {
                work.can_go_on()?;
                part.notes.push(format!("{}: {}", way.name(), work.explain(&error)));
            }
        }
    }
    let names: Vec<String> = built.iter().map(|(way, _)| work.configuration(&[&way.id()])).collect();
    let mut renderers: Vec<_> = built.iter_mut().map(|(_, b)| &mut b.renderer).collect();
    let times = work.time_in_turn(&names, &mut renderers, work.either(3, 9))?;
    let mut judges = [Judge::default(), Judge::default()];
    for ((way, ready), times) in built.iter().zip(&times) {
        // Without an accelerator there may be fewer rays, and then the correct hits differ, too.
        let judge = &mut judges[usize::from(way.options.accelerator == Accelerator::None)];
        let judged = judge.judge(work, &ready.renderer)?;
        if times.is_given_up {
            part.notes.push(format!("{}: {}", way.name(), judged.given_up()));
        }
        let (of, rays) = (judge.sample().len(), ready.renderer.plan().rays as usize);
        table.rows.push(judged.fill(row(work, way, ready, times), Drawn::of_pixels(of, rays)));
    }
    compare(&mut table.rows[first..]);
    let rows = &table.rows[first..];
    part.figure("time", time_plot(rows).svg()?, "");
    part.figure("bytes", bytes_plot(rows).svg()?, "");
    part.figure("build", bars(rows).svg()?, "");
    part.table(rows, SHOWN);
    say(work, rows, &mut part);
    Ok(part)
}

fn say(work: &Work<'_>, rows: &[Row], part: &mut Part) {
    let automatic = rows.iter().find(|r| r.get("is_automatic") == "true");
    let fastest = rows.iter().filter(|r| r.get("accelerator") == "grid");
    let fastest = fastest.filter(|r| r.number("trace_ratio").is_some());
    let fastest = fastest.min_by(|a, b| {
        let time = |r: &Row| r.number("trace_ratio").unwrap_or(f64::INFINITY);
        time(a).total_cmp(&time(b))
    });
    if let (Some(automatic), Some(fastest)) = (automatic, fastest) {
        part.prose.push(format!(
            "The ratio is relative to the automatic resolution, {} × {} × {}; the fastest resolution takes {} of its \
             time. Wrong rays at any resolution: at most {}.",
            number("cells_x", automatic),
            number("cells_y", automatic),
            number("cells_z", automatic),
            number("trace_ratio", fastest),
            rows.iter()
                .max_by_key(|r| r.number("wrong_rays").unwrap_or(0.0) as u64)
                .map_or_else(|| "?".into(), |row| number("wrong_rays", row)),
        ));
    }
    part.prose.push(format!(
        "Times are {}; building is timed by the wall clock on the CPU. A structure pays off after the number of rays \
         for which its building time, beyond that of any plan, equals the time saved compared with testing every \
         triangle.",
        work.clock_in_words()
    ));
}

/// The automatic grid, coarser and finer ones, the BVH, and no accelerator.
fn ways(work: &Work<'_>, part: &mut Part) -> Result<Vec<Way>, Error> {
    let options = Options { shade: false, ..Options::new(work.camera_rays()) };
    let (_, data) = Plan::new(&work.subject.scene, &options, &work.machine().limits())?;
    let automatic = data.grid.cells.map(|n| n.max(1) as u32);
    let steps = work.either(1.0, 0.5);
    let mut ways: Vec<Way> = vec![Way { options: options.clone(), factor: Some(1.0) }];
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
        ways.push(Way { options: Options { grid: GridSize::Cells(cells), ..options.clone() }, factor: Some(factor) });
    }
    ways.sort_by(|a, b| a.factor.unwrap_or(0.0).total_cmp(&b.factor.unwrap_or(0.0)));
    ways.push(Way { options: Options { accelerator: Accelerator::Bvh, ..options.clone() }, factor: None });
    let rays = fewer_rays(work);
    if rays_of(&rays) < view_rays(work) {
        part.notes.push(format!(
            "none: testing every triangle for each of {} rays takes too long. It has {} rays, and their times are \
             not compared, so the number of rays after which a structure pays off is unknown",
            view_rays(work),
            rays_of(&rays)
        ));
    }
    let none = Options { accelerator: Accelerator::None, rays, steps_per_pass: TESTS_PER_PASS, ..options };
    ways.push(Way { options: none, factor: None });
    Ok(ways)
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
    let tests = work.either(1u64 << 24, 1 << 28);
    let most = (tests / (work.subject.scene.triangles.len() as u64).max(1)).max(64);
    let mut size = work.size;
    while u64::from(size.width) * u64::from(size.height) > most && size.width * size.height > 1 {
        size.width = (size.width / 2).max(1);
        size.height = (size.height / 2).max(1);
    }
    Work { size, ..*work }.camera_rays()
}

/// Builds. The build time is the median of three; only planning is repeated.
fn build(work: &Work<'_>, options: &Options) -> Result<Built, Error> {
    let mut built = work.build(options)?;
    let mut times = vec![built.build_s];
    for _ in 0..work.either(0, 2) {
        work.machine().forget_kernels();
        let begin = Instant::now();
        Plan::new(&work.subject.scene, options, &work.machine().limits())?;
        times.push(begin.elapsed().as_secs_f64());
    }
    built.build_s = quantile(&times, 0.5).unwrap_or(built.build_s);
    Ok(built)
}

fn row(work: &Work<'_>, way: &Way, built: &Built, times: &Times) -> Row {
    let (plan, data) = (built.renderer.plan(), built.renderer.data());
    let grid = GridSummary::of(plan, data);
    let median = times.median();
    let cell = |axis: usize| grid.map(|g| g.cells[axis]);
    let per_ray = median.filter(|_| plan.rays > 0).map(|ns| ns / plan.rays as f64);
    // Times with fewer rays are not comparable: a GPU that is not fully used takes longer per ray.
    let view_s = median.filter(|_| plan.rays == view_rays(work)).map(|ns| ns / 1e9);
    let row = work
        .row(COLUMNS)
        .set("configuration", work.configuration(&[&way.id()]))
        .set("accelerator", way.options.accelerator.name())
        .set("resolution_factor", way.factor)
        .set("is_automatic", way.factor.map(|_| way.options.grid == GridSize::Auto))
        .set("cells_x", cell(0))
        .set("cells_y", cell(1))
        .set("cells_z", cell(2))
        .set("cells", grid.map(|g| g.cells.iter().map(|&n| n as u64).product::<u64>()))
        .set("leaps", grid.map(|g| g.leaps))
        .set("references", grid.map(|g| g.references))
        .set("structure_bytes", structure_bytes(plan))
        .set("build_s", built.build_s)
        .set("rays", plan.rays)
        .set("ns_per_ray", per_ray)
        .set("view_s", view_s)
        .set("view_with_build_s", view_s.map(|s| s + built.build_s))
        .set("passes", built.renderer.pass_count())
        .set("clock", work.clock());
    times.fill(row, work.seed())
}

/// Adds the columns that compare rows, for those that traced the whole view.
fn compare(rows: &mut [Row]) {
    let whole = |r: &Row| r.number("view_s").and_then(|_| r.number("ns_per_ray"));
    let automatic = rows.iter().find(|r| r.get("is_automatic") == "true").and_then(whole);
    let is_none = |r: &Row| r.get("accelerator") == "none";
    let none = rows.iter().find(|r| is_none(r)).and_then(|r| whole(r).zip(r.number("build_s")));
    for row in rows.iter_mut() {
        let (per_ray, build_s) = (whole(row), row.number("build_s"));
        let ratio = per_ray.zip(automatic).map(|(ns, automatic)| ns / automatic);
        let pays = per_ray.zip(build_s).zip(none).filter(|_| !is_none(row)).and_then(|((ns, build), (none, least))| {
            // A structure that does not save time never pays off.
            (none > ns).then(|| (1e9 * (build - least) / (none - ns)).max(0.0).ceil())
        });
        *row = row.clone().set("trace_ratio", ratio).set("paid_off_rays", pays);
    }
}

fn over_cells(rows: &[Row], y: impl Fn(&Row) -> Option<f64>) -> Vec<(f64, f64)> {
    rows.iter().filter_map(|r| Some((r.number("cells")?, y(r)?))).collect()
}

fn automatic_place(rows: &[Row]) -> Vec<(f64, String)> {
    let cells = rows.iter().find(|r| r.get("is_automatic") == "true").and_then(|r| r.number("cells"));
    cells.map(|cells| (cells, "automatic".to_owned())).into_iter().collect()
}

fn cells_axis() -> Axis {
    Axis::new("cells of the grid", Scale::Log)
}

fn time_plot(rows: &[Row]) -> Plot {
    let grid: Vec<Row> = rows.iter().filter(|r| r.get("accelerator") == "grid").cloned().collect();
    let mut trace = Series::line("trace the view", 0, over_cells(&grid, |r| Some(r.number("median_ns")? / 1e6)));
    trace.whiskers =
        grid.iter().filter_map(|r| Some((r.number("low_ns")? / 1e6, r.number("high_ns")? / 1e6))).collect();
    Plot {
        title: "Time by resolution".into(),
        x: cells_axis(),
        y: Axis::new("time, ms", Scale::Log),
        series: vec![trace, Series::line("plan and build", 1, over_cells(&grid, |r| Some(r.number("build_s")? * 1e3)))],
        places: automatic_place(rows),
    }
}

fn bytes_plot(rows: &[Row]) -> Plot {
    let line = Series::line("cells and lists", 2, over_cells(rows, |r| Some(r.number("structure_bytes")? / 1024.0)));
    Plot {
        title: "Memory by resolution".into(),
        x: cells_axis(),
        y: Axis::new("memory, KiB", Scale::Log),
        series: vec![line],
        places: automatic_place(rows),
    }
}

fn bars(rows: &[Row]) -> Bars {
    let is_shown = |r: &&Row| r.get("accelerator") != "grid" || r.get("is_automatic") == "true";
    let bar = |r: &Row| {
        let (build, view) = (r.number("build_s")? * 1e3, r.number("view_s")? * 1e3);
        Some((r.get("accelerator").to_owned(), vec![(build, 0), (view, 1)]))
    };
    Bars {
        title: "One view, including building".into(),
        x: "time, ms".into(),
        legend: vec!["plan and build".into(), "trace the view".into()],
        bars: rows.iter().filter(is_shown).filter_map(bar).collect(),
    }
}
