//! Layers of streams that keep the same at each depth, or after each bounce.

use crate::options::MOST_DEPTH;
use crate::shared::constants::{BRANCH, NO_CELL, RECORD};
use crate::tables::stream::Meaning::{self, Float, Id};

/// The names of what is kept of a ray that waits at each depth.
macro_rules! branches {
    ($($depth:literal)*) => {
        &[$(
            concat!("x_", $depth), concat!("y_", $depth), concat!("z_", $depth),
            concat!("dx_", $depth), concat!("dy_", $depth), concat!("dz_", $depth),
            concat!("r_", $depth), concat!("g_", $depth), concat!("b_", $depth),
            concat!("triangle_", $depth),
        )*]
    };
}
pub(super) const BRANCH_LAYERS: &[&str] = branches!(0 1 2 3 4 5 6 7);
const _: () = assert!(BRANCH_LAYERS.len() == (BRANCH * MOST_DEPTH) as usize);

/// What each of them is.
pub(super) const BRANCH_MEANING: [Meaning; BRANCH_LAYERS.len()] = {
    let mut meaning = [Float; BRANCH_LAYERS.len()];
    let mut last = BRANCH as usize - 1;
    while last < meaning.len() {
        meaning[last] = Id;
        last += BRANCH as usize;
    }
    meaning
};

/// The names of what is kept of a photon at each place where it is stored.
macro_rules! records {
    ($($bounce:literal)*) => {
        &[$(
            concat!("x_", $bounce), concat!("y_", $bounce), concat!("z_", $bounce),
            concat!("dx_", $bounce), concat!("dy_", $bounce), concat!("dz_", $bounce),
            concat!("r_", $bounce), concat!("g_", $bounce), concat!("b_", $bounce),
            concat!("map_", $bounce), concat!("ended_", $bounce),
        )*]
    };
}
pub(super) const RECORD_LAYERS: &[&str] = records!(1 2 3 4 5 6 7);
const _: () = assert!(RECORD_LAYERS.len() == (RECORD * (MOST_DEPTH - 1)) as usize);

/// What each of them is: the last two of a record are ids.
pub(super) const RECORD_MEANING: [Meaning; RECORD_LAYERS.len()] = {
    let mut meaning = [Float; RECORD_LAYERS.len()];
    let mut end = RECORD as usize;
    while end <= meaning.len() {
        meaning[end - 2] = Id;
        meaning[end - 1] = Id;
        end += RECORD as usize;
    }
    meaning
};

/// Before they are written: no photon.
pub(super) const UNRECORDED: [u32; RECORD_LAYERS.len()] = {
    let mut unwritten = [0; RECORD_LAYERS.len()];
    let mut end = RECORD as usize;
    while end <= unwritten.len() {
        unwritten[end - 2] = NO_CELL;
        end += RECORD as usize;
    }
    unwritten
};
