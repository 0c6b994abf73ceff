//! Where a ray is in the pipeline: the tags of the `state` stream.
//!
//! Which kernel moves a ray from one to the next is in the kernels' rows, see [`crate::programs::closest_hit::kernels::transitions`].
//!
//! The tags become constants of the WGSL module `package::state`, made from [`STATES`], so shaders
//! and twins cannot disagree.

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

/// The WGSL module `package::state`.
#[must_use]
pub fn wgsl_module() -> String {
    STATES.iter().map(|(tag, name, _)| format!("const {name}: u32 = {tag}u;\n")).collect()
}
