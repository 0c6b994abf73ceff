//! The kernels that build irregular grids: twins of the WGSL in this folder.

pub(super) mod finish;
pub(super) mod kernels;
pub(super) mod map;
pub(super) mod merge;
pub(super) mod pass;
pub(super) mod refine;
