//! Twin of `vertex.wgsl`: a path at one of its hits.

use super::next_sample;
use super::random::{OF_PHOTONS, decided_by};
use crate::numbers::real::{Real, Vec3};
use crate::programs::closest_hit::shade::surface::{diffuse_color, material_of, surface_normal};
use crate::scene_data::SceneData;
use crate::shared::shading::Material;
use crate::shared::start::{Start, on_side, start_of};
use crate::tables::texels::Texels;

/// A path at one of its hits.
pub(in crate::programs) struct Vertex<'a, R: Real> {
    pixel: [u32; 2],
    /// The index of the pixel's sample.
    sample: u32,
    /// How many bounces led here.
    pub(in crate::programs) depth: u32,
    pub(in crate::programs) triangle: u32,
    /// Along which the path came; length 1.
    pub(in crate::programs) direction: Vec3<R>,
    pub(in crate::programs) start: Start<R>,
    /// Interpolated, on the side from which the path came.
    pub(in crate::programs) normal: Vec3<R>,
    pub(in crate::programs) material: &'a Material,
    /// Its diffuse colour here.
    pub(in crate::programs) color: Vec3<R>,
    /// The share of the light along the path that reaches the pixel.
    pub(in crate::programs) carried: Vec3<R>,
}

impl<'a, R: Real> Vertex<'a, R> {
    pub(in crate::programs) fn new(
        ray: &Texels<'_, R>,
        scene: &'a SceneData,
        depth: u32,
        (triangle, [u, v]): (u32, [R; 2]),
        direction: Vec3<R>,
        carried: Vec3<R>,
    ) -> Self {
        let start = start_of(scene.corners(triangle), [u, v], direction);
        let material = material_of(scene, triangle);
        Self {
            pixel: [ray.x, ray.y],
            sample: next_sample(ray, scene),
            depth,
            triangle,
            direction,
            normal: on_side(&start, surface_normal(scene, triangle, u, v)),
            start,
            material,
            color: diffuse_color(scene, material, triangle, [u, v]),
            carried,
        }
    }

    /// The same for a photon, which decides by its own index, and by numbers that no pixel has.
    pub(in crate::programs) fn of_photon(self, photon: u32) -> Self {
        Self { pixel: OF_PHOTONS, sample: photon, ..self }
    }

    /// The pair of numbers that decides something here.
    pub(in crate::programs) fn decided_by(&self, scene: &SceneData, what: u32) -> [f32; 2] {
        self.decided_after(scene, 0, what)
    }

    /// The same for a path that has so many decisions before those at its first hit.
    pub(in crate::programs) fn decided_after(&self, scene: &SceneData, before: u32, what: u32) -> [f32; 2] {
        let (sampler, seed, depth) = (scene.features.sampler(), scene.sampling.seed, self.depth + before);
        decided_by(sampler, seed, self.pixel, self.sample, depth, what)
    }
}
