//! A closed mesh from inside: no ray may get out; see [`raystep_lab::watertight`].

use raystep_kernels::{Device, GridSize};
use raystep_lab::watertight;
use raystep_scenes::Scene;

use crate::ways::Way;
use crate::{block_on, gpu_of};

/// An icosphere of 1,280 triangles, its corners rounded at that scale.
#[must_use]
pub fn closed_mesh(scale: f64) -> Scene {
    watertight::closed_mesh(scale).expect("a small mesh")
}

/// Rays from a few origins inside, at corners and edges; how many miss.
#[must_use]
pub fn misses(device: &Device, scene: &Scene, way: Way, count: usize, grid: GridSize, seed: u64) -> usize {
    block_on(gpu_of(device), watertight::misses(device, scene, way, count, grid, seed)).expect("a run")
}
