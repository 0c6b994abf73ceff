//! Checks the explanations in a trace against the ray's streams before and after the pass and against the scene's data,
//! with separate arithmetic in f64, not with the code that wrote them.

mod geometry;
mod grid;
mod scan;
mod test;
mod tree;

use raystep_kernels::export::trace::{RayState, Trace, TraceRow};
use raystep_kernels::programs::closest_hit::states::{
    BACKGROUND, DONE, ISECT_HIT, ISECT_NO_HIT, SHADE, TRAV, TRAV_SETUP, UNWRITTEN,
};
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::tables::state::Tag;
use scan::{Scan, same};

/// The kind of an explanation.
pub type Kind = &'static str;

/// A row of a trace.
struct Row<'a> {
    data: &'a SceneData,
    before: &'a RayState,
    after: &'a RayState,
    tested: Option<u32>,
}

/// Checks the explanation of every row. Returns the kinds that occurred; an error names the row.
///
/// # Errors
/// If an explanation cannot be parsed or is wrong.
pub fn check(trace: &Trace, data: &SceneData) -> Result<Vec<Kind>, String> {
    let mut kinds = Vec::new();
    // Before its first pass only a ray's state is known; an input ray has one, and waits for setup.
    let mut before: Option<RayState> = None;
    for row in &trace.rows {
        let unmade = RayState { t: None, triangle: None, barycentric: None, ..row.after };
        let row_before = before.unwrap_or(unmade);
        let one = Row { data, before: &row_before, after: &row.after, tested: row.tested };
        let said = one.check(row).map_err(|why| {
            format!(
                "pass {}, {} ({:?} > {}): {why}\n{}",
                row.number(),
                row.kernel,
                row.state_before,
                row.after.state,
                row.why
            )
        })?;
        kinds.extend(said);
        before = Some(row.after);
    }
    Ok(kinds)
}

impl Row<'_> {
    fn check(&self, row: &TraceRow) -> Result<Vec<Kind>, String> {
        let mut words = Scan::new(&row.why);
        let is_walk = ["traverse_grid", "traverse_bvh", "intersect", "walk"].contains(&row.kernel);
        let cell = (self.data.features.grid && is_walk).then(|| grid::cell_of(self.data, self.before.cell_index));
        same("the row's cell", row.cell_before, cell)?;
        if row.kernel != "intersect" {
            same("the triangle tested", self.tested, None)?;
        }
        let kinds = match row.kernel {
            "generate" => self.generated(&mut words)?,
            "setup" => self.set_up(&mut words)?,
            "traverse_grid" => self.moved_in_grid(&mut words)?,
            "traverse_bvh" => self.moved_in_tree(&mut words)?,
            "intersect" => self.intersected(&mut words)?,
            "walk" => self.walked(&mut words)?,
            "shade" => self.shaded(&mut words)?,
            "accumulate" => self.accumulated(&mut words)?,
            other => return Err(format!("no words of {other} are known")),
        };
        words.end()?;
        Ok(kinds)
    }

    fn is(&self, tag: Tag) -> Result<(), String> {
        same("the state after", self.after.tag, tag)
    }

    fn generated(&self, words: &mut Scan<'_>) -> Result<Vec<Kind>, String> {
        self.is(TRAV_SETUP)?;
        if !self.data.features.samples {
            words.literal("a ray through the pixel's centre")?;
            return Ok(vec!["generated"]);
        }
        words.literal("sample ")?;
        let before = self.before.samples.ok_or("no number of samples")?;
        // In the first row, the only thing known about the time before the pass is that there was no sample.
        same("the sample", words.number::<u32>()?, if self.before.tag == UNWRITTEN { before + 1 } else { 1 })?;
        words.literal(": a ray through its place in the pixel")?;
        Ok(vec!["generated"])
    }

    fn accumulated(&self, words: &mut Scan<'_>) -> Result<Vec<Kind>, String> {
        words.literal("mean of ")?;
        same("samples", Some(words.number::<u32>()?), self.after.samples)?;
        words.literal(" of ")?;
        let all = words.number::<u32>()?;
        words.literal(" samples: ")?;
        let is_last = words.is("the picture has it");
        if !is_last {
            words.literal("on to the next sample")?;
        }
        same("the last sample", is_last, self.after.samples == Some(all))?;
        self.is(if is_last { DONE } else { UNWRITTEN })?;
        Ok(vec!["accumulated"])
    }

    fn shaded(&self, words: &mut Scan<'_>) -> Result<Vec<Kind>, String> {
        let kind = if words.is("equation (1) at triangle ") {
            same("the state before", self.before.tag, SHADE)?;
            same("the triangle", Some(words.number()?), self.before.triangle)?;
            if self.after.tag == SHADE {
                words.literal(": ")?;
                // The item counts lights; the highest bit marks it as such.
                same("lights summed", words.number::<u32>()?, self.after.item & 0x7fff_ffff)?;
                words.literal(" of ")?;
                same("lights", words.number::<u32>()?, self.data.shading.lights)?;
                words.literal(" lights summed so far")?;
                return Ok(vec!["lights summed"]);
            }
            "shaded"
        } else {
            words.literal("nothing was hit: background")?;
            same("the state before", self.before.tag, BACKGROUND)?;
            "background"
        };
        self.is(DONE)?;
        let color = self.after.color.ok_or("no colour")?;
        for (name, value) in [": r ", " g ", " b "].into_iter().zip(color) {
            words.literal(name)?;
            let said = words.number::<f64>()?;
            // Printed with three digits.
            if (said - f64::from(value)).abs() > 0.000_501 {
                return Err(format!("{name}{said}, and it is {value}"));
            }
        }
        Ok(vec![kind])
    }

    fn set_up(&self, words: &mut Scan<'_>) -> Result<Vec<Kind>, String> {
        let (features, triangles) = (&self.data.features, self.data.info.triangles);
        if features.grid {
            return self.started_in_grid(words);
        }
        if words.is("no triangles: there is nothing to hit") {
            same("triangles", triangles, 0)?;
            return Ok(vec!["no triangles"]);
        }
        if features.bvh {
            words.literal("starts at the root of ")?;
            same("nodes", words.number::<usize>()?, self.data.bvh_nodes.len())?;
            words.literal(" nodes")?;
            same("the node", (self.after.cell_index, self.after.previous), (0, Some(u32::MAX)))?;
            self.is(TRAV)?;
        } else {
            words.literal("no grid: all ")?;
            same("triangles", words.number()?, triangles)?;
            words.literal(" triangles are tested")?;
            self.is(ISECT_NO_HIT)?;
        }
        Ok(vec!["started"])
    }

    fn walked(&self, words: &mut Scan<'_>) -> Result<Vec<Kind>, String> {
        let (features, after) = (&self.data.features, self.after);
        let steps = u64::from(self.data.info.steps);
        words.literal("up to ")?;
        let most = words.number::<u64>()?;
        let (unit, expected) = match (features.grid, features.bvh) {
            (true, _) if features.skip => (" steps or leaps: ", steps),
            (true, _) => (" steps: ", steps),
            // A step through a BVH is up to eight nodes.
            (_, true) => (" nodes: ", 8 * steps),
            _ => (" triangles: ", steps),
        };
        words.literal(unit)?;
        same("steps", most, expected)?;
        let kind = if words.is("over, nothing hit") {
            self.is(BACKGROUND)?;
            same("the hit", after.triangle, None)?;
            "walk missed"
        } else if words.is(if features.any_hit {
            "over, any hit ends the ray"
        } else {
            "over, the nearest hit is found"
        }) {
            self.is(SHADE)?;
            "walk hit"
        } else {
            let tag = if features.bvh {
                TRAV
            } else if after.triangle.is_some() && features.grid {
                ISECT_HIT
            } else {
                ISECT_NO_HIT
            };
            if features.grid {
                words.literal("now in ")?;
                same("the cell", words.cell()?, grid::cell_of(self.data, after.cell_index))?;
                self.listing(words, after.cell_index)?;
                self.is(tag)?;
            } else if features.bvh {
                words.literal("now at node ")?;
                same("the node", words.number()?, after.cell_index)?;
            } else {
                same("the item", words.number()?, after.item)?;
                words.literal(" of ")?;
                same("triangles", words.number()?, self.data.info.triangles)?;
                words.literal(" triangles tested")?;
            }
            "walk goes on"
        };
        let is_new = (self.before.triangle, self.before.t) != (after.triangle, after.t);
        if words.is("; a ") {
            same("a nearer one", words.is("nearer "), self.before.triangle.is_some())?;
            words.literal("hit of triangle ")?;
            same("the triangle", Some(words.number()?), after.triangle)?;
            words.literal(" at t ")?;
            same("t", Some(words.number::<f32>()?.to_bits()), after.t.map(f32::to_bits))?;
            same("a new hit", is_new, true)?;
            return Ok(vec![kind, "walk found"]);
        }
        same("a new hit", is_new, false)?;
        Ok(vec![kind])
    }
}
