//! A closed mesh from inside: no ray may get out.

use raystep_kernels::shared::constants::NO_TRIANGLE;
use raystep_kernels::{Device, GridSize, Options, RaySource, Stream};
use raystep_scenes::{Scene, generate};

use crate::ways::Way;
use crate::{rays, traced, values};

/// An icosphere of 1,280 triangles, its corners rounded at that scale.
#[must_use]
pub fn closed_mesh(scale: f64) -> Scene {
    let mut scene = generate::icosphere(3).expect("a small mesh");
    for corner in scene.triangles.iter_mut().flatten() {
        *corner = corner.map(|v| (f64::from(v) * scale) as f32);
    }
    scene
}

/// Rays from a few origins inside, at corners and edges; how many miss.
#[must_use]
pub fn misses(device: &Device, scene: &Scene, way: Way, count: usize, grid: GridSize, seed: u64) -> usize {
    let size = scene.bounds().max.x;
    let mut missed = 0;
    for (i, origin) in [[0.0f32; 3], [0.3, -0.2, 0.1], [-0.55, 0.4, 0.45], [0.0, 0.7, 0.0]].into_iter().enumerate() {
        let rays = rays::at_edges(scene, origin.map(|v| v * size), count.div_ceil(4), seed + i as u64);
        let mut options = way.of(&Options::new(RaySource::Given(rays)));
        (options.shade, options.grid) = (false, grid);
        let renderer = traced(scene, &options, device);
        let hit = values(&renderer, Stream::Hit);
        missed += hit.layer(2)[..renderer.plan().rays as usize].iter().filter(|&&t| t == NO_TRIANGLE).count();
    }
    missed
}
