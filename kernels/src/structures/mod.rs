//! What keeps a ray from testing every triangle: a uniform grid, or a bounding volume hierarchy.

pub mod bvh;
pub mod grid;

use bvh::{BvhData, WideBvhData};
use grid::GridData;

/// What was built over the triangles of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Structure {
    /// Nothing: every ray tests every triangle.
    #[default]
    None,
    /// A uniform grid.
    Grid {
        /// Its lists.
        data: GridData,
        /// How far each empty cell is from the next list, see [`grid::distances`]; empty where rays do not leap.
        distances: Vec<u32>,
    },
    /// A binary tree, for rays that are stepped.
    Bvh(BvhData),
    /// An eight-wide tree, for the fused kernel.
    Wide(WideBvhData),
}

impl Structure {
    /// The longest list of a cell or leaf; 0 where lists are not told apart.
    #[must_use]
    pub fn longest_list(&self) -> u32 {
        let longest = match self {
            Self::Grid { data, .. } => data.cells.windows(2).map(|w| w[1] - w[0]).max(),
            Self::Bvh(data) => data.nodes.iter().map(|node| node.count()).max(),
            Self::Wide(_) | Self::None => None,
        };
        longest.unwrap_or(0)
    }

    /// Cells along x, y and z together; 0 without a grid.
    #[must_use]
    pub fn cells_along_axes(&self) -> u64 {
        match self {
            Self::Grid { data, .. } => data.grid.cells.iter().map(|&n| n as u64).sum(),
            _ => 0,
        }
    }
}
