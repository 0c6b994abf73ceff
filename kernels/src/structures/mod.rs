//! Acceleration structures: a uniform grid, an irregular one, or a bounding volume hierarchy.

pub mod bvh;
pub mod grid;
pub mod irregular;

use bvh::{BvhData, WideBvhData};
use grid::GridData;
use irregular::IrregularData;

/// The acceleration structure of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Structure {
    /// None: every ray tests every triangle.
    #[default]
    None,
    /// A uniform grid.
    Grid {
        /// The grid and its lists.
        data: GridData,
        /// Distance of each empty cell to the next list, see [`grid::distances`]; empty without empty-space skipping.
        distances: Vec<u32>,
    },
    /// An irregular grid.
    Irregular(IrregularData),
    /// A binary BVH, for rays that are stepped.
    Bvh(BvhData),
    /// An eight-wide BVH, for the fused kernel.
    Wide(WideBvhData),
}

impl Structure {
    /// Length of the longest list of a cell or leaf; 0 for structures without such lists.
    #[must_use]
    pub fn longest_list(&self) -> u32 {
        let longest = match self {
            Self::Grid { data, .. } => data.cells.windows(2).map(|w| w[1] - w[0]).max(),
            Self::Irregular(data) => data.lengths.iter().copied().max(),
            Self::Bvh(data) => data.nodes.iter().map(|node| node.count()).max(),
            Self::Wide(_) | Self::None => None,
        };
        longest.unwrap_or(0)
    }

    /// Sum of the cells along x, y and z; 0 without a grid.
    #[must_use]
    pub fn cells_along_axes(&self) -> u64 {
        match self {
            Self::Grid { data, .. } => data.grid.cells.iter().map(|&n| n as u64).sum(),
            _ => 0,
        }
    }
}
