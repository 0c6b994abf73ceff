//! Where a ray is in the pipeline: the tags of the `state` stream, and every way from one to the next.
//!
//! The tags become constants of the WGSL module `package::state`, made from [`STATES`], so shaders
//! and twins cannot disagree.

use crate::kernel::Kernel;

/// Tag of the `state` stream, layer 0.
pub type Tag = u32;

/// Not yet generated: what a cleared texture holds.
pub const UNWRITTEN: Tag = 0;
/// Waits for the set-up kernel.
pub const TRAV_SETUP: Tag = 1;
/// Goes on to the next voxel or node.
pub const TRAV: Tag = 2;
/// Tests the triangles of its voxel; nothing hit so far.
pub const ISECT_NO_HIT: Tag = 3;
/// Tests the triangles of its voxel; the nearest hit so far is kept.
pub const ISECT_HIT: Tag = 4;
/// Waits to be shaded from its hit.
pub const SHADE: Tag = 5;
/// Waits to be given the background's colour.
pub const BACKGROUND: Tag = 6;
/// Finished.
pub const DONE: Tag = 7;

/// Number of tags.
pub const COUNT: usize = 8;

/// Every state: tag, its name in WGSL and in reports, and what it means.
pub const STATES: [(Tag, &str, &str); COUNT] = [
    (UNWRITTEN, "UNWRITTEN", "no ray yet"),
    (TRAV_SETUP, "TRAV_SETUP", "waits for the set-up kernel"),
    (TRAV, "TRAV", "goes on to the next voxel or node"),
    (ISECT_NO_HIT, "ISECT_NO_HIT", "tests its voxel's triangles, nothing hit yet"),
    (ISECT_HIT, "ISECT_HIT", "tests its voxel's triangles, the nearest hit is kept"),
    (SHADE, "SHADE", "waits to be shaded from its hit"),
    (BACKGROUND, "BACKGROUND", "hit nothing, waits for the background's colour"),
    (DONE, "DONE", "finished"),
];

/// The name of a tag, or `"?"` for a value that is none.
#[must_use]
pub fn name(tag: Tag) -> &'static str {
    STATES.get(tag as usize).map_or("?", |s| s.1)
}

/// How many rays are in each state, indexed by tag.
pub type StateCounts = [u32; COUNT];

/// States in which a walking kernel may still change what a ray hits.
pub const WALKING: [Tag; 4] = [TRAV_SETUP, TRAV, ISECT_NO_HIT, ISECT_HIT];

/// States in which it is decided what a ray hits.
pub const DECIDED: [Tag; 3] = [SHADE, BACKGROUND, DONE];

/// Whether a ray in this state will hit nothing else any more.
#[must_use]
pub fn is_decided(tag: Tag) -> bool {
    DECIDED.contains(&tag)
}

/// Rays whose hit is decided.
#[must_use]
pub fn decided(counts: &StateCounts) -> u64 {
    sum(counts, &DECIDED)
}

/// Rays that still walk.
#[must_use]
pub fn walking(counts: &StateCounts) -> u64 {
    sum(counts, &WALKING)
}

fn sum(counts: &StateCounts, tags: &[Tag]) -> u64 {
    tags.iter().map(|&tag| u64::from(counts[tag as usize])).sum()
}

/// One way from a state to the next.
#[derive(Clone, Copy, Debug)]
pub struct Transition {
    /// State before the pass.
    pub from: Tag,
    /// The kernel that does it.
    pub kernel: Kernel,
    /// Condition, in words.
    pub when: &'static str,
    /// State after the pass.
    pub to: Tag,
}

const fn way(from: Tag, kernel: Kernel, when: &'static str, to: Tag) -> Transition {
    Transition { from, kernel, when, to }
}

/// The state machine. A pass that leaves a ray's tag as it was is listed only where the kernel worked
/// on the ray. `--numerics paper` and runs without a grid use a subset.
pub const TRANSITIONS: &[Transition] = &[
    way(UNWRITTEN, Kernel::Generate, "every ray", TRAV_SETUP),
    way(TRAV_SETUP, Kernel::Setup, "misses the grid's box", BACKGROUND),
    way(TRAV_SETUP, Kernel::Setup, "enters the grid", ISECT_NO_HIT),
    way(TRAV_SETUP, Kernel::Setup, "with a tree: at its root", TRAV),
    way(ISECT_NO_HIT, Kernel::Intersect, "tested one triangle, no hit", ISECT_NO_HIT),
    way(ISECT_NO_HIT, Kernel::Intersect, "nearer hit", ISECT_HIT),
    way(ISECT_HIT, Kernel::Intersect, "tested one triangle", ISECT_HIT),
    way(ISECT_NO_HIT, Kernel::Intersect, "last triangle hit, within this cell", SHADE),
    way(ISECT_NO_HIT, Kernel::Intersect, "list ended, or last triangle hit beyond this cell", TRAV),
    way(ISECT_HIT, Kernel::Intersect, "list ended, t within this cell", SHADE),
    way(ISECT_HIT, Kernel::Intersect, "list ended, t beyond the cell's exit", TRAV),
    way(ISECT_NO_HIT, Kernel::Intersect, "without a grid: list ended, nothing hit", BACKGROUND),
    way(TRAV, Kernel::TraverseGrid, "next cell", ISECT_NO_HIT),
    way(TRAV, Kernel::TraverseGrid, "next cell, hit kept", ISECT_HIT),
    way(TRAV, Kernel::TraverseGrid, "leaves the grid", BACKGROUND),
    way(TRAV, Kernel::TraverseGrid, "leaves the grid, hit kept", SHADE),
    way(TRAV, Kernel::TraverseBvh, "inner node or box missed", TRAV),
    way(TRAV, Kernel::TraverseBvh, "enters a leaf", ISECT_NO_HIT),
    way(TRAV, Kernel::TraverseBvh, "enters a leaf, hit kept", ISECT_HIT),
    way(TRAV, Kernel::TraverseBvh, "tree done", BACKGROUND),
    way(TRAV, Kernel::TraverseBvh, "tree done, hit kept", SHADE),
    way(ISECT_NO_HIT, Kernel::Walk, "steps taken, nothing hit", ISECT_NO_HIT),
    way(ISECT_NO_HIT, Kernel::Walk, "steps taken, a hit kept", ISECT_HIT),
    way(ISECT_HIT, Kernel::Walk, "steps taken, the hit kept", ISECT_HIT),
    way(ISECT_NO_HIT, Kernel::Walk, "nearest hit found", SHADE),
    way(ISECT_HIT, Kernel::Walk, "nearest hit found", SHADE),
    way(ISECT_NO_HIT, Kernel::Walk, "walk over, nothing hit", BACKGROUND),
    way(TRAV, Kernel::Walk, "steps taken", TRAV),
    way(TRAV, Kernel::Walk, "tree done, hit", SHADE),
    way(TRAV, Kernel::Walk, "tree done, nothing hit", BACKGROUND),
    way(UNWRITTEN, Kernel::Fused, "loop turns spent, in a list without a hit", ISECT_NO_HIT),
    way(UNWRITTEN, Kernel::Fused, "loop turns spent, in a list, a hit kept", ISECT_HIT),
    way(UNWRITTEN, Kernel::Fused, "loop turns spent, between nodes", TRAV),
    way(TRAV_SETUP, Kernel::Fused, "loop turns spent, in a list without a hit", ISECT_NO_HIT),
    way(TRAV_SETUP, Kernel::Fused, "loop turns spent, in a list, a hit kept", ISECT_HIT),
    way(TRAV_SETUP, Kernel::Fused, "loop turns spent, between nodes", TRAV),
    way(ISECT_NO_HIT, Kernel::Fused, "loop turns spent again", ISECT_NO_HIT),
    way(ISECT_NO_HIT, Kernel::Fused, "loop turns spent again, a hit kept", ISECT_HIT),
    way(ISECT_NO_HIT, Kernel::Fused, "hit", SHADE),
    way(ISECT_NO_HIT, Kernel::Fused, "no hit", BACKGROUND),
    way(ISECT_HIT, Kernel::Fused, "loop turns spent again", ISECT_HIT),
    way(ISECT_HIT, Kernel::Fused, "hit", SHADE),
    way(TRAV, Kernel::Fused, "loop turns spent again", TRAV),
    way(TRAV, Kernel::Fused, "hit", SHADE),
    way(TRAV, Kernel::Fused, "no hit", BACKGROUND),
    way(UNWRITTEN, Kernel::Fused, "hit", SHADE),
    way(UNWRITTEN, Kernel::Fused, "no hit", BACKGROUND),
    way(TRAV_SETUP, Kernel::Fused, "hit", SHADE),
    way(TRAV_SETUP, Kernel::Fused, "no hit", BACKGROUND),
    way(SHADE, Kernel::Shade, "loop turns spent, lights are left", SHADE),
    way(SHADE, Kernel::Shade, "shaded", DONE),
    way(BACKGROUND, Kernel::Shade, "background", DONE),
    way(DONE, Kernel::Accumulate, "the pixel wants more samples", UNWRITTEN),
    way(DONE, Kernel::Accumulate, "it was the last sample", DONE),
];

/// The WGSL module `package::state`.
#[must_use]
pub fn wgsl_module() -> String {
    STATES.iter().map(|(tag, name, _)| format!("const {name}: u32 = {tag}u;\n")).collect()
}
