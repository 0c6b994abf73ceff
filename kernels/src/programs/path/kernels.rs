//! Its kernels: one that picks a light, one that picks a direction, and one that does both along the whole path.

use super::{breaks, explain, rounding};
use crate::options::reasons::{Because, NO_SHADE, On, Passes, Reason, Run};
use crate::program::instance::twin;
use crate::program::kernel::{Path, Proof};
use crate::program::{Home, KernelInfo};
use crate::programs::closest_hit::states::{
    ALL, BACKGROUND, DONE, OCCLUDED, SCATTER, SHADE, SHADOW_SETUP, TRAV_SETUP, VISIBLE,
};
use crate::programs::closest_hit::streams;
use crate::shared::constants::{LIST_SIDE, WORKGROUP};
use crate::tables::kernel::{Counts, Launch, Role, Transition};
use crate::tables::state::Tag;

/// The tables that its own kernels name.
static HOME: Home = Home { streams: &streams::STREAMS, states: ALL };

const fn send(from: Tag, when: &'static str, to: Tag) -> Transition {
    Transition { from, when, to }
}

/// Why a run does without a kernel of one step of a path.
fn absent(run: &Run<'_>) -> Reason {
    match run.features.whole_paths {
        true => run.needed_only(On::Any, Passes::Stepped),
        false if run.options.shade => (Because::Options, "needed only with --integrator path"),
        false => NO_SHADE,
    }
}

/// Why a run does without the kernel of whole paths.
fn absent_whole(run: &Run<'_>) -> Reason {
    match run.features.path && run.is_fused() {
        true if run.features.exact_order => {
            (Because::Options, "needed only with --order rounded: rays wait for integers between its steps")
        }
        true => (Because::Scene, "it would bind more storage buffers, or take more loop turns, than the device allows"),
        false if run.options.shade => (Because::Options, "needed only with --integrator path and --schedule fused"),
        false => NO_SHADE,
    }
}

/// Adds what a surface emits, and casts a shadow ray.
pub(in crate::programs) const OF_SAMPLE_LIGHT: KernelInfo = KernelInfo {
    name: "sample_light",
    wgsl: include_str!("sample_light.wgsl"),
    twin: twin!(element sample_light),
    home: &HOME,
    takes: &[SHADE, BACKGROUND],
    sends: &[
        send(SHADE, "casts a shadow ray", SHADOW_SETUP),
        send(SHADE, "no light can arrive by a shadow ray", SCATTER),
        send(BACKGROUND, "the background is around the scene", SCATTER),
    ],
    role: Role::Finish,
    workgroup: LIST_SIDE,
    launch: Launch::Whole,
    counts: Counts::Sent,
    resumes: |_| false,
    list: None,
    proof: Proof::NONE,
    colour: [90, 165, 90],
    why_absent: absent,
    summary: "adds what the surface emits, and casts a shadow ray to an emitter picked at random",
    explain: explain::of_sample_light,
    path: Path::Stays,
    rounding: rounding::OF_SAMPLE_LIGHT,
    breaks: breaks::OF_SAMPLE_LIGHT,
};

/// Adds what the shadow ray brought, and sends the path on, or ends it.
pub(super) const OF_SAMPLE_BSDF: KernelInfo = KernelInfo {
    name: "sample_bsdf",
    wgsl: include_str!("sample_bsdf.wgsl"),
    twin: twin!(element sample_bsdf),
    home: &HOME,
    takes: &[SCATTER, OCCLUDED, VISIBLE],
    sends: &[
        send(SCATTER, "the path goes on", TRAV_SETUP),
        send(SCATTER, "the path ends", DONE),
        send(OCCLUDED, "the path goes on", TRAV_SETUP),
        send(OCCLUDED, "the path ends", DONE),
        send(VISIBLE, "adds the light, the path goes on", TRAV_SETUP),
        send(VISIBLE, "adds the light, the path ends", DONE),
    ],
    colour: [60, 150, 170],
    why_absent: absent,
    summary: "adds what the shadow ray brought, and sends the path on in a random direction, or ends it",
    explain: explain::of_sample_bsdf,
    rounding: rounding::OF_SAMPLE_BSDF,
    breaks: breaks::OF_SAMPLE_BSDF,
    ..OF_SAMPLE_LIGHT
};

/// Follows a path from its first ray to its end.
pub(super) const OF_FUSED_PATH: KernelInfo = KernelInfo {
    name: "fused_path",
    wgsl: include_str!("fused_path.wgsl"),
    twin: twin!(element fused_path),
    home: &HOME,
    takes: &[TRAV_SETUP],
    sends: &[send(TRAV_SETUP, "the path has ended", DONE)],
    role: Role::Whole,
    workgroup: WORKGROUP,
    launch: Launch::Bands,
    counts: Counts::AllTo(DONE),
    resumes: |_| false,
    list: None,
    proof: Proof::new(|data, features| data.indices_hold(features) && data.shading_indices_hold(features)),
    colour: [200, 80, 140],
    why_absent: absent_whole,
    summary: "follows the path from its first ray to its end",
    explain: explain::of_fused_path,
    path: Path::Stays,
    rounding: rounding::OF_FUSED_PATH,
    breaks: breaks::OF_FUSED_PATH,
};
