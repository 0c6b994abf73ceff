//! Decides through which acceleration structure a run traces its scene, and the options of the kernels that follow.

use raystep_scenes::Scene;

use super::features::features;
use crate::numbers::units::Units;
use crate::options::features::{Features, StructureKind};
use crate::options::{Accelerator, GridSize, MOST_LISTED, MOST_LISTED_IN_ONE_LEVEL, Options, Rule, ScheduleKind, Skip};
use crate::plan::{Limits, PlanError, check_buffer, check_list};
use crate::program::Program;
use crate::program::live::{LIVE_RAYS, live_bytes};
use crate::scene_data::{bvh_growth, origins, traced_vertices};
use crate::structures::bvh::{self, BvhOptions, BvhQuality, Padding};
use crate::structures::grid::{Corners, CountedGrid, GridData};
use crate::structures::irregular::IrregularData;
use crate::structures::{Structure, grid, irregular};

/// A structure that was built, and the decisions that go with it.
pub(super) struct Resolved {
    /// The accelerator; never [`Accelerator::Auto`].
    pub(super) accelerator: Accelerator,
    /// The options of the kernels, except those that depend on iterations of their loops.
    pub(super) features: Features,
    /// The structure.
    pub(super) structure: Structure,
    /// Corners in traced units, nine floats per triangle.
    pub(super) vertices: Vec<f32>,
    /// What the structure is built for.
    pub(super) extent: Extent,
}

/// The sizes that growth depends on, in traced units.
#[derive(Clone, Copy, Default)]
pub(super) struct Extent {
    /// The box of all corners.
    pub(super) bounds: Corners,
    /// Bounds distances, see [`grid::reach`].
    pub(super) reach: f32,
}

/// The input of building a structure.
pub(in crate::programs) struct Site<'a> {
    pub(in crate::programs) options: &'a Options,
    pub(in crate::programs) vertices: &'a [f32],
    /// The box of all ray origins.
    pub(in crate::programs) origins: Option<Corners>,
    /// Bounds distances, see [`grid::reach`].
    pub(in crate::programs) reach: f32,
    /// Size of the executor's largest buffer, in 32-bit words.
    pub(in crate::programs) most_words: u64,
}

/// A grid whose resolution is chosen, with its lists counted.
pub(in crate::programs) enum ChosenGrid {
    /// A uniform one, with or without distances for empty-space skipping.
    Uniform { counted: CountedGrid, leaps: bool },
    /// One whose crowded cells are divided. It is walked as an irregular one.
    TwoLevels(CountedGrid),
}

/// A grid that is built.
pub(crate) enum Built {
    /// A uniform one, with or without distances for empty-space skipping.
    Uniform { data: GridData, leaps: bool },
    /// An irregular one, or one of two levels.
    Irregular(Box<IrregularData>),
}

/// The structure of a grid, and the features that follow from it.
fn adopt(mut features: Features, built: Built) -> (Features, Structure) {
    match built {
        Built::Uniform { data, leaps } => {
            features.skip = leaps;
            let distances = if leaps { grid::distances(&data.grid, &data.cells) } else { Vec::new() };
            (features, Structure::Grid { data, distances })
        }
        Built::Irregular(data) => {
            (features.grid, features.irregular) = (false, true);
            features.aside = data.aside > 0;
            // The grid is smaller than the scene, so rays may start outside of it.
            features.clip |= features.aside;
            (features, Structure::Irregular(*data))
        }
    }
}

/// Builds the first of the requested accelerators that suits the scene. `built` stands for the first one.
///
/// # Errors
/// If none of them can be built, or the scene does not fit `limits`.
pub(super) fn resolve(
    program: &Program,
    scene: &Scene,
    options: &Options,
    units: Units,
    limits: &Limits,
    (width, height): (u32, u32),
    mut built: Option<Built>,
) -> Result<Resolved, PlanError> {
    let mut corners = None;
    let mut candidates = options.accelerator.candidates(scene.triangles.len(), limits.is_gpu).iter();
    loop {
        let accelerator = candidates.next().copied().unwrap_or_default();
        let is_last = candidates.as_slice().is_empty();
        let features = features(scene, options, accelerator, units);
        let attempt = check_sizes(program, scene, options, &features, limits, u64::from(width) * u64::from(height));
        let attempt = attempt.and_then(|()| {
            let (vertices, origins, extent) = corners.get_or_insert_with(|| {
                let vertices = traced_vertices(scene, units);
                let bounds = grid::bounds(&vertices);
                let origins = origins(options, units);
                let origins = if features.photons { Some(with_photons(bounds, origins)) } else { origins };
                (vertices, origins, Extent { bounds, reach: grid::reach(bounds, origins) })
            });
            let most_words = limits.list_words(options.scene_data);
            let site = Site { options, vertices, origins: *origins, reach: extent.reach, most_words };
            match built.take() {
                Some(built) => Ok(Some(adopt(features, built))),
                None => site.build(features, is_last),
            }
        });
        match attempt {
            Ok(Some((features, structure))) => {
                let (vertices, _, whole) = corners.unwrap_or_default();
                let extent = match &structure {
                    Structure::Irregular(data) => Extent { bounds: data.bounds, reach: data.reach },
                    _ => whole,
                };
                return Ok(Resolved { accelerator, features, structure, vertices, extent });
            }
            Err(error) if is_last => return Err(error),
            Ok(None) | Err(_) => {}
        }
    }
}

/// The box of all ray origins, with those of photons: they begin on surfaces, or in a sphere about the scene, or miss it.
fn with_photons(bounds: Corners, origins: Option<Corners>) -> Corners {
    let diagonal = (0..3).map(|axis| (bounds[1][axis] - bounds[0][axis]).powi(2)).sum::<f32>().sqrt();
    let [low, high] =
        [-diagonal, diagonal].map(|far| [0, 1, 2].map(|axis| 0.5 * (bounds[0][axis] + bounds[1][axis]) + far));
    let [first, last] = origins.unwrap_or([low, high]);
    [[0, 1, 2].map(|axis| low[axis].min(first[axis])), [0, 1, 2].map(|axis| high[axis].max(last[axis]))]
}

/// Rejects what is known to be too large before anything is built.
fn check_sizes(
    program: &Program,
    scene: &Scene,
    options: &Options,
    features: &Features,
    limits: &Limits,
    texels: u64,
) -> Result<(), PlanError> {
    let triangles = scene.triangles.len() as u64;
    let corners = if options.schedule == ScheduleKind::Fused || features.many_steps {
        ("packed_triangles", 48)
    } else {
        ("vertices", 36)
    };
    for (name, bytes, is_used) in [
        (corners.0, corners.1, true),
        ("normals", 36, features.normals),
        ("texcoords", 24, features.textures),
        ("vertex_colors", 36, features.vertex_colors),
    ] {
        if is_used && (name == corners.0 || options.shade) {
            check_list(name, triangles * bytes, options.scene_data, limits)?;
        }
    }
    if let GridSize::Cells(cells) = options.grid
        && features.grid
    {
        check_list("grid_cells", 4 * (grid::check_cells(cells)? + 1), options.scene_data, limits)?;
    }
    if features.live_lists {
        check_buffer(LIVE_RAYS, live_bytes(program, texels), limits)?;
    }
    Ok(())
}

impl Site<'_> {
    /// Builds the structure that `features` name, and the features that follow from it. `None` for a grid if another
    /// accelerator suits the scene better; the last candidate is always built.
    fn build(&self, mut features: Features, is_last: bool) -> Result<Option<(Features, Structure)>, PlanError> {
        let structure = match features.structure() {
            StructureKind::None => Structure::None,
            StructureKind::Grid => match self.grid(&mut features, is_last)? {
                Some(structure) => structure,
                None => return Ok(None),
            },
            StructureKind::Irregular => {
                let data = irregular::build(self.vertices, self.origins, self.is_grown(), self.most_words)?;
                return Ok(Some(adopt(features, Built::Irregular(Box::new(data)))));
            }
            StructureKind::Bvh => self.tree(&mut features)?,
        };
        if let Structure::Wide(tree) = &structure {
            // The root is not pushed, and a node's siblings wait on the stack while its children are visited.
            (features.wide, features.stack) = (true, tree.depth.saturating_sub(1));
        }
        Ok(Some((features, structure)))
    }

    fn is_grown(&self) -> bool {
        self.options.without != Some(Rule::CellGrowth)
    }

    /// Builds the grid.
    fn grid(&self, features: &mut Features, is_last: bool) -> Result<Option<Structure>, PlanError> {
        let Self { vertices, reach, most_words, .. } = *self;
        let Some(chosen) = self.choose(features, is_last)? else { return Ok(None) };
        let built = match chosen {
            ChosenGrid::TwoLevels(counted) => {
                match irregular::build_two_levels(vertices, counted.cells(), reach, self.is_grown(), most_words) {
                    Ok(data) => Built::Irregular(Box::new(data)),
                    // If it does not fit, one level does.
                    Err(_) => Built::Uniform { data: counted.fill(vertices), leaps: false },
                }
            }
            ChosenGrid::Uniform { counted, leaps } => Built::Uniform { data: counted.fill(vertices), leaps },
        };
        let (adopted, structure) = adopt(*features, built);
        *features = adopted;
        Ok(Some(structure))
    }

    /// Chooses a grid's resolution: the counts of its lists tell whether most of its cells are empty, or a few of them
    /// crowded, before they are filled. `None` if another accelerator suits the scene better.
    pub(in crate::programs) fn choose(
        &self,
        features: &Features,
        is_last: bool,
    ) -> Result<Option<ChosenGrid>, PlanError> {
        let Self { options, vertices, reach, most_words, .. } = *self;
        let counted = grid::count_lists(vertices, options.grid, reach, self.is_grown(), most_words)?;
        let is_sparse = counted.is_sparse();
        let listed = counted.weighted_list();
        if !is_last && (is_sparse || listed > MOST_LISTED) {
            return Ok(None);
        }
        let is_automatic = (options.grid, options.skip) == (GridSize::Auto, Skip::Auto);
        let may_divide = is_automatic && features.keeps_no_tmax() && !features.in_cell;
        if may_divide && listed > MOST_LISTED_IN_ONE_LEVEL {
            return Ok(Some(ChosenGrid::TwoLevels(counted)));
        }
        let leaps = features.keeps_no_tmax()
            && match options.skip {
                Skip::On => true,
                Skip::Off => false,
                Skip::Auto => is_sparse,
            };
        // Empty-space skipping is faster through a finer grid, if the resolution is automatic.
        let counted = match options.grid {
            GridSize::Auto if leaps => {
                drop(counted);
                grid::count_lists_for_leaps(vertices, reach, most_words)?
            }
            _ => counted,
        };
        Ok(Some(ChosenGrid::Uniform { counted, leaps }))
    }

    fn tree(&self, features: &mut Features) -> Result<Structure, PlanError> {
        let Self { options, vertices, reach, most_words, .. } = *self;
        let padding = if options.without == Some(Rule::BoxPadding) {
            Padding::Fixed(0.0)
        } else if features.ray_padding {
            Padding::PerRay
        } else {
            Padding::suits(vertices, bvh_growth(reach))
        };
        features.ray_padding = padding == Padding::PerRay;
        let how = BvhOptions { most_words, quality: BvhQuality::for_triangles((vertices.len() / 9) as u64) };
        Ok(if options.schedule == ScheduleKind::Fused {
            Structure::Wide(bvh::build_wide(vertices, padding, &how)?)
        } else {
            Structure::Bvh(bvh::build(vertices, padding, &how)?)
        })
    }
}
