//! What rounding may change in one pass of each kernel, if a device contracts products and sums, or divides less
//! exactly than the CPU reference.
//!
//! WGSL allows a division to be off by 2.5 units in the last place, and a product and a sum to be contracted or not.
//! Software Vulkan does neither, and agrees bit for bit; an H200 does both.

use super::streams::{
    ACCUMULATED, BLOCKS, COLOR, CONTROL, HIT, PLACE, RAY_DIRECTION, RAY_ORIGIN, SCAN, STATE, STATE_T, TMAX, VOXEL,
};
use crate::program::rounding::{Each, Off, Rounding, Ties};
use crate::tables::stream::Stream;

/// Layers 0 to 2: x, y and z, or r, g and b.
const ALL_3: &[usize] = &[0, 1, 2];
/// Sums of three terms, each of the size of the result or of 1.
const SUM: Off = Off::Roundings(4.0);
/// A colour that is multiplied or added to.
pub const COLOUR: &[(Stream, &[usize], Off)] = &[(COLOR, ALL_3, SUM)];
/// Barycentric weights and t of a hit.
const OF_A_HIT: [(Stream, &[usize], Off); 2] =
    [(HIT, &[0, 1], Off::WeightOfTriangle), (STATE, &[STATE_T], Off::DistanceToTriangle)];

/// The virtual cell by which a ray comes into a cell of an irregular grid.
const OF_A_VOXEL: (Stream, &[usize], Off) = (VOXEL, ALL_3, Off::OneVoxel);

pub(super) const OF_GENERATE: Rounding =
    Rounding { floats: &[(RAY_ORIGIN, ALL_3, SUM), (RAY_DIRECTION, ALL_3, SUM)], ties: Ties::None };

pub(super) const OF_SETUP: Rounding = Rounding {
    floats: &[(TMAX, ALL_3, Off::PerAxis(Each::Pass)), (CONTROL, ALL_3, Off::PerAxis(Each::Pass)), OF_A_VOXEL],
    ties: Ties::FirstCell,
};

pub(super) const OF_TRAVERSE_GRID: Rounding = Rounding {
    floats: &[(TMAX, ALL_3, Off::PerAxis(Each::Pass)), (CONTROL, ALL_3, Off::PerAxis(Each::Pass))],
    ties: Ties::Leap,
};

pub(super) const OF_TRAVERSE_IRREGULAR: Rounding =
    Rounding { floats: &[(TMAX, ALL_3, Off::PerAxis(Each::Pass)), OF_A_VOXEL], ties: Ties::Leap };

pub(super) const OF_TRAVERSE_BVH: Rounding = Rounding { floats: &[], ties: Ties::Box };

pub(super) const OF_INTERSECT: Rounding = Rounding {
    floats: &[OF_A_HIT[0], OF_A_HIT[1], (SCAN, &[1, 2, 3], Off::PerAxis(Each::Iteration))],
    ties: Ties::Triangle,
};

/// With the paper's rules tmax grows by a rounded tDelta at every step, and a control term by a rounded slope; there are
/// fewer steps than loop iterations.
pub(super) const OF_WALK: Rounding = Rounding {
    floats: &[
        OF_A_HIT[0],
        OF_A_HIT[1],
        (TMAX, ALL_3, Off::PerAxis(Each::Step)),
        (CONTROL, ALL_3, Off::PerAxis(Each::Step)),
        OF_A_VOXEL,
    ],
    ties: Ties::Many,
};

pub(super) const OF_FUSED: Rounding = Rounding {
    floats: &[OF_A_HIT[0], OF_A_HIT[1], (PLACE, &[4, 5, 6], Off::PerAxis(Each::Iteration)), OF_A_VOXEL],
    ties: Ties::Many,
};

/// Square roots, divisions and sums of terms below 1 or the value itself; a spot's cone multiplies a cosine's error.
pub(super) const OF_SHADE: Rounding =
    Rounding { floats: &[(COLOR, ALL_3, Off::RoundingsOfLight(64.0))], ties: Ties::None };

/// A division that is added to. The number of samples is exact.
pub(super) const OF_ACCUMULATE: Rounding = Rounding {
    floats: &[(ACCUMULATED, &[0, 1, 2, 3], SUM), (BLOCKS, &[0, 1, 2, 3], SUM), (COLOR, ALL_3, SUM)],
    ties: Ties::None,
};
