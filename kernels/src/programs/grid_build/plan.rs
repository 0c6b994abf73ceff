//! Plans a grid that is built pass by pass.

use raystep_scenes::Scene;

use super::PROGRAM;
use super::elements::{CELLS, TRIANGLES, WHOLE};
use super::schedule::{self, Kind};
use crate::numbers::units::Units;
use crate::options::features::Features;
use crate::options::{Accelerator, Options, Rule};
use crate::plan::over::{Over, in_rows};
use crate::plan::{Limits, Plan, PlanError, check_list, check_rays, check_scene};
use crate::programs::closest_hit::plan::features::features;
use crate::programs::closest_hit::plan::resolve::{self, ChosenGrid};
use crate::scene_data::{Contents, SceneData, origins, traced_vertices};
use crate::shared::build::Build;
use crate::shared::grid_walk::Grid;
use crate::structures::grid;
use crate::structures::irregular::{Layout, Site};

/// Plans the build of the grid that the same options would trace rays through. Its resolution is decided here; the
/// length of its lists is found by the build.
pub(in crate::programs) fn plan(
    scene: &Scene,
    options: &Options,
    limits: &Limits,
) -> Result<(Plan, SceneData), PlanError> {
    if matches!(options.accelerator, Accelerator::Bvh | Accelerator::None) {
        return Err(PlanError::NotBuilt(options.accelerator));
    }
    let units = Units::of(scene);
    check_scene(scene, units)?;
    // The growth of cells depends on where rays begin.
    check_rays(options, units)?;
    check_list("vertices", 36 * scene.triangles.len() as u64, options.scene_data, limits)?;
    let vertices = traced_vertices(scene, units);
    let is_grown = options.without != Some(Rule::CellGrowth);
    let most_words = limits.list_words(options.scene_data);
    let origins = origins(options, units);
    if options.accelerator == Accelerator::Irregular {
        let Site { vertices, aside, extent, layout, .. } = Site::new(&vertices, origins, is_grown, most_words)?;
        let (plan, mut data) = of(&What::Irregular(layout), vertices.into_owned(), units, options, limits)?;
        data.set_aside = aside;
        (data.bounds, data.reach) = extent;
        return Ok((plan, data));
    }
    let bounds = grid::bounds(&vertices);
    let reach = grid::reach(bounds, origins);
    let site = resolve::Site { options, vertices: &vertices, origins, reach, most_words };
    let features = features(scene, options, Accelerator::Grid, units);
    // The last candidate is always suited.
    let what = match site.choose(&features, true)? {
        Some(ChosenGrid::TwoLevels(counted)) => {
            What::TwoLevels(Layout::below(&vertices, reach, is_grown, counted.cells()))
        }
        Some(ChosenGrid::Uniform { counted, leaps }) => {
            What::Uniform { grid: *counted.grid(), growth: counted.growth(), leaps }
        }
        None => return Err(PlanError::NotBuilt(options.accelerator)),
    };
    let (plan, mut data) = of(&what, vertices, units, options, limits)?;
    (data.bounds, data.reach) = (bounds, reach);
    Ok((plan, data))
}

/// A grid before its lists are filled.
pub(crate) enum What {
    /// A uniform grid, the growth of its cells, and whether rays leap over empty ones.
    Uniform { grid: Grid, growth: f32, leaps: bool },
    /// A uniform grid whose crowded cells hold finer ones.
    TwoLevels(Layout),
    /// An irregular grid.
    Irregular(Layout),
}

impl What {
    fn kind(&self) -> Kind {
        match self {
            Self::Uniform { .. } => Kind::Uniform,
            Self::TwoLevels(_) => Kind::TwoLevels,
            Self::Irregular(_) => Kind::Irregular,
        }
    }
}

/// Plans the build of a grid over these triangles.
pub(crate) fn of(
    what: &What,
    vertices: Vec<f32>,
    units: Units,
    options: &Options,
    limits: &Limits,
) -> Result<(Plan, SceneData), PlanError> {
    let triangles = (vertices.len() / 9) as u64;
    let (grid, growth, build) = match what {
        What::Uniform { grid, growth, .. } => (*grid, *growth, Build::new(grid, *growth, triangles as u32)),
        What::TwoLevels(layout) => (layout.at(0), layout.growth, layout.build(triangles as u32, false)),
        What::Irregular(layout) => (layout.at(0), layout.growth, layout.build(triangles as u32, true)),
    };
    let is_uniform = what.kind() == Kind::Uniform;
    let skip = matches!(what, What::Uniform { leaps: true, .. });
    let features = Features {
        grid: is_uniform,
        irregular: !is_uniform,
        skip,
        robust: true,
        scene_data: options.scene_data,
        ..Features::default()
    };
    let data = SceneData::new(features, Contents { units, grid, growth, build, vertices, ..Contents::default() });

    let cells: u64 = build.cells.iter().map(|&n| u64::from(n)).product();
    let sizes = [in_rows(&TRIANGLES, triangles, limits)?, in_rows(&CELLS, cells, limits)?, in_rows(&WHOLE, 1, limits)?];
    let run = Over {
        program: &PROGRAM,
        schedule: schedule::of(what.kind(), cells as u32),
        sizes: &sizes,
        accelerator: if is_uniform { Accelerator::Grid } else { Accelerator::Irregular },
    };
    Ok((run.plan(&data, options, limits)?, data))
}
