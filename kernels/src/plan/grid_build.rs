//! Plans a grid that is built pass by pass.

use std::collections::BTreeSet;

use raystep_scenes::Scene;

use super::check::{PlanError, check_buffer, check_rays, check_scene};
use super::{Limits, Plan, Planned, PlannedSet, housekeeping, planned_buffers, planned_streams, variants};
use crate::numbers::units::Units;
use crate::options::features::Features;
use crate::options::{Accelerator, Options, Rule};
use crate::program::sizes::derive;
use crate::programs::grid_build::elements::{CELLS, TRIANGLES};
use crate::programs::grid_build::{PROGRAM, schedule};
use crate::scene_data::{SceneData, origins, traced_vertices};
use crate::shared::build::Build;
use crate::shared::grid_walk::Grid;
use crate::structures::grid;
use crate::tables::elements::Size;
use crate::tables::sizes::fill_bytes;

/// Plans the build of the grid that the same options would trace rays through. Its resolution is decided here; the
/// length of its lists is found by the build.
pub(super) fn plan(scene: &Scene, options: &Options, limits: &Limits) -> Result<(Plan, SceneData), PlanError> {
    let units = Units::of(&scene.bounds());
    check_scene(scene, units)?;
    // The growth of cells depends on where rays begin.
    check_rays(options, units)?;
    check_buffer("vertices", 36 * scene.triangles.len() as u64, limits)?;
    let vertices = traced_vertices(scene, units);
    let is_grown = options.without != Some(Rule::CellGrowth);
    let reach = grid::reach(grid::bounds(&vertices), origins(options, units));
    let (grid, growth) = grid::planes(&vertices, options.grid, reach, is_grown, limits.storage_bytes / 4)?;
    of(grid, growth, vertices, units, options, limits)
}

/// Plans the build of the lists of a grid over these triangles.
pub(crate) fn of(
    grid: Grid,
    growth: f32,
    vertices: Vec<f32>,
    units: Units,
    options: &Options,
    limits: &Limits,
) -> Result<(Plan, SceneData), PlanError> {
    let triangles = (vertices.len() / 9) as u64;
    let features = Features { grid: true, robust: true, ..Features::default() };
    let build = Build::new(&grid, growth, triangles as u32);
    let data = SceneData { features, units, grid, growth, build, vertices, ..SceneData::default() };

    let cells: u64 = build.cells.iter().map(|&n| u64::from(n)).product();
    let fold = |elements: &str, count: u64| {
        let fits = Size::folded(count, limits.image_side);
        fits.ok_or_else(|| PlanError::TooMany { elements: elements.to_owned(), count, side: limits.image_side })
    };
    let mut known = vec![None; PROGRAM.elements.len()];
    for (size, elements) in known.iter_mut().zip(PROGRAM.elements) {
        if elements.name == TRIANGLES.name {
            *size = Some(fold(elements.name, triangles)?);
        } else if elements.name == CELLS.name {
            *size = Some(fold(elements.name, cells)?);
        }
    }
    derive(&PROGRAM, &mut known, limits.image_side).map_err(|error| PlanError::TooMany {
        elements: error.elements.to_owned(),
        count: error.count,
        side: limits.image_side,
    })?;
    let sets: Vec<_> = PROGRAM.elements.iter().zip(known).map(|(&what, size)| PlannedSet { what, size }).collect();
    let schedule = schedule::of(cells as u32);
    let variants = variants(&PROGRAM, &schedule, &features)?;
    let bound: BTreeSet<&str> = variants.iter().flat_map(|v| &v.bindings).map(|b| b.name.as_str()).collect();
    let size = sets[0].size.unwrap_or(Size { width: 1, height: 1, count: 0 });
    let streams = planned_streams(&PROGRAM, &sets, &bound);
    let mut buffers = planned_buffers(&PROGRAM, &bound, &data, limits)?;
    buffers.extend(housekeeping(&PROGRAM, &bound, size.texels()));
    buffers.push(Planned { what: "fill", bytes: fill_bytes(size, sets.len(), PROGRAM.streams) });
    let mut plan = Plan {
        program: &PROGRAM,
        sets,
        image_side: limits.image_side,
        most_elements: limits.rays.min(limits.storage_bytes / 4),
        width: size.width,
        height: size.height,
        rays: triangles,
        triangles,
        accelerator: Accelerator::Grid,
        features,
        pass_bound: schedule.steps.len() as u64,
        schedule,
        variants,
        streams,
        buffers,
        left_out: Vec::new(),
    };
    plan.left_out = super::decide::absent(&plan, options);
    Ok((plan, data))
}
