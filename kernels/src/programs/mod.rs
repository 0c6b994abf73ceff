//! Programs: the kernels of each, with their rows, streams and schedules.

pub mod closest_hit;

use crate::program::Program;

/// Every program.
pub static ALL: [&Program; 1] = [&closest_hit::PROGRAM];
