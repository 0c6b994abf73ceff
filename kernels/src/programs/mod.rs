//! Programs: the kernels of each, with their rows, streams and schedules.

pub mod closest_hit;
pub mod grid_build;
