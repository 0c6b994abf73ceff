//! All hits of a ray are those that rational arithmetic finds, through every structure, by every schedule and on every device;
//! and a closed surface is left as often as it is entered, wherever a ray passes it.

use std::sync::Arc;

use raystep_kernels::shared::crossing::sees_front;
use raystep_kernels::{AllHits, AllHitsPlace, CastHit, Caster, Device, Options, Order, Ray, RaySource, ScheduleKind};
use raystep_lab::rays::Random;
use raystep_lab::reference::Triangles;
use raystep_scenes::Scene;
use raystep_scenes::generate::icosphere;
use raystep_tests::{block_on, devices, gpu, gpu_of, parity, thorough};

use crate::exact_order::{COMBINATIONS, Corners, Numbers, family, terrain};

fn caster(scene: &Arc<Scene>, options: &Options, device: &Device) -> Caster {
    let options = Options { all_hits: true, ..options.clone() };
    block_on(gpu_of(device), Caster::new(scene.clone(), &options, device)).expect("a caster")
}

fn all_hits(caster: &mut Caster, rays: &[Ray], device: &Device) -> AllHits {
    let found = block_on(gpu_of(device), caster.cast_all(rays)).expect("hits");
    assert_eq!(caster.unfinished(), 0);
    found
}

/// The triangles of each ray.
fn triangles(found: &AllHits, rays: usize) -> Vec<Vec<u32>> {
    let mut of_rays = vec![Vec::new(); rays];
    for (&ray, hit) in found.rays.iter().zip(&found.hits) {
        of_rays[ray as usize].push(hit.triangle);
    }
    of_rays
}

const KINDS: [&str; 7] = ["needles", "boards", "duplicates", "coplanar", "lattice", "far", "terrain"];

#[test]
fn every_combination_lists_what_rational_arithmetic_finds() {
    let count = if thorough() { 20_000 } else { 120 };
    let mut at_edges = 0;
    for (place, kind) in KINDS.into_iter().enumerate() {
        let (corners, rays) = if kind == "terrain" { terrain(count) } else { family(kind, count) };
        let scene = Arc::new(Scene::from_triangles(corners));
        let vertices: Vec<f32> = scene.triangles.iter().flatten().flatten().copied().collect();
        let exact = Triangles::new(&vertices);
        let wanted: Vec<Vec<u32>> = rays.iter().map(|ray| exact.crossings(ray.origin, ray.direction)).collect();
        let hits: usize = wanted.iter().map(Vec::len).sum();
        assert!(4 * hits > count, "{kind}: {hits} hits of {count} rays");
        for (ray, wanted) in rays.iter().zip(&wanted) {
            let met = exact.candidates(ray.origin, ray.direction).possible;
            at_edges += usize::from(met.iter().filter(|met| met.is_exact).count() != wanted.len());
        }
        for (index, (accelerator, schedule, steps_per_pass)) in COMBINATIONS.into_iter().enumerate() {
            let options = Options { accelerator, schedule, steps_per_pass, ..Caster::options() };
            let on = |name: &str, device: &Device, rays: &[Ray]| {
                let found = all_hits(&mut caster(&scene, &options, device), rays, device);
                let label = format!("{kind}, {accelerator} {schedule} {steps_per_pass} on {name}");
                for (i, (found, wanted)) in triangles(&found, rays.len()).iter().zip(&wanted).enumerate() {
                    assert_eq!(found, wanted, "{label}: {:?}", rays[i]);
                }
                found
            };
            let cpu = on("the CPU", &Device::Cpu(None), &rays);
            // Each of them with one of the kinds.
            if thorough() || index % KINDS.len() == place {
                let few = &rays[..count.min(400)];
                let found = on("the GPU", &Device::Gpu(gpu()), few);
                let bits = |hit: &CastHit| [hit.t, hit.u, hit.v].map(f32::to_bits);
                let same = found.hits.iter().zip(&cpu.hits).all(|(one, other)| bits(one) == bits(other));
                assert!(same, "{kind}, {accelerator} {schedule} {steps_per_pass}: t, u or v differ");
            }
        }
    }
    // Otherwise nothing would have been tested.
    assert!(at_edges > 50, "only {at_edges} rays meet an edge");
}

/// The black fields of a chessboard in three dimensions: boxes that share edges and corners with others. And the radius of a sphere
/// about all.
fn boxes() -> (Vec<Corners>, f32) {
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut corners = Vec::new();
    // Every second of 27.
    for at in (0..27).step_by(2) {
        let at = [at % 3, at / 3 % 3, at / 9].map(|v| v as f32 - 1.5);
        let corner = |i: u32| [0, 1, 2].map(|axis| at[axis] + ((i >> axis) & 1) as f32);
        let of_faces = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
        corners.extend(of_faces.map(|ids| ids.map(corner)));
    }
    (corners, 3.0)
}

fn sphere() -> (Vec<Corners>, f32) {
    let sphere = icosphere(3).expect("a small mesh");
    (sphere.triangles.to_vec(), 1.0)
}

/// Rays from outside of what is within a sphere of this radius: at corners, edges and silhouettes, along edges and in the planes
/// of triangles.
fn aimed(corners: &[Corners], radius: f32, count: usize, seed: u32) -> Vec<Ray> {
    let mut numbers = Numbers(Random::of(seed, 5));
    let n = &mut numbers;
    let plus = |a: [f32; 3], b: [f32; 3], by: f32| [0, 1, 2].map(|i| a[i] + by * b[i]);
    let minus = |a: [f32; 3], b: [f32; 3]| plus(a, b, -1.0);
    (0..count)
        .map(|i| {
            let [a, b, c] = corners[n.below(corners.len())];
            let [p, q] = [[a, b], [b, c], [c, a]][n.below(3)];
            // Powers of two and lattices keep what is aimed at exact.
            let towards = match i % 6 {
                0 => p,
                1 => plus(p, minus(q, p), 0.5),
                2 => plus(p, minus(q, p), n.below(8) as f32 / 8.0),
                3 => plus(a, plus(minus(b, a), minus(c, a), 1.0), 0.25),
                _ => p,
            };
            let away = match i % 6 {
                // Along an edge, and in the plane of a triangle: other triangles' silhouettes.
                4 => minus(p, q),
                5 => plus(minus(p, q), minus(c, a), n.one()),
                _ => n.point(),
            };
            let size = away.iter().fold(0.0f32, |m, v| m.max(v.abs())).max(1e-3);
            let by = (4.0 * radius / size).log2().ceil().exp2();
            let origin = plus(towards, away, by);
            Ray::new(origin, minus(towards, origin))
        })
        .filter(|ray| ray.direction != [0.0; 3])
        .collect()
}

/// Rays that are within a surface after one hit more than after the other.
fn odd(found: &AllHits, rays: usize) -> usize {
    triangles(found, rays).iter().filter(|triangles| triangles.len() % 2 == 1).count()
}

#[test]
fn a_closed_surface_is_left_as_often_as_it_is_entered() {
    let mut odd_by_t = 0;
    let mut hits = 0;
    for (mesh, (corners, radius)) in [("boxes", boxes()), ("sphere", sphere())] {
        let scene = Arc::new(Scene::from_triangles(corners.clone()));
        for (name, device) in devices() {
            let is_cpu = name == "cpu";
            for (index, (accelerator, schedule, steps_per_pass)) in COMBINATIONS.into_iter().enumerate() {
                if !is_cpu && !thorough() && index % 4 != 0 {
                    continue;
                }
                // Those that are fast do most of the work.
                let is_fast = schedule == ScheduleKind::Fused && accelerator != raystep_kernels::Accelerator::None;
                let count = match (thorough(), is_cpu, is_fast) {
                    (true, true, true) => 1_000_000,
                    (true, false, true) => 100_000,
                    (true, ..) => 5_000,
                    (false, true, true) => 5_000,
                    (false, false, true) => 500,
                    _ => 200,
                };
                let label = format!("{mesh}, {accelerator} {schedule} {steps_per_pass} on {name}");
                let options = Options { accelerator, schedule, steps_per_pass, ..Caster::options() };
                let mut caster = caster(&scene, &options, &device);
                for (part, first) in (0..count).step_by(50_000).enumerate() {
                    let rays = aimed(&corners, radius, (count - first).min(50_000), part as u32);
                    let found = all_hits(&mut caster, &rays, &device);
                    assert_eq!(odd(&found, rays.len()), 0, "{label}: odd counts");
                    for (ray, triangles) in rays.iter().zip(triangles(&found, rays.len())) {
                        let enters = triangles.iter().enumerate().all(|(i, &triangle)| {
                            sees_front(ray.direction, corners[triangle as usize]) == (i % 2 == 0)
                        });
                        assert!(enters, "{label}: {ray:?} does not enter and leave in turn: {triangles:?}");
                    }
                    hits += found.hits.len();
                }
            }
        }
        odd_by_t += iterated(&scene, &aimed(&corners, radius, 6_000, 0));
    }
    assert!(hits > 50_000, "{hits} hits");
    // What is counted one hit after the other, each with the t of the one before as t_min.
    assert!(odd_by_t > 1_000, "only {odd_by_t} odd counts by t");
}

fn iterated(scene: &Arc<Scene>, rays: &[Ray]) -> usize {
    let options = Options { order: Order::Exact, ..Caster::options() };
    let mut caster = block_on(None, Caster::new(scene.clone(), &options, &Device::Cpu(None))).expect("a caster");
    let mut going: Vec<(Ray, usize)> = rays.iter().map(|&ray| (ray, 0)).collect();
    for _ in 0..100 {
        let rays: Vec<Ray> = going.iter().map(|(ray, _)| *ray).collect();
        let hits = block_on(None, caster.cast(&rays)).expect("hits");
        for ((ray, count), hit) in going.iter_mut().zip(hits).filter(|(_, hit)| hit.is_hit()) {
            (*ray, *count) = (ray.between(hit.t, f32::INFINITY), *count + 1);
        }
    }
    going.iter().filter(|(_, count)| count % 2 == 1).count()
}

/// From inside, on a surface and at its corners, too, the moved origin tells.
#[test]
fn a_ray_that_starts_on_a_surface_is_inside_or_outside_of_it() {
    let (corners, _) = boxes();
    let scene = Arc::new(Scene::from_triangles(corners.clone()));
    let mut numbers = Numbers(Random::of(3, 1));
    let half = |n: &mut Numbers| [0; 3].map(|_| 0.5 * n.below(10) as f32 - 2.5);
    let rays: Vec<Ray> = (0..1000)
        .map(|_| [half(&mut numbers), half(&mut numbers)])
        .filter(|[origin, direction]| *direction != [0.0; 3] && *origin != [0.0; 3])
        .map(|[origin, direction]| Ray::new(origin, direction))
        .collect();
    let (mut inside, mut at_start) = (0, 0);
    for (name, device) in devices() {
        let found = all_hits(&mut caster(&scene, &Caster::options(), &device), &rays, &device);
        for (ray, triangles) in rays.iter().zip(triangles(&found, rays.len())) {
            // The fields are [-1.5, -0.5), [-0.5, 0.5) and [0.5, 1.5) along each axis.
            let fields: f32 = ray.origin.iter().map(|v| (v + 1.5).floor()).sum();
            let is_inside = ray.origin.iter().all(|v| (-1.5..1.5).contains(v)) && fields % 2.0 == 0.0;
            assert_eq!(triangles.len() % 2 == 1, is_inside, "{name}: {ray:?}: {triangles:?}");
            inside += usize::from(is_inside);
        }
        at_start += found.hits.iter().filter(|hit| hit.t == 0.0).count();
        assert!(found.hits.iter().all(|hit| hit.t >= 0.0 && hit.t.is_finite()), "{name}");
    }
    assert!(inside > 200 && at_start > 50, "{inside} inside, {at_start} at the start");
}

#[test]
fn parts_batches_and_intervals_change_nothing() {
    let (corners, _) = boxes();
    let scene = Arc::new(Scene::from_triangles(corners.clone()));
    for (name, device) in devices() {
        // A round takes software Vulkan as long for one ray as for many.
        let (count, parts) = match name {
            "cpu" => (600, &[(1, 40), (7, 1000), (100, 64)][..]),
            _ => (60, &[(20, 40)][..]),
        };
        let rays = aimed(&corners, 3.0, count, 9);
        let mut caster = caster(&scene, &Caster::options(), &device);
        let whole = all_hits(&mut caster, &rays, &device);
        assert!(whole.hits.len() > count, "{} hits", whole.hits.len());
        for &(most, batch) in parts {
            caster.set_batch(batch);
            let (mut place, mut found, mut largest) = (AllHitsPlace::with_most(most), AllHits::default(), 0);
            loop {
                let before = found.hits.len();
                let more = block_on(gpu_of(&device), caster.cast_some(&rays, &mut place, &mut found)).expect("hits");
                largest = largest.max(found.hits.len() - before);
                if !more {
                    break;
                }
            }
            assert!(found == whole, "{name}: at most {most} at a time, batches of {batch}");
            assert_eq!(place.rays(), rays.len());
            assert!(largest <= most + batch as usize, "{name}: {largest} hits at once");
        }
        // Every second ray ends, or begins later.
        let cut: Vec<Ray> = rays
            .iter()
            .enumerate()
            .map(|(i, ray)| match i % 3 {
                0 => *ray,
                1 => ray.between(0.0, 1.0),
                _ => ray.between(1.0, f32::INFINITY),
            })
            .collect();
        let of_cut = all_hits(&mut caster, &cut, &device);
        let counts = |&(&ray, hit): &(&u64, &CastHit)| {
            let ray = cut[ray as usize];
            (ray.t_min == 0.0 || hit.t > ray.t_min) && hit.t < ray.t_max
        };
        let wanted: Vec<_> = whole.rays.iter().zip(&whole.hits).filter(counts).collect();
        assert!(wanted.len() < whole.hits.len());
        assert!(of_cut.rays.iter().zip(&of_cut.hits).eq(wanted), "{name}: intervals");
    }
}

#[test]
fn what_finds_no_hits_in_order_is_refused() {
    let scene = Arc::new(Scene::from_triangles(vec![[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]));
    let device = Device::Cpu(None);
    let refused = |options: &Options| {
        let made = block_on(None, Caster::new(scene.clone(), options, &device));
        made.err().map(|error| error.to_string()).expect("no caster")
    };
    let all = Options { all_hits: true, ..Caster::options() };
    assert!(refused(&Options { any_hit: true, ..all.clone() }).contains("exclude any hit"));
    assert!(refused(&Options { numerics: raystep_kernels::Numerics::Paper, ..all }).ends_with("--numerics robust"));
    let mut caster = block_on(None, Caster::new(scene, &Caster::options(), &device)).expect("a caster");
    let error = block_on(None, caster.cast_all(&[])).expect_err("another caster");
    assert!(error.to_string().contains("Options::all_hits"), "{error}");
}

/// Pass by pass, a device leaves what the CPU reference kernels leave, also where rays wait for another dispatch.
#[test]
fn integers_decide_alike_on_a_device_and_on_the_cpu() {
    let (corners, radius) = sphere();
    let scene = Scene::from_triangles(corners.clone());
    let rays = aimed(&corners, radius, 40, 2);
    for (accelerator, schedule, steps_per_pass) in [COMBINATIONS[0], COMBINATIONS[8]] {
        let rays = RaySource::Given(rays.clone());
        let options = Options { accelerator, schedule, steps_per_pass, order: Order::Exact, ..Options::new(rays) };
        let options = Options { all_hits: true, shade: false, counters: true, ..options };
        let label = format!("{accelerator} {schedule} {steps_per_pass}");
        let found = parity::compare_in_turns(&gpu(), &scene, &options, 2048);
        assert_eq!((found.breaches, found.miscounts), (vec![], vec![]), "{label}");
    }
}
