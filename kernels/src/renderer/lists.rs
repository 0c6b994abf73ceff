//! The grid that a run has built.

use std::ops::ControlFlow;

use raystep_scenes::Scene;

use super::{Device, RenderError, Renderer};
use crate::options::mapping::Mapping;
use crate::options::{Accelerator, BuiltBy, LEAST_FOR_DEVICE, Options, ProgramName};
use crate::plan::{Plan, PlanError};
use crate::programs::Built;
use crate::programs::grid_build::elements::REFERENCES;
use crate::programs::grid_build::streams::{
    CELL, FAULTS, ITEM, LIST, MAP_BELOW, MAP_TOP, START, STARTS_IN_ALL, TRIANGLE_EVEN, TRIANGLE_ODD,
};
use crate::programs::primitives::radix::digits_of;
use crate::scene_data::SceneData;
use crate::structures::grid::{GridData, GridError};
use crate::structures::irregular::{self, IrregularCell, IrregularData, LAST_ITEM, Layout};
use crate::tables::elements::Elements;
use crate::tables::stream::Stream;

/// The lists of a grid, in the format of [`GridData`](crate::structures::grid::GridData).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lists {
    /// Start of each cell's list, and one entry more.
    pub cells: Vec<u32>,
    /// The lists: triangle ids, ascending within a cell.
    pub items: Vec<u32>,
}

impl Lists {
    /// The lists that a run of the build has made, once it is complete.
    ///
    /// # Errors
    /// If the run builds no grid, is not complete, or the device fails.
    pub async fn of(renderer: &Renderer) -> Result<Self, RenderError> {
        check(renderer).await?;
        let data = renderer.data();
        let mut cells = values(renderer, START).await?;
        cells.extend(values(renderer, STARTS_IN_ALL).await?);
        let is_sorted_evenly = digits_of(data.build.cells.iter().product()).is_multiple_of(2);
        let sorted = if is_sorted_evenly { TRIANGLE_EVEN } else { TRIANGLE_ODD };
        let items = if count(renderer, &REFERENCES) == 0 { Vec::new() } else { values(renderer, sorted).await? };
        Ok(Self { cells, items })
    }
}

impl IrregularData {
    /// The irregular grid, or that of two levels, that a run of the build has made, once it is complete.
    ///
    /// # Errors
    /// If the run builds no such grid, is not complete, or the device fails.
    pub async fn of(renderer: &Renderer) -> Result<Self, RenderError> {
        check(renderer).await?;
        let data = renderer.data();
        let layout = Layout::of(&data.build, &data.grid);
        let mut map = values(renderer, MAP_TOP).await?;
        map.extend(values(renderer, MAP_BELOW).await?);
        let lengths = layer(renderer, LIST, 1).await?;
        let records = renderer.values(CELL).await?;
        let cells = (0..count(renderer, CELL.info().elements)).map(|i| {
            let [xy, zx, yz, first] = [0, 1, 2, 3].map(|layer| records.get(layer, i));
            let halves = |word: u32| [word as u16, (word >> 16) as u16];
            let ([low_x, low_y], [low_z, high_x], [high_y, high_z]) = (halves(xy), halves(zx), halves(yz));
            IrregularCell { low: [low_x, low_y, low_z], high: [high_x, high_y, high_z], first }
        });
        let mut items = values(renderer, ITEM).await?;
        if items.is_empty() {
            items.push(LAST_ITEM);
        }
        let built = Self::of_buffers(&layout, map, cells.collect(), items, lengths);
        Ok(Self { bounds: data.bounds, reach: data.reach, ..built }.with_aside(&data.set_aside))
    }
}

/// Builds on the host the irregular grid, or that of two levels, whose build pass by pass this data is for.
///
/// # Errors
/// If a buffer would be larger than `most_words`.
pub fn build_on_host(data: &SceneData, most_words: u64) -> Result<IrregularData, GridError> {
    let layout = Layout::of(&data.build, &data.grid);
    let built = irregular::build_laid_out(&data.vertices, &layout, data.build.by_content(), most_words)?;
    Ok(IrregularData { bounds: data.bounds, reach: data.reach, ..built }.with_aside(&data.set_aside))
}

/// What the last passes found wrong with the grid: nothing, or it must not be used.
async fn check(renderer: &Renderer) -> Result<(), RenderError> {
    let mut faults = 0;
    for stream in FAULTS.into_iter().filter(|&stream| renderer.plan().has_stream(stream)) {
        faults += values(renderer, stream).await?.into_iter().map(u64::from).sum::<u64>();
    }
    if faults > 0 { Err(RenderError::Faulty(faults)) } else { Ok(()) }
}

impl Plan {
    /// Plans a run and prepares the data that it binds, as [`new`](Self::new); a grid is built by whom the options
    /// say ([`Options::build`]).
    ///
    /// # Errors
    /// If the scene or the options do not fit the device, or it fails.
    pub async fn on(scene: &Scene, options: &Options, device: &Device) -> Result<(Self, SceneData), RenderError> {
        let limits = device.limits();
        let is_for_device = match (options.build, options.accelerator) {
            (BuiltBy::Auto, Accelerator::Irregular) => {
                device.is_hardware() && limits.computes() && scene.triangles.len() >= LEAST_FOR_DEVICE
            }
            (BuiltBy::Device, accelerator) => matches!(accelerator, Accelerator::Grid | Accelerator::Irregular),
            _ => false,
        };
        if options.build == BuiltBy::Device && is_for_device && !limits.computes() {
            let why = "--build device needs compute shaders, which this adapter does not have: use --build host";
            return Err(PlanError::Refused(why.into()).into());
        }
        if !is_for_device || !options.traces_rays() {
            return Ok(Self::new(scene, options, &limits)?);
        }
        let building = Options {
            program: ProgramName::GridBuild,
            // A build appends to lists, so it is computed.
            mapping: Mapping::Compute,
            timings: false,
            keep_passes: false,
            ..options.clone()
        };
        let mut renderer = Renderer::new(scene, &building, device).await?;
        renderer.run(|_| ControlFlow::Continue(())).await?;
        let built = match renderer.plan().accelerator {
            Accelerator::Irregular => Built::Irregular(Box::new(IrregularData::of(&renderer).await?)),
            _ => {
                let Lists { cells, items } = Lists::of(&renderer).await?;
                let data = renderer.data();
                let (grid, growth) = (data.grid, data.growth);
                Built::Uniform { data: GridData { grid, cells, items, growth }, leaps: data.features.skip }
            }
        };
        drop(renderer);
        Ok(Self::through(scene, options, &limits, built)?)
    }
}

fn count(renderer: &Renderer, elements: &Elements) -> usize {
    renderer.size(elements).map_or(0, |size| size.count as usize)
}

/// The values of a stream with one layer, one per element.
async fn values(renderer: &Renderer, stream: Stream) -> Result<Vec<u32>, RenderError> {
    layer(renderer, stream, 0).await
}

/// The values of a layer of a stream, one per element.
async fn layer(renderer: &Renderer, stream: Stream, layer: usize) -> Result<Vec<u32>, RenderError> {
    let mut values = renderer.values(stream).await?.layer(layer).to_vec();
    values.truncate(count(renderer, stream.info().elements));
    Ok(values)
}
