//! Twin of `dda.wgsl`: the 3D-DDA of Fujimoto, Tanaka and Iwata, *ARTS: Accelerated Ray-Tracing System*, 1986.

use crate::numbers::real::{Real, Vec3};

/// Cells that the ray crosses along each axis while it crosses one along the driving axis: 1 there.
pub fn slopes<R: Real>(direction: Vec3<R>, width: Vec3<R>) -> Vec3<R> {
    let (d, w) = (direction.to_array(), width.to_array());
    let speed = [0, 1, 2].map(|a| (d[a] / w[a]).abs());
    let fastest = speed[0].max(speed[1]).max(speed[2]);
    Vec3::from(speed.map(|v| if v == fastest { R::one() } else { v / fastest }))
}

/// Of several axes with slope 1, the first drives.
pub fn driving_axis<R: Real>(slope: Vec3<R>) -> usize {
    let is_one = slope.map(|s| s == R::one());
    if is_one.x {
        0
    } else if is_one.y {
        1
    } else {
        2
    }
}

/// The control terms of a ray in its first cell; `position`: in cells.
pub fn first_control<R: Real>(position: Vec3<R>, cell: [i32; 3], direction: Vec3<R>, slope: Vec3<R>) -> Vec3<R> {
    let (position, direction) = (position.to_array(), direction.to_array());
    let left = [0, 1, 2].map(|a| {
        let low = R::from_i32(cell[a]);
        if direction[a] < R::zero() { position[a] - low } else { low + R::one() - position[a] }
    });
    slope * Vec3::splat(left[driving_axis(slope)]) - Vec3::from(left)
}

/// The axis that is crossed next: where two terms are positive, the one that is larger in proportion to its slope. Ties
/// are in the order of Listing 1.
pub fn crossed_axis<R: Real>(control: Vec3<R>, slope: Vec3<R>) -> [bool; 3] {
    let x_before_y = control.x * slope.y > control.y * slope.x;
    let x_before_z = control.x * slope.z > control.z * slope.x;
    let y_before_z = control.y * slope.z > control.z * slope.y;
    let x = x_before_y && x_before_z;
    let y = !x_before_y && y_before_z;
    [x, y, !x && !y]
}

/// The control terms after a step along an axis.
pub fn next_control<R: Real>(control: Vec3<R>, slope: Vec3<R>, axis: [bool; 3]) -> Vec3<R> {
    let drives = axis[driving_axis(slope)];
    let (control, slope) = (control.to_array(), slope.to_array());
    Vec3::from([0, 1, 2].map(|a| {
        let along = if drives { slope[a] } else { R::zero() };
        control[a] + along - if axis[a] { R::one() } else { R::zero() }
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shared::constants::PAPER_PARALLEL;
    use crate::shared::grid_walk::{Grid, WalkRules};

    const PAPER: WalkRules = WalkRules { robust: false, clip: false, drifting: false, dda: false };

    /// The cells of a walk in f64.
    fn cells(dda: bool, origin: [f64; 3], direction: [f64; 3]) -> Vec<[i32; 3]> {
        let mut grid = Grid::default();
        // Widths that differ, so that the driving axis is not that of the longest component.
        (grid.cells, grid.width) = ([8, 16, 4], [0.25, 0.125, 0.5]);
        let rules = WalkRules { dda, ..PAPER };
        let ray = grid.ray(rules, Vec3::from(origin), Vec3::from(direction));
        let mut walk = grid.enter(rules, &ray);
        let mut cells = Vec::new();
        while walk.inside && grid.is_in_grid(walk.cell) && cells.len() < 100 {
            cells.push(walk.cell);
            walk = grid.advance(rules, walk, &ray);
        }
        cells
    }

    #[test]
    fn both_walks_visit_the_same_cells() {
        // Few enough values that many rays are parallel to an axis, run along planes, or through edges and corners, and
        // many that do not: a Weyl sequence.
        let few = [-1.0, -0.5, -0.25, 0.0, 0.25, 0.5, 1.0];
        let weyl = |i: usize, by: f64| (i as f64 * by).fract();
        let (mut longest, mut driven) = (0, [0; 3]);
        for i in 0..20_000 {
            let places = [1.0, 7.0, 49.0].map(|by| (i as f64 / by) as usize % 7);
            let direction = match i % 2 {
                0 => places.map(|place| few[place]),
                _ => [0.618_033_988_7, 0.754_877_666_2, 0.569_840_291_0].map(|by| weyl(i, by) - 0.5),
            };
            let origin = match i % 3 {
                // In the middle of a cell, so that diagonals go through edges.
                0 => [0.875, 0.9375, 0.75],
                _ => [0.819_172_513_4, 0.671_043_606_7, 0.549_700_477_9].map(|by| 2.0 * weyl(i, by)),
            };
            // The paper takes a ray that is nearly parallel to an axis as parallel; a 3D-DDA needs no such rule.
            let is_nearly_parallel = |d: &f64| *d != 0.0 && d.abs() < f64::from(PAPER_PARALLEL);
            if direction == [0.0; 3] || direction.iter().any(is_nearly_parallel) {
                continue;
            }
            let found = cells(true, origin, direction);
            assert_eq!(found, cells(false, origin, direction), "{origin:?} {direction:?}");
            longest = longest.max(found.len());
            driven[driving_axis(slopes(Vec3::from(direction), Vec3::<f64>::from_f32([0.25, 0.125, 0.5])))] += 1;
        }
        assert!(longest > 20 && driven.iter().all(|&n| n > 500), "{longest} {driven:?}");
    }

    #[test]
    fn control_terms_of_a_known_ray_are_those_of_a_line_drawn_by_hand() {
        // Along x one cell, along y a quarter, along z back by a half, from the lower third of a cell.
        let slope = slopes(Vec3::new(0.5f64, 0.125, -0.25), Vec3::new(0.5, 0.5, 0.5));
        assert_eq!(slope, Vec3::new(1.0, 0.25, 0.5));
        let direction = Vec3::new(0.5, 0.125, -0.25);
        let control = first_control(Vec3::new(2.25, 3.5, 1.125), [2, 3, 1], direction, slope);
        // 0.75 cells to go along x: y reaches 3.6875, of 4; z 0.75, past 1.
        assert_eq!(control, Vec3::new(0.0, -0.3125, 0.25));
        assert_eq!(crossed_axis(control, slope), [false, false, true]);
        let control = next_control(control, slope, [false, false, true]);
        assert_eq!(control, Vec3::new(0.0, -0.3125, -0.75));
        assert_eq!(crossed_axis(control, slope), [true, false, false]);
        assert_eq!(next_control(control, slope, [true, false, false]), Vec3::new(0.0, -0.0625, -0.25));
    }
}
