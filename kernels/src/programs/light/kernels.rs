//! Its kernels: those of the walk for shadow rays, and the one that casts them.

use super::{breaks, explain, rounding};
use crate::options::reasons::{Reason, Run};
use crate::program::instance::twin;
use crate::program::kernel::{Path, Proof};
use crate::program::{Home, Instance, KernelInfo, Renamed};
use crate::programs::closest_hit::kernels::{DECIDE, SETUP};
use crate::programs::closest_hit::states::{
    ALL, BACKGROUND, DONE, OCCLUDED, SCATTER, SHADE, SHADOW_SETUP, TRAV_SETUP, VISIBLE,
};
use crate::programs::closest_hit::streams::{no_shadows, no_specular};
use crate::programs::closest_hit::{self, streams};
use crate::shared::constants::LIST_SIDE;
use crate::tables::kernel::{Counts, Launch, ListInfo, Role, Transition};
use crate::tables::state::Tag;

/// The tables that its own kernel names.
static HOME: Home = Home { streams: &streams::STREAMS, states: ALL };

/// The states of a walk, and what they are called for a shadow ray: any hit ends it, so none is kept while it walks.
const STATES: [(&str, &str); 7] = [
    ("TRAV_SETUP", "SHADOW_SETUP"),
    ("TRAV", "SHADOW_TRAV"),
    ("ISECT_NO_HIT", "SHADOW_ISECT"),
    ("ISECT_HIT", ""),
    ("EXACT", "SHADOW_EXACT"),
    ("SHADE", "OCCLUDED"),
    ("BACKGROUND", "VISIBLE"),
];

/// The streams and lists of a walk that shadow rays have of their own.
const BINDS: &[(&str, &str)] = &[
    ("ray_origin", "shadow_origin"),
    ("ray_direction", "shadow_direction"),
    ("hit", "blocker"),
    ("counters", "shadow_counters"),
    ("intersect_list", "shadow_intersect_list"),
    ("traverse_list", "shadow_traverse_list"),
];

/// Lists of live rays, for each kind of ray.
pub(in crate::programs) const LISTS: [ListInfo; 4] = [
    closest_hit::kernels::LISTS[0],
    closest_hit::kernels::LISTS[1],
    ListInfo { name: "shadow_intersect_list", slots: ["shadow_intersect_list_even", "shadow_intersect_list_odd"] },
    ListInfo { name: "shadow_traverse_list", slots: ["shadow_traverse_list_even", "shadow_traverse_list_odd"] },
];

/// The names of the kernels of a walk for shadow rays, why a run does without each, and its colour.
pub(super) type OfShadows = (&'static str, fn(&Run<'_>) -> Reason, [u8; 3]);
pub(super) const SHADOWS: [OfShadows; 8] = [
    ("shadow_setup", absent::<0>, [170, 130, 60]),
    ("shadow_traverse_grid", absent::<1>, [140, 110, 60]),
    ("shadow_traverse_irregular", absent::<2>, [140, 110, 60]),
    ("shadow_traverse_bvh", absent::<3>, [140, 110, 60]),
    ("shadow_intersect", absent::<4>, [190, 90, 120]),
    ("shadow_walk", absent::<5>, [160, 120, 90]),
    ("shadow_fused", absent::<6>, [150, 70, 110]),
    ("shadow_decide", absent::<7>, [170, 40, 100]),
];
const _: () = assert!(DECIDE.index() - SETUP.index() + 1 == SHADOWS.len());

/// Why a run does without a kernel of the walk for shadow rays: what it would be needed for, if there are any.
fn absent<const OF: usize>(run: &Run<'_>) -> Reason {
    match run.features.shadows {
        true => (closest_hit::kernels::KERNELS[SETUP.index() + OF].kernel.why_absent)(run),
        false => no_shadows(run),
    }
}

const fn send(from: Tag, when: &'static str, to: Tag) -> Transition {
    Transition { from, when, to }
}

/// Casts shadow rays, and adds up the light that they bring.
pub(super) const OF_ILLUMINATE: KernelInfo = KernelInfo {
    name: "illuminate",
    wgsl: include_str!("illuminate.wgsl"),
    twin: twin!(element illuminate),
    home: &HOME,
    takes: &[SHADE, BACKGROUND, OCCLUDED, VISIBLE],
    sends: &[
        send(SHADE, "casts a shadow ray", SHADOW_SETUP),
        send(SHADE, "loop turns spent, lights are left", SHADE),
        send(SHADE, "no light shines on it", DONE),
        send(SHADE, "no light shines on it, rays may go on", SCATTER),
        send(BACKGROUND, "background", DONE),
        send(BACKGROUND, "background, of a ray that may be one of several", SCATTER),
        send(OCCLUDED, "casts the next shadow ray", SHADOW_SETUP),
        send(OCCLUDED, "loop turns spent, lights are left", SHADE),
        send(OCCLUDED, "it was the last light", DONE),
        send(OCCLUDED, "it was the last light, rays may go on", SCATTER),
        send(VISIBLE, "adds the light, and casts the next shadow ray", SHADOW_SETUP),
        send(VISIBLE, "adds the light; loop turns spent, lights are left", SHADE),
        send(VISIBLE, "adds the light of the last", DONE),
        send(VISIBLE, "adds the light of the last, rays may go on", SCATTER),
    ],
    role: Role::Finish,
    workgroup: LIST_SIDE,
    launch: Launch::Whole,
    counts: Counts::Sent,
    resumes: |features| features.resumes_light,
    list: None,
    proof: Proof::NONE,
    colour: [90, 165, 90],
    why_absent: no_shadows,
    summary: "casts a shadow ray to the next light, and adds what the one before brought",
    explain: explain::of_illuminate,
    path: Path::Stays,
    rounding: rounding::OF_ILLUMINATE,
    breaks: breaks::OF_ILLUMINATE,
};

/// Adds the light of a hit to the pixel's, and goes on with what the surface reflects and refracts.
pub(super) const OF_SCATTER: KernelInfo = KernelInfo {
    name: "scatter",
    wgsl: include_str!("scatter.wgsl"),
    twin: twin!(element scatter),
    home: &HOME,
    takes: &[SCATTER],
    sends: &[
        send(SCATTER, "a ray is reflected or refracted, or one that waits is next", TRAV_SETUP),
        send(SCATTER, "no ray goes on, and none waits", DONE),
    ],
    role: Role::Finish,
    workgroup: LIST_SIDE,
    launch: Launch::Whole,
    counts: Counts::Sent,
    resumes: |_| false,
    list: None,
    proof: Proof::NONE,
    colour: [60, 150, 170],
    why_absent: no_specular,
    summary: "adds the light of the hit to the pixel's, and goes on with what the surface reflects and refracts",
    explain: explain::of_scatter,
    path: Path::Stays,
    rounding: rounding::OF_SCATTER,
    breaks: breaks::OF_SCATTER,
};

/// The instance of a kernel of the walk for shadow rays.
pub(super) fn for_shadow_rays(of: Instance, (name, why_absent, colour): OfShadows) -> Option<Instance> {
    let renamed = Renamed::new(&of.kernel, ALL, &STATES)?.of_existing();
    // A camera in the grid does not tell where its rays end, so they are clipped.
    let sets = of.with_sets(&[("any_hit", true), ("leaves", true), ("intervals", false), ("clip", true)]);
    let kernel = KernelInfo { why_absent, colour, ..of.kernel };
    Some(Instance { name, kernel, binds: BINDS, renamed: Some(Box::leak(Box::new(renamed))), sets, ..of })
}
