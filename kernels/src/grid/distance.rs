//! How far each empty cell is from the next cell with a list (proximity clouds, Cohen and Sheffer, 1994).

use crate::parallel::for_chunks;
use crate::shared::grid_walk::Grid;

/// The farthest distance that is told apart: what a byte holds.
const FARTHEST: u8 = 255;

/// Chessboard distance of every cell to the nearest one with a list, at most 255: 0 for a cell with a list.
/// Four cells a word, the first in the lowest byte.
///
/// Exact up to the limit: the chessboard distance is the largest of the three axes' distances, so it can be
/// found axis by axis, as Saito and Toriwaki (1994) do for the Euclidean one: along a row, the smallest of
/// `max(d, distance along the row)` is taken over all cells of the row, by one sweep each way.
#[must_use]
pub fn distances(grid: &Grid, cells: &[u32]) -> Vec<u32> {
    let [nx, ny, nz] = grid.cells.map(|n| n as usize);
    let count = nx * ny * nz;
    let mut bytes: Vec<u8> = cells.windows(2).map(|w| if w[0] < w[1] { 0 } else { FARTHEST }).collect();
    bytes.resize(count, FARTHEST);
    // Along x every row lies together; along y and z rows are gathered slice by slice.
    for_chunks(&mut bytes, nx, |_, row| {
        let (mut spread, mut scratch) = (row.to_vec(), Scratch::default());
        scratch.sweep(&mut spread);
        row.copy_from_slice(&spread);
    });
    for_chunks(&mut bytes, nx * ny, |_, slice| {
        let (mut line, mut scratch) = (vec![0; ny], Scratch::default());
        for x in 0..nx {
            (0..ny).for_each(|y| line[y] = slice[x + nx * y]);
            scratch.sweep(&mut line);
            (0..ny).for_each(|y| slice[x + nx * y] = line[y]);
        }
    });
    let plane = nx * ny;
    let (mut line, mut scratch) = (vec![0; nz], Scratch::default());
    for xy in 0..plane {
        (0..nz).for_each(|z| line[z] = bytes[xy + plane * z]);
        scratch.sweep(&mut line);
        (0..nz).for_each(|z| bytes[xy + plane * z] = line[z]);
    }
    bytes.resize(count.next_multiple_of(4), 0);
    bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
}

/// What a sweep keeps: the cells whose value can still be the smallest farther on.
#[derive(Default)]
struct Scratch {
    best: Vec<u8>,
}

impl Scratch {
    /// `line[i] = min over j of max(line[j], |i - j|)`.
    fn sweep(&mut self, line: &mut [u8]) {
        self.best.clear();
        self.best.extend_from_slice(line);
        one_way(line.iter().copied(), self.best.iter_mut());
        one_way(line.iter().copied().rev(), self.best.iter_mut().rev());
        line.copy_from_slice(&self.best);
    }
}

/// Lowers `best[i]` to the smallest `max(value[j], i - j)` over j up to i.
fn one_way<'a>(values: impl Iterator<Item = u8>, best: impl Iterator<Item = &'a mut u8>) {
    // Of two earlier cells the later one with the smaller value is always the better.
    let mut candidates: Vec<(usize, u8)> = Vec::new();
    let mut first = 0;
    for (i, (value, best)) in values.zip(best).enumerate() {
        while candidates.len() > first && candidates.last().is_some_and(|c| c.1 >= value) {
            candidates.pop();
        }
        candidates.push((i, value));
        let cost = |c: &(usize, u8)| (i - c.0).max(usize::from(c.1));
        // Values rise from the oldest to the newest; distances fall. The best is where they cross.
        while first + 1 < candidates.len() && cost(&candidates[first + 1]) <= cost(&candidates[first]) {
            first += 1;
        }
        *best = (*best).min(cost(&candidates[first]).min(usize::from(FARTHEST)) as u8);
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
