//! Scenes in which something huge stands beside something small are traced with few tests per ray, and correctly.

use glam::{DMat3, DVec3};
use raystep_kernels::programs::closest_hit::streams;
use raystep_kernels::{Accelerator, Device, Options, Ray, RaySource, ScheduleKind, Skip};
use raystep_lab::rays::Random;
use raystep_scenes::{Scene, generate};
use raystep_tests::configurations::Configuration;
use raystep_tests::{check, devices, hits, mistakes_among, thorough, traced, values};

/// Most triangles that a ray may test, on average.
const MOST_TESTS: f64 = 60.0;

const RAYS: u32 = 600;

type Triangle = [DVec3; 3];

fn scene_of(triangles: &[Triangle]) -> Scene {
    let mut scene = generate::icosphere(0).expect("a sphere");
    scene.triangles = triangles.iter().map(|t| t.map(|p| p.as_vec3().to_array())).collect();
    scene.triangle_materials = vec![0; triangles.len()];
    (scene.normals, scene.texcoords, scene.colors) = (None, None, None);
    scene
}

fn triangles_of(scene: &Scene) -> Vec<Triangle> {
    scene.triangles.iter().map(|t| t.map(|p| glam::Vec3::from(p).as_dvec3())).collect()
}

/// A square of two triangles in the plane y = `y`.
fn plane(y: f64, half: f64) -> [Triangle; 2] {
    let [a, b, c, d] =
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, z]: [f64; 2]| DVec3::new(x * half, y, z * half));
    [[a, b, c], [a, c, d]]
}

/// A box of twelve triangles around the origin.
fn hall(half: f64) -> Vec<Triangle> {
    let side = |turn: DMat3| plane(-half, half).map(|t| t.map(|p| turn * p));
    let quarter = std::f64::consts::FRAC_PI_2;
    (0..4)
        .map(|i| DMat3::from_rotation_z(f64::from(i) * quarter))
        .chain([quarter, -quarter].map(DMat3::from_rotation_x))
        .flat_map(side)
        .collect()
}

/// Rays towards corners, edges and insides of `of`, from around it; and from there in any direction, as after a bounce.
fn rays(of: &[Triangle], distance: f64) -> Vec<Ray> {
    let points = || of.iter().flatten();
    let center = points().sum::<DVec3>() / points().count() as f64;
    (0..RAYS)
        .map(|i| {
            let mut random = Random::of(i, 5);
            let [a, b, c] = of[random.below(of.len())];
            let target = match i % 4 {
                0 => a,
                1 => a.lerp(b, random.unit()),
                _ => a * 0.5 + b.lerp(c, random.unit()) * 0.5,
            };
            let away = center + random.on_sphere() * distance;
            let (origin, direction) = if i % 3 == 0 {
                ((target + (away - target) * 1e-3).as_vec3(), random.on_sphere())
            } else {
                (away.as_vec3(), target - away.as_vec3().as_dvec3())
            };
            Ray::new(origin.to_array(), direction.as_vec3().to_array())
        })
        .collect()
}

type Hits = [Vec<u32>; 4];

/// The mean number of tests per ray, and the hits, which are compared with f64 unless they are those `judged` before.
fn tests_of(
    label: &str,
    scene: &Scene,
    rays: &[Ray],
    configuration: Configuration,
    device: &Device,
    judged: &Option<Hits>,
) -> (f64, Hits) {
    let options = Options { shade: false, counters: true, ..Options::new(RaySource::Given(rays.to_vec())) };
    let renderer = traced(scene, &configuration.of(&options), device);
    assert_eq!(renderer.unfinished(), 0, "{label} {configuration}");
    let hits = hits(&renderer);
    if judged.as_ref() == Some(&hits) && !thorough() {
        // The same hits have the same mistakes.
    } else if scene.triangles.len() < 30_000 || thorough() {
        let report = check(&renderer);
        assert_eq!(report.counts.errors(), 0, "{label} {configuration}: {report}");
    } else {
        let some: Vec<usize> = (0..rays.len()).step_by(5).collect();
        assert_eq!(mistakes_among(&renderer, &some), [], "{label} {configuration}");
    }
    let counts = values(&renderer, streams::COUNTERS);
    let tests = (0..rays.len()).map(|ray| f64::from(counts.get(1, ray))).sum::<f64>() / rays.len() as f64;
    (tests, hits)
}

fn few_tests(label: &str, scene: &Scene, rays: &[Ray]) {
    use ScheduleKind::{Compact, Fused};
    // In turn; in the full suite, each scene on both devices.
    let turn = label.len() % 2;
    for (at, (name, device)) in devices().into_iter().enumerate() {
        if at != turn && !thorough() {
            continue;
        }
        let mut first = None;
        for configuration in [
            Configuration::new(Accelerator::Bvh, Fused, 1),
            Configuration::new(Accelerator::Bvh, Compact, 8),
            Configuration::new(Accelerator::Irregular, Fused, 1),
            Configuration::new(Accelerator::Irregular, Compact, 8),
            Configuration::new(Accelerator::Auto, Fused, 1),
        ] {
            let (tests, hits) = tests_of(label, scene, rays, configuration, &device, &first);
            assert_eq!(
                &hits,
                first.get_or_insert_with(|| hits.clone()),
                "{label}, {configuration} on {name}: other hits"
            );
            println!("{label}, {configuration} on {name}: {tests:.1} tests per ray");
            assert!(tests <= MOST_TESTS, "{label}, {configuration} on {name}: {tests} tests per ray");
        }
    }
}

/// A sphere of 20,480 triangles on a plane of ever larger extent; the whole turned, and moved by ten diameters.
#[test]
fn a_sphere_on_a_huge_plane_costs_few_tests() {
    let sphere = triangles_of(&generate::icosphere(5).expect("a sphere"));
    let turn = DMat3::from_rotation_z(0.6) * DMat3::from_rotation_x(0.5);
    for (i, half) in [1.0, 1e3, 1e5, 1e7].into_iter().enumerate() {
        let places =
            [("at the origin", DMat3::IDENTITY, DVec3::ZERO), ("turned and moved", turn, DVec3::new(11.0, -7.0, 15.0))];
        for (j, (place, turn, offset)) in places.into_iter().enumerate() {
            // In turn; in the full suite, each plane in both places.
            if (i + j) % 2 > 0 && !thorough() {
                continue;
            }
            let moved = |t: &Triangle| t.map(|p| turn * p + offset);
            let small: Vec<Triangle> = sphere.iter().map(moved).collect();
            let all: Vec<Triangle> = sphere.iter().chain(&plane(-1.0, half)).map(moved).collect();
            few_tests(&format!("plane of {half:e} {place}"), &scene_of(&all), &rays(&small, 2.5));
        }
    }
}

/// A sphere far from the world's origin, where coordinates have few bits left for it; and in a hall of that size.
#[test]
fn a_sphere_far_from_the_origin_costs_few_tests() {
    let sphere = triangles_of(&generate::icosphere(4).expect("a sphere"));
    for offset in [1e3, 1e5] {
        let moved = |t: &Triangle| t.map(|p| p + DVec3::new(0.3, 0.9, -0.6) * offset);
        let small: Vec<Triangle> = sphere.iter().map(moved).collect();
        let in_hall = [&small[..], &hall(2.0 * offset)].concat();
        few_tests(&format!("{offset:e} away"), &scene_of(&small), &rays(&small, 2.5));
        few_tests(&format!("{offset:e} away in a hall"), &scene_of(&in_hall), &rays(&small, 2.5));
    }
}

/// A scene that fills one cell of its grid: half of its triangles lie in a cube of 1/64 of its side. A uniform grid gets a
/// second level there.
#[test]
fn a_crowded_cell_is_divided_further() {
    let cloud = triangles_of(&generate::soup(5_000, 4).expect("soup"));
    let crowd: Vec<Triangle> = cloud.iter().map(|t| t.map(|p| p / 64.0 + DVec3::new(0.3, 0.6, 0.2))).collect();
    let (scene, rays) = (scene_of(&[&cloud[..], &crowd].concat()), rays(&crowd, 0.03));
    for (name, device) in devices() {
        for configuration in [
            Configuration::new(Accelerator::Grid, ScheduleKind::Second, 1),
            Configuration::new(Accelerator::Grid, ScheduleKind::Compact, 8),
            Configuration::new(Accelerator::Grid, ScheduleKind::Fused, 1),
        ] {
            let of = |skip: Skip| {
                let rays = RaySource::Given(rays.clone());
                let options = configuration.of(&Options { shade: false, counters: true, ..Options::new(rays) });
                let renderer = traced(&scene, &Options { skip, ..options }, &device);
                assert_eq!(renderer.plan().accelerator, Accelerator::Grid);
                let counts = values(&renderer, streams::COUNTERS);
                let tests = (0..RAYS as usize).map(|ray| f64::from(counts.get(1, ray))).sum::<f64>();
                (tests / f64::from(RAYS), renderer)
            };
            let (one, two) = (of(Skip::Off), of(Skip::Auto));
            println!("{configuration} on {name}: {:.1} tests per ray, in two levels {:.1}", one.0, two.0);
            assert!(one.1.plan().features.grid && two.1.plan().features.irregular, "{configuration} on {name}");
            assert_eq!(hits(&one.1), hits(&two.1), "{configuration} on {name}");
            assert_eq!(check(&two.1).counts.errors(), 0, "{configuration} on {name}");
            // Cells with up to 16 triangles are left as they are.
            assert!(two.0 < 40.0 && one.0 > 20.0 * two.0, "{configuration} on {name}: {} and {}", one.0, two.0);
        }
    }
}

#[test]
fn a_hair_ball_in_a_hall_costs_few_tests() {
    let hair = triangles_of(&generate::hair(2_000, 3).expect("hair"));
    let all = [&hair[..], &hall(1e5)].concat();
    few_tests("hair in a hall", &scene_of(&all), &rays(&hair, 4.0));
}

#[test]
fn a_needle_above_terrain_costs_few_tests() {
    let ground = triangles_of(&generate::terrain(20_000, 2).expect("terrain"));
    let needle = DVec3::new(1.0, 0.3, 0.7).normalize() * 1e6;
    let start = DVec3::new(0.0, 1.0, 0.0);
    let all = [&ground[..], &[[start, start + DVec3::X * 0.01, start + needle]]].concat();
    few_tests("terrain with a needle", &scene_of(&all), &rays(&ground, 1.5));
}

/// The tiny object in a room 300,000 times as large, in which the growth of a uniform padding made all boxes overlap.
#[test]
fn a_tiny_object_in_a_room_costs_few_tests() {
    let scene = generate::tiny_in_room(20_000, 300_000).expect("a scene");
    let all = triangles_of(&scene);
    few_tests("a knot in a room", &scene, &rays(&all[..all.len() - 12], 4.0));
}

/// Rays at the edges of a sphere, and of the hall around it, which is much larger: without any growth of boxes, some of
/// them pass between the boxes of two triangles.
#[test]
fn edges_of_a_small_object_and_of_its_hall_lose_no_ray() {
    let sphere = triangles_of(&generate::icosphere(3).expect("a sphere"));
    for i in 0..8 {
        let mut random = Random::of(i, 8);
        let half = 10.0f64.powi(4 + i as i32 / 2);
        let turn = match i % 2 {
            0 => glam::DQuat::IDENTITY,
            _ => glam::DQuat::from_rotation_arc(DVec3::Y, random.on_sphere()),
        };
        let all: Vec<Triangle> = sphere.iter().chain(&hall(half)).map(|t| t.map(|p| turn * p)).collect();
        let rays: Vec<Ray> = (0..8000)
            .map(|i| {
                let of = if i % 8 == 0 { &all[sphere.len()..] } else { &all[..sphere.len()] };
                let [a, b, _] = of[random.below(of.len())];
                let origin = (random.on_sphere() * 2.5).as_vec3();
                Ray::new(origin.to_array(), (a.lerp(b, random.unit()) - origin.as_dvec3()).as_vec3().to_array())
            })
            .collect();
        let options = Options { shade: false, ..Options::new(RaySource::Given(rays)) };
        for schedule in [ScheduleKind::Fused, ScheduleKind::Compact] {
            let configuration = Configuration::new(Accelerator::Bvh, schedule, 8);
            let renderer = traced(&scene_of(&all), &configuration.of(&options), &Device::Cpu(None));
            assert!(renderer.plan().features.ray_padding);
            let report = check(&renderer);
            assert_eq!(report.counts.errors(), 0, "{half:e} {configuration}: {report}");
        }
    }
}
