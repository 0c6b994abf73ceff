//! Distance of each empty cell to the next cell with a list (proximity clouds, Cohen and Sheffer, 1994).

use crate::shared::grid_walk::Grid;

/// Largest distance that is stored: the maximum of a byte.
const FARTHEST: u8 = 255;

/// Chessboard distance of every cell to the nearest one with a list, at most 255: 0 for a cell with a list. Four cells
/// per word, the first in the lowest byte.
///
/// Two passes over the cells, forwards and backwards; in each, a cell's distance is at most one more than that of any
/// of the 13 neighbours before it. For the chessboard distance that is exact (Rosenfeld and Pfaltz, 1968).
#[must_use]
pub fn distances(grid: &Grid, cells: &[u32]) -> Vec<u32> {
    let [nx, ny, nz] = grid.cells.map(|n| n as usize);
    let count = nx * ny * nz;
    let mut bytes: Vec<u8> = cells.windows(2).map(|w| if w[0] < w[1] { 0 } else { FARTHEST }).collect();
    bytes.resize(count, FARTHEST);
    let rows: Vec<(usize, usize)> = (0..nz).flat_map(|z| (0..ny).map(move |y| (y, z))).collect();
    let mut nearest = vec![FARTHEST; nx];
    for &(y, z) in &rows {
        let row = (y + ny * z) * nx;
        let (before, this) = bytes.split_at_mut(row);
        let (below, slice) = (y > 0, z > 0);
        let earlier = [below.then_some(nx), slice.then_some(nx * ny)].into_iter().flatten();
        let corners = [(slice && below).then_some(nx * (ny + 1)), (slice && y + 1 < ny).then_some(nx * (ny - 1))];
        for back in earlier.chain(corners.into_iter().flatten()) {
            spread(&before[row - back..][..nx], &mut nearest, &mut this[..nx]);
        }
        along(this[..nx].iter_mut());
    }
    for &(y, z) in rows.iter().rev() {
        let row = (y + ny * z) * nx;
        let (this, after) = bytes.split_at_mut(row + nx);
        let (above, slice) = (y + 1 < ny, z + 1 < nz);
        let later = [above.then_some(nx), slice.then_some(nx * ny)].into_iter().flatten();
        let corners = [(slice && above).then_some(nx * (ny + 1)), (slice && y > 0).then_some(nx * (ny - 1))];
        for forth in later.chain(corners.into_iter().flatten()) {
            spread(&after[forth - nx..][..nx], &mut nearest, &mut this[row..]);
        }
        along(this[row..].iter_mut().rev());
    }
    bytes.resize(count.next_multiple_of(4), 0);
    bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
}

/// Limits each cell of `to` to one more than any of the three cells next to it in the neighbouring row `from`.
fn spread(from: &[u8], nearest: &mut [u8], to: &mut [u8]) {
    nearest.copy_from_slice(from);
    for (n, next) in nearest.iter_mut().zip(&from[1..]) {
        *n = (*n).min(*next);
    }
    for (n, last) in nearest[1..].iter_mut().zip(from) {
        *n = (*n).min(*last);
    }
    for (t, n) in to.iter_mut().zip(nearest) {
        *t = (*t).min(n.saturating_add(1));
    }
}

/// Limits each cell to one more than the cell before it.
fn along<'a>(row: impl Iterator<Item = &'a mut u8>) {
    let mut last = FARTHEST;
    for cell in row {
        last = last.saturating_add(1).min(*cell);
        *cell = last;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_those_of_a_search_over_all_cells() {
        let grid = Grid { cells: [7, 5, 9], ..Grid::default() };
        for seed in 0..40u32 {
            let mut cells = vec![0u32];
            for i in 0..7 * 5 * 9u32 {
                let noise = (i + 1000 * seed).wrapping_mul(2_654_435_761) >> 16;
                cells.push(cells[i as usize] + u32::from(noise % (2 + seed * 4) == 0));
            }
            let packed = distances(&grid, &cells);
            let full = |c: usize| cells[c] < cells[c + 1];
            let at = |c: usize| [c % 7, c / 7 % 5, c / 35];
            for c in 0..7 * 5 * 9 {
                let farthest = |o: usize| (0..3).map(|a| at(c)[a].abs_diff(at(o)[a])).max().unwrap_or(0);
                let expected = (0..7 * 5 * 9).filter(|&o| full(o)).map(farthest).min().unwrap_or(255);
                assert_eq!((packed[c / 4] >> (8 * (c % 4)) & 0xff) as usize, expected, "cell {c}, seed {seed}");
            }
        }
    }
}
