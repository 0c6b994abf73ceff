//! Scenes and rays of the families, the same on every machine.

use std::ops::Range;

use glam::{DMat3, DVec3};
use raystep_kernels::{GridSize, Ray};
use raystep_scenes::{Scene, generate};

use crate::Error;
use crate::rays::Random;
use crate::stability::Workload;
use crate::stability::make::{self, Triangle, drawn, given, ray, scene_of, sphere, towards, vec};

type Made = Result<Workload, Error>;

/// Where objects stand: on no plane of an automatic grid.
const PLACE: DVec3 = DVec3::new(0.11, -0.07, 0.13);
/// Where scenes are moved: neither along an axis nor a diagonal.
const AWAY: DVec3 = DVec3::new(1.0, -0.7, 0.4);
/// Subdivisions of a sphere of 5,120 triangles.
const FINE: u64 = 4;
const SLIVERS: i32 = 400;

fn triangle(corners: [DVec3; 3]) -> Triangle {
    corners.map(|p| p.as_vec3().to_array())
}

/// Two triangles.
fn quad(corners: [DVec3; 4]) -> [Triangle; 2] {
    make::quad(corners.map(|p| p.as_vec3().to_array()))
}

/// A random point on a random edge of some of the triangles.
fn on_edge(scene: &Scene, of: &Range<usize>, random: &mut Random) -> DVec3 {
    let corners = scene.triangles[of.start + random.below(of.len())].map(vec);
    let edge = random.below(3);
    corners[edge].lerp(corners[(edge + 1) % 3], random.unit())
}

/// A random point in a random triangle.
pub(super) fn on_surface(scene: &Scene, random: &mut Random) -> DVec3 {
    let [a, b, c] = scene.triangles[random.below(scene.triangles.len())].map(vec);
    let (u, v) = random.in_triangle();
    a + (b - a) * u + (c - a) * v
}

/// Rays to the edges of some triangles, from random points around their centre.
fn from_around(scene: Scene, of: Range<usize>, center: DVec3, distance: f64, count: usize, seed: u32) -> Workload {
    let rays = drawn(count, seed, |_, random| {
        let origin = center + random.on_sphere() * distance;
        towards(on_edge(&scene, &of, random), origin)
    });
    given(scene, rays)
}

/// A sphere with a diameter of 1 / `ratio` in a cube of side 1.
pub(super) fn room(ratio: f64, count: usize, seed: u32) -> Made {
    let radius = 0.5 / ratio;
    let mut scene = sphere(FINE, |p| p * radius + PLACE)?;
    let object = 0..scene.triangles.len();
    scene.triangles.extend(generate_cube(0.5));
    Ok(from_around(scene_of(scene.triangles), object, PLACE, 2.5 * radius, count, seed))
}

fn generate_cube(half: f64) -> Vec<Triangle> {
    let wall = |axis: usize, side: f64| {
        let corner = |[a, b]: [f64; 2]| {
            let mut p = [side; 3];
            (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (a, b);
            DVec3::from(p) * half
        };
        quad([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(corner))
    };
    (0..3).flat_map(|axis| [-1.0, 1.0].map(|side| wall(axis, side))).flatten().collect()
}

pub(super) fn plane(ratio: f64, count: usize, seed: u32) -> Made {
    let mut scene = sphere(FINE, |p| p)?;
    let object = 0..scene.triangles.len();
    let corner = |[x, z]: [f64; 2]| DVec3::new(x * ratio, -1.0, z * ratio);
    scene.triangles.extend(quad([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(corner)));
    let scene = scene_of(scene.triangles);
    let rays = drawn(count, seed, |_, random| {
        let around = random.on_sphere() * 2.5;
        towards(on_edge(&scene, &object, random), DVec3::new(around.x, around.y.abs(), around.z))
    });
    Ok(given(scene, rays))
}

pub(super) fn extents(ratio: f64, count: usize, seed: u32) -> Made {
    let scene = sphere(FINE, |p| DVec3::new(p.x, p.y, p.z / ratio))?;
    let all = 0..scene.triangles.len();
    Ok(from_around(scene, all, DVec3::ZERO, 2.5, count, seed))
}

pub(super) fn slivers(aspect: f64, count: usize, seed: u32) -> Made {
    strip(aspect, DMat3::IDENTITY, count, seed)
}

pub(super) fn slivers_aslant(aspect: f64, count: usize, seed: u32) -> Made {
    strip(aspect, DMat3::from_rotation_z(0.6) * DMat3::from_rotation_x(0.5), count, seed)
}

/// Slivers of length 1, side by side in a plane, and rays from one side of it.
fn strip(aspect: f64, turn: DMat3, count: usize, seed: u32) -> Made {
    let at = |k: i32, y: f64| turn * DVec3::new(f64::from(k - SLIVERS / 2) / aspect, y, 0.0);
    let sliver = |k: i32| quad([at(k, 0.0), at(k + 1, 0.0), at(k + 1, 1.0), at(k, 1.0)]);
    let scene = scene_of((0..SLIVERS).flat_map(sliver).collect());
    let rays = drawn(count, seed, |_, random| {
        let target = on_surface(&scene, random);
        let side = DVec3::new(random.unit() - 0.5, random.unit() - 0.5, 1.0);
        towards(target, target + turn * side)
    });
    Ok(given(scene, rays))
}

pub(super) fn crowd(share: f64, count: usize, seed: u32) -> Made {
    const SIZE: f64 = 1.0 / 64.0;
    let mut triangles = generate::soup(5_000, 1)?.triangles;
    let crowded = (share * triangles.len() as f64).round() as usize;
    let small = |p: [f32; 3]| (DVec3::new(0.37, 0.41, 0.33) + vec(p) * SIZE).as_vec3().to_array();
    // Spread over the whole file, as nothing else in it has an order.
    for i in 0..crowded {
        let place = i * triangles.len() / crowded;
        triangles[place] = triangles[place].map(small);
    }
    let (scene, all) = (scene_of(triangles), 0..5_000);
    let rays = drawn(count, seed, |_, random| {
        let origin = DVec3::new(random.unit(), random.unit(), random.unit());
        towards(on_edge(&scene, &all, random), origin)
    });
    Ok(given(scene, rays))
}

/// Rays from inside a closed sphere around `center` to its edges.
fn from_inside(scene: Scene, center: DVec3, count: usize, seed: u32) -> Workload {
    let all = 0..scene.triangles.len();
    let rays = drawn(count, seed, |_, random| {
        let side = [(); 3].map(|()| random.unit() - 0.5);
        towards(on_edge(&scene, &all, random), center + DVec3::from(side) * 0.8)
    });
    given(scene, rays)
}

pub(super) fn layers(copies: f64, count: usize, seed: u32) -> Made {
    let triangles = sphere(2, |p| p)?.triangles.repeat(copies as usize);
    Ok(from_inside(scene_of(triangles), DVec3::ZERO, count, seed))
}

pub(super) fn offset(distance: f64, count: usize, seed: u32) -> Made {
    let center = AWAY.normalize() * distance;
    Ok(from_inside(sphere(3, |p| p + center)?, center, count, seed))
}

/// A flat box of `cells` by `cells` by 1, with a wall across a corner region at its far end.
pub(super) fn walk(cells: f64, count: usize, seed: u32) -> Made {
    let (x, low) = (0.96 * cells, 0.8 * cells);
    let corner = |[y, z]: [f64; 2]| DVec3::new(x, y, z);
    let mut triangles = quad([[low, 0.0], [cells, 0.0], [cells, 1.0], [low, 1.0]].map(corner)).to_vec();
    let far = DVec3::new(cells, cells, 1.0);
    triangles.push(triangle([DVec3::ZERO, DVec3::X * 0.1, DVec3::Y * 0.1]));
    triangles.push(triangle([far, far - DVec3::X * 0.01, far - DVec3::Z * 0.1]));
    let scene = scene_of(triangles);
    let rays = drawn(count, seed, |_, random| {
        let origin = DVec3::new(0.4, 0.4, 0.3) + 0.3 * DVec3::new(random.unit(), random.unit(), random.unit());
        let target = DVec3::new(x, low + (cells - low) * random.unit(), 0.1 + 0.8 * random.unit());
        towards(target, origin)
    });
    let side = cells as u32;
    Ok(Workload { grid: GridSize::Cells([side, side, 1]), ..given(scene, rays) })
}

pub(super) fn outlier(distance: f64, count: usize, seed: u32) -> Made {
    let mut scene = sphere(FINE, |p| p)?;
    let object = 0..scene.triangles.len();
    let far = AWAY.normalize() * distance;
    scene.triangles.push(triangle([far, far + DVec3::X * 0.1, far + DVec3::Y * 0.1]));
    Ok(from_around(scene_of(scene.triangles), object, DVec3::ZERO, 2.5, count, seed))
}

/// Eight panels, one above the other in a tilted plane; each has a row of triangles below its long edge.
pub(super) fn t_junctions(edges: f64, count: usize, seed: u32) -> Made {
    const PANELS: i32 = 8;
    let most = edges as i32;
    let at = |x: f64, y: f64| DVec3::new(x, y, 0.37 * x + 0.21 * y);
    let mut triangles = Vec::new();
    for panel in 0..PANELS {
        let y = f64::from(panel);
        let x = |k: i32| f64::from(k) / edges;
        triangles.extend(quad([at(0.0, y), at(1.0, y), at(1.0, y + 0.5), at(0.0, y + 0.5)]));
        for k in 0..most {
            triangles.extend(quad([at(x(k), y - 0.5), at(x(k + 1), y - 0.5), at(x(k + 1), y), at(x(k), y)]));
        }
    }
    let rays = drawn(count, seed, |_, random| {
        let (panel, k) = (random.below(PANELS as usize), random.below(most as usize + 1));
        // The vertex as rounded to f32.
        let target = at(k as f64 / edges, panel as f64).as_vec3().as_dvec3();
        let side = DVec3::new(random.unit() - 0.5, random.unit() - 0.5, 1.0 + random.unit());
        towards(target, target + side)
    });
    Ok(given(scene_of(triangles), rays))
}

/// 50 by 50 squares in the plane x = z, whose points f32 represents exactly.
pub(super) fn squares() -> Vec<Triangle> {
    const SQUARES: i32 = 50;
    let at = |i: i32, k: i32| DVec3::new(f64::from(i), f64::from(k), f64::from(i)) / f64::from(SQUARES);
    let square = |i: i32, k: i32| quad([at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)]);
    let places = (0..SQUARES).flat_map(|i| (0..SQUARES).map(move |k| (i, k)));
    places.flat_map(|(i, k)| square(i, k)).collect()
}

pub(super) fn grazing(inverse_sine: f64, count: usize, seed: u32) -> Made {
    let scene = scene_of(squares());
    let (along, normal) = (DVec3::new(1.0, 0.0, 1.0).normalize(), DVec3::new(-1.0, 0.0, 1.0).normalize());
    let (sine, cosine) = (1.0 / inverse_sine, (1.0 - inverse_sine.powi(-2)).sqrt());
    let rays = drawn(count, seed, |_, random| {
        let target = on_surface(&scene, random);
        // A direction in the plane; the ray comes from above it.
        let around = random.on_sphere();
        let (a, b) = (around.x, around.y);
        let length = a.hypot(b).max(f64::MIN_POSITIVE);
        let direction = (along * (a / length) + DVec3::Y * (b / length)) * cosine - normal * sine;
        ray((target - direction).as_vec3().as_dvec3(), direction)
    });
    Ok(given(scene, rays))
}

/// Rays from the inner part of any scene's box to its edges; none without triangles.
pub(super) fn own(scene: &Scene, count: usize, seed: u32) -> Vec<Ray> {
    let all = 0..scene.triangles.len();
    if all.is_empty() {
        return Vec::new();
    }
    let bounds = scene.bounds();
    let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
    drawn(count, seed, |_, random| {
        let side = [(); 3].map(|()| 0.1 + 0.8 * random.unit());
        towards(on_edge(scene, &all, random), min + (max - min) * DVec3::from(side))
    })
}
