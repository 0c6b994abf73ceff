//! A grid that the program `grid-build` has built, and the one that the host builds.

use raystep_kernels::renderer::{Lists, build_on_host};
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::structures::grid::{self, GridData, GridError};
use raystep_kernels::structures::irregular::IrregularData;
use raystep_kernels::{Accelerator, RenderError, Renderer};

/// A grid that was built.
#[derive(PartialEq)]
pub enum Built {
    /// One level.
    Uniform(Lists),
    /// Irregular, or of two levels.
    Irregular(Box<IrregularData>),
}

impl Built {
    /// The result of a build that has run to its end.
    ///
    /// # Errors
    /// If the device fails, or the build has found a fault in its grid.
    pub async fn of(renderer: &Renderer) -> Result<Self, RenderError> {
        Ok(match renderer.plan().accelerator {
            Accelerator::Irregular => Self::Irregular(Box::new(IrregularData::of(renderer).await?)),
            _ => Self::Uniform(Lists::of(renderer).await?),
        })
    }

    /// The same as the host builds it, with so many words a buffer.
    ///
    /// # Errors
    /// If it does not fit them.
    pub fn on_host(renderer: &Renderer, most_words: u64) -> Result<Self, GridError> {
        let data: &SceneData = renderer.data();
        if renderer.plan().accelerator == Accelerator::Irregular {
            return Ok(Self::Irregular(Box::new(build_on_host(data, most_words)?)));
        }
        let GridData { cells, items, .. } = grid::lists(&data.grid, data.growth, &data.vertices, most_words)?;
        Ok(Self::Uniform(Lists { cells, items }))
    }
}
