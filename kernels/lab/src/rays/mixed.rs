//! Rays for tests, in scene units, the same on every machine: everywhere in a scene, and at its edges.

use raystep_kernels::Ray;
use raystep_scenes::Scene;

use super::Random;
use super::aimed::on_edge;

/// A third each: from inside the scene's box, from outside towards it, and from points on the surface. Without
/// triangles the last third starts inside.
#[must_use]
pub fn mixed(scene: &Scene, count: usize, seed: u64) -> Vec<Ray> {
    let mut random = Random::new(seed);
    let bounds = scene.bounds();
    let (min, size) = (bounds.min.as_dvec3(), (bounds.max - bounds.min).as_dvec3());
    let diagonal = size.length();
    let inside = |r: &mut Random| (min + size * glam::DVec3::new(r.unit(), r.unit(), r.unit())).as_vec3().to_array();
    let ray = |i: usize| match i % 3 {
        0 => Ray::new(inside(&mut random), random.direction()),
        1 => {
            let away = glam::Vec3::from(random.direction()).as_dvec3() * diagonal * (1.0 + random.unit());
            let origin = (min + size * 0.5 + away).as_vec3();
            let target = glam::Vec3::from(inside(&mut random));
            Ray::new(origin.to_array(), (target - origin).to_array())
        }
        _ => {
            let Some(triangle) = scene.triangles.get(random.below(scene.triangles.len())) else {
                return Ray::new(inside(&mut random), random.direction());
            };
            let corners = triangle.map(|p| glam::Vec3::from(p).as_dvec3());
            let (a, b) = random.in_triangle();
            let origin = corners[0] + (corners[1] - corners[0]) * a + (corners[2] - corners[0]) * b;
            Ray::new(origin.as_vec3().to_array(), random.direction())
        }
    };
    (0..count).map(ray).collect()
}

/// Rays with an end, like shadow rays: from one point of the scene's box or surface to another one, which lies
/// at t = 1.
#[must_use]
pub fn segments(scene: &Scene, count: usize, seed: u64) -> Vec<Ray> {
    let (from, to) = (mixed(scene, 3 * count, seed), mixed(scene, 3 * count, seed + 1));
    let ray = |i: usize| {
        // Of three random rays, the first starts inside the box, the last on the surface.
        let (origin, target) = (from[3 * i + [0, 2][i % 2]].origin, to[3 * i + [0, 2][i / 2 % 2]].origin);
        Ray::new(origin, (glam::Vec3::from(target) - glam::Vec3::from(origin)).to_array())
    };
    (0..count).map(ray).filter(|ray| ray.direction != [0.0; 3]).collect()
}

/// Rays from `origin` towards every vertex and along every edge of the scene in turn, at points that f32 rounds to
/// either side. None if there are no triangles.
#[must_use]
pub fn at_edges(scene: &Scene, origin: [f32; 3], count: usize, seed: u64) -> Vec<Ray> {
    if scene.triangles.is_empty() {
        return Vec::new();
    }
    let mut random = Random::new(seed);
    let from = glam::Vec3::from(origin).as_dvec3();
    let ray = |i| Ray::new(origin, (on_edge(scene, i, &mut random) - from).as_vec3().to_array());
    (0..count).map(ray).collect()
}
