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

/// Where a state lies on a ray's way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StateRole {
    /// There is no ray yet.
    Unborn,
    /// The ray is on its way; what it hits is not known.
    Active,
    /// What it hits is known, its result is not.
    Resolved,
    /// Its result is known.
    Finished,
}

/// A row of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StateInfo {
    /// Which state.
    pub tag: Tag,
    /// Its name in WGSL and in reports.
    pub name: &'static str,
    /// Where it lies on a ray's way.
    pub role: StateRole,
    /// What a ray does there, for people.
    pub meaning: &'static str,
}

const fn row(tag: Tag, name: &'static str, role: StateRole, meaning: &'static str) -> StateInfo {
    StateInfo { tag, name, role, meaning }
}

/// Every state.
pub const STATES: [StateInfo; COUNT] = [
    row(UNWRITTEN, "UNWRITTEN", StateRole::Unborn, "no ray yet"),
    row(TRAV_SETUP, "TRAV_SETUP", StateRole::Active, "waits for the set-up kernel"),
    row(TRAV, "TRAV", StateRole::Active, "continues to the next voxel or node"),
    row(ISECT_NO_HIT, "ISECT_NO_HIT", StateRole::Active, "tests its voxel's triangles, nothing hit yet"),
    row(ISECT_HIT, "ISECT_HIT", StateRole::Active, "tests its voxel's triangles, the nearest hit is kept"),
    row(SHADE, "SHADE", StateRole::Resolved, "waits to be shaded from its hit"),
    row(BACKGROUND, "BACKGROUND", StateRole::Resolved, "hit nothing, waits for the background's colour"),
    row(DONE, "DONE", StateRole::Finished, "finished"),
];

/// Where rays are as long as nobody has made them.
pub const UNBORN: Tag = UNWRITTEN;
/// Where rays begin that come from outside, and those that the fused kernel makes itself.
pub const BORN: Tag = TRAV_SETUP;
/// Where a ray goes whose walk is given up: it has hit nothing.
pub const GIVEN_UP: Tag = BACKGROUND;

/// The name of a tag, or `"?"` for a value that is none.
#[must_use]
pub fn name(tag: Tag) -> &'static str {
    STATES.get(tag as usize).map_or("?", |state| state.name)
}

/// Where a tag lies on a ray's way; `None` for a value that is none.
#[must_use]
pub fn role(tag: Tag) -> Option<StateRole> {
    STATES.get(tag as usize).map(|state| state.role)
}

/// How many rays are in each state, indexed by tag.
pub type StateCounts = [u32; COUNT];

/// Whether a ray in this state may still hit something, or something else.
#[must_use]
pub fn is_walking(tag: Tag) -> bool {
    role(tag) == Some(StateRole::Active)
}

/// Whether a ray in this state will hit nothing else any more.
#[must_use]
pub fn is_decided(tag: Tag) -> bool {
    matches!(role(tag), Some(StateRole::Resolved | StateRole::Finished))
}

/// Rays whose hit is decided.
#[must_use]
pub fn decided(counts: &StateCounts) -> u64 {
    sum(counts, is_decided)
}

/// Rays that still walk.
#[must_use]
pub fn walking(counts: &StateCounts) -> u64 {
    sum(counts, is_walking)
}

fn sum(counts: &StateCounts, is_counted: impl Fn(Tag) -> bool) -> u64 {
    (0..).zip(counts).filter(|&(tag, _)| is_counted(tag)).map(|(_, &rays)| u64::from(rays)).sum()
}

/// The WGSL module `package::state`.
#[must_use]
pub fn wgsl_module() -> String {
    STATES.iter().map(|StateInfo { tag, name, .. }| format!("const {name}: u32 = {tag}u;\n")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_in_the_order_of_the_tags_and_of_a_rays_way() {
        for (tag, state) in (0..).zip(&STATES) {
            assert_eq!((state.tag, name(tag), role(tag)), (tag, state.name, Some(state.role)));
        }
        assert!(STATES.is_sorted_by_key(|state| state.role as u8));
        assert_eq!((name(99), role(99), is_decided(99)), ("?", None, false));
        let counts = [1, 2, 4, 8, 16, 32, 64, 128];
        assert_eq!((walking(&counts), decided(&counts)), (30, 224));
    }
}
