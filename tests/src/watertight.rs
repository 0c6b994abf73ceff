//! A closed mesh seen from inside, which no ray may leave; see [`raystep_lab::watertight`].

use raystep_kernels::{Device, GridSize};
use raystep_lab::watertight;
use raystep_scenes::Scene;

use crate::configurations::Configuration;
use crate::{block_on, gpu_of};

/// An icosphere of 1,280 triangles, its vertices rounded at this scale.
#[must_use]
pub fn closed_mesh(scale: f64) -> Scene {
    watertight::closed_mesh(scale).expect("a small mesh")
}

/// Traces rays from a few origins inside, aimed at vertices and edges, and returns how many miss.
#[must_use]
pub fn misses(
    device: &Device,
    scene: &Scene,
    configuration: Configuration,
    count: usize,
    grid: GridSize,
    seed: u64,
) -> usize {
    block_on(gpu_of(device), watertight::misses(device, scene, configuration, count, grid, seed)).expect("a run")
}
