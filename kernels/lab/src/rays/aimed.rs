//! Rays aimed at places where ray tracers make mistakes: edges of triangles, and points where surfaces cross the faces
//! of a grid's cells.
//!
//! They start anywhere in the scene's box except near its sides, so that rules which require the origin to be inside
//! the grid apply to them, too.

use glam::{DVec3, Vec3};
use raystep_kernels::options::Ray;
use raystep_kernels::scene_data::SceneData;
use raystep_scenes::Scene;

use super::{Random, ray};

/// What rays are aimed at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aim<'a> {
    /// Middles of edges, corners, and points along edges.
    Edges,
    /// Corners.
    Corners,
    /// Middles of edges.
    Middles,
    /// Any points of edges.
    Along,
    /// Points of triangles in a cell's face, every other one on an edge of the cell if there is one.
    Faces(&'a Planes),
    /// Any direction.
    Anywhere,
}

impl Aim<'_> {
    /// Its name in tables.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Edges => "edges",
            Self::Corners => "corners",
            Self::Middles => "edge_middles",
            Self::Along => "along_edges",
            Self::Faces(_) => "faces",
            Self::Anywhere => "anywhere",
        }
    }
}

/// Share of the scene's box, along each axis, in which origins lie.
const INNER: f64 = 0.8;

/// How many triangles are tried to find one that crosses a plane.
const TRIES: usize = 64;

/// The planes between a grid's cells, in scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Planes {
    corner: [f64; 3],
    width: [f64; 3],
    cells: [i32; 3],
}

impl Planes {
    /// Those of a run's grid.
    #[must_use]
    pub fn of(data: &SceneData) -> Self {
        let unit = data.units.scene_units_per_stream_unit();
        let scaled = |v: [f32; 3]| v.map(|v| f64::from(v) * unit);
        Self { corner: scaled(data.grid.corner), width: scaled(data.grid.width), cells: data.grid.cells }
    }

    /// A random inner plane of the grid between two coordinates; `None` if there is none.
    fn between(&self, axis: usize, low: f64, high: f64, random: &mut Random) -> Option<f64> {
        // A grid without width has no planes to aim at.
        if self.width[axis].is_nan() || self.width[axis] <= 0.0 {
            return None;
        }
        let index = |x: f64| (x - self.corner[axis]) / self.width[axis];
        let first = index(low).ceil().max(1.0);
        let last = index(high).floor().min(f64::from(self.cells[axis] - 1));
        (first <= last).then(|| {
            let chosen = first + random.below((last - first) as usize + 1) as f64;
            self.corner[axis] + self.width[axis] * chosen
        })
    }
}

/// `count` rays; none if the scene has no triangle to aim at. If none of the triangles tried crosses a face, the ray
/// aims at a point of a triangle.
#[must_use]
pub fn aimed(scene: &Scene, aim: Aim<'_>, count: usize, seed: u32) -> Vec<Ray> {
    let bounds = scene.bounds();
    if bounds.is_empty() {
        return Vec::new();
    }
    let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
    let (middle, half) = ((min + max) * 0.5, (max - min) * (0.5 * INNER));
    let aimed = |i: usize| {
        let mut random = Random::of(i as u32, seed);
        let mut side = || 2.0 * random.unit() - 1.0;
        let origin = middle + half * DVec3::new(side(), side(), side());
        // The exact f32 origin is what the target is seen from.
        let origin = origin.as_vec3().as_dvec3();
        let direction = match aim {
            Aim::Edges => on_edge(scene, i, &mut random) - origin,
            Aim::Corners => on_edge(scene, 0, &mut random) - origin,
            Aim::Middles => on_edge(scene, 1, &mut random) - origin,
            Aim::Along => on_edge(scene, 2, &mut random) - origin,
            Aim::Faces(planes) => in_face(scene, planes, i, &mut random) - origin,
            Aim::Anywhere => random.on_sphere(),
        };
        ray(origin, direction)
    };
    (0..count).filter_map(aimed).collect()
}

fn triangle(scene: &Scene, random: &mut Random) -> [DVec3; 3] {
    scene.triangles[random.below(scene.triangles.len())].map(|p| Vec3::from(p).as_dvec3())
}

/// A point on an edge, where two triangles that share it must not both report a miss.
pub(super) fn on_edge(scene: &Scene, i: usize, random: &mut Random) -> DVec3 {
    let corners = triangle(scene, random);
    let edge = random.below(3);
    let (a, b) = (corners[edge], corners[(edge + 1) % 3]);
    let along = match i % 4 {
        0 => 0.0,
        1 => 0.5,
        _ => random.unit(),
    };
    a + (b - a) * along
}

fn in_face(scene: &Scene, planes: &Planes, i: usize, random: &mut Random) -> DVec3 {
    let mut point = DVec3::ZERO;
    for _ in 0..TRIES {
        let corners = triangle(scene, random);
        let (u, v) = random.in_triangle();
        point = corners[0] + (corners[1] - corners[0]) * u + (corners[2] - corners[0]) * v;
        let axis = random.below(3);
        let along = corners.map(|c| c[axis]);
        let (low, high) = (along[0].min(along[1]).min(along[2]), along[0].max(along[1]).max(along[2]));
        let Some(plane) = planes.between(axis, low, high, random) else { continue };
        // The plane cuts two edges; a point between the two cuts is in the triangle. A triangle that lies in the plane
        // is not cut, and any of its points will do.
        let cut = |k: usize| {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            let share = (plane - a[axis]) / (b[axis] - a[axis]);
            (0.0..=1.0).contains(&share).then(|| a + (b - a) * share)
        };
        let cuts: Vec<DVec3> = (0..3).filter_map(cut).collect();
        if let [first, .., last] = cuts[..] {
            // At the edge of a cell, where the line from one point to the other crosses another plane.
            let other = (axis + 1 + random.below(2)) % 3;
            let (a, b) = (first[other], last[other]);
            let share = match planes.between(other, a.min(b), a.max(b), random) {
                Some(plane) if i.is_multiple_of(2) && a != b => (plane - a) / (b - a),
                _ => random.unit(),
            };
            return first + (last - first) * share;
        }
        if low == high {
            return point;
        }
    }
    point
}

#[cfg(test)]
mod tests {
    use raystep_kernels::GridSize;
    use raystep_kernels::options::{Options, RaySource};
    use raystep_kernels::plan::{Limits, Plan};
    use raystep_scenes::generate;

    use super::*;

    fn planes(scene: &Scene, cells: u32) -> Planes {
        let rays = RaySource::Given(vec![Ray::new([0.0; 3], [1.0; 3])]);
        let options = Options { grid: GridSize::Cells([cells; 3]), shade: false, ..Options::new(rays) };
        Planes::of(&Plan::new(scene, &options, &Limits::CPU).expect("a plan").1)
    }

    /// How far from a point a ray passes, relative to the distance of the point from the origin.
    fn misses_by(ray: &Ray, point: DVec3) -> f64 {
        let (origin, direction) = (Vec3::from(ray.origin).as_dvec3(), Vec3::from(ray.direction).as_dvec3());
        (point - origin).cross(direction).length() / (direction.length() * (point - origin).length())
    }

    #[test]
    fn rays_go_where_they_are_aimed_and_start_within_the_box() {
        let scene = generate::icosphere(2).expect("a sphere");
        let planes = planes(&scene, 8);
        let corners: Vec<DVec3> = scene.triangles.iter().flatten().map(|&p| Vec3::from(p).as_dvec3()).collect();
        let edges = aimed(&scene, Aim::Edges, 400, 1);
        assert_eq!(edges.len(), 400);
        let at_corner = |ray: &&Ray| corners.iter().any(|&c| misses_by(ray, c) < 1e-6);
        assert!(edges.iter().filter(at_corner).count() >= 100, "every fourth is aimed at a corner");

        // Aimed at faces, t = 1 is there: the direction is all the way.
        let on_plane = |ray: &&Ray| {
            let target = Vec3::from(ray.origin).as_dvec3() + Vec3::from(ray.direction).as_dvec3();
            (0..3).any(|a| {
                let at = (target[a] - planes.corner[a]) / planes.width[a];
                (at - at.round()).abs() < 1e-5
            })
        };
        assert_eq!(aimed(&scene, Aim::Faces(&planes), 400, 1).iter().filter(on_plane).count(), 400);
        let anywhere = aimed(&scene, Aim::Anywhere, 400, 1);
        assert!(anywhere.iter().filter(on_plane).count() < 20);
        for ray in edges.iter().chain(&anywhere) {
            assert!(ray.origin.iter().all(|v| v.abs() <= 0.81), "{ray:?}");
        }
        assert_eq!(anywhere, aimed(&scene, Aim::Anywhere, 400, 1));
        assert_ne!(anywhere, aimed(&scene, Aim::Anywhere, 400, 2));
    }

    #[test]
    fn walls_in_planes_are_aimed_at_and_nothing_has_no_rays() {
        let wall = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]];
        let ends = [[[-2.0; 3], [-2.0, -2.0, -1.9], [-2.0, -1.9, -2.0]], [[2.0; 3], [2.0, 2.0, 1.9], [2.0, 1.9, 2.0]]];
        let materials = vec![raystep_scenes::Material::default()];
        let triangles = vec![wall, ends[0], ends[1]];
        let scene = Scene { triangles, triangle_materials: vec![0; 3], materials, ..Scene::default() };
        let rays = aimed(&scene, Aim::Faces(&planes(&scene, 4)), 100, 3);
        assert_eq!(rays.len(), 100);
        for aim in [Aim::Edges, Aim::Faces(&planes(&scene, 4)), Aim::Anywhere] {
            assert_eq!(aimed(&Scene::default(), aim, 10, 1), []);
        }
    }

    #[test]
    fn a_grid_without_width_has_no_planes() {
        let mut random = Random::of(0, 1);
        for width in [0.0, f64::NAN] {
            let planes = Planes { corner: [0.0; 3], width: [width; 3], cells: [4; 3] };
            assert_eq!(planes.between(0, 0.0, 0.0, &mut random), None);
            assert_eq!(planes.between(0, -1.0, 1.0, &mut random), None);
        }
    }
}
