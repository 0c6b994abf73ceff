//! Numbers, units and the few helpers that everything else is written with.

pub mod bytes;
pub mod named;
pub mod parallel;
pub mod real;
pub mod srgb;
pub mod units;
