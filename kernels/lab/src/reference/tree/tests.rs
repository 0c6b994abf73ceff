use raystep_kernels::options::{Options, Ray, RaySource};
use raystep_kernels::plan::{Limits, Plan};
use raystep_scenes::{Scene, generate};

use super::super::Triangles;
use super::*;
use crate::rays::{Aim, Random, aimed};

type Given = [[f32; 3]; 2];

/// Rays through triangles, past them by any share of their size or of their distance, and along axes and edges.
fn rays(vertices: &[f32], count: usize, random: &mut Random) -> Vec<Given> {
    let triangles = vertices.len() / 9;
    let corner = |random: &mut Random| {
        let first = 9 * random.below(triangles) + 3 * random.below(3);
        wide([vertices[first], vertices[first + 1], vertices[first + 2]])
    };
    let near = |point: DVec3, random: &mut Random| {
        // From nothing to far more than what f32 rounds.
        let off = point.length().max(1e-30) * 10f64.powi(-(random.below(9) as i32));
        if random.below(4) == 0 { point } else { point + off * random.on_sphere() }
    };
    let make = |_| {
        let (from, to) = (corner(random), corner(random));
        let origin = near(if random.below(3) == 0 { from } else { from * 3.0 + to }, random).as_vec3();
        let direction = match random.below(6) {
            0 => [0.0, 0.0, 1.0],
            1 => [0.0, -1.0, 1e-30],
            2 => (to - from).as_vec3().to_array(),
            _ => (near(to, random) - origin.as_dvec3()).as_vec3().to_array(),
        };
        [origin.to_array(), direction]
    };
    (0..count).map(make).collect()
}

/// Asserts that both find the same; returns how many candidates there were in all.
fn agree(name: &str, vertices: &[f32], rays: &[Given]) -> usize {
    let triangles = Triangles::new(vertices);
    let mut found = 0;
    for &[origin, direction] in rays {
        let (fast, slow) = (triangles.candidates(origin, direction), triangles.brute_force(origin, direction));
        // As text: what is edge-on has weights that are not numbers.
        assert_eq!(format!("{fast:?}"), format!("{slow:?}"), "{name}: {origin:?} {direction:?}");
        found += fast.possible.len();
    }
    found
}

/// Random triangles of a size relative to a cube, at an offset: sometimes without area, or the same several times.
fn random_triangles(count: usize, size: f64, offset: f64, random: &mut Random) -> Vec<f32> {
    let mut all: Vec<f32> = Vec::new();
    let mut point = DVec3::ZERO;
    for _ in 0..count {
        if random.below(8) > 0 {
            point = DVec3::splat(offset) + random.on_sphere() * random.unit();
        }
        let mut corners = [0; 3].map(|_| point + size * random.unit() * random.on_sphere());
        match random.below(8) {
            0 => corners[2] = corners[1],
            1 => corners[2] = 0.5 * (corners[0] + corners[1]),
            2 => corners = [point; 3],
            3 => corners.iter_mut().for_each(|c| c.z = point.z),
            _ => {}
        }
        all.extend(corners.iter().flat_map(|c| c.as_vec3().to_array()));
    }
    all
}

#[test]
fn no_candidate_is_left_out_among_random_and_degenerate_triangles() {
    let mut random = Random::new(41);
    for (count, size, offset) in [
        (1, 1.0, 0.0),
        (5, 0.3, 0.0),
        (400, 0.05, 0.0),
        (400, 1.0, 3.0),
        (400, 1e-4, 0.0),
        // So far away that f32's errors are many times as large as the triangles.
        (300, 1e-4, 1e4),
        (300, 1e-3, 1e7),
        (300, 0.0, 1.0),
        (300, 1e-20, 1e-25),
        (300, 1e30, 0.0),
    ] {
        let vertices = random_triangles(count, size, offset, &mut random);
        let found = agree(&format!("{count} of {size:e} at {offset:e}"), &vertices, &rays(&vertices, 600, &mut random));
        assert!(found > 100, "{count} of {size:e} at {offset:e}: only {found} candidates");
    }
}

/// A scene's vertices in traced units, with rays of all kinds.
fn traced(scene: &Scene, each: usize) -> (Vec<f32>, Vec<Given>) {
    let aims = [Aim::Corners, Aim::Middles, Aim::Along, Aim::Anywhere];
    let given: Vec<Ray> = aims.into_iter().zip(1..).flat_map(|(aim, seed)| aimed(scene, aim, each, seed)).collect();
    let options = Options { shade: false, ..Options::new(RaySource::Given(given.clone())) };
    let (_, data) = Plan::new(scene, &options, &Limits::CPU).expect("a plan");
    let of = |ray: &Ray| {
        let (ray, _) = raystep_kernels::scene_data::traced_ray(ray, data.units);
        [ray.origin, ray.direction]
    };
    (data.vertices.clone(), given.iter().map(of).collect())
}

#[test]
fn no_candidate_is_left_out_in_generated_scenes() {
    for scene in [
        generate::cornell_box(),
        generate::terrain(2_000, 1).expect("a terrain"),
        generate::hair(200, 1).expect("hair"),
        generate::tiny_in_room(500, 1_000_000).expect("a room"),
        generate::sphere_flake(1, 1).expect("spheres"),
    ] {
        let (vertices, rays) = traced(&scene, 200);
        let found = agree(&scene.name, &vertices, &rays);
        assert!(found > 600, "{}: only {found} candidates", scene.name);
    }
}

#[test]
fn what_is_not_finite_hides_nothing() {
    let mut random = Random::new(3);
    let mut vertices = random_triangles(100, 0.5, 0.0, &mut random);
    let rays = rays(&vertices, 300, &mut random);
    for (triangle, value) in [(7, f32::NAN), (20, f32::INFINITY), (50, f32::MAX), (51, -f32::MAX)] {
        vertices[9 * triangle + triangle % 9] = value;
    }
    assert!(agree("not finite", &vertices, &rays) > 100);
    let odd = [f32::NAN, f32::INFINITY, 0.0, f32::MAX, f32::MIN_POSITIVE];
    let of_odd = odd.iter().flat_map(|&a| odd.iter().map(move |&b| [[a, 0.0, 1.0], [b, 0.0, -b]]));
    agree("odd rays", &vertices, &of_odd.collect::<Vec<_>>());
    assert_eq!(agree("nothing", &[], &rays), 0);
}

#[test]
fn a_ray_looks_at_few_of_many_triangles() {
    let scene = generate::terrain(50_000, 1).expect("a terrain");
    let (vertices, rays) = traced(&scene, 250);
    let triangles = Triangles::new(&vertices);
    let work: u64 = rays.iter().map(|&[origin, direction]| triangles.work(origin, direction)).sum();
    let a_ray = work / rays.len() as u64;
    println!("{a_ray} looks a ray");
    // Measured: 500 to 600. Testing every triangle would be 50,000 and more.
    assert!(a_ray < 2_000, "{a_ray} looks a ray");
}
