//! Explanations of the walk through the BVH.

use raystep_kernels::programs::closest_hit::states::{BACKGROUND, ISECT_HIT, ISECT_NO_HIT, SHADE, TRAV};

use super::geometry::{U, interval, ray};
use super::scan::{Scan, same};
use super::{Kind, Row};

/// The parent of a node without one.
const NONE: u32 = u32::MAX;

impl Row<'_> {
    /// The node that has this child, by searching all nodes.
    fn parent_of(&self, node: u32) -> u32 {
        let has = |of: &raystep_kernels::structures::bvh::BvhNode| {
            of.count() == 0 && [of.first, of.first + 1].contains(&node)
        };
        let parent = self.data.bvh_nodes.iter().position(has);
        if node == 0 { NONE } else { parent.map_or(NONE, |parent| parent as u32) }
    }

    /// The child that the ray reaches first, by its direction along the node's split axis.
    fn nearer_child(&self, node: u32) -> u32 {
        let of = &self.data.bvh_nodes[node as usize];
        let along = self.before.direction[((of.link >> 30) as usize).min(2)];
        if along < 0.0 { of.first + 1 } else { of.first }
    }

    pub(super) fn moved_in_tree(&self, words: &mut Scan<'_>) -> Result<Vec<Kind>, String> {
        let (before, after) = (self.before, self.after);
        let at = before.cell_index;
        let parent = self.parent_of(at);
        words.literal("node ")?;
        same("the node", words.number()?, at)?;
        let comes_down = before.previous == Some(parent);
        let mut kinds = Vec::new();
        let mut is_met = false;
        if words.is(": its box is ") {
            same("comes from above or beside", comes_down, true)?;
            is_met = words.is("met: ");
            if !is_met {
                words.literal("missed")?;
                let is_beyond_hit = words.is(", or beyond the nearest hit");
                same("a nearest hit", is_beyond_hit, before.triangle.is_some())?;
                same("an end", is_beyond_hit || words.is(", or beyond the ray's end"), before.t.is_some())?;
                words.literal(": ")?;
            }
            self.box_is(is_met)?;
            kinds.push(if is_met { "box met" } else { "box missed" });
        } else {
            words.literal(" is done: ")?;
            same("comes from above or beside", comes_down, false)?;
            kinds.push("node done");
        }
        let has_hit = before.triangle.is_some();
        let node = &self.data.bvh_nodes[at as usize];
        let is_down = if words.is("a leaf, which lists ") {
            let count = words.number::<u32>()?;
            words.literal(if count == 1 { " triangle" } else { " triangles" })?;
            same("listed", count, node.count())?;
            same("the place", (after.cell_index, after.previous, after.item), (at, Some(at), 0))?;
            self.is(if has_hit { ISECT_HIT } else { ISECT_NO_HIT })?;
            kinds.push("leaf");
            true
        } else if words.is("down to node ") {
            let to = words.number::<u32>()?;
            words.literal(", the nearer child")?;
            same("the nearer child", to, self.nearer_child(at))?;
            same("the place", (after.cell_index, after.previous), (to, Some(at)))?;
            self.is(TRAV)?;
            kinds.push("down");
            true
        } else {
            let is_nearer = parent != NONE && self.nearer_child(parent) == at;
            if words.is("up to node ") {
                let to = words.number::<u32>()?;
                same("the parent", (to, is_nearer), (parent, false))?;
                same("the place", (after.cell_index, after.previous), (to, Some(at)))?;
                self.is(TRAV)?;
                kinds.push("up");
            } else if words.is("on to node ") {
                let to = words.number::<u32>()?;
                words.literal(", the sibling")?;
                same("the sibling", (self.parent_of(to), is_nearer, to == at), (parent, true, false))?;
                same("the place", (after.cell_index, after.previous), (to, Some(parent)))?;
                self.is(TRAV)?;
                kinds.push("sibling");
            } else {
                words.literal("the tree is done; ")?;
                words.literal(if has_hit { "the kept hit is the nearest" } else { "nothing hit" })?;
                same("the root", at, 0)?;
                self.is(if has_hit { SHADE } else { BACKGROUND })?;
                kinds.push("tree done");
            }
            false
        };
        same("a box that is met is entered", is_met, is_down)?;
        Ok(kinds)
    }

    /// Checked in f64: a box that is hit must be hit when slightly enlarged; one that is missed must be missed when
    /// slightly shrunk.
    fn box_is(&self, is_met: bool) -> Result<(), String> {
        let node = &self.data.bvh_nodes[self.before.cell_index as usize];
        let (min, max) = (node.min.map(f64::from), node.max.map(f64::from));
        let (o, d) = ray(self.before);
        // Four roundings of the distance to a face, in t; in space the same of the largest distance.
        let far = min.into_iter().chain(max).chain(o).fold(0.0, |m: f64, v| m.max(v.abs()));
        let by = 8.0 * U * far;
        let nearest = self.before.t.map_or(f64::INFINITY, f64::from);
        let within = |by: f64, rounding: f64| {
            interval((o, d), min, max, by)
                .is_some_and(|[enter, leave]| leave >= 0.0 && enter.max(0.0) <= nearest * (1.0 + rounding))
        };
        let holds = if is_met { within(by, 8.0 * U) } else { !within(-by, -8.0 * U) };
        if holds { Ok(()) } else { Err(format!("its box is said to be met: {is_met}, and in f64 it is not so")) }
    }
}
