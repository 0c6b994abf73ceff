//! The lists of a grid that a run has built.

use super::{RenderError, Renderer};
use crate::programs::grid_build::elements::REFERENCES;
use crate::programs::grid_build::radix::digits_of;
use crate::programs::grid_build::streams::{START, STARTS_IN_ALL, TRIANGLE_EVEN, TRIANGLE_ODD};
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
        let data = renderer.data();
        let mut cells = values(renderer, START).await?;
        cells.extend(values(renderer, STARTS_IN_ALL).await?);
        let is_sorted_evenly = digits_of(data.build.cells.iter().product()).is_multiple_of(2);
        let sorted = if is_sorted_evenly { TRIANGLE_EVEN } else { TRIANGLE_ODD };
        let items = if count(renderer, &REFERENCES) == 0 { Vec::new() } else { values(renderer, sorted).await? };
        Ok(Self { cells, items })
    }
}

fn count(renderer: &Renderer, elements: &Elements) -> usize {
    renderer.size(elements).map_or(0, |size| size.count as usize)
}

/// The values of a stream with one layer, one per element.
async fn values(renderer: &Renderer, stream: Stream) -> Result<Vec<u32>, RenderError> {
    let mut values = renderer.values(stream).await?.bits;
    values.truncate(count(renderer, stream.info().elements));
    Ok(values)
}
