//! Twin of `vertex.wgsl`: a path at one of its hits.

use super::next_sample;
use super::random::decided_by;
use crate::numbers::real::{Real, Vec3};
use crate::programs::closest_hit::shade::surface::{diffuse_color, material_of, surface_normal};
use crate::scene_data::SceneData;
use crate::shared::shading::Material;
use crate::shared::start::{Start, on_side, start_of};
use crate::tables::texels::Texels;

/// A path at one of its hits.
pub(super) struct Vertex<'a, R: Real> {
    pixel: [u32; 2],
    /// The index of the pixel's sample.
    sample: u32,
    /// How many bounces led here.
    pub(super) depth: u32,
    pub(super) triangle: u32,
    /// Along which the path came; length 1.
    pub(super) direction: Vec3<R>,
    pub(super) start: Start<R>,
    /// Interpolated, on the side from which the path came.
    pub(super) normal: Vec3<R>,
    pub(super) material: &'a Material,
    /// Its diffuse colour here.
    pub(super) color: Vec3<R>,
    /// The share of the light along the path that reaches the pixel.
    pub(super) carried: Vec3<R>,
}

impl<'a, R: Real> Vertex<'a, R> {
    pub(super) fn new(
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

    /// The pair of numbers that decides something here.
    pub(super) fn decided_by(&self, scene: &SceneData, what: u32) -> [f32; 2] {
        decided_by(scene.features.sampler(), scene.sampling.seed, self.pixel, self.sample, self.depth, what)
    }
}
