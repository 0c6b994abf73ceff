//! States of a ray: the tags in the stream `state`.

use crate::tables::state::{StateInfo, StateRole, States, Tag};

/// Not yet generated: what a cleared texture holds.
pub const UNWRITTEN: Tag = 0;
/// Waits for the set-up kernel.
pub const TRAV_SETUP: Tag = 1;
/// Continues to the next cell or node.
pub const TRAV: Tag = 2;
/// Tests the triangles of its cell or leaf; nothing hit so far.
pub const ISECT_NO_HIT: Tag = 3;
/// Tests the triangles of its cell or leaf; the nearest hit so far is kept.
pub const ISECT_HIT: Tag = 4;
/// Waits for integers to decide what it hits.
pub const EXACT: Tag = 5;
/// Waits to be shaded from its hit.
pub const SHADE: Tag = 6;
/// Waits to be given the background's colour.
pub const BACKGROUND: Tag = 7;
/// Finished.
pub const DONE: Tag = 8;
/// A shadow ray waits for its set-up kernel.
pub const SHADOW_SETUP: Tag = 9;
/// A shadow ray continues to its next cell or node.
pub const SHADOW_TRAV: Tag = 10;
/// A shadow ray tests the triangles of its cell or leaf.
pub const SHADOW_ISECT: Tag = 11;
/// A shadow ray waits for integers to decide whether something is in its way.
pub const SHADOW_EXACT: Tag = 12;
/// Something is between the hit and a light.
pub const OCCLUDED: Tag = 13;
/// Nothing is.
pub const VISIBLE: Tag = 14;
/// Has the light of its hit, and waits for rays that go on from there.
pub const SCATTER: Tag = 15;

/// Looks for the photons near its hit.
pub const GATHER: Tag = 16;
/// Has found them.
pub const GATHERED: Tag = 17;
/// A photon that has not been emitted.
pub const PHOTON_UNBORN: Tag = 18;
/// A photon waits for the set-up kernel.
pub const PHOTON_SETUP: Tag = 19;
/// A photon continues to its next cell or node.
pub const PHOTON_TRAV: Tag = 20;
/// A photon tests the triangles of its cell or leaf; nothing hit so far.
pub const PHOTON_NO_HIT: Tag = 21;
/// A photon tests the triangles of its cell or leaf; the nearest hit so far is kept.
pub const PHOTON_HIT: Tag = 22;
/// A photon waits for integers to decide what it hits.
pub const PHOTON_EXACT: Tag = 23;
/// A photon has reached a surface.
pub const PHOTON_ARRIVED: Tag = 24;
/// A photon leaves the scene.
pub const PHOTON_LEAVES: Tag = 25;
/// A photon was absorbed, or has left the scene.
pub const PHOTON_DONE: Tag = 26;

/// The state of any ray: that of a shadow ray is called as in the walk of the ray before it, and that of a photon as in the
/// walk of a ray.
#[must_use]
pub const fn of_any_ray(tag: Tag) -> Tag {
    match tag {
        SHADOW_SETUP => TRAV_SETUP,
        SHADOW_TRAV => TRAV,
        SHADOW_ISECT => ISECT_NO_HIT,
        SHADOW_EXACT | PHOTON_EXACT => EXACT,
        OCCLUDED => SHADE,
        VISIBLE => BACKGROUND,
        PHOTON_UNBORN => UNWRITTEN,
        PHOTON_SETUP => TRAV_SETUP,
        PHOTON_TRAV => TRAV,
        PHOTON_NO_HIT => ISECT_NO_HIT,
        PHOTON_HIT => ISECT_HIT,
        PHOTON_ARRIVED => SHADE,
        PHOTON_LEAVES => BACKGROUND,
        PHOTON_DONE => DONE,
        of_ray => of_ray,
    }
}

const fn row(tag: Tag, name: &'static str, role: StateRole, colour: [u8; 3], meaning: &'static str) -> StateInfo {
    StateInfo { tag, name, role, colour, meaning }
}

/// Every state of a ray.
pub const STATES: States = States(ALL.0.split_at(DONE as usize + 1).0);

/// The same, and those of a shadow ray.
pub const OF_LIGHT: States = States(ALL.0.split_at(SCATTER as usize + 1).0);

/// The same, and those of photons, and of rays that gather them.
pub const ALL: States = States(&[
    row(UNWRITTEN, "UNWRITTEN", StateRole::Unborn, [40, 40, 46], "no ray yet"),
    row(TRAV_SETUP, "TRAV_SETUP", StateRole::Active, [190, 174, 212], "waits for the set-up kernel"),
    row(TRAV, "TRAV", StateRole::Active, [56, 108, 176], "continues to the next cell or node"),
    row(
        ISECT_NO_HIT,
        "ISECT_NO_HIT",
        StateRole::Active,
        [253, 192, 134],
        "tests the triangles of its cell or leaf, nothing hit yet",
    ),
    row(
        ISECT_HIT,
        "ISECT_HIT",
        StateRole::Active,
        [240, 120, 40],
        "tests the triangles of its cell or leaf, the nearest hit is kept",
    ),
    row(EXACT, "EXACT", StateRole::Active, [220, 60, 60], "waits for integers to decide what it hits"),
    row(SHADE, "SHADE", StateRole::Resolved, [127, 201, 127], "waits to be shaded from its hit"),
    row(
        BACKGROUND,
        "BACKGROUND",
        StateRole::Resolved,
        [102, 102, 120],
        "hit nothing, waits for the background's colour",
    ),
    row(DONE, "DONE", StateRole::Finished, [225, 225, 230], "finished"),
    row(SHADOW_SETUP, "SHADOW_SETUP", StateRole::Active, [214, 190, 120], "a shadow ray waits for the set-up kernel"),
    row(
        SHADOW_TRAV,
        "SHADOW_TRAV",
        StateRole::Active,
        [140, 110, 60],
        "a shadow ray continues to the next cell or node",
    ),
    row(
        SHADOW_ISECT,
        "SHADOW_ISECT",
        StateRole::Active,
        [190, 90, 120],
        "a shadow ray tests the triangles of its cell or leaf",
    ),
    row(
        SHADOW_EXACT,
        "SHADOW_EXACT",
        StateRole::Active,
        [170, 40, 100],
        "a shadow ray waits for integers to decide whether something is in its way",
    ),
    row(OCCLUDED, "OCCLUDED", StateRole::Resolved, [70, 60, 90], "something is between the hit and the light"),
    row(VISIBLE, "VISIBLE", StateRole::Resolved, [250, 220, 90], "nothing is between the hit and the light"),
    row(
        SCATTER,
        "SCATTER",
        StateRole::Resolved,
        [110, 190, 200],
        "the light of the hit is known, rays may go on from there",
    ),
    row(GATHER, "GATHER", StateRole::Resolved, [150, 200, 120], "looks for the photons near its hit"),
    row(GATHERED, "GATHERED", StateRole::Resolved, [190, 220, 150], "has found the photons near its hit"),
    row(PHOTON_UNBORN, "PHOTON_UNBORN", StateRole::Unborn, [60, 52, 40], "no photon yet"),
    row(PHOTON_SETUP, "PHOTON_SETUP", StateRole::Active, [236, 214, 150], "a photon waits for the set-up kernel"),
    row(PHOTON_TRAV, "PHOTON_TRAV", StateRole::Active, [96, 140, 120], "a photon continues to its next cell or node"),
    row(
        PHOTON_NO_HIT,
        "PHOTON_NO_HIT",
        StateRole::Active,
        [230, 170, 140],
        "a photon tests the triangles of its cell or leaf, nothing hit yet",
    ),
    row(
        PHOTON_HIT,
        "PHOTON_HIT",
        StateRole::Active,
        [210, 110, 80],
        "a photon tests the triangles of its cell or leaf, the nearest hit is kept",
    ),
    row(
        PHOTON_EXACT,
        "PHOTON_EXACT",
        StateRole::Active,
        [200, 40, 20],
        "a photon waits for integers to decide what it hits",
    ),
    row(PHOTON_ARRIVED, "PHOTON_ARRIVED", StateRole::Resolved, [160, 190, 90], "a photon has reached a surface"),
    row(PHOTON_LEAVES, "PHOTON_LEAVES", StateRole::Resolved, [110, 100, 130], "a photon leaves the scene"),
    row(
        PHOTON_DONE,
        "PHOTON_DONE",
        StateRole::Finished,
        [240, 235, 215],
        "a photon was absorbed, or has left the scene",
    ),
]);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_in_the_order_of_a_rays_course() {
        assert!(STATES.0.is_sorted_by_key(|state| state.role as u8));
        assert_eq!((STATES.name(99), STATES.role(99), STATES.is_decided(99)), ("?", None, false));
        let counts = [1, 2, 4, 8, 16, 32, 64, 128, 256].into_iter().collect();
        assert_eq!((STATES.walking(&counts), STATES.decided(&counts)), (62, 448));
    }
}
