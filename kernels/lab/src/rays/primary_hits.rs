//! Rays that leave from what a camera sees.

use std::ops::Range;

use glam::{DVec3, Vec3};
use raystep_kernels::numbers::parallel::map_ranges;
use raystep_kernels::numbers::units::Units;
use raystep_kernels::options::Ray;
use raystep_kernels::renderer::RayHit;
use raystep_scenes::{Camera, Light, Projection, Scene};

use super::{PIXELS_PER_TASK, Random, TILE, in_tiles, ray};
use crate::reference::possible;

/// The hits of a camera's rays.
///
/// A ray from a hit starts off its surface, on the viewer's side, at the smallest of some heights at which the surface is
/// no obstacle to it: by the [bounds on f32's errors](crate::reference), the watertight test cannot find the triangle
/// that the ray leaves. The first height is twice what f32 may round the origin by, or one rounding of the triangle's size
/// if that is more; each next one is twice the one before. So the height follows from the errors, which grow with the
/// coordinates, with the triangle, and with how flat the ray leaves it, and not from the size of the scene.
#[derive(Clone, Copy, Debug)]
pub struct PrimaryHits<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The camera.
    pub camera: &'a Camera,
    /// Pixels per row.
    pub width: u32,
    /// One per pixel, as [`Renderer::hits`](raystep_kernels::Renderer::hits) gives them.
    pub hits: &'a [Option<RayHit>],
}

/// A point of a surface that a ray leaves.
struct Departure {
    /// In the triangle, exactly but for f64's rounding.
    point: DVec3,
    /// Unit, towards the viewer.
    normal: DVec3,
    corners: [Vec3; 3],
}

impl PrimaryHits<'_> {
    /// One ray per hit, with a density of cos θ / π about the normal.
    ///
    /// Normal plus a point of the unit sphere: Shirley et al., "Sampling Transformations Zoo", §16.6.2, in
    /// *Ray Tracing Gems*, 2019.
    #[must_use]
    pub fn bounce(&self, seed: u32) -> Vec<Ray> {
        self.each(|pixel, normal| {
            let sum = normal + Random::of(pixel, seed).on_sphere();
            // The opposite of the normal would cancel it.
            let direction = if sum.length_squared() > 1e-12 { sum.normalize() } else { normal };
            move |_| Some(direction)
        })
    }

    /// One ray per hit whose visible side faces its light. The direction spans the whole distance from origin to light,
    /// so t = 1 is at the light. Of several lights, each hit takes one at random. A directional light is placed beyond
    /// any shadow in the scene; the cone of a spot is ignored.
    ///
    /// In a scene without lights, one is placed at the centre of the top (+Y) of the scene's box: the headlight that
    /// shading would use is at the eye, which every hit sees by definition.
    #[must_use]
    pub fn shadow(&self, seed: u32) -> Vec<Ray> {
        let bounds = self.scene.bounds();
        let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
        let far = 2.0 * (max - min).length();
        let top = (min + max) * 0.5 + DVec3::Y * ((max.y - min.y) * 0.5);
        self.each(|pixel, normal| {
            let lights = self.scene.lights.as_slice();
            let light = lights.get(Random::of(pixel, seed).below(lights.len()));
            move |origin| {
                let direction = match light {
                    Some(Light::Point { position, .. } | Light::Spot { position, .. }) => {
                        Vec3::from(*position).as_dvec3() - origin
                    }
                    Some(Light::Directional { direction, .. }) => Vec3::from(*direction).as_dvec3() * -far,
                    None => top - origin,
                };
                (direction.dot(normal) > 0.0).then_some(direction)
            }
        })
    }

    /// A ray for every hit, in order: `directions` makes for a pixel and its normal what finds a direction from an origin;
    /// if there is none, the ray is omitted.
    fn each<D: Fn(DVec3) -> Option<DVec3>>(&self, directions: impl Fn(u32, DVec3) -> D + Sync) -> Vec<Ray> {
        let units = Units::of(self.scene);
        let ray_of = |i: usize| {
            let departure = self.departure(self.hits.get(i)?.as_ref()?)?;
            departure.ray(units, directions(i as u32, departure.normal))
        };
        // In tiles of pixels, so that the rays of a workgroup start near each other.
        let width = (self.width as usize).max(1);
        let (columns, rows) = (width.div_ceil(TILE), self.hits.len().div_ceil(width).div_ceil(TILE));
        let part = |tiles: Range<usize>| {
            let mut rays = Vec::new();
            for tile in tiles {
                let (left, top) = (tile % columns * TILE, tile / columns * TILE);
                let pixels = (0..TILE * TILE).map(|i| (left + i % TILE, top + i / TILE));
                rays.extend(pixels.filter(|p| p.0 < width).filter_map(|(x, y)| ray_of(y * width + x)));
            }
            rays
        };
        in_tiles(&map_ranges(columns * rows, PIXELS_PER_TASK / (TILE * TILE), part).concat())
    }

    /// `None` for a triangle without area: it has no normal.
    fn departure(&self, hit: &RayHit) -> Option<Departure> {
        let corners = self.scene.triangles.get(hit.triangle as usize)?.map(Vec3::from);
        let [a, b, c] = corners.map(|corner| corner.as_dvec3());
        let (ab, ac) = (b - a, c - a);
        // Weights give a point in the triangle's plane, where t would give one on the ray. Rounded, they may lie beyond an
        // edge.
        let (u, v) = (f64::from(hit.u).max(0.0), f64::from(hit.v).max(0.0));
        let sum = (u + v).max(1.0);
        let point = a + (ab * u + ac * v) / sum;
        let normal = ab.cross(ac).try_normalize()?;
        let towards_viewer = match self.camera.projection {
            Projection::Perspective { .. } => self.camera.eye - point,
            Projection::Orthographic { .. } => -self.camera.forward,
        };
        let normal = if normal.dot(towards_viewer) < 0.0 { -normal } else { normal };
        Some(Departure { point, normal, corners })
    }
}

impl Departure {
    /// The ray from the smallest height at which f32 cannot find the surface. `None` if there is no direction, no such
    /// height within the triangle's size, or the ray cannot be traced.
    fn ray(&self, units: Units, direction: impl Fn(DVec3) -> Option<DVec3>) -> Option<Ray> {
        let vertices: Vec<f32> = self.corners.iter().flat_map(|c| c.to_array()).map(|v| units.to_traced(v)).collect();
        let size = self.corners.iter().map(|corner| (corner.as_dvec3() - self.point).length()).fold(0.0, f64::max);
        let place = self.point.as_vec3();
        let rounding = (0..3).map(|axis| self.normal[axis].abs() * unit_in_last_place(place[axis])).sum::<f64>();
        let mut height = rounding.max(size * f64::from(f32::EPSILON) / 2.0);
        loop {
            let origin = (self.point + self.normal * height).as_vec3();
            let ray = ray(origin.as_dvec3(), direction(origin.as_dvec3())?)?;
            let traced = ray.origin.map(|v| units.to_traced(v));
            if possible(&vertices, traced, ray.direction, 0).is_none() {
                return Some(ray);
            }
            height *= 2.0;
            if height > size {
                return None;
            }
        }
    }
}

/// Distance to the next f32 away from 0: twice what rounding to f32 moves a value by.
fn unit_in_last_place(value: f32) -> f64 {
    let size = value.abs().min(f32::MAX.next_down());
    f64::from(size.next_up()) - f64::from(size)
}

#[cfg(test)]
mod tests;
