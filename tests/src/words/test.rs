//! Explanations of a triangle test, and of what follows at the end of a list.

use raystep_kernels::programs::closest_hit::states::{BACKGROUND, ISECT_HIT, ISECT_NO_HIT, SHADE, TRAV};
use raystep_lab::reference::possible;

use super::geometry::{OnPlane, on_plane, ray};
use super::grid::{distance, listed};
use super::scan::{Scan, same};
use super::{Kind, Row};

/// The threshold on the determinant in Möller and Trumbore's paper.
const SMALL: f64 = 1e-6;

impl Row<'_> {
    /// The list that the ray works on: its length, and the next triangle in it.
    fn list(&self) -> (u32, Option<u32>) {
        let (data, at, item) = (self.data, self.before.cell_index as usize, self.before.item);
        if data.features.grid {
            let first = data.grid_cells[at];
            let count = listed(data, at as u32) as u32;
            (count, (item < count).then(|| data.grid_items[(first + item) as usize]))
        } else if data.features.bvh {
            let node = &data.bvh_nodes[at];
            (node.count(), (item < node.count()).then(|| data.bvh_items[(node.first + item) as usize]))
        } else {
            (data.info.triangles, (item < data.info.triangles).then_some(item))
        }
    }

    pub(super) fn intersected(&self, words: &mut Scan<'_>) -> Result<Vec<Kind>, String> {
        let (count, next) = self.list();
        same("the triangle tested", self.tested, next)?;
        let mut kinds = Vec::new();
        if let Some(triangle) = next {
            words.literal("triangle ")?;
            same("the triangle", words.number()?, triangle)?;
            words.literal(": ")?;
            kinds.push(self.tested(words, triangle)?);
            same("the item", self.after.item, self.before.item + 1)?;
        }
        let has_hit = self.after.triangle.is_some();
        if self.data.features.any_hit && has_hit {
            words.literal("; any hit ends the ray")?;
            self.is(SHADE)?;
            kinds.push("any hit");
            return Ok(kinds);
        }
        // The paper's numerics take another pass to notice the end of a list.
        let ends = if self.data.features.robust { self.before.item + 1 >= count } else { next.is_none() };
        if !ends {
            self.is(if has_hit { ISECT_HIT } else { ISECT_NO_HIT })?;
            return Ok(kinds);
        }
        if next.is_some() {
            words.literal("; ")?;
        }
        kinds.push(self.ended(words, count, next.is_some())?);
        Ok(kinds)
    }

    fn ended(&self, words: &mut Scan<'_>, count: u32, has_tested: bool) -> Result<Kind, String> {
        let (features, after) = (&self.data.features, self.after);
        let has_hit = after.triangle.is_some();
        if features.bvh {
            words.literal("the leaf is done")?;
            self.is(TRAV)?;
            return Ok("leaf done");
        }
        words.literal(match (features.grid, count, has_tested) {
            (true, 0, _) => "empty cell",
            (false, 0, _) => "no triangles",
            (false, _, true) => "last triangle",
            _ => "list ended",
        })?;
        if !features.grid {
            words.literal(if has_hit { ": the nearest hit is accepted" } else { ": nothing hit" })?;
            self.is(if has_hit { SHADE } else { BACKGROUND })?;
            return Ok(if has_hit { "last accepted" } else { "last missed" });
        }
        if words.is(" with a hit: accepted") {
            same("counts only in its cell, a hit", (features.in_cell, has_hit), (true, true))?;
            self.is(SHADE)?;
            return Ok("accepted in its cell");
        }
        words.literal(": ")?;
        let least = self.before.tmax.iter().flatten().copied().reduce(f32::min);
        if features.any_hit && after.t <= least {
            words.literal("the ray ends at t ")?;
            same("the ray's end", Some(words.number::<f32>()?.to_bits()), after.t.map(f32::to_bits))?;
            words.literal(" <= exit ")?;
            same("the exit", Some(words.number::<f32>()?), least)?;
            words.literal(", nothing hit")?;
            self.is(BACKGROUND)?;
            return Ok("ray ended");
        }
        let mut kind = if count == 0 { "empty cell" } else { "list ended" };
        if words.is("t ") {
            same("t", Some(words.number::<f32>()?.to_bits()), after.t.map(f32::to_bits))?;
            same("counts only in its cell, a hit", (features.in_cell, has_hit), (false, true))?;
            let is_accepted = words.is(" <= exit ");
            if !is_accepted {
                words.literal(" is beyond the exit ")?;
            }
            let exit = words.number::<f32>()?;
            same("the exit", Some(exit), least)?;
            same("t within the exit", after.t <= least, is_accepted)?;
            if is_accepted {
                words.literal(", accepted")?;
                self.is(SHADE)?;
                return Ok(if count == 0 { "accepted in an empty cell" } else { "accepted" });
            }
            words.literal(", kept; ")?;
            kind = "kept";
        } else {
            same("a hit", has_hit, false)?;
        }
        let leaps = features.skip && distance(self.data, self.before.cell_index) > 1;
        words.literal(if leaps { "on past empty cells" } else { "on to the next cell" })?;
        self.is(TRAV)?;
        Ok(kind)
    }

    fn tested(&self, words: &mut Scan<'_>, triangle: u32) -> Result<Kind, String> {
        let (data, before, after) = (self.data, self.before, self.after);
        let robust = data.features.robust;
        let exact = on_plane(data, ray(before), triangle);
        let may_hit = possible(&data.vertices, before.origin, before.direction, triangle);
        let is_new = (before.triangle, before.t) != (after.triangle, after.t);
        if words.is("hit at t ") {
            let t = words.number::<f32>()?;
            exact.near("t", f64::from(t), exact.t, exact.bounds[1])?;
            if robust && may_hit.is_none() {
                return Err("a hit, and no rounding takes the ray into the triangle".into());
            }
            if words.is(", u ") {
                same("a new hit", is_new, true)?;
                let u = words.number::<f32>()?;
                words.literal(", v ")?;
                let said = [t, u, words.number::<f32>()?].map(f32::to_bits);
                let [u, v] = after.barycentric.ok_or("no weights")?;
                same("the hit", Some(said), after.t.map(|t| [t, u, v].map(f32::to_bits)))?;
                same("the hit's triangle", after.triangle, Some(triangle))?;
                if before.t.is_some_and(|nearest| t > nearest) {
                    return Err("a hit farther than the one before".into());
                }
                return Ok("hit");
            }
            same("a new hit", is_new, false)?;
            if words.is(", beyond the ray's end ") {
                let end = words.number::<f32>()?;
                same("the ray's end", Some(end.to_bits()), before.t.map(f32::to_bits))?;
                same("any hit, beyond", (data.features.any_hit, t >= end), (true, true))?;
                return Ok("beyond the end");
            }
            if words.is(", not nearer than ") {
                let nearest = words.number::<f32>()?;
                same("the nearest", Some(nearest.to_bits()), before.t.map(f32::to_bits))?;
                if t < nearest || before.triangle.is_none_or(|before| before == triangle) {
                    return Err(format!("t {t} is nearer than {nearest}, or the same hit"));
                }
                return Ok("not nearer");
            }
            words.literal(", but outside of this cell")?;
            same("counts only in its cell", data.features.in_cell, true)?;
            self.is_outside_of_cell(&exact)?;
            return Ok("outside of the cell");
        }
        same("a new hit", is_new, false)?;
        if words.is("tested again, the same hit at t ") {
            same("t", Some(words.number::<f32>()?.to_bits()), before.t.map(f32::to_bits))?;
            same("the nearest hit's triangle", before.triangle, Some(triangle))?;
            return Ok("again");
        }
        if robust && may_hit.is_some_and(|p| p.is_definite && before.t.is_none_or(|t| p.t + p.t_bound < f64::from(t))) {
            return Err("a miss, and whatever the rounding, the ray hits".into());
        }
        self.missed(words, &exact)
    }

    fn missed(&self, words: &mut Scan<'_>, exact: &OnPlane) -> Result<Kind, String> {
        let robust = self.data.features.robust;
        let least = exact.weights.iter().copied().fold(f64::INFINITY, f64::min);
        // If the ray lies nearly in the plane, nothing is known about where it meets it.
        let is_steep = exact.bounds[0] < 0.5;
        if words.is("seen edge-on") {
            return if is_steep { Err(format!("seen from the side by {}", exact.det)) } else { Ok("edge-on") };
        }
        if words.is("outside by less than a rounding") || words.is("missed by less than a rounding") {
            let is_close = least.abs() <= exact.bounds[0] || exact.t.abs() <= exact.bounds[1];
            return if is_close || !is_steep {
                Ok("rounding")
            } else {
                Err(format!("missed by {least}, t {}", exact.t))
            };
        }
        if words.is("determinant ") {
            let det = words.number::<f32>()?;
            words.literal(" is below 0.000001, taken as edge-on")?;
            same("robust", robust, false)?;
            exact.near("the determinant", f64::from(det), exact.det, exact.bounds[2])?;
            return if f64::from(det).abs() < SMALL { Ok("small determinant") } else { Err(format!("{det}")) };
        }
        if words.is("t ") {
            let t = words.number::<f32>()?;
            words.literal(", behind the origin")?;
            same("behind", t <= 0.0, true)?;
            if is_steep {
                exact.near("t", f64::from(t), exact.t, exact.bounds[1])?;
                exact.near("an inside weight", least.min(0.0), 0.0, exact.bounds[0])?;
            }
            return Ok("behind");
        }
        let weights = [("u = ", 0), ("v = ", 1), ("1 - u - v = ", 2)];
        let (_, which) = weights.into_iter().find(|(name, _)| words.is(name)).ok_or("no reason that is known")?;
        let weight = words.number::<f32>()?;
        words.literal(", outside")?;
        same("outside", weight < 0.0, true)?;
        if is_steep {
            exact.near("the weight", f64::from(weight), exact.weights[which], exact.bounds[0])?;
            exact.near("the smallest weight", exact.weights[which], least, exact.bounds[0])?;
        }
        Ok("outside")
    }

    /// Succeeds if the exact hit is outside the cell, or within rounding of its faces.
    fn is_outside_of_cell(&self, exact: &OnPlane) -> Result<(), String> {
        let grid = &self.data.grid;
        let cell = super::grid::cell_of(self.data, self.before.cell_index);
        let (o, d) = ray(self.before);
        let is_outside = (0..3).any(|a| {
            let low = f64::from(grid.corner[a]) + f64::from(grid.width[a]) * f64::from(cell[a]);
            let high = low + f64::from(grid.width[a]);
            let place = o[a] + d[a] * exact.t;
            let slack =
                d[a].abs() * exact.bounds[1] + 16.0 * super::geometry::U * (low.abs() + high.abs() + o[a].abs());
            place < low + slack || place > high - slack
        });
        same("outside of the cell", true, is_outside)
    }
}

impl OnPlane {
    fn near(&self, what: &str, said: f64, is: f64, bound: f64) -> Result<(), String> {
        // The negated comparison catches NaN.
        #[allow(clippy::neg_cmp_op_on_partial_ord, reason = "NaN is near nothing")]
        let is_off = !((said - is).abs() <= bound) && bound.is_finite();
        if is_off { Err(format!("{what}: {said} is said, and it is {is}, give or take {bound:e}")) } else { Ok(()) }
    }
}
