//! Rays as a path tracer would trace after the eye rays, generated from the hits of eye rays.
//!
//! | kind | ray |
//! |---|---|
//! | primary | from the camera through the centre of a pixel |
//! | bounce | from a primary hit, cosine-weighted about the surface's geometric normal on the viewer's side |
//! | shadow | from a primary hit to a light; blocked by anything before the light, at t < 1 |
//! | random | from anywhere in the scene's box, in any direction |
//!
//! Bounce and shadow rays are generated in tiles of pixels and traced in tiles, so that the rays of a workgroup start
//! near each other. A pixel without such a ray is omitted: it hits nothing, or its light is behind the surface. A
//! pixel's ray depends only on its hit, its index and the seed: it has the same bits in any order and on any machine
//! (IEEE +, −, ×, ÷ and √ only).
//!
//! Origins of bounce and shadow rays are moved off the surface along the normal by [`SURFACE_OFFSET`] times
//! the largest coordinate of the scene's box. Rounding a point to f32 moves it by at most 2⁻²⁴ of that, so the
//! origin stays on the viewer's side.

mod aimed;
pub mod file;
mod mixed;
mod random;
mod view;

use glam::DVec3;
use raystep_kernels::named;
use raystep_kernels::numbers::parallel::map_ranges;
use raystep_kernels::options::Ray;
use raystep_kernels::plan::{given_width, tiled};
use raystep_kernels::renderer::RayHit;
use raystep_kernels::shared::constants::WORKGROUP;
use raystep_scenes::{Bounds, Camera, Light, Projection, Scene};

pub use aimed::{Aim, Planes, aimed};
pub use mixed::{at_edges, mixed, segments};
pub use random::Random;
pub use view::view;

/// Distance of origins from the surface, as a share of the largest coordinate of the scene's box.
pub const SURFACE_OFFSET: f64 = 1.0 / (1u32 << 16) as f64;

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

/// The hits of a camera's rays.
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

/// Where a ray starts.
struct Departure {
    point: DVec3,
    /// Unit, towards the viewer.
    normal: DVec3,
}

impl PrimaryHits<'_> {
    /// One ray per hit, with a density of cos θ / π about the normal.
    ///
    /// Normal plus a point of the unit sphere: Shirley et al., "Sampling Transformations Zoo", §16.6.2, in
    /// *Ray Tracing Gems*, 2019.
    #[must_use]
    pub fn bounce(&self, seed: u32) -> Vec<Ray> {
        self.each(|pixel, at| {
            let sum = at.normal + Random::of(pixel, seed).on_sphere();
            // The opposite of the normal would cancel it.
            let direction = if sum.length_squared() > 1e-12 { sum.normalize() } else { at.normal };
            ray(at.point, direction)
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
        self.each(|pixel, at| {
            let lights = self.scene.lights.as_slice();
            let light = lights.get(Random::of(pixel, seed).below(lights.len()));
            let direction = match light {
                Some(Light::Point { position, .. } | Light::Spot { position, .. }) => {
                    glam::Vec3::from(*position).as_dvec3() - at.point
                }
                Some(Light::Directional { direction, .. }) => glam::Vec3::from(*direction).as_dvec3() * -far,
                None => top - at.point,
            };
            (direction.dot(at.normal) > 0.0).then(|| ray(at.point, direction)).flatten()
        })
    }

    /// Calls `make` for every hit, in order; `None` results are omitted.
    fn each(&self, make: impl Fn(u32, &Departure) -> Option<Ray> + Sync) -> Vec<Ray> {
        let bounds = self.scene.bounds();
        let offset = f64::from(bounds.min.abs().max(bounds.max.abs()).max_element()) * SURFACE_OFFSET;
        let ray_of = |i: usize| make(i as u32, &self.departure(self.hits.get(i)?.as_ref()?, offset)?);
        // In tiles of pixels, so that the rays of a workgroup start near each other.
        let width = (self.width as usize).max(1);
        let (columns, rows) = (width.div_ceil(TILE), self.hits.len().div_ceil(width).div_ceil(TILE));
        let part = |tiles: std::ops::Range<usize>| {
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
    fn departure(&self, hit: &RayHit, offset: f64) -> Option<Departure> {
        let [a, b, c] = self.scene.triangles.get(hit.triangle as usize)?.map(|p| glam::Vec3::from(p).as_dvec3());
        let (ab, ac) = (b - a, c - a);
        // Vertex weights give a point in the triangle; t would only give one on the ray.
        let point = a + ab * f64::from(hit.u) + ac * f64::from(hit.v);
        let normal = ab.cross(ac).try_normalize()?;
        let towards_viewer = match self.camera.projection {
            Projection::Perspective { .. } => self.camera.eye - point,
            Projection::Orthographic { .. } => -self.camera.forward,
        };
        let normal = if normal.dot(towards_viewer) < 0.0 { -normal } else { normal };
        Some(Departure { point: point + normal * offset, normal })
    }
}

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

    fn camera(eye: DVec3) -> Camera {
        let projection = Projection::Perspective { vertical_fov: 1.0 };
        Camera::look_at(eye, DVec3::ZERO, DVec3::Y, projection).expect("a view")
    }

    /// A floor at y = 7, seen from above; some pixels hit nothing.
    fn floor(lights: Vec<Light>) -> (Scene, Vec<Option<RayHit>>) {
        let triangles = vec![[[-4.0, 7.0, -4.0], [4.0, 7.0, -4.0], [0.0, 7.0, 8.0]]];
        let hit = |i: u32| RayHit { t: 1.0, u: 0.3, v: (i % 64) as f32 / 100.0, triangle: 0 };
        let hits = (0..16_384).map(|i| (i % 4 != 1).then(|| hit(i))).collect();
        (Scene { triangles, lights, ..Scene::default() }, hits)
    }

    #[test]
    fn bounces_leave_on_the_viewers_side_cosine_weighted() {
        let (scene, hits) = floor(Vec::new());
        for side in [1.0, -1.0] {
            let camera = camera(DVec3::new(0.0, 7.0 + 20.0 * side, 1.0));
            let rays = PrimaryHits { scene: &scene, camera: &camera, width: 128, hits: &hits }.bounce(1);
            assert_eq!(rays.len(), 12_288, "one per hit");
            let mut cosines = [0.0; 2];
            let mut sum = Vec3::ZERO;
            for ray in &rays {
                let height = (f64::from(ray.origin[1]) - 7.0) * side;
                assert!((height / (8.0 * SURFACE_OFFSET) - 1.0).abs() < 0.01, "{ray:?}");
                let cosine = f64::from(ray.direction[1]) * side;
                assert!(cosine >= 0.0, "{ray:?} goes below");
                cosines[0] += cosine;
                cosines[1] += cosine * cosine;
                sum += Vec3::from(ray.direction);
            }
            // The means of cos θ and cos² θ are 2/3 and 1/2; tolerance is five standard errors of 12,288 rays.
            let n = rays.len() as f64;
            assert!((cosines[0] / n - 2.0 / 3.0).abs() < 0.011, "{}", cosines[0] / n);
            assert!((cosines[1] / n - 0.5).abs() < 0.014, "{}", cosines[1] / n);
            assert!((sum.x / sum.y).abs() < 0.03 && (sum.z / sum.y).abs() < 0.03, "no side is preferred: {sum}");
        }
    }

    #[test]
    fn shadow_rays_end_at_the_light_unless_it_is_behind() {
        let color = [1.0; 3];
        let point = |y| Light::Point { position: [1.0, y, 2.0], color, intensity: 1.0 };
        let above = camera(DVec3::new(0.0, 30.0, 1.0));
        let rays = |lights: Vec<Light>, camera: &Camera| {
            let (scene, hits) = floor(lights);
            PrimaryHits { scene: &scene, camera, width: 128, hits: &hits }.shadow(1)
        };
        let end = |ray: &Ray| Vec3::from(ray.origin) + Vec3::from(ray.direction);
        let lit = rays(vec![point(9.0)], &above);
        assert_eq!(lit.len(), 12_288);
        assert!(lit.iter().all(|r| end(r).abs_diff_eq(Vec3::new(1.0, 9.0, 2.0), 1e-5)));
        assert_eq!(rays(vec![point(-9.0)], &above), [], "the floor blocks its light everywhere");
        assert_eq!(rays(vec![point(9.0)], &camera(DVec3::new(0.0, -30.0, 1.0))), []);

        let down = Light::Directional { direction: [0.0, -1.0, 0.0], color, intensity: 1.0 };
        let far = (8.0f32 * 8.0 + 12.0 * 12.0).sqrt() * 2.0;
        assert!(rays(vec![down], &above).iter().all(|r| r.direction == [0.0, far, 0.0]));

        let both = rays(vec![point(9.0), point(12.0)], &above);
        let low = both.iter().filter(|r| end(r).y < 10.0).count();
        assert!((5_800..6_500).contains(&low), "each light gets its half: {low} of {}", both.len());

        // Without a light, the centre of the box's top is used; a slope raises the top above the floor.
        let (mut scene, hits) = floor(Vec::new());
        scene.triangles.push([[-4.0, 7.0, 0.0], [4.0, 11.0, 0.0], [0.0, 7.0, 0.0]]);
        let rays = PrimaryHits { scene: &scene, camera: &above, width: 128, hits: &hits }.shadow(1);
        assert!(!rays.is_empty() && rays.iter().all(|r| end(r).abs_diff_eq(Vec3::new(0.0, 11.0, 2.0), 1e-5)));
    }

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
    fn a_pixels_ray_is_its_own() {
        let (scene, hits) = floor(Vec::new());
        let camera = camera(DVec3::new(0.0, 20.0, 1.0));
        let bounce = |hits: &[Option<RayHit>], seed| {
            PrimaryHits { scene: &scene, camera: &camera, width: 128, hits }.bounce(seed)
        };
        let all = bounce(&hits, 1);
        assert_eq!(all, bounce(&hits, 1));
        assert_ne!(all, bounce(&hits, 2));
        let mut fewer = hits.clone();
        fewer[..8].fill(None);
        let kept = bounce(&fewer, 1);
        assert_eq!(kept.len(), all.len() - 6);
        assert!(kept.iter().all(|ray| all.contains(ray)), "what other pixels see does not matter");
        assert_eq!(bounce(&vec![None; 9], 1), []);
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
    fn what_cannot_be_traced_is_left_out() {
        let line = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
        let huge = [[f32::MAX, 0.0, 0.0], [f32::MAX, 1.0, 0.0], [f32::MAX, 0.0, 1.0]];
        let scene = Scene { triangles: vec![line, huge], ..Scene::default() };
        let camera = camera(DVec3::new(1e39, 0.0, 5.0));
        let hits: Vec<_> = (0..3).map(|triangle| Some(RayHit { t: 1.0, u: 0.1, v: 0.1, triangle })).collect();
        assert_eq!(PrimaryHits { scene: &scene, camera: &camera, width: 128, hits: &hits }.bounce(1), []);
    }

    #[test]
    fn names_are_read_back() {
        for kind in RayKind::ALL {
            assert_eq!(kind.to_string().parse(), Ok(*kind));
        }
        assert!("x".parse::<RayKind>().is_err());
    }
}
