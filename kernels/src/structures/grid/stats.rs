//! Statistics of a grid's lists.

use super::{GridData, count};

/// Statistics of a grid's lists.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridStats {
    /// Number of cells.
    pub cells: u64,
    /// Number of cells with an empty list.
    pub empty: u64,
    /// Number of entries in all lists.
    pub references: u64,
    /// Number of entries that are there only because cells are grown.
    pub added_by_growth: u64,
    /// Length of the longest list.
    pub longest: u32,
}

impl GridData {
    /// Computes the statistics; tests all triangles again to find what the growth added.
    #[must_use]
    pub fn stats(&self, vertices: &[f32]) -> GridStats {
        let lengths = || self.cells.windows(2).map(|w| w[1] - w[0]);
        let exact = count(vertices, &self.grid, 0.0, u64::MAX)
            .map_or(0, |counts| counts.into_iter().map(|c| u64::from(c.into_inner())).sum());
        GridStats {
            cells: self.cells.len() as u64 - 1,
            empty: lengths().filter(|&n| n == 0).count() as u64,
            references: self.items.len() as u64,
            added_by_growth: self.items.len() as u64 - exact,
            longest: lengths().max().unwrap_or(0),
        }
    }
}
