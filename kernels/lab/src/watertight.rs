//! A closed mesh seen from inside, which no ray may leave.

use std::ops::ControlFlow;

use raystep_kernels::shared::constants::NO_TRIANGLE;
use raystep_kernels::{Device, GridSize, Options, RaySource, RenderError, Renderer};
use raystep_scenes::Scene;
use raystep_scenes::generate::{self, GenerateError};

use crate::configuration::Configuration;
use crate::rays;

/// An icosphere of 1,280 triangles, its vertices rounded at this scale.
///
/// # Errors
/// If there is not enough memory for the mesh.
pub fn closed_mesh(scale: f64) -> Result<Scene, GenerateError> {
    let mut scene = generate::icosphere(3)?;
    for corner in scene.triangles.iter_mut().flatten() {
        *corner = corner.map(|v| (f64::from(v) * scale) as f32);
    }
    Ok(scene)
}

/// Traces rays from a few origins inside, aimed at vertices and edges, and returns how many miss.
///
/// # Errors
/// If the device fails or the mesh does not fit it.
pub async fn misses(
    device: &Device,
    scene: &Scene,
    configuration: Configuration,
    count: usize,
    grid: GridSize,
    seed: u64,
) -> Result<usize, RenderError> {
    let size = scene.bounds().max.x;
    let mut missed = 0;
    for (i, origin) in [[0.0f32; 3], [0.3, -0.2, 0.1], [-0.55, 0.4, 0.45], [0.0, 0.7, 0.0]].into_iter().enumerate() {
        let rays = rays::at_edges(scene, origin.map(|v| v * size), count.div_ceil(4), seed + i as u64);
        let mut options = configuration.of(&Options::new(RaySource::Given(rays)));
        (options.shade, options.grid) = (false, grid);
        let mut renderer = Renderer::new(scene, &options, device).await?;
        renderer.run(|_| ControlFlow::Continue(())).await?;
        let triangle = renderer.results()?.triangle;
        let hit = renderer.values(triangle.stream).await?;
        let triangles = &hit.layer(triangle.layer)[..renderer.plan().rays as usize];
        missed += triangles.iter().filter(|&&triangle| triangle == NO_TRIANGLE).count();
    }
    Ok(missed)
}
