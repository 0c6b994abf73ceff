//! Numbers, units and a few helpers that everything else uses.

pub mod bytes;
pub mod named;
pub mod npy;
pub mod parallel;
pub mod real;
pub mod srgb;
pub mod units;
