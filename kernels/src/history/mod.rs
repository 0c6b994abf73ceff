//! The history of one ray: a row for every pass that worked on it, read from the executor's own streams, with the
//! reason for what it did in words and numbers.

mod alone;
pub mod light_tree;
pub mod units;

use std::fmt;
use std::ops::ControlFlow;
use std::sync::Arc;

pub use alone::RunSoFar;

use crate::executor::cpu::Interpreted;
use crate::interpret::Element;
use crate::options::features::StructureKind;
use crate::plan::Plan;
pub use crate::program::RayState;
use crate::program::{Decoding, Kernel};
use crate::renderer::{Pass, RenderError, Renderer};
use crate::scene_data::SceneData;
use crate::shared::grid_walk::Grid;
use crate::tables::elements::Elements;
use crate::tables::stream::Stream;

/// The effect of one pass on the ray.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct TraceRow {
    /// The pass's index in the run of all rays; `None` for a pass that waits for the last ray's walk, if only this ray
    /// was traced.
    pub pass: Option<usize>,
    /// Name of its kernel.
    pub kernel: &'static str,
    /// The ray's state before it.
    pub state_before: &'static str,
    /// Cell (x, y, z) of a uniform grid that a pass of the walk works in: where the ray is before it.
    pub cell_before: Option<[i32; 3]>,
    /// The triangle tested by the pass, if any.
    pub tested: Option<u32>,
    /// The ray after the pass.
    pub after: RayState,
    /// Cell (x, y, z) of a uniform grid that the ray is in after the pass; `None` before and after its walk.
    pub cell_after: Option<[i32; 3]>,
    /// The same as a 1-D index; with an irregular grid its cell, with a BVH its node.
    pub index_after: Option<u32>,
    /// The reason, in words.
    pub why: String,
    /// What a user's kernel has printed, as `label = value`.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Vec::is_empty"))]
    pub notes: Vec<String>,
}

/// The history of one ray.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Trace {
    /// Pixel (x, y); for input rays, in the image they fill row by row. For another element, its texel.
    pub pixel: [u32; 2],
    /// The element of another set that walks as rays do, whose history it is; `None` for a ray.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub element: Option<NamedElement>,
    /// Scene units per traced unit: multiply lengths by this.
    pub scene_units_per_stream_unit: f64,
    /// Then add this to points, for the coordinates of the scene's file.
    pub scene_offset: [f64; 3],
    /// Multiply t by this to get t along the ray as the caller gave it.
    pub t_scale: f64,
    /// Number of rays traced: this one alone, or all of the run.
    pub rays: u64,
    /// Number of passes of the run of all rays, if all were traced; the ray waited in those that have no row.
    pub passes: Option<usize>,
    /// The uniform grid that the ray walks through, if there is one.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub grid: Option<TraceGrid>,
    /// The rows.
    pub rows: Vec<TraceRow>,
}

/// An element of a set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct NamedElement {
    /// The set, in the plural.
    pub set: &'static str,
    /// Its index, from 0.
    pub index: u32,
}

impl NamedElement {
    /// What one of the set is called.
    #[must_use]
    pub fn noun(&self) -> &'static str {
        self.set.strip_suffix('s').unwrap_or(self.set)
    }
}

impl fmt::Display for NamedElement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.noun(), self.index)
    }
}

/// What initial tMax and tDelta are computed from, in traced units.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct TraceGrid {
    /// Lower corner of cell (0, 0, 0).
    pub corner: [f32; 3],
    /// Cells along each axis.
    pub cells: [i32; 3],
    /// Size of a cell.
    pub width: [f32; 3],
}

/// Which rays to trace for the history of one ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rays {
    /// The ray alone, if [that is possible](Renderer::can_go_alone), else all. Its rows are those of the run of all
    /// rays, bit for bit, except for what depends on the other rays: the number of passes, and the indices of those
    /// that wait for the last ray's walk.
    One,
    /// All rays of the run.
    All,
}

/// Steps `renderer` from its first pass to its last and records one ray. `progress` is called after every pass and may
/// stop the run.
///
/// # Errors
/// If the image has no such pixel, the device fails, or `progress` stopped the run.
pub async fn trace(
    renderer: &mut Renderer,
    x: u32,
    y: u32,
    rays: Rays,
    progress: impl FnMut(&Pass) -> ControlFlow<()>,
) -> Result<Trace, RenderError> {
    let follower = Follower::begin(renderer, [x, y], rays).await?;
    follow(follower, renderer, progress).await
}

/// The same for an element of another set that walks through the scene as rays do, counted from 0. All elements are traced.
///
/// # Errors
/// If the run has no such element, the device fails, or `progress` stopped the run.
pub async fn trace_element(
    renderer: &mut Renderer,
    set: &Elements,
    index: u32,
    progress: impl FnMut(&Pass) -> ControlFlow<()>,
) -> Result<Trace, RenderError> {
    let follower = Follower::of_element(renderer, set, index).await?;
    follow(follower, renderer, progress).await
}

async fn follow(
    mut follower: Follower,
    renderer: &mut Renderer,
    mut progress: impl FnMut(&Pass) -> ControlFlow<()>,
) -> Result<Trace, RenderError> {
    while let Some(pass) = follower.step(renderer).await? {
        if progress(&pass).is_break() {
            return Err(RenderError::Cancelled { passes: renderer.pass_count() });
        }
    }
    Ok(follower.finish(renderer))
}

/// Records one ray while a run is stepped: [`trace`] in pieces.
#[derive(Clone, Debug)]
pub struct Follower {
    of: Decoding,
    pixel: [u32; 2],
    is_alone: bool,
    before: RayState,
    rows: Vec<TraceRow>,
    /// Kernels that run only after the last ray's walk.
    after_all: Vec<Kernel>,
    /// The kernels that are a user's.
    interpreted: Arc<[Interpreted]>,
}

impl Follower {
    /// Returns a run to before its first pass.
    ///
    /// # Errors
    /// If the image has no such pixel, or the device fails.
    pub async fn begin(renderer: &mut Renderer, [x, y]: [u32; 2], rays: Rays) -> Result<Self, RenderError> {
        // If there is only one input ray, it is the whole run.
        let is_alone = rays == Rays::One && renderer.plan().rays > 1 && renderer.restart_alone(x, y)?;
        if !is_alone {
            renderer.restart();
        }
        let plan = renderer.plan();
        let of = plan.program.rays.ok_or(RenderError::NoRays(plan.program.name))?;
        Self::new(renderer, of, [x, y], is_alone).await
    }

    /// The same for an element of another set: all are traced.
    ///
    /// # Errors
    /// If the run has no such element, or the device fails.
    pub async fn of_element(renderer: &mut Renderer, set: &Elements, index: u32) -> Result<Self, RenderError> {
        let (of, texel) = texel_of(renderer, set, index)?;
        renderer.restart();
        Self::new(renderer, of, texel, false).await
    }

    async fn new(renderer: &Renderer, of: Decoding, pixel: [u32; 2], is_alone: bool) -> Result<Self, RenderError> {
        let before = state_of(renderer, &of, pixel).await?;
        let after_all = after_all(renderer.plan());
        let interpreted = Interpreted::of(renderer.plan()).into();
        Ok(Self { of, pixel, is_alone, before, rows: Vec::new(), after_all, interpreted })
    }

    /// Runs a pass; `None` at the end of the run.
    ///
    /// # Errors
    /// If the device fails.
    pub async fn step(&mut self, renderer: &mut Renderer) -> Result<Option<Pass>, RenderError> {
        let [x, y] = self.pixel;
        let next = renderer.next_kernel().filter(|kernel| kernel.takes().contains(&self.before.tag));
        let printing = next.and_then(|kernel| Interpreted::printing(&self.interpreted, kernel));
        let given = match printing {
            Some(code) => Some((code, renderer.texels(code.streams(), x, y).await?.concat())),
            None => None,
        };
        let Some(pass) = renderer.step().await? else { return Ok(None) };
        // A kernel leaves every ray alone that is not in its states, so there is nothing to read back.
        if pass.kernel.takes().contains(&self.before.tag) {
            let after = state_of(renderer, &self.of, self.pixel).await?;
            let mut row = TraceRow::new(&pass, renderer.data(), &self.before, &after);
            if let Some((code, mut texels)) = given {
                let data = pass.kernel.reads(renderer.data());
                let (mut counter, size) = (code.counter(&data), [renderer.plan().width, renderer.plan().height]);
                if counter.run(Element { texel: [x, y], size }, &mut texels).is_ok() {
                    row.notes = counter.told();
                }
            }
            row.pass = row.pass.filter(|_| !(self.is_alone && self.after_all.contains(&pass.kernel)));
            self.rows.push(row);
            self.before = after;
        }
        Ok(Some(pass))
    }

    /// The history, at the end of the run.
    #[must_use]
    pub fn finish(self, renderer: &Renderer) -> Trace {
        let whole = Trace::of(renderer, &self.of, self.pixel, self.rows);
        if self.is_alone { Trace { rays: 1, passes: None, ..whole } } else { whole }
    }
}

/// Kernels that run only after the last ray's walk: when that is depends on all rays.
fn after_all(plan: &Plan) -> Vec<Kernel> {
    let kernels = plan.schedule.kernels();
    let walk = kernels.iter().rposition(|kernel| kernel.is_walk()).map_or(0, |last| last + 1);
    kernels[walk..].to_vec()
}

/// Decodes a ray's texels as they are now.
///
/// # Errors
/// If the image has no such pixel, or the device fails.
pub async fn ray_state(renderer: &Renderer, x: u32, y: u32) -> Result<RayState, RenderError> {
    let plan = renderer.plan();
    let rays = plan.program.rays.ok_or(RenderError::NoRays(plan.program.name))?;
    state_of(renderer, &rays, [x, y]).await
}

/// How an element of a set that walks as rays do is decoded, and its texel.
///
/// # Errors
/// If the run has no such element.
pub fn texel_of(renderer: &Renderer, set: &Elements, index: u32) -> Result<(Decoding, [u32; 2]), RenderError> {
    let program = renderer.plan().program;
    let of = program.decoding_of(set).ok_or(RenderError::NoRays(program.name))?;
    let missing = |count| RenderError::NoElement { elements: of.elements().map_or("", |set| set.name), index, count };
    let size = renderer.size(set).ok_or_else(|| missing(0))?;
    if index >= size.count {
        return Err(missing(size.count));
    }
    Ok((of, [index % size.width, index / size.width]))
}

/// Decodes an element's texels as they are now.
///
/// # Errors
/// If there is no such texel, or the device fails.
pub async fn state_of(renderer: &Renderer, of: &Decoding, [x, y]: [u32; 2]) -> Result<RayState, RenderError> {
    let streams: Vec<Stream> = of.streams.iter().copied().filter(|&s| renderer.plan().has_stream(s)).collect();
    let texels = renderer.texels(&streams, x, y).await?;
    Ok((of.decode)(&|stream| streams.iter().position(|&s| s == stream).map(|i| texels[i].as_slice())))
}

impl TraceRow {
    /// Describes what a pass did to a ray that it worked on.
    #[must_use]
    pub fn new(pass: &Pass, data: &SceneData, before: &RayState, after: &RayState) -> Self {
        let structure = data.features.structure();
        let is_grid = structure == StructureKind::Grid;
        let has_places = structure != StructureKind::None;
        let index_after = (has_places && after.is_walking).then_some(after.cell_index);
        let (tested, why) = pass.kernel.explain(data, before, after);
        Self {
            pass: Some(pass.index),
            kernel: pass.kernel.name(),
            state_before: before.state,
            cell_before: (is_grid && pass.kernel.is_walk()).then(|| data.grid.cell_of_index(before.cell_index)),
            tested,
            after: *after,
            cell_after: index_after.filter(|_| is_grid).map(|index| data.grid.cell_of_index(index)),
            index_after,
            why,
            notes: Vec::new(),
        }
    }

    /// What was printed, to be appended to a sentence.
    #[must_use]
    pub fn noted(&self) -> String {
        self.notes.iter().map(|note| format!("; {note}")).collect()
    }

    /// Whether the pass is known to be among the first `passes` of the run.
    #[must_use]
    pub fn is_within(&self, passes: usize) -> bool {
        self.pass.is_some_and(|pass| pass < passes)
    }

    /// Number of passes of the run up to and including this one, if known.
    #[must_use]
    pub fn place(&self) -> Option<usize> {
        self.pass.map(|pass| pass + 1)
    }

    /// The pass's index; without one it is the run's last.
    #[must_use]
    pub fn number(&self) -> String {
        self.pass.map_or_else(|| "last".into(), |pass| pass.to_string())
    }
}

impl TraceGrid {
    fn of(data: &SceneData) -> Option<Self> {
        let Grid { corner, cells, width, .. } = data.grid;
        data.features.grid.then_some(Self { corner, cells, width })
    }

    /// tDelta per axis, the t between two planes of the grid; `None` for an axis that the direction is parallel to.
    #[must_use]
    pub fn t_delta(&self, direction: [f32; 3]) -> [Option<f32>; 3] {
        [0, 1, 2].map(|axis| Some((self.width[axis] / direction[axis]).abs()).filter(|t| t.is_finite()))
    }
}

impl Trace {
    /// Whose it is: `pixel 3,5`, or `photon 12`.
    #[must_use]
    pub fn name(&self) -> String {
        let [x, y] = self.pixel;
        self.element.map_or_else(|| format!("pixel {x},{y}"), |element| element.to_string())
    }

    /// A point in scene units, in traced units.
    #[must_use]
    pub fn traced(&self, point: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|axis| (point[axis] - self.scene_offset[axis]) / self.scene_units_per_stream_unit)
    }

    /// The same for what is decoded so: a ray, or an element of another set.
    #[must_use]
    pub fn of(renderer: &Renderer, of: &Decoding, [x, y]: [u32; 2], rows: Vec<TraceRow>) -> Self {
        let (all, of) = (renderer.plan().program.elements, of.elements());
        let others = all.iter().skip(1).find(|set| of.is_some_and(|of| of.name == set.name));
        let named =
            others.and_then(|set| Some(NamedElement { set: set.name, index: y * renderer.size(set)?.width + x }));
        Self { element: named, ..Self::new(renderer, [x, y], rows) }
    }

    /// The rows of a ray, from a run that is complete.
    #[must_use]
    pub fn new(renderer: &Renderer, [x, y]: [u32; 2], rows: Vec<TraceRow>) -> Self {
        let units = renderer.data().units;
        let scene_units_per_stream_unit = units.scene_units_per_stream_unit();
        let t_scale = renderer.t_scale(y as usize * renderer.plan().width as usize + x as usize);
        let (rays, passes) = (renderer.plan().rays, Some(renderer.pass_count()));
        let scene_offset = units.offset.to_array();
        let grid = TraceGrid::of(renderer.data());
        let (pixel, element) = ([x, y], None);
        Self { pixel, element, scene_units_per_stream_unit, scene_offset, t_scale, rays, passes, grid, rows }
    }
}
