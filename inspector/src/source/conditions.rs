//! What every condition of a kernel's file means for a ray's streams before and after the pass.
//!
//! Conditions are identified by their text, so that changing a kernel fails a test instead of marking the wrong lines.
//! A condition with the same text has the same meaning throughout a file. `None` is for what the streams do not show.

use raystep_kernels::Kernel;
use raystep_kernels::export::trace::RayState;
use raystep_kernels::options::features::Features;
use raystep_kernels::shared::constants::LIGHTS_SUMMED;
use raystep_kernels::tables::state::{BACKGROUND, ISECT_HIT, ISECT_NO_HIT, SHADE, TRAV, TRAV_SETUP, Tag, UNWRITTEN};

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
    /// The kernel with this condition.
    pub kernel: Kernel,
    /// The text in parentheses, with whitespace normalised.
    pub text: &'static str,
    /// Whether it held; for a loop, whether its body ran at all.
    pub held: fn(&Case) -> Option<bool>,
}

const fn row(kernel: Kernel, text: &'static str, held: fn(&Case) -> Option<bool>) -> Condition {
    Condition { kernel, text, held }
}

/// A ray that has streams is inside the image.
const OUTSIDE: &str = "any(texel >= textureDimensions(state))";

/// Every condition that a ray can meet in one of the paper's kernels.
pub const CONDITIONS: &[Condition] = &[
    row(Kernel::Generate, OUTSIDE, |_| Some(false)),
    row(Kernel::Generate, "textureLoad(state, texel, 0).x != UNWRITTEN", |c| Some(!c.was(&[UNWRITTEN]))),
    row(Kernel::Setup, OUTSIDE, |_| Some(false)),
    row(Kernel::Setup, "textureLoad(state, texel, 0).x != TRAV_SETUP", |c| Some(!c.was(&[TRAV_SETUP]))),
    // The only way to BACKGROUND with a grid; without one, this line is omitted.
    row(Kernel::Setup, "!walk.inside", |c| Some(c.is(&[BACKGROUND]))),
    row(Kernel::TraverseGrid, OUTSIDE, |_| Some(false)),
    row(Kernel::TraverseGrid, "textureLoad(state, texel, 0).x != TRAV", |c| Some(!c.was(&[TRAV]))),
    row(Kernel::TraverseGrid, "!walk.inside", |c| Some(c.is(&[SHADE, BACKGROUND]))),
    row(Kernel::TraverseBvh, OUTSIDE, |_| Some(false)),
    row(Kernel::TraverseBvh, "textureLoad(state, texel, 0).x != TRAV", |c| Some(!c.was(&[TRAV]))),
    row(Kernel::TraverseBvh, "at.node == NO_NODE", |c| Some(c.is(&[SHADE, BACKGROUND]))),
    // The streams contain nothing about earlier cells.
    row(Kernel::Intersect, "var step = 0; step < bound && walk.inside; step++", |_| None),
    row(Kernel::Intersect, "index == cell", |_| None),
    row(Kernel::Intersect, "low < high", |_| None),
    row(Kernel::Intersect, "grid_items[middle] < triangle", |_| None),
    row(Kernel::Intersect, "begun != NO_CELL", |_| None),
    row(Kernel::Intersect, "turns >= TURNS", |c| Some(c.searches_on())),
    row(Kernel::Intersect, "is_listed(triangle, index)", |_| None),
    row(Kernel::Intersect, "repeated == NOT_KNOWN_YET", |c| Some(c.searches_on())),
    row(Kernel::Intersect, OUTSIDE, |_| Some(false)),
    row(Kernel::Intersect, "tag != ISECT_NO_HIT && tag != ISECT_HIT", |c| Some(!c.was(&[ISECT_NO_HIT, ISECT_HIT]))),
    row(Kernel::Intersect, "in_list", |c| Some(c.after.item != c.before.item || c.searches_on())),
    row(Kernel::Intersect, "candidate.is_hit && accepted", |c| Some(c.has_new_hit())),
    row(Kernel::Intersect, "ended", |c| match c.is(&[ISECT_NO_HIT, ISECT_HIT]) {
        true => Some(false),
        // Any hit goes to SHADE, whether the list has ended or not.
        false if c.features.any_hit && c.has_nearer_hit() => None,
        false => Some(true),
    }),
    row(Kernel::Intersect, "nearest_t < nearest_before", |c| Some(c.has_nearer_hit())),
    row(Kernel::Shade, "light.kind == 1u", |_| None),
    row(Kernel::Shade, "light.kind == 2u", |_| None),
    row(Kernel::Shade, OUTSIDE, |_| Some(false)),
    row(Kernel::Shade, "tag != SHADE && tag != BACKGROUND", |c| Some(!c.was(&[SHADE, BACKGROUND]))),
    row(Kernel::Shade, "tag == SHADE", |c| Some(c.was(&[SHADE]))),
    row(Kernel::Shade, "material.texture != 0xffffffffu", |_| None),
    row(Kernel::Shade, "material.double_sided != 0u && dot3(normal, direction) > 0.0", |_| None),
    row(Kernel::Shade, "var i = 0u; i < shading.lights; i++", |_| None),
    row(Kernel::Shade, "first >= LIGHTS_SUMMED", |c| Some(c.before.item >= LIGHTS_SUMMED)),
    row(Kernel::Shade, "var i = first; i < end; i++", |_| None),
    row(Kernel::Shade, "end < shading.lights", |c| Some(c.is(&[SHADE]))),
    row(Kernel::Accumulate, OUTSIDE, |_| Some(false)),
    row(Kernel::Accumulate, "textureLoad(state, texel, 0).x != DONE || before >= f32(sampling.samples)", |c| {
        Some(c.after.samples == c.before.samples)
    }),
    row(Kernel::Accumulate, "samples < f32(sampling.samples)", |c| Some(c.is(&[UNWRITTEN]))),
    // For a kernel that takes several steps, only the code around them.
    row(Kernel::Walk, OUTSIDE, |_| Some(false)),
    row(Kernel::Walk, "place.tag != TRAV && place.tag != ISECT_NO_HIT && place.tag != ISECT_HIT", |c| {
        Some(!c.was(&[TRAV, ISECT_NO_HIT, ISECT_HIT]))
    }),
    row(Kernel::Walk, "place.trace.triangle != triangle_before || place.trace.t != t_before", |c| {
        Some(c.has_new_hit())
    }),
];

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

    /// Whether the search for a repeated test continues in the next pass: only then does a ray stay at the same item.
    fn searches_on(&self) -> bool {
        self.after.item == self.before.item && self.is(&[ISECT_NO_HIT, ISECT_HIT])
    }

    /// A different triangle at the same t counts too: hits are ordered by (t, triangle).
    fn has_new_hit(&self) -> bool {
        self.has_nearer_hit() || self.after.triangle != self.before.triangle
    }

    /// Whether a condition held; `None` if the streams do not show it, or the table lacks it.
    pub(super) fn held(&self, kernel: Kernel, text: &str) -> Option<bool> {
        CONDITIONS.iter().find(|c| c.kernel == kernel && c.text == text).and_then(|c| (c.held)(self))
    }
}
