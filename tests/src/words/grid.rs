//! Explanations of the walk through the grid.

use raystep_kernels::programs::closest_hit::states::{BACKGROUND, ISECT_HIT, ISECT_NO_HIT, SHADE};
use raystep_kernels::scene_data::SceneData;

use super::geometry::{V, interval, plane_t, ray};
use super::scan::{Scan, same};
use super::{Kind, Row};

/// Cell coordinates of a 1-D index, x fastest.
pub(super) fn cell_of(data: &SceneData, index: u32) -> [i32; 3] {
    let [nx, ny, _] = data.grid.cells.map(|n| n as u32);
    [index % nx, index / nx % ny, index / (nx * ny)].map(|n| n as i32)
}

/// 1-D index of cell coordinates, which may be outside the grid.
fn index_of(data: &SceneData, [x, y, z]: [i32; 3]) -> i64 {
    let [nx, ny, _] = data.grid.cells.map(i64::from);
    i64::from(x) + nx * (i64::from(y) + ny * i64::from(z))
}

fn is_in_grid(data: &SceneData, cell: [i32; 3]) -> bool {
    cell.iter().zip(data.grid.cells).all(|(&c, n)| (0..n).contains(&c))
}

/// How many triangles a cell lists.
pub(super) fn listed(data: &SceneData, index: u32) -> usize {
    let index = index as usize;
    (data.grid_cells[index + 1] - data.grid_cells[index]) as usize
}

/// The distance to the nearest cell with a list, at most 255; checks every cell within that distance.
pub(super) fn distance(data: &SceneData, index: u32) -> i32 {
    let at = cell_of(data, index);
    let [nx, ny, nz] = data.grid.cells;
    let mut nearest = 255;
    for z in (at[2] - nearest).max(0)..=(at[2] + nearest).min(nz - 1) {
        for y in (at[1] - nearest).max(0)..=(at[1] + nearest).min(ny - 1) {
            let across = (z - at[2]).abs().max((y - at[1]).abs());
            if across >= nearest {
                continue;
            }
            for x in (at[0] - nearest).max(0)..=(at[0] + nearest).min(nx - 1) {
                let far = across.max((x - at[0]).abs());
                if far < nearest && listed(data, index_of(data, [x, y, z]) as u32) > 0 {
                    nearest = far;
                }
            }
        }
    }
    nearest
}

/// A plane between cells.
fn plane(data: &SceneData, axis: usize, at: i32) -> f64 {
    f64::from(data.grid.corner[axis]) + f64::from(data.grid.width[axis]) * f64::from(at)
}

fn corners(data: &SceneData, from: [i32; 3], to: [i32; 3]) -> [V; 2] {
    [from, to].map(|cell| [0, 1, 2].map(|axis| plane(data, axis, cell[axis])))
}

/// How far a point may seem to be outside its cell: the margin by which cells are grown for that reason, or without it
/// the same 64 roundings of the largest distance.
fn slack(data: &SceneData, o: V) -> f64 {
    let far =
        corners(data, [0; 3], data.grid.cells).into_iter().flatten().chain(o).fold(0.0, |m: f64, v| m.max(v.abs()));
    f64::from(data.growth).max(64.0 * super::geometry::U * far)
}

impl Row<'_> {
    /// `, which lists 3 triangles`
    pub(super) fn listing(&self, words: &mut Scan<'_>, index: u32) -> Result<(), String> {
        words.literal(", which ")?;
        let said = if words.is("is empty") {
            0
        } else {
            words.literal("lists ")?;
            let count = words.number()?;
            words.literal(if count == 1 { " triangle" } else { " triangles" })?;
            count
        };
        same("listed", said, listed(self.data, index))
    }

    fn here(&self, words: &mut Scan<'_>) -> Result<(), String> {
        same("the cell", words.cell()?, cell_of(self.data, self.after.cell_index))
    }

    pub(super) fn started_in_grid(&self, words: &mut Scan<'_>) -> Result<Vec<Kind>, String> {
        let data = self.data;
        let (o, d) = ray(self.after);
        let slack = slack(data, o);
        let [min, max] = corners(data, [0; 3], data.grid.cells);
        if words.is("misses the grid's box") {
            same("robust", data.features.robust, true)?;
            self.is(BACKGROUND)?;
            let inside = interval((o, d), min, max, -slack).filter(|t| t[1] >= 0.0);
            same("the t inside", inside, None)?;
            return Ok(vec!["misses the grid"]);
        }
        if words.is("starts outside of the grid, which the paper's rules do not handle") {
            same("robust", data.features.robust, false)?;
            self.is(BACKGROUND)?;
            let is_inside = (0..3).all(|a| o[a] > min[a] + slack && o[a] < max[a] - slack);
            same("inside", is_inside, false)?;
            return Ok(vec!["starts outside"]);
        }
        self.is(ISECT_NO_HIT)?;
        let is_wrapped = words.is("starts outside of the grid, where the index is that of ");
        if !is_wrapped {
            words.literal("starts in ")?;
        }
        self.here(words)?;
        self.listing(words, self.after.cell_index)?;
        if is_wrapped {
            same("robust", data.features.robust, false)?;
            let is_beyond = (0..3).any(|a| o[a] >= max[a] - slack);
            same("beyond a + face", is_beyond, true)?;
            return Ok(vec!["starts wrapped"]);
        }
        let cell = cell_of(data, self.after.cell_index);
        let [low, high] = corners(data, cell, cell.map(|c| c + 1));
        let enters = interval((o, d), min, max, slack).map_or(0.0, |t| t[0]).max(0.0);
        let place = [0, 1, 2].map(|a| o[a] + d[a] * enters);
        for a in 0..3 {
            // An error of t where the box is entered shifts the point along the ray as well as across the face.
            let reach = d.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
            let along = if enters > 0.0 { 2.0 * slack * d[a].abs() / steepest(d, reach) } else { 0.0 };
            if place[a] < low[a] - slack - along || place[a] > high[a] + slack + along {
                return Err(format!("the ray enters at {place:?}, outside of {low:?} to {high:?}"));
            }
        }
        Ok(vec!["starts inside"])
    }

    pub(super) fn moved_in_grid(&self, words: &mut Scan<'_>) -> Result<Vec<Kind>, String> {
        let far = if self.data.features.skip { distance(self.data, self.before.cell_index) } else { 1 };
        let (kind, is_out) = if words.is("empty for ") { self.leapt(words, far)? } else { self.stepped(words, far)? };
        if !is_out {
            self.here(words)?;
            self.listing(words, self.after.cell_index)?;
            same("the item", self.after.item, 0)?;
        }
        let has_hit = self.before.triangle.is_some();
        if words.is("; the hit is kept") {
            same("a hit, inside", (has_hit, is_out), (true, false))?;
            self.is(ISECT_HIT)?;
        } else if words.is("; the kept hit is the nearest") {
            same("a hit, outside", (has_hit, is_out), (true, true))?;
            self.is(SHADE)?;
        } else if words.is("; nothing hit") {
            same("a hit, outside", (has_hit, is_out), (false, true))?;
            self.is(BACKGROUND)?;
        } else {
            same("a hit, inside", (has_hit, is_out), (false, false))?;
            self.is(ISECT_NO_HIT)?;
        }
        Ok(vec![kind])
    }

    /// `36 cells around: leaps by x -16, y -18, z -37, over 70 empty cells, leaving the empty ones through -z at t 1.5,
    /// to `
    fn leapt(&self, words: &mut Scan<'_>, far: i32) -> Result<(Kind, bool), String> {
        let data = self.data;
        same("empty cells around", words.number::<i32>()?, far - 1)?;
        words.literal(if far == 2 { " cell around: leaps " } else { " cells around: leaps " })?;
        let (from, to) = (cell_of(data, self.before.cell_index), cell_of(data, self.after.cell_index));
        let is_out = words.is("out of the grid, ");
        let moved = [0, 1, 2].map(|a| to[a] - from[a]);
        if !is_out {
            let mut comma = "by ";
            for axis in (0..3).filter(|&axis| moved[axis] != 0) {
                words.literal(comma)?;
                same("the axis", words.axis()?, axis)?;
                words.literal(if moved[axis] > 0 { " +" } else { " " })?;
                same("the leap", words.number::<i32>()?, moved[axis])?;
                comma = ", ";
            }
            words.literal(", over ")?;
            let passed = words.number::<i32>()?;
            same("the cells between", passed, moved.iter().map(|n| n.abs()).sum::<i32>() - 1)?;
            words.literal(if passed == 1 { " empty cell, " } else { " empty cells, " })?;
        }
        words.literal("leaving the empty ones through ")?;
        let (sign, axis) = words.way()?;
        words.literal(" at t ")?;
        let t = words.number::<f32>()?;
        if !is_out {
            words.literal(", to ")?;
        }
        let (o, d) = ray(self.before);
        let corner = |a: usize| f64::from(data.grid.corner[a]);
        let slack = slack(data, o);
        // The planes that bound the cube of empty cells, and the first of them that the ray meets.
        for a in (0..3).filter(|&a| d[a].abs() > 1e-15) {
            let face = if d[a] > 0.0 { from[a] + far } else { from[a] - far + 1 };
            let (exact, bound) = plane_t((o, d), a, corner(a), plane(data, a, face));
            if a == axis && (f64::from(t) - exact).abs() > bound {
                return Err(format!("t {t}, and the cube ends there at {exact}, give or take {bound:e}"));
            }
            if f64::from(t) > exact + bound {
                return Err(format!("t {t}, and the ray leaves the cube along axis {a} at {exact}"));
            }
        }
        same("the way", sign, if d[axis] > 0.0 { 1 } else { -1 })?;
        let place = [0, 1, 2].map(|a| o[a] + d[a] * f64::from(t));
        if is_out {
            let beyond = from[axis] + sign * far;
            let [min, max] = corners(data, [0; 3], data.grid.cells);
            let is_beyond = (0..3).any(|a| place[a] <= min[a] + slack || place[a] >= max[a] - slack);
            same("beyond the grid", is_beyond || !(0..data.grid.cells[axis]).contains(&beyond), true)?;
            return Ok(("leaps out", true));
        }
        same("cells along the axis", moved[axis], sign * far)?;
        for a in (0..3).filter(|&a| a != axis) {
            same(
                "a leap within the cube",
                moved[a].abs() < far && (moved[a] == 0 || (moved[a] > 0) == (d[a] > 0.0)),
                true,
            )?;
            let (low, high) = (plane(data, a, to[a]), plane(data, a, to[a] + 1));
            if place[a] < low - slack || place[a] > high + slack {
                return Err(format!("at t {t} the ray is at {}, outside of {low} to {high}", place[a]));
            }
        }
        Ok(("leaps", false))
    }

    /// `tmax.z 0.8 is smallest: step -z to `
    fn stepped(&self, words: &mut Scan<'_>, far: i32) -> Result<(Kind, bool), String> {
        let (data, tmax) = (self.data, self.before.tmax);
        if far > 1 {
            return Err(format!("the nearest list is {far} cells away: this was a leap"));
        }
        words.literal("tmax.")?;
        let axis = words.axis()?;
        words.literal(" ")?;
        let t = words.number::<f32>()?;
        same("tmax", Some(t.to_bits()), tmax[axis].map(f32::to_bits))?;
        words.literal(" is smallest")?;
        let least = tmax.iter().flatten().copied().fold(f32::INFINITY, f32::min);
        let mut but_for = 0.0;
        if words.is(" but for rounding, as is tmax.") {
            let other = words.axis()?;
            words.literal(" ")?;
            same("the other tmax", words.number::<f32>()?, tmax[other].ok_or("no tmax")?)?;
            but_for = 4.0 * f32::EPSILON * t.abs();
        } else if words.is(", as is tmax.") {
            same("the equal tmax", tmax[words.axis()?], Some(t))?;
        } else {
            same("how many are smallest", tmax.iter().filter(|other| **other == Some(t)).count(), 1)?;
        }
        if t > least + but_for {
            return Err(format!("tmax {t}, and the smallest is {least}"));
        }
        words.literal(": step ")?;
        let (sign, way) = words.way()?;
        same("the axis", way, axis)?;
        let along = self.before.direction[axis];
        same("the way", sign, if along > 0.0 { 1 } else { -1 })?;
        let mut next = cell_of(data, self.before.cell_index);
        next[axis] += sign;
        if words.is(", out of the grid") {
            // With the paper's numerics a ray has left the grid if its index is outside the arrays.
            let index = index_of(data, next);
            let cells: i64 = data.grid.cells.iter().map(|&n| i64::from(n)).product();
            let is_in = if data.features.robust {
                is_in_grid(data, next)
            } else {
                next.iter().all(|&c| c >= 0) && index < cells
            };
            same("in the grid", is_in, false)?;
            return Ok(("steps out", true));
        }
        let is_wrapped = words.is(", over the grid's face, where the index is that of ");
        same("the index", i64::from(self.after.cell_index), index_of(data, next))?;
        same("in the grid", is_in_grid(data, next), !is_wrapped)?;
        if is_wrapped {
            same("robust", data.features.robust, false)?;
            return Ok(("wraps", false));
        }
        words.literal(" to ")?;
        same("the next cell", cell_of(data, self.after.cell_index), next)?;
        Ok(("steps", false))
    }
}

/// The smallest direction component that the point of entry may have been divided by, kept away from zero.
fn steepest(d: V, reach: f64) -> f64 {
    d.iter().map(|v| v.abs()).filter(|v| *v > 1e-6 * reach).fold(reach, f64::min)
}
