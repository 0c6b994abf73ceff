//! Scenes and rays for the cases, the same on every machine.

use std::collections::BTreeSet;
use std::ops::Range;

use glam::DVec3;
use raystep_kernels::GridSize;
use raystep_kernels::options::{Ray, RaySource};
use raystep_scenes::{Camera, Material, Projection, Scene, generate};

use crate::Error;
use crate::rays::Random;
use crate::stability::Workload;
use crate::stability::planes::Planes;

pub(crate) type Triangle = [[f32; 3]; 3];
type Made = Result<Workload, Error>;

/// Seed of all random numbers.
pub(super) const SEED: u32 = 2007;

/// A scene of triangles.
pub(crate) fn scene_of(triangles: Vec<Triangle>) -> Scene {
    let triangle_materials = vec![0; triangles.len()];
    Scene { triangles, triangle_materials, materials: vec![Material::default()], ..Scene::default() }
}

/// Rays in a scene, with the automatic grid.
pub(crate) fn given(scene: Scene, rays: Vec<Ray>) -> Workload {
    Workload { scene, rays: RaySource::Given(rays), grid: GridSize::Auto }
}

/// A closed unit sphere with its vertices moved.
pub(crate) fn sphere(subdivisions: u64, moved: impl Fn(DVec3) -> DVec3) -> Result<Scene, Error> {
    let triangles = generate::icosphere(subdivisions)?.triangles;
    let corner = |p: [f32; 3]| moved(vec(p)).as_vec3().to_array();
    Ok(scene_of(triangles.into_iter().map(|t| t.map(corner)).collect()))
}

pub(crate) fn vec(p: [f32; 3]) -> DVec3 {
    glam::Vec3::from(p).as_dvec3()
}

pub(crate) fn ray(origin: DVec3, direction: DVec3) -> Ray {
    Ray::new(origin.as_vec3().to_array(), direction.as_vec3().to_array())
}

/// A ray from the origin as rounded to f32.
pub(crate) fn towards(target: DVec3, origin: DVec3) -> Ray {
    let origin = origin.as_vec3().as_dvec3();
    ray(origin, target - origin)
}

/// Two triangles.
pub(crate) fn quad<T: Copy>([a, b, c, d]: [T; 4]) -> [[T; 3]; 2] {
    [[a, b, c], [a, c, d]]
}

/// Values from random numbers of their own, by index: more of them begin with the same ones.
pub(crate) fn drawn<T>(count: usize, seed: u32, mut one: impl FnMut(usize, &mut Random) -> T) -> Vec<T> {
    (0..count).map(|i| one(i, &mut Random::of(i as u32, seed))).collect()
}

/// A random point in a cube around the origin.
fn in_cube(random: &mut Random, half: f64) -> DVec3 {
    let mut side = || (2.0 * random.unit() - 1.0) * half;
    DVec3::new(side(), side(), side())
}

/// A random point in a triangle, away from its edges.
fn within(triangle: &Triangle, random: &mut Random) -> DVec3 {
    let weights = [0; 3].map(|_| 0.1 + random.unit());
    let sum: f64 = weights.iter().sum();
    (0..3).map(|c| vec(triangle[c]) * (weights[c] / sum)).sum()
}

/// Random directions from random points in a cube.
pub(super) fn inside(half: f64, count: usize) -> Vec<Ray> {
    drawn(count, SEED + 2, |_, r| ray(in_cube(r, half), r.on_sphere()))
}

/// Rays inside a closed sphere along each axis, both ways, with the other components ±`tiny`.
pub(super) fn near_axis(count: usize, tiny: f32) -> Made {
    let rays = drawn(count, SEED + 3, |i, random| {
        let sign = |bit: usize| if ((i / 3) >> bit) & 1 == 0 { 1.0 } else { -1.0 };
        let mut direction = [tiny * sign(0), tiny * sign(1), tiny * sign(2)];
        direction[i % 3] = sign(i % 3);
        Ray::new(in_cube(random, 0.5).as_vec3().to_array(), direction)
    });
    Ok(Workload { grid: GridSize::Cells([64; 3]), ..given(sphere(3, |p| p)?, rays) })
}

/// What rays are aimed at.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum At {
    /// Points along edges, mainly their middles.
    Edges,
    /// Vertices.
    Corners,
}

/// Rays from a few points around `center` to edges or vertices of the scene, all different; fewer than `count` to
/// vertices if there are not as many.
pub(super) fn aimed(scene: Scene, count: usize, at: At, center: DVec3) -> Workload {
    const FROM: [[f32; 3]; 4] = [[0.0; 3], [0.3, -0.2, 0.1], [-0.45, 0.4, 0.35], [0.0, 0.6, 0.0]];
    // Every pair of a target and an origin at most once: rays that repeat say nothing new.
    let targets = targets(&scene, at);
    let mut pairs: Vec<(usize, usize)> =
        (0..targets.len()).flat_map(|t| (0..FROM.len()).map(move |f| (t, f))).collect();
    Random::of(0, SEED + 4).shuffle(&mut pairs);
    let most = if at == At::Corners { pairs.len() } else { usize::MAX };
    let rays = drawn(count.min(most), SEED + 4, |i, random| {
        let (target, from) = pairs[i % pairs.len()];
        let [a, b] = targets[target];
        let along = match (at, i % 2) {
            (At::Corners, _) => 0.0,
            (At::Edges, 0) if i < pairs.len() => 0.5,
            (At::Edges, _) => random.unit(),
        };
        towards(a + (b - a) * along, center + vec(FROM[from]))
    });
    given(scene, rays)
}

/// The scene's different edges, or its different vertices, each twice.
fn targets(scene: &Scene, at: At) -> Vec<[DVec3; 2]> {
    let mut seen = BTreeSet::new();
    let mut targets = Vec::new();
    for corners in &scene.triangles {
        for k in 0..3 {
            let (a, b) = (corners[k], if at == At::Edges { corners[(k + 1) % 3] } else { corners[k] });
            // + 0 makes -0 the same as 0.
            let bits = |p: [f32; 3]| p.map(|v| (v + 0.0).to_bits());
            if seen.insert((bits(a).min(bits(b)), bits(a).max(bits(b)))) {
                targets.push([vec(a), vec(b)]);
            }
        }
    }
    targets
}

/// A closed sphere far from the origin: half of the rays aim at edges, half anywhere.
pub(super) fn moved(count: usize, distance: f64) -> Made {
    let center = DVec3::new(1.0, -0.7, 0.4) * distance;
    let mut workload = aimed(sphere(2, |p| p + center)?, count, At::Edges, center);
    workload.grid = GridSize::Cells([8; 3]);
    if let RaySource::Given(rays) = &mut workload.rays {
        for (one, other) in rays.iter_mut().zip(inside(0.4, count)).step_by(2) {
            *one = ray(center + vec(other.origin), vec(other.direction));
        }
    }
    Ok(workload)
}

/// The same with scaled units.
pub(super) fn scaled(count: usize, scale: f64) -> Made {
    let mut workload = aimed(sphere(3, |p| p)?, count, At::Edges, DVec3::ZERO);
    let scaled = |p: [f32; 3]| (vec(p) * scale).as_vec3().to_array();
    workload.scene.triangles.iter_mut().flatten().for_each(|p| *p = scaled(*p));
    if let RaySource::Given(rays) = &mut workload.rays {
        rays.iter_mut().for_each(|r| r.origin = scaled(r.origin));
    }
    Ok(workload)
}

/// Rays from a distance towards the inner part of a sphere.
pub(super) fn from_afar(count: usize, distance: f64) -> Made {
    let rays = drawn(count, SEED + 5, |_, random| {
        let origin = random.on_sphere() * distance;
        towards(random.on_sphere() * 0.5, origin)
    });
    Ok(given(sphere(3, |p| p)?, rays))
}

/// Rays from points on the surface of a sphere.
pub(super) fn on_surface(count: usize) -> Made {
    let scene = sphere(3, |p| p)?;
    let start = |r: &mut Random| within(&scene.triangles[r.below(scene.triangles.len())], r);
    let rays = drawn(count, SEED + 6, |_, r| ray(start(r), r.on_sphere()));
    Ok(given(scene, rays))
}

/// Rays from points on cell faces in any direction.
pub(super) fn on_faces(count: usize) -> Made {
    let scene = sphere(3, |p| p)?;
    let mut rays = inside(0.5, count);
    let planes = Planes::of(&scene, rays.clone(), [16; 3])?;
    for (i, ray) in rays.iter_mut().enumerate() {
        ray.origin[i % 3] = planes.plane(i % 3, 5 + (i / 3 % 7) as i32);
    }
    Ok(Workload { grid: GridSize::Cells([16; 3]), ..given(scene, rays) })
}

/// Rays towards every triangle in turn, from `away` above the scene's centre, slightly oblique.
fn from_above(scene: Scene, count: usize, away: f64) -> Workload {
    let bounds = scene.bounds();
    let eye = (bounds.min + bounds.max).as_dvec3() * 0.5 + DVec3::new(0.1, -0.07, 1.0) * away;
    let rays = drawn(count, SEED + 7, |_, random| {
        let origin = eye + in_cube(random, 0.2 * away);
        towards(within(&scene.triangles[random.below(scene.triangles.len())], random), origin)
    });
    given(scene, rays)
}

/// A strip cut lengthwise into slivers, with rays to its inner half.
pub(super) fn slivers(count: usize, aspect: f64) -> Made {
    const SLIVERS: i32 = 400;
    let x = |k: i32| (f64::from(k - SLIVERS / 2) / aspect) as f32;
    let strip = |k: i32| quad([[x(k), 0.0, 0.0], [x(k + 1), 0.0, 0.0], [x(k + 1), 1.0, 0.0], [x(k), 1.0, 0.0]]);
    let scene = scene_of((0..SLIVERS).flat_map(strip).collect());
    let rays = drawn(count, SEED + 8, |_, random| {
        let target = DVec3::new((random.unit() - 0.5) * f64::from(x(SLIVERS)), 0.2 + 0.6 * random.unit(), 0.0);
        towards(target, DVec3::new((random.unit() - 0.5) * 0.8, random.unit(), 1.0))
    });
    Ok(given(scene, rays))
}

/// Every triangle of a closed sphere twice.
pub(super) fn duplicates(count: usize) -> Made {
    let scene = sphere(2, |p| p)?;
    let triangles = [scene.triangles.clone(), scene.triangles].concat();
    Ok(given(scene_of(triangles), inside(0.4, count)))
}

/// Three sheets of different triangles in one plane, as far as f32 can represent it.
pub(super) fn coplanar(count: usize) -> Made {
    let at = |x: f32, y: f32| [x, y, 0.3 * x + 0.2 * y];
    let sheet = |low: f32, high: f32| quad([at(low, low), at(high, low), at(high, high), at(low, high)]);
    Ok(from_above(scene_of([(0.0, 1.0), (-0.1, 1.2), (-0.25, 1.05)].map(|(l, h)| sheet(l, h)).concat()), count, 1.0))
}

/// A terrain without height, flat along z.
pub(super) fn flat(count: usize) -> Made {
    let terrain = generate::terrain(200, 1)?.triangles;
    let flat = terrain.into_iter().map(|t| t.map(|p| [p[0], p[2], 0.37])).collect();
    Ok(from_above(scene_of(flat), count, 1.0))
}

/// Rays in a flat scene's plane.
pub(super) fn in_plane(count: usize) -> Made {
    let mut workload = flat(count)?;
    if let RaySource::Given(rays) = &mut workload.rays {
        for (i, ray) in rays.iter_mut().enumerate() {
            (ray.origin[2], ray.direction[2]) = (0.37, if i % 2 == 0 { 0.0 } else { -0.0 });
        }
    }
    Ok(workload)
}

/// Rays exactly in a tilted triangle's plane: integers with x + 2y + 3z = 0.
pub(super) fn in_tilted_plane(count: usize) -> Made {
    let on_plane = |r: &mut Random, most: usize| {
        let mut whole = || r.below(2 * most + 1) as f32 - most as f32;
        let (y, z) = (whole(), whole());
        [-2.0 * y - 3.0 * z, y, z]
    };
    let triangle = [[1700.0, -400.0, -300.0], [-300.0, 450.0, -200.0], [-1500.0, 0.0, 500.0]];
    let rays = drawn(count, SEED + 10, |_, r| {
        let origin = on_plane(r, 900);
        let direction = on_plane(r, 900);
        Ray::new(origin, if direction == [0.0; 3] { [-2.0, 1.0, 0.0] } else { direction })
    });
    Ok(given(scene_of(vec![triangle]), rays))
}

/// Triangles with two or three identical vertices.
pub(super) fn without_area(count: usize) -> Made {
    let triangle = |i: usize, r: &mut Random| {
        let [a, b] = [0; 2].map(|_| in_cube(r, 1.0).as_vec3().to_array());
        [[a, b, b], [a, b, a], [a, a, b], [a, a, a]][i % 4]
    };
    Ok(from_above(scene_of(drawn(500, SEED + 11, triangle)), count, 2.0))
}

/// Degenerate triangles along the x axis.
pub(super) fn line(count: usize, away: f64) -> Made {
    let triangle = |i: i32| [0.0, 1.0, 0.375].map(|k| [(f64::from(i) + k) as f32, 0.0, 0.0]);
    Ok(from_above(scene_of((0..64).map(triangle).collect()), count, away))
}

/// One triangle.
pub(super) fn one_triangle(count: usize) -> Made {
    Ok(from_above(scene_of(vec![[[-1.0, -0.8, 0.1], [1.0, -1.0, -0.2], [0.1, 1.0, 0.3]]]), count, 2.0))
}

/// No triangle.
pub(super) fn no_triangle(count: usize) -> Made {
    Ok(given(scene_of(Vec::new()), inside(1.0, count)))
}

/// Ten thousand triangles in one grid cell, seen from nearby.
pub(super) fn crowd(count: usize) -> Made {
    const SIZE: f64 = 1e-3;
    let soup = generate::soup(10_000, 1)?.triangles;
    let middle = scene_of(soup.clone()).bounds();
    let middle = (middle.min + middle.max).as_dvec3() * 0.5;
    let small = |p: [f32; 3]| ((vec(p) - middle) * SIZE + DVec3::splat(0.1)).as_vec3().to_array();
    let mut triangles: Vec<Triangle> = soup.into_iter().map(|t| t.map(small)).collect();
    let rays = drawn(count, SEED + 12, |_, random| {
        let origin = DVec3::splat(0.1) + random.on_sphere() * 2.0 * SIZE;
        towards(within(&triangles[random.below(triangles.len())], random), origin)
    });
    triangles.extend([
        [[-1.0, -1.0, -1.0], [-0.9, -1.0, -1.0], [-1.0, -0.9, -1.0]],
        [[1.0, 1.0, 1.0], [0.9, 1.0, 1.0], [1.0, 0.9, 1.0]],
    ]);
    Ok(Workload { grid: GridSize::Cells([8; 3]), ..given(scene_of(triangles), rays) })
}

/// A closed sphere containing another one 100,000 times smaller, seen from close to it.
pub(super) fn tiny_detail(count: usize) -> Made {
    const SIZE: f64 = 1e-5;
    let place = DVec3::new(0.2, 0.1, -0.3);
    let mut scene = sphere(2, |p| p * SIZE + place)?;
    let detail = scene.triangles.len();
    scene.triangles.extend(sphere(2, |p| p)?.triangles);
    let rays = drawn(count, SEED + 13, |_, random| {
        let origin = place + random.on_sphere() * 10.0 * SIZE;
        towards(within(&scene.triangles[random.below(detail)], random), origin)
    });
    Ok(given(scene_of(scene.triangles), rays))
}

/// A wall at the end of a walk of 3,000 cells, along the diagonal of a grid with one layer. It is just before a plane:
/// a ray that is not in its cell by then never enters it.
pub(super) fn long_walk(count: usize) -> Made {
    const SIDE: f32 = 1600.0;
    const CELLS: [u32; 3] = [1600, 1600, 1];
    let ends = |x: f32| {
        let wall = |y: f32, z: f32| [x, y, z];
        let [one, two] = quad([wall(1300.0, 0.0), wall(SIDE, 0.0), wall(SIDE, 1.0), wall(1300.0, 1.0)]);
        let near = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let far = [[SIDE, 0.0, 0.0], [SIDE, 1.0, 0.0], [SIDE, 0.0, 1.0]];
        scene_of(vec![one, two, near, far])
    };
    let plane = Planes::of(&ends(1500.0), vec![Ray::new([1.0; 3], [1.0; 3])], CELLS)?.plane(0, 1580);
    let x = plane - 0.004;
    let rays = drawn(count, SEED + 14, |_, random| {
        let origin = DVec3::new(0.6, 0.6, 0.3) + in_cube(random, 0.2);
        let target = DVec3::new(f64::from(x), 1400.0 + 190.0 * random.unit(), 0.3);
        ray(origin, target - origin)
    });
    Ok(Workload { grid: GridSize::Cells(CELLS), ..given(ends(x), rays) })
}

/// Triangles, each half as large and half as far away as the one before, which no BVH can balance. Rays aim at those of
/// some levels.
pub(super) fn halving(count: usize, levels: Range<i32>) -> Made {
    let triangle = |i: i32| {
        let x = 0.5f32.powi(i);
        [[x, -0.25 * x, -0.25 * x], [x, 0.25 * x, -0.2 * x], [x, 0.0, 0.3 * x]]
    };
    let scene = scene_of((0..levels.end).map(triangle).collect());
    let aimed_at = &scene.triangles[levels.start as usize..];
    let rays = drawn(count, SEED + 15, |i, random| {
        let triangle = &aimed_at[i % aimed_at.len()];
        let size = f64::from(triangle[0][0]);
        let origin = (DVec3::X * 1.3 + in_cube(random, 0.1)) * size;
        ray(origin, within(triangle, random) - origin)
    });
    Ok(given(scene, rays))
}

/// Identical triangles, which no BVH can separate.
pub(super) fn identical(count: usize) -> Made {
    Ok(from_above(scene_of(vec![[[-1.0, -1.0, 0.3], [1.0, -0.8, -0.2], [0.1, 1.0, 0.4]]; 2000]), count, 2.0))
}

/// An image of the inside of a closed sphere.
pub(super) fn picture(width: u32, height: u32, fov_deg: f64) -> Made {
    let eye = DVec3::new(0.05, 0.1, 0.2);
    camera(sphere(3, |p| p)?, eye, DVec3::new(-0.3, 0.1, -1.0), [width, height], fov_deg, GridSize::Auto)
}

/// An image along an axis from a point on a plane of the grid.
pub(super) fn picture_on_plane(side: u32, fov_deg: f64) -> Made {
    let scene = sphere(3, |p| p)?;
    let planes = Planes::of(&scene, inside(0.5, 8), [16; 3])?;
    let eye = DVec3::new(f64::from(planes.plane(0, 7)), 0.04, 0.2);
    camera(scene, eye, eye - DVec3::Z, [side; 2], fov_deg, GridSize::Cells([16; 3]))
}

/// The paper's box, whose walls lie in planes of the grid.
pub(super) fn walls(count: usize) -> Made {
    let side = (count.isqrt() as u32).max(1);
    let scene = generate::cornell_box();
    let camera = scene.cameras.first().cloned().ok_or(Error::NoView)?;
    let rays = RaySource::Camera { camera, width: side, height: side };
    Ok(Workload { scene, rays, grid: GridSize::Cells([20; 3]) })
}

fn camera(scene: Scene, eye: DVec3, target: DVec3, [width, height]: [u32; 2], fov_deg: f64, grid: GridSize) -> Made {
    let projection = Projection::Perspective { vertical_fov: fov_deg.to_radians() };
    let camera = Camera::look_at(eye, target, DVec3::Y, projection).ok_or(Error::NoView)?;
    Ok(Workload { scene, rays: RaySource::Camera { camera, width, height }, grid })
}
