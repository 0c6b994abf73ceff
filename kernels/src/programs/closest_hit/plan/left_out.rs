//! Why a run of rays does without some rows of the tables, and some code.

use raystep_scenes::Scene;

use crate::options::keep::Item;
use crate::options::{Options, Rule};
use crate::plan::{Because, LeftOut, Plan, absent};

/// Everything that a run of rays leaves out: rows of the tables, and code.
pub(super) fn left_out(plan: &Plan, scene: &Scene, options: &Options) -> Vec<LeftOut> {
    let mut all = absent(plan, options);
    let f = &plan.features;
    let one_light = if scene.lights.is_empty() { "no light: one headlight" } else { "one light" };
    let code = [
        (
            Item::Clipping,
            f.structure().has_cells() && f.robust,
            "code that clips rays to the grid",
            "the camera is inside the grid",
        ),
        (
            Item::RayPadding,
            f.bvh && options.without != Some(Rule::BoxPadding),
            "code that grows boxes by their distance",
            "growth by the reach of the scene hardly enlarges boxes",
        ),
        (Item::ManyLights, options.shade && !f.shadows, "code for more than one light", one_light),
        (Item::DirectionalLights, options.shade, "code for directional lights", "no directional light"),
        (Item::SpotLights, options.shade, "code for spot lights", "no spot light"),
        (Item::Emission, options.shade, "code for emitted light", "no emissive material"),
        (Item::DoubleSided, options.shade, "code for double-sided materials", "no double-sided material"),
    ];
    for (item, _, what, reason) in code.into_iter().filter(|&(item, has_place, ..)| has_place && !f.has(item)) {
        all.push(LeftOut { what: what.into(), because: Because::Scene, reason, item: Some(item) });
    }
    // What this scene does without is what a reader wants to know.
    all.sort_by_key(|item| item.because != Because::Scene);
    all
}
