//! What rounding may change in one pass of each kernel, if a device contracts products and sums, or divides less
//! exactly than the CPU reference.
//!
//! WGSL allows a division to be off by 2.5 units in the last place, and a product and a sum to be contracted or not.
//! Software Vulkan does neither, and agrees bit for bit; an H200 does both.

use super::streams::{
    ACCUMULATED, BLOCKS, COLOR, CONTROL, HIT, PLACE, RAY_DIRECTION, RAY_ORIGIN, SCAN, STATE, STATE_T, TMAX, VOXEL,
};
use crate::tables::stream::Stream;

/// What rounding may change in one pass of a kernel: nothing else may differ from its CPU reference.
#[derive(Clone, Copy, Debug)]
pub struct Rounding {
    /// The floats that the kernel computes: layers of a stream, and how far off they may be. Floats that it only copies
    /// are not listed.
    pub floats: &'static [(Stream, &'static [usize], Off)],
    /// The comparisons whose result rounding may change, so that a ray takes another branch.
    pub ties: Ties,
}

/// How far off a float may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Off {
    /// What decides a step through a grid, computed once or in each part of the pass: tMax by [`DIVISION`] units in the
    /// last place, control terms of a 3D-DDA by [`CONTROL_TERM`] for each cell along the grid and each part.
    PerAxis(Each),
    /// Multiples of 2⁻²³ of the larger number, or of 1 if both are smaller.
    Roundings(f32),
    /// The same, times the largest factor by which a light's cone scales a cosine.
    RoundingsOfLight(f32),
    /// Twice the triangle's own bound for t. That bound allows the 10 roundings of a sheared corner; a ray that the
    /// kernel generates itself is off by 4 more, and twice the bound covers both.
    DistanceToTriangle,
    /// Twice the triangle's own bound for a barycentric weight, likewise.
    WeightOfTriangle,
    /// An integer, off by one: the virtual cell of a point on the plane between two.
    OneVoxel,
}

/// The factor by which the error of one computation is multiplied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Each {
    /// It is computed once.
    Pass,
    /// It is computed in every step of the pass.
    Step,
    /// It is computed in every loop iteration that a dispatch allows.
    Iteration,
}

/// The comparisons of a kernel whose result rounding may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ties {
    /// None: it compares integers, or floats that it only reads.
    None,
    /// The point of entry with the planes between cells.
    FirstCell,
    /// The end of a skip over empty cells, or of a step through an irregular grid, with the planes between cells; and
    /// the control terms of a 3D-DDA, in proportion to its slopes.
    Leap,
    /// The ray with the box of a node.
    Box,
    /// The ray with the edges of a triangle, and its t with the nearest so far and the exit of the cell.
    Triangle,
    /// Many of these: only a comparison with neighbouring rays tells.
    Many,
}

/// Layers 0 to 2: x, y and z, or r, g and b.
const ALL_3: &[usize] = &[0, 1, 2];
/// A division and a product, which may be contracted with the sum before them.
pub const DIVISION: u64 = 4;
/// A control term begins as a difference of positions in cells, each of them a division, and a step adds a slope, a
/// quotient of two; in multiples of 2⁻²³.
pub const CONTROL_TERM: f32 = 8.0;
/// Sums of three terms, each of the size of the result or of 1.
const SUM: Off = Off::Roundings(4.0);
/// A colour that is multiplied or added to.
pub const COLOUR: &[(Stream, &[usize], Off)] = &[(COLOR, ALL_3, SUM)];
/// Barycentric weights and t of a hit.
const OF_A_HIT: [(Stream, &[usize], Off); 2] =
    [(HIT, &[0, 1], Off::WeightOfTriangle), (STATE, &[STATE_T], Off::DistanceToTriangle)];

/// The virtual cell by which a ray comes into a cell of an irregular grid.
const OF_A_VOXEL: (Stream, &[usize], Off) = (VOXEL, ALL_3, Off::OneVoxel);

/// For kernels that only copy floats.
pub const NONE: Rounding = Rounding { floats: &[], ties: Ties::None };

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
