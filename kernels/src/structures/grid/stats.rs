//! How a grid's lists are distributed.

use super::{GridData, count};

/// How a grid's lists are distributed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridStats {
    /// Cells in all.
    pub cells: u64,
    /// Cells with an empty list.
    pub empty: u64,
    /// Entries of all lists.
    pub references: u64,
    /// Entries that are there only because cells are grown.
    pub added_by_growth: u64,
    /// Longest list.
    pub longest: u32,
}

impl GridData {
    /// Statistics; walks all triangles once more to tell what the growth added.
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
