//! Statistics of acceleration structures: the lists of a grid's cells, and the nodes of a BVH.

mod nodes;
mod tree;

use raystep_kernels::scene_data::SceneData;

pub use nodes::{Filling, Node, Nodes, RankBy};
pub use tree::TreeStats;
pub(crate) use tree::at_point;

/// Entries of a histogram of lengths: one each for 0, 1, …; the last one counts everything that is as long or longer.
pub const LENGTHS: usize = 128;

/// The lists of a grid's cells.
#[derive(Clone, Debug, PartialEq)]
pub struct GridStats {
    /// Cells along x, y and z.
    pub cells: [i32; 3],
    /// Cells that list at least one triangle.
    pub occupied: u64,
    /// Entries of all lists.
    pub references: u64,
    /// Length of the longest list.
    pub longest: u32,
    /// The first cell with such a list.
    pub longest_cell: u32,
    /// How many cells list 0, 1, … triangles: [`LENGTHS`] numbers.
    pub lengths: Vec<u64>,
    /// How many triangles are listed by 0, 1, … cells: [`LENGTHS`] numbers.
    pub listings: Vec<u64>,
    /// Most cells that list the same triangle.
    pub most_listed: u32,
    /// A triangle listed that many times.
    pub most_listed_triangle: Option<u32>,
}

impl GridStats {
    /// Statistics of a scene's grid; `None` without one. Takes 4 bytes of memory per triangle.
    #[must_use]
    pub fn of(data: &SceneData) -> Option<Self> {
        if data.grid_cells.len() < 2 {
            return None;
        }
        let mut lengths = vec![0; LENGTHS];
        let (mut longest, mut longest_cell) = (0, 0);
        for (cell, list) in (0..).zip(data.grid_cells.windows(2)) {
            let length = list[1].saturating_sub(list[0]);
            lengths[(length as usize).min(LENGTHS - 1)] += 1;
            if length > longest {
                (longest, longest_cell) = (length, cell);
            }
        }
        let mut listed = vec![0u32; data.info.triangles as usize];
        for &triangle in &data.grid_items {
            if let Some(count) = listed.get_mut(triangle as usize) {
                *count += 1;
            }
        }
        let mut listings = vec![0; LENGTHS];
        listed.iter().for_each(|&count| listings[(count as usize).min(LENGTHS - 1)] += 1);
        let most_listed = listed.iter().copied().max().unwrap_or(0);
        Some(Self {
            cells: data.grid.cells,
            occupied: data.grid_cells.len() as u64 - 1 - lengths[0],
            references: data.grid_items.len() as u64,
            longest,
            longest_cell,
            lengths,
            listings,
            most_listed,
            most_listed_triangle: listed.iter().position(|&n| n == most_listed).map(|triangle| triangle as u32),
        })
    }

    /// All cells.
    #[must_use]
    pub fn cells_in_all(&self) -> u64 {
        self.lengths.iter().sum()
    }

    /// Share of cells that list at least one triangle.
    #[must_use]
    pub fn occupancy(&self) -> f64 {
        self.occupied as f64 / self.cells_in_all().max(1) as f64
    }

    /// Mean length of the lists that are not empty.
    #[must_use]
    pub fn mean_length(&self) -> f64 {
        self.references as f64 / self.occupied.max(1) as f64
    }

    /// Number of cells that list a triangle, on average.
    #[must_use]
    pub fn references_per_triangle(&self) -> f64 {
        self.references as f64 / self.listings.iter().sum::<u64>().max(1) as f64
    }
}

/// The triangles that a cell lists; empty for a cell outside the grid.
#[must_use]
pub fn triangles_in(data: &SceneData, cell: u32) -> &[u32] {
    let cell = cell as usize;
    let bounds = data.grid_cells.get(cell).zip(data.grid_cells.get(cell + 1));
    bounds.and_then(|(&first, &end)| data.grid_items.get(first as usize..end as usize)).unwrap_or_default()
}

/// List lengths in one layer of cells, as an image. Columns follow the first and rows the second of the other two
/// axes; row 0 has the largest coordinate, so that up is up.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Slice {
    /// The axis perpendicular to the slice, 0 to 2.
    pub axis: usize,
    /// The cell's index along it.
    pub index: i32,
    /// Columns.
    pub width: i32,
    /// Rows.
    pub height: i32,
    /// `width * height` lengths, row by row.
    pub lengths: Vec<u32>,
}

impl Slice {
    /// The slice at cell `index` of `axis` (0 to 2); `None` if there is no such cell.
    #[must_use]
    pub fn of(data: &SceneData, axis: usize, index: i32) -> Option<Self> {
        let cells = data.grid.cells;
        if axis > 2 || index < 0 || index >= cells[axis] || data.grid_cells.len() < 2 {
            return None;
        }
        let [across, up] = across(axis);
        let mut slice = Self { axis, index, width: cells[across], height: cells[up], lengths: Vec::new() };
        let places = (0..slice.height).flat_map(|row| (0..slice.width).map(move |column| (column, row)));
        let lengths = places.map(|(column, row)| {
            let cell = data.grid.cell_index(slice.cell(column, row));
            triangles_in(data, cell).len() as u32
        });
        slice.lengths = lengths.collect();
        Some(slice)
    }

    /// The cell (x, y, z) at a pixel of the image.
    #[must_use]
    pub fn cell(&self, column: i32, row: i32) -> [i32; 3] {
        let [across, up] = across(self.axis);
        let mut cell = [self.index; 3];
        (cell[across], cell[up]) = (column, self.height - 1 - row);
        cell
    }
}

/// The two axes of a slice.
fn across(axis: usize) -> [usize; 2] {
    match axis {
        0 => [1, 2],
        1 => [0, 2],
        _ => [0, 1],
    }
}

#[cfg(test)]
mod tests {
    use raystep_kernels::{GridSize, Limits, Options, Plan, RaySource};
    use raystep_scenes::generate;

    use super::*;

    fn room(cells: [u32; 3]) -> SceneData {
        let grid = GridSize::Cells(cells);
        let options = Options { grid, shade: false, ..Options::new(RaySource::Given(Vec::new())) };
        Plan::new(&generate::cornell_box(), &options, &Limits::CPU).expect("a small scene").1
    }

    #[test]
    fn every_list_and_every_triangle_is_counted_once() {
        let data = room([5, 4, 3]);
        let stats = GridStats::of(&data).expect("a grid");
        assert_eq!((stats.cells, stats.cells_in_all()), ([5, 4, 3], 60));
        assert_eq!(stats.references, data.grid_items.len() as u64);
        assert_eq!(stats.listings.iter().sum::<u64>(), u64::from(data.info.triangles));
        let weighted = |histogram: &[u64]| (0..).zip(histogram).map(|(n, count)| n * count).sum::<u64>();
        assert_eq!([weighted(&stats.lengths), weighted(&stats.listings)], [stats.references; 2]);
        let lists: Vec<usize> = (0..60).map(|cell| triangles_in(&data, cell).len()).collect();
        assert_eq!(stats.occupied, lists.iter().filter(|&&n| n > 0).count() as u64);
        assert!(stats.occupied < 60, "the middle of a room is empty");
        assert_eq!(Some(&(stats.longest as usize)), lists.iter().max());
        assert_eq!(lists[stats.longest_cell as usize], stats.longest as usize);
        let triangle = stats.most_listed_triangle.expect("triangles");
        let holds = |cell: &u32| triangles_in(&data, *cell).contains(&triangle);
        assert_eq!((0..60).filter(holds).count(), stats.most_listed as usize);
        assert!(triangles_in(&data, 60).is_empty() && triangles_in(&data, u32::MAX).is_empty());
    }

    #[test]
    fn slices_along_an_axis_show_every_cell_once() {
        let data = room([5, 4, 3]);
        for axis in 0..3 {
            let mut seen = Vec::new();
            for index in 0..data.grid.cells[axis] {
                let slice = Slice::of(&data, axis, index).expect("a slice");
                assert_eq!(slice.lengths.len() as i32, slice.width * slice.height);
                for row in 0..slice.height {
                    for column in 0..slice.width {
                        let cell = data.grid.cell_index(slice.cell(column, row));
                        let length = slice.lengths[(row * slice.width + column) as usize];
                        assert_eq!(length as usize, triangles_in(&data, cell).len());
                        seen.push(cell);
                    }
                }
            }
            seen.sort_unstable();
            assert_eq!(seen, (0..60).collect::<Vec<_>>(), "axis {axis}");
            assert_eq!(Slice::of(&data, axis, data.grid.cells[axis]), None);
            assert_eq!(Slice::of(&data, axis, -1), None);
        }
        assert_eq!(Slice::of(&data, 3, 0), None);
        // The floor, which covers the whole room, is in the last row.
        let slice = Slice::of(&data, 2, 1).expect("a slice");
        assert_eq!(slice.cell(0, slice.height - 1), [0, 0, 1]);
    }

    #[test]
    fn without_a_grid_there_is_nothing_to_say() {
        assert_eq!(GridStats::of(&SceneData::default()), None);
        assert_eq!(Slice::of(&SceneData::default(), 0, 0), None);
        assert!(triangles_in(&SceneData::default(), 0).is_empty());
    }
}
