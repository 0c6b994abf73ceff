//! Exchanges one numerical rule at a time, and measures what it costs and which rays it saves.
//!
//! Rays start inside the scene's box, so that the rules for origins outside do not hide the others, and are aimed where
//! the rules differ. The grid is finer than the automatic one.

use raystep_kernels::plan::Plan;
use raystep_kernels::{Accelerator, GridSize, Numerics, Options, Ray, RaySource, Rule, Skip};

use super::judge::{Judge, Judged};
use super::page::{Part, number};
use super::work::{Built, SEED, Work};
use crate::Error;
use crate::plots::{Axis, Mark, Plot, Scale, Series, Stroke};
use crate::rays::{Aim, Planes, aimed};
use crate::statistics::quantile;
use crate::tidy::{Row, Table};

pub(super) const COLUMNS: &[&str] = &[
    "schema_version",
    "scene",
    "adapter",
    "aim",
    "accelerator",
    "factor",
    "cells_x",
    "cells_y",
    "cells_z",
    "rays",
    "judged_rays",
    "missed",
    "false_hits",
    "wrong_hits",
    "undecided",
    "wrong_rays",
    "wrong_per_million",
    "wrong_per_million_low",
    "wrong_per_million_high",
    "at_bound",
    "passes",
    "repeats",
    "median_ns",
    "low_ns",
    "high_ns",
    "time_ratio",
    "clock",
];

const SHOWN: &[&str] = &[
    "aim",
    "accelerator",
    "factor",
    "judged_rays",
    "missed",
    "false_hits",
    "wrong_hits",
    "undecided",
    "wrong_per_million",
    "wrong_per_million_low",
    "wrong_per_million_high",
    "at_bound",
    "repeats",
    "median_ns",
    "time_ratio",
];

/// The robust numerics, unchanged.
const ROBUST: &str = "robust";
/// The paper's numerics.
const PAPER: &str = "paper";

/// A configuration: its name, and what it changes.
#[derive(Clone)]
struct Way {
    accelerator: Accelerator,
    factor: String,
    options: Options,
}

fn ways(rays: &RaySource, cells: GridSize) -> Vec<Way> {
    let mut ways = Vec::new();
    for accelerator in [Accelerator::Grid, Accelerator::Bvh] {
        let grid = if accelerator == Accelerator::Grid { cells } else { GridSize::Auto };
        // Only one difference at a time: some rules cannot skip empty cells, so none do.
        let skip = Skip::Off;
        let options = Options { accelerator, grid, skip, shade: false, ..Options::new(rays.clone()) };
        let mut add = |factor: &str, options: Options| ways.push(Way { accelerator, factor: factor.into(), options });
        add(ROBUST, options.clone());
        for &rule in Rule::ALL.iter().filter(|rule| has_rule(accelerator, **rule)) {
            add(&format!("without {rule}"), Options { without: Some(rule), ..options.clone() });
        }
        add(PAPER, Options { numerics: Numerics::Paper, ..options });
    }
    ways
}

/// Whether walks through this accelerator use the rule.
fn has_rule(accelerator: Accelerator, rule: Rule) -> bool {
    match rule {
        Rule::TMax | Rule::Acceptance | Rule::CellGrowth => accelerator == Accelerator::Grid,
        Rule::BoxPadding => accelerator == Accelerator::Bvh,
        Rule::TriangleTest => true,
    }
}

/// The requested resolution, or one much finer than the automatic grid along each axis with more than one cell: more
/// cell faces at which rays may be lost, and longer walks along which errors accumulate.
fn cells(work: &Work<'_>, automatic: [i32; 3]) -> [u32; 3] {
    if let GridSize::Cells(cells) = work.grid {
        return cells;
    }
    let most = work.either(1u32 << 15, 1 << 20);
    let axes = automatic.iter().filter(|&&n| n > 1).count().max(1);
    let count: f64 = automatic.iter().map(|&n| f64::from(n.max(1))).product();
    let factor = (f64::from(most) / count).powf(1.0 / axes as f64).max(1.0);
    automatic.map(|n| if n > 1 { (f64::from(n) * factor).round().min(1024.0) as u32 } else { 1 })
}

pub(super) fn run(work: &Work<'_>, table: &mut Table) -> Result<Part, Error> {
    let mut part = Part::default();
    let scene = &work.subject.scene;
    if scene.triangles.is_empty() {
        part.notes.push("the scene has no triangle to aim at".into());
        return Ok(part);
    }
    let first = table.rows.len();
    // Ray origins slightly affect the grid, so use an origin like those of the measured rays.
    let nowhere = Options { shade: false, ..Options::new(RaySource::Given(vec![some_ray(work)])) };
    let (_, data) = Plan::new(scene, &nowhere, &work.machine().limits())?;
    let cells = cells(work, data.grid.cells);
    let gridded = Options { grid: GridSize::Cells(cells), ..nowhere };
    let (_, data) = Plan::new(scene, &gridded, &work.machine().limits())?;
    let planes = Planes::of(&data);
    let count = work.either(2048, 1 << 15).min(Judge::most_rays(work));
    let aims = [Aim::Edges, Aim::Faces(&planes), Aim::Anywhere];
    for aim in aims {
        work.stage(&format!("factors, rays at {}", aim.name()));
        let rays = RaySource::Given(aimed(scene, aim, count, SEED));
        if let Err(error) = one_aim(work, aim, &ways(&rays, GridSize::Cells(cells)), table, &mut part) {
            work.can_go_on()?;
            part.notes.push(format!("rays at {}: {}", aim.name(), work.explain(&error)));
        }
    }
    let rows = &table.rows[first..];
    for aim in aims {
        part.figure(plot(aim, rows).svg()?, "");
    }
    part.table(rows, SHOWN);
    if let Some(row) = rows.iter().find(|row| !row.get("cells_x").is_empty()) {
        part.prose.push(format!(
            "The grid has {} × {} × {} cells. Times are {}; ratios are relative to robust numerics with the same \
             accelerator and the same rays, interleaved.",
            number(row.get("cells_x")),
            number(row.get("cells_y")),
            number(row.get("cells_z")),
            work.clock_in_words()
        ));
    }
    Ok(part)
}

/// A ray from the centre of the scene.
fn some_ray(work: &Work<'_>) -> Ray {
    let bounds = work.subject.scene.bounds();
    let middle = (bounds.min * 0.5 + bounds.max * 0.5).to_array();
    Ray { origin: middle, direction: [1.0, 0.0, 0.0] }
}

fn one_aim(work: &Work<'_>, aim: Aim<'_>, ways: &[Way], table: &mut Table, part: &mut Part) -> Result<(), Error> {
    let mut built: Vec<(&Way, Built)> = Vec::new();
    for way in ways {
        match work.build(&way.options) {
            Ok(ready) => built.push((way, ready)),
            Err(error) => {
                work.can_go_on()?;
                part.notes.push(format!(
                    "rays at {}, {} {}: {}",
                    aim.name(),
                    way.accelerator,
                    way.factor,
                    work.explain(&error)
                ));
            }
        }
    }
    let mut renderers: Vec<_> = built.iter_mut().map(|(_, b)| &mut b.renderer).collect();
    let times = work.time_in_turn(&mut renderers, work.either(3, 9))?;
    let robust_of = |accelerator: Accelerator| {
        built.iter().position(|(way, _)| way.accelerator == accelerator && way.factor == ROBUST)
    };
    let mut judge = Judge::default();
    for (i, (way, ready)) in built.iter().enumerate() {
        let judged: Judged = judge.judge(work, &ready.renderer)?;
        if times[i].is_given_up {
            part.notes.push(format!(
                "rays at {}, {} {}: {}",
                aim.name(),
                way.accelerator,
                way.factor,
                judged.given_up()
            ));
        }
        let ratios = robust_of(way.accelerator).map(|robust| times[i].ratios(&times[robust]));
        let [x, y, z] = ready.renderer.data().grid.cells;
        let is_grid = way.accelerator == Accelerator::Grid;
        let cells = |n: i32| is_grid.then_some(n);
        let row = work
            .row(COLUMNS)
            .set("aim", aim.name())
            .set("accelerator", way.accelerator.name())
            .set("factor", &*way.factor)
            .set("cells_x", cells(x))
            .set("cells_y", cells(y))
            .set("cells_z", cells(z))
            .set("rays", ready.renderer.plan().rays)
            .set("passes", ready.renderer.pass_count())
            .set("time_ratio", ratios.and_then(|ratios| quantile(&ratios, 0.5)))
            .set("clock", work.clock());
        table.rows.push(judged.fill(times[i].fill(row)));
    }
    Ok(())
}

fn plot(aim: Aim<'_>, rows: &[Row]) -> Plot {
    let mut factors: Vec<&str> = Vec::new();
    for row in rows {
        if !factors.contains(&row.get("factor")) {
            factors.push(row.get("factor"));
        }
    }
    let mut series = Vec::new();
    for (accelerator, mark) in [("grid", Mark::Dot), ("bvh", Mark::Triangle)] {
        for (color, factor) in factors.iter().enumerate() {
            let wanted = [("aim", aim.name()), ("accelerator", accelerator), ("factor", factor)];
            for row in rows.iter().filter(|row| row.is(&wanted)) {
                let at = (row.number("median_ns"), row.number("wrong_per_million"));
                let ends = (row.number("wrong_per_million_low"), row.number("wrong_per_million_high"));
                if let ((Some(ns), Some(wrong)), (Some(low), Some(high))) = (at, ends) {
                    series.push(Series {
                        name: format!("{accelerator}, {factor}"),
                        points: vec![(ns / 1e6, wrong)],
                        whiskers: vec![(low, high)],
                        color,
                        mark,
                        stroke: Stroke::None,
                    });
                }
            }
        }
    }
    let at = match aim {
        Aim::Edges => "Rays at edges and corners",
        Aim::Faces(_) => "Rays at surfaces where they meet the faces of cells",
        Aim::Anywhere => "Rays anywhere",
    };
    Plot {
        title: at.into(),
        x: Axis::new("time of all rays, ms", Scale::Log),
        y: Axis::new("wrong rays per million", Scale::LogWithZero),
        series,
        places: Vec::new(),
    }
}
