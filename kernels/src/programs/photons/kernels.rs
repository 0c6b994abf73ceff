//! Its kernels: those that emit photons, send them on and find where they are stored, and those that gather them.

use super::{breaks, explain, rounding};
use crate::options::reasons::{Because, NO_SHADE, Reason, Run};
use crate::program::instance::twin;
use crate::program::kernel::{Path, Proof};
use crate::program::{Home, KernelInfo};
use crate::programs::closest_hit::elements::no_map;
use crate::programs::closest_hit::states::{
    ALL, DONE, GATHER, GATHERED, OCCLUDED, PHOTON_ARRIVED, PHOTON_DONE, PHOTON_LEAVES, PHOTON_SETUP, PHOTON_UNBORN,
    SCATTER, TRAV_SETUP, VISIBLE,
};
use crate::programs::closest_hit::streams;
use crate::programs::path::kernels::OF_SAMPLE_LIGHT;
use crate::shared::constants::WORKGROUP;
use crate::tables::kernel::{Counts, Launch, Role, Transition};
use crate::tables::state::Tag;

/// The tables that its own kernels name.
static HOME: Home = Home { streams: &streams::STREAMS, states: ALL };

const fn send(from: Tag, when: &'static str, to: Tag) -> Transition {
    Transition { from, when, to }
}

/// Why a run does without what the rays of the camera need in any run with photons.
fn no_photons(run: &Run<'_>) -> Reason {
    match run.options.shade {
        true => (Because::Options, "needed only with --integrator photons"),
        false => NO_SHADE,
    }
}

/// Emits every photon.
pub(super) const OF_EMIT_PHOTONS: KernelInfo = KernelInfo {
    name: "emit_photons",
    wgsl: include_str!("emit_photons.wgsl"),
    twin: twin!(element emit_photons),
    home: &HOME,
    takes: &[PHOTON_UNBORN, PHOTON_DONE],
    sends: &[
        send(PHOTON_UNBORN, "every photon", PHOTON_SETUP),
        send(PHOTON_DONE, "in the next iteration", PHOTON_SETUP),
    ],
    role: Role::Source,
    workgroup: WORKGROUP,
    launch: Launch::Whole,
    counts: Counts::AllTo(PHOTON_SETUP),
    resumes: |_| false,
    list: None,
    proof: Proof::NONE,
    colour: [210, 160, 40],
    why_absent: no_map,
    summary: "emits every photon from a light or a surface that glows, picked by its power",
    explain: explain::of_emit_photons,
    path: Path::Stays,
    rounding: rounding::OF_EMIT_PHOTONS,
    breaks: breaks::OF_EMIT_PHOTONS,
};

/// Stores photons where they arrive, and sends them on.
pub(super) const OF_SCATTER_PHOTONS: KernelInfo = KernelInfo {
    name: "scatter_photons",
    wgsl: include_str!("scatter_photons.wgsl"),
    twin: twin!(element scatter_photons),
    home: &HOME,
    takes: &[PHOTON_ARRIVED, PHOTON_LEAVES],
    sends: &[
        send(PHOTON_ARRIVED, "reflected or refracted", PHOTON_SETUP),
        send(PHOTON_ARRIVED, "absorbed, or has bounced as often as it may", PHOTON_DONE),
        send(PHOTON_LEAVES, "has left the scene", PHOTON_DONE),
    ],
    colour: [180, 120, 60],
    why_absent: no_map,
    summary: "stores the photon where it has arrived, and reflects or refracts it, or ends it by chance",
    explain: explain::of_scatter_photons,
    rounding: rounding::OF_SCATTER_PHOTONS,
    breaks: breaks::OF_SCATTER_PHOTONS,
    ..OF_SAMPLE_LIGHT
};

/// Finds the cell of each place where a photon is stored.
pub(super) const OF_KEY_PHOTONS: KernelInfo = KernelInfo::once(
    ("key_photons", include_str!("key_photons.wgsl")),
    super::key_photons::key_photons,
    [150, 120, 190],
    "finds the cell of each place where a photon is stored",
    no_map,
    breaks::OF_KEY_PHOTONS,
);

/// Finds where the list of each cell begins.
pub(super) const OF_SEARCH_CELLS: KernelInfo = KernelInfo::once(
    ("search_cells", include_str!("search_cells.wgsl")),
    super::search_cells::search_cells,
    [90, 165, 90],
    "finds where the list of each cell begins, by a binary search",
    no_map,
    breaks::OF_SEARCH_CELLS,
);

/// Adds the light at a hit, and sends the ray on, begins to gather photons, or ends it.
pub(super) const OF_LOOK_UP: KernelInfo = KernelInfo {
    name: "look_up",
    wgsl: include_str!("look_up.wgsl"),
    twin: twin!(element look_up),
    home: &HOME,
    takes: &[SCATTER, OCCLUDED, VISIBLE, GATHERED],
    sends: &[
        send(SCATTER, "a mirror or glass sends it on", TRAV_SETUP),
        send(SCATTER, "a diffuse surface: looks for photons", GATHER),
        send(SCATTER, "nothing was hit, or it ends", DONE),
        send(OCCLUDED, "a diffuse surface: looks for photons", GATHER),
        send(OCCLUDED, "without a map of photons", DONE),
        send(VISIBLE, "adds the light, and looks for photons", GATHER),
        send(VISIBLE, "adds the light, without a map of photons", DONE),
        send(GATHERED, "adds the light of a map, and looks in the other", GATHER),
        send(GATHERED, "adds the light of caustics, and is sent on once", TRAV_SETUP),
        send(GATHERED, "adds the light that photons bring", DONE),
    ],
    colour: [60, 150, 170],
    why_absent: no_photons,
    summary: "adds what the shadow ray brought, or what photons bring, and sends the ray on at a mirror or glass",
    explain: explain::of_look_up,
    rounding: rounding::OF_LOOK_UP,
    breaks: breaks::OF_LOOK_UP,
    ..OF_SAMPLE_LIGHT
};

/// Looks for the photons near a hit.
pub(super) const OF_GATHER: KernelInfo = KernelInfo {
    name: "gather",
    wgsl: include_str!("gather.wgsl"),
    twin: twin!(pass gather),
    home: &HOME,
    takes: &[GATHER],
    sends: &[
        send(GATHER, "a cell was searched, or a part of it", GATHER),
        send(GATHER, "no cell is left that is near enough", GATHERED),
    ],
    colour: [120, 170, 90],
    why_absent: no_map,
    summary: "looks for the photons near the hit, in the nearest cell that is left",
    explain: explain::of_gather,
    rounding: rounding::OF_GATHER,
    breaks: breaks::OF_GATHER,
    ..OF_SAMPLE_LIGHT
};
