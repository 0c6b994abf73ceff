//! What every condition of a kernel's file means for a ray's streams before and after the pass.
//!
//! A condition is identified by its text, so if a kernel changes, a test fails before a line is marked wrongly.
//! The same text always means the same in a file. `None` is for what the streams do not tell.

use super::ray_state::RayState;
use super::states::{BACKGROUND, ISECT_HIT, ISECT_NO_HIT, SHADE, TRAV, TRAV_SETUP, UNWRITTEN};
use crate::options::features::Features;
use crate::program::Kernel;
use crate::shared::constants::LIGHTS_SUMMED;
use crate::tables::state::Tag;

/// A ray in one pass.
#[derive(Clone, Copy, Debug)]
pub struct Case<'a> {
    /// The run's options.
    pub features: &'a Features,
    /// The ray before the pass.
    pub before: &'a RayState,
    /// The ray after it.
    pub after: &'a RayState,
}

/// A row of the table.
#[derive(Clone, Copy, Debug)]
pub struct Condition {
    /// The text between its parentheses, with single spaces.
    pub text: &'static str,
    /// Whether it was true; for a loop, whether its body ran at all.
    pub held: fn(&Case) -> Option<bool>,
}

const fn row(text: &'static str, held: fn(&Case) -> Option<bool>) -> Condition {
    Condition { text, held }
}

/// Always false: a ray that has texels is inside the image.
const OUTSIDE: &str = "any(texel >= textureDimensions(state))";

pub(super) const OF_GENERATE: &[Condition] = &[
    row(OUTSIDE, |_| Some(false)),
    row("textureLoad(state, texel, 0).x != UNWRITTEN", |c| Some(!c.was(&[UNWRITTEN]))),
];

pub(super) const OF_SETUP: &[Condition] = &[
    row(OUTSIDE, |_| Some(false)),
    row("textureLoad(state, texel, 0).x != TRAV_SETUP", |c| Some(!c.was(&[TRAV_SETUP]))),
    // With a grid, the only way to BACKGROUND; without one, this line is left out.
    row("!walk.inside", |c| Some(c.is(&[BACKGROUND]))),
];

pub(super) const OF_TRAVERSE_GRID: &[Condition] = &[
    row(OUTSIDE, |_| Some(false)),
    row("textureLoad(state, texel, 0).x != TRAV", |c| Some(!c.was(&[TRAV]))),
    row("!walk.inside", |c| Some(c.is(&[SHADE, BACKGROUND]))),
];

pub(super) const OF_TRAVERSE_BVH: &[Condition] = &[
    row(OUTSIDE, |_| Some(false)),
    row("textureLoad(state, texel, 0).x != TRAV", |c| Some(!c.was(&[TRAV]))),
    row("at.node == NO_NODE", |c| Some(c.is(&[SHADE, BACKGROUND]))),
];

pub(super) const OF_INTERSECT: &[Condition] = &[
    // The streams hold nothing about earlier cells.
    row("var step = 0; step < bound && walk.inside; step++", |_| None),
    row("index == cell", |_| None),
    row("low < high", |_| None),
    row("grid_items[middle] < triangle", |_| None),
    row("begun != NO_CELL", |_| None),
    row("turns >= TURNS", |c| Some(c.searches_on())),
    row("is_listed(triangle, index)", |_| None),
    row("repeated == NOT_KNOWN_YET", |c| Some(c.searches_on())),
    row(OUTSIDE, |_| Some(false)),
    row("tag != ISECT_NO_HIT && tag != ISECT_HIT", |c| Some(!c.was(&[ISECT_NO_HIT, ISECT_HIT]))),
    row("in_list", |c| Some(c.after.item != c.before.item || c.searches_on())),
    row("candidate.is_hit && accepted", |c| Some(c.has_new_hit())),
    row("ended", |c| match c.is(&[ISECT_NO_HIT, ISECT_HIT]) {
        true => Some(false),
        // Any hit goes to SHADE, whether the list has ended or not.
        false if c.features.any_hit && c.has_nearer_hit() => None,
        false => Some(true),
    }),
    row("nearest_t < nearest_before", |c| Some(c.has_nearer_hit())),
    // A ray that ends at any hit may be there because its list ended.
    row("tag == TRAV && load_interval(texel).y <= exit", |c| (!c.features.any_hit).then_some(c.is(&[BACKGROUND]))),
];

pub(super) const OF_SHADE: &[Condition] = &[
    row("light.kind == 1u", |_| None),
    row("light.kind == 2u", |_| None),
    row(OUTSIDE, |_| Some(false)),
    row("tag != SHADE && tag != BACKGROUND", |c| Some(!c.was(&[SHADE, BACKGROUND]))),
    row("tag == SHADE", |c| Some(c.was(&[SHADE]))),
    row("material.texture != 0xffffffffu", |_| None),
    row("material.double_sided != 0u && dot3(normal, direction) > 0.0", |_| None),
    row("var i = 0u; i < shading.lights; i++", |_| None),
    row("first >= LIGHTS_SUMMED", |c| Some(c.before.item >= LIGHTS_SUMMED)),
    row("var i = first; i < end; i++", |_| None),
    row("end < shading.lights", |c| Some(c.is(&[SHADE]))),
];

pub(super) const OF_ACCUMULATE: &[Condition] = &[
    row(OUTSIDE, |_| Some(false)),
    row("textureLoad(state, texel, 0).x != DONE || before >= f32(sampling.samples)", |c| {
        Some(c.after.samples == c.before.samples)
    }),
    row("samples < f32(sampling.samples)", |c| Some(c.is(&[UNWRITTEN]))),
];

// Of a kernel that takes several steps, only the conditions before and after the steps.
pub(super) const OF_WALK: &[Condition] = &[
    row(OUTSIDE, |_| Some(false)),
    row("place.tag != TRAV && place.tag != ISECT_NO_HIT && place.tag != ISECT_HIT", |c| {
        Some(!c.was(&[TRAV, ISECT_NO_HIT, ISECT_HIT]))
    }),
    row("place.trace.triangle != triangle_before || place.trace.t != t_before", |c| Some(c.has_new_hit())),
];

/// The conditions of a kernel's file that a ray's pass through it can meet.
#[must_use]
pub fn of(kernel: Kernel) -> &'static [Condition] {
    super::own(kernel).map_or(&[], |own| own.conditions)
}

impl Case<'_> {
    fn was(&self, tags: &[Tag]) -> bool {
        tags.contains(&self.before.tag)
    }

    fn is(&self, tags: &[Tag]) -> bool {
        tags.contains(&self.after.tag)
    }

    fn has_nearer_hit(&self) -> bool {
        self.after.t != self.before.t
    }

    /// Whether the search for a repeated test continues in the next pass: nothing else leaves a ray at the same item of
    /// its list.
    fn searches_on(&self) -> bool {
        self.after.item == self.before.item && self.is(&[ISECT_NO_HIT, ISECT_HIT])
    }

    /// A different triangle at the same t counts too: hits are ordered by (t, triangle).
    fn has_new_hit(&self) -> bool {
        self.has_nearer_hit() || self.after.triangle != self.before.triangle
    }

    /// Whether a condition was true; `None` if the streams do not tell, or the table does not contain it.
    #[must_use]
    pub fn held(&self, kernel: Kernel, text: &str) -> Option<bool> {
        of(kernel).iter().find(|c| c.text == text).and_then(|c| (c.held)(self))
    }
}
