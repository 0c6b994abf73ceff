//! What rounding may change in one pass of a kernel, if a device contracts products and sums, or divides less exactly than
//! the CPU reference.

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
    /// The square root of such multiples: what is computed by way of the cosine of a refracted ray, where that is near 0.
    Roots(f32),
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

/// A division and a product, which may be contracted with the sum before them.
pub const DIVISION: u64 = 4;
/// A control term begins as a difference of positions in cells, each of them a division, and a step adds a slope, a
/// quotient of two; in multiples of 2⁻²³.
pub const CONTROL_TERM: f32 = 8.0;

impl Rounding {
    /// For kernels that only copy floats.
    pub const NONE: Self = Self { floats: &[], ties: Ties::None };
}
