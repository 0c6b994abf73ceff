//! Rays as a path tracer would trace after the eye rays, generated from the hits of eye rays.
//!
//! | kind | ray |
//! |---|---|
//! | primary | from the camera through the centre of a pixel |
//! | bounce | from a primary hit, cosine-weighted about the surface's geometric normal on the viewer's side |
//! | shadow | from a primary hit to a light that its visible side faces; blocked by anything before the light, at t < 1 |
//! | random | from anywhere in the scene's box, in any direction |
//!
//! Bounce and shadow rays are generated in tiles of pixels and traced in tiles, so that the rays of a workgroup start
//! near each other. A pixel without such a ray is omitted: it hits nothing, its light is behind the surface, or f32 cannot
//! tell on which side of the surface a ray would start. A pixel's ray depends only on its hit, its index and the seed: it
//! has the same bits in any order and on any machine (IEEE +, −, ×, ÷ and √ only).
//!
//! Bounce and shadow rays start off the surface, as near as the bounds on f32's errors allow: see [`PrimaryHits`].

mod aimed;
pub mod file;
mod mixed;
mod primary_hits;
mod random;
mod view;

use glam::DVec3;
use raystep_kernels::named;
use raystep_kernels::numbers::parallel::map_ranges;
use raystep_kernels::options::Ray;
use raystep_kernels::plan::{given_width, tiled};
use raystep_kernels::shared::constants::WORKGROUP;
use raystep_scenes::Bounds;

pub use aimed::{Aim, Planes, aimed};
pub use mixed::{at_edges, mixed, segments};
pub use primary_hits::PrimaryHits;
pub use random::Random;
pub use view::view;

/// Pixels per task.
const PIXELS_PER_TASK: usize = 1 << 15;

/// Kinds of rays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum RayKind {
    /// From the camera through a pixel.
    #[default]
    Primary,
    /// From what the camera sees, into the half space in front of it.
    Bounce,
    /// From what the camera sees to a light.
    Shadow,
    /// From anywhere to anywhere.
    Random,
}

named!(RayKind, "primary, bounce, shadow, random", Primary "primary", Bounce "bounce", Shadow "shadow", Random "random");

/// Width and height of a tile in pixels: those of a workgroup.
const TILE: usize = WORKGROUP as usize;

/// Consecutive rays, placed so that each workgroup's tile of the image in which input rays are arranged has consecutive
/// ones; see [`given_width`].
#[must_use]
pub fn in_tiles(rays: &[Ray]) -> Vec<Ray> {
    let width = given_width(rays.len() as u64) as usize;
    let mut placed = rays.to_vec();
    for (index, ray) in rays.iter().enumerate() {
        placed[tiled(index, width, rays.len())] = *ray;
    }
    placed
}

/// `count` rays with uniformly distributed origins in the scene's box and uniformly distributed directions.
#[must_use]
pub fn random(bounds: &Bounds, count: usize, seed: u32) -> Vec<Ray> {
    let (min, size) = match bounds.is_empty() {
        true => (DVec3::ZERO, DVec3::ZERO),
        false => (bounds.min.as_dvec3(), (bounds.max.as_dvec3() - bounds.min.as_dvec3())),
    };
    let part = |range: std::ops::Range<usize>| {
        let ray_of = |i: usize| {
            let mut random = Random::of(i as u32, seed);
            let x = random.unit();
            let y = random.unit();
            let z = random.unit();
            ray(min + size * DVec3::new(x, y, z), random.on_sphere())
        };
        range.filter_map(ray_of).collect::<Vec<_>>()
    };
    map_ranges(count, PIXELS_PER_TASK, part).concat()
}

/// Rounded to f32; `None` if the result cannot be traced.
fn ray(origin: DVec3, direction: DVec3) -> Option<Ray> {
    let (origin, direction) = (origin.as_vec3(), direction.as_vec3());
    let is_traceable = origin.is_finite() && direction.is_finite() && direction != glam::Vec3::ZERO;
    is_traceable.then(|| Ray::new(origin.to_array(), direction.to_array()))
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn random_rays_fill_the_box_and_the_sphere() {
        let bounds = Bounds { min: Vec3::new(-1.0, 2.0, 3.0), max: Vec3::new(1.0, 2.0, 7.0) };
        let rays = random(&bounds, 20_000, 5);
        assert_eq!(rays.len(), 20_000);
        let (mut origin, mut direction, mut height) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        for ray in &rays {
            let at = Vec3::from(ray.origin);
            assert!(at.cmpge(bounds.min).all() && at.cmple(bounds.max).all(), "{at}");
            assert!((Vec3::from(ray.direction).length() - 1.0).abs() < 1e-6);
            origin += at.as_dvec3() / 20_000.0;
            direction += Vec3::from(ray.direction).as_dvec3() / 20_000.0;
            height += f64::from(ray.direction[2]).abs() / 20_000.0;
        }
        assert!(origin.abs_diff_eq(DVec3::new(0.0, 2.0, 5.0), 0.05), "{origin}");
        let corner = rays.iter().filter(|r| r.origin[0] > 0.0 && r.origin[2] > 5.0).count();
        assert!((4_700..5_300).contains(&corner), "a quarter of the box holds {corner} of 20,000");
        // Archimedes: z is uniform on a sphere, so the mean of |z| is 1/2.
        assert!(direction.length() < 0.03 && (height - 0.5).abs() < 0.02, "{direction} {height}");
        assert!(random(&Bounds::EMPTY, 3, 0).iter().all(|r| r.origin == [0.0; 3]));
    }

    #[test]
    fn a_tile_of_rays_leaves_from_a_tile_of_pixels() {
        let rays: Vec<Ray> = (0..1000).map(|i| Ray::new([i as f32, 0.0, 0.0], [1.0; 3])).collect();
        let placed = in_tiles(&rays);
        let (width, first) = (given_width(1000) as usize, |i: usize| placed[i].origin[0] as usize);
        assert_eq!(width, 32);
        assert_eq!([first(0), first(7), first(8), first(width), first(8 * width)], [0, 7, 64, 8, 256]);
        let mut all: Vec<usize> = (0..1000).map(first).collect();
        all.sort_unstable();
        assert_eq!(all, (0..1000).collect::<Vec<_>>());
    }

    #[test]
    fn names_are_read_back() {
        for kind in RayKind::ALL {
            assert_eq!(kind.to_string().parse(), Ok(*kind));
        }
        assert!("x".parse::<RayKind>().is_err());
    }
}
