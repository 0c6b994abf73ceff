//! Scenes that break ray tracers: overlapping triangles, triangles without area, coordinates at f32's limits, an empty
//! scene. Every configuration is compared with f64 brute force: no errors except ties.

mod long_lists;

use raystep_kernels::shared::constants::NO_TRIANGLE;
use raystep_kernels::{Accelerator, Options, Ray, RaySource};
use raystep_scenes::{Camera, Material, Scene, generate};
use raystep_tests::configurations::{Configuration, EVERY};
use raystep_tests::rays::{self, Random};
use raystep_tests::{Checked, check_each, devices, scene, thorough};

/// A third of random rays start on a surface, where t = 0 is a tie.
const ON_SURFACE: f64 = 0.34;

fn made_of(triangles: Vec<[[f32; 3]; 3]>) -> Scene {
    let triangle_materials = vec![0; triangles.len()];
    Scene { triangles, triangle_materials, materials: vec![Material::default()], ..Scene::default() }
}

/// An image of `side` by `side` rays that frames the scene.
fn picture(scene: &Scene, side: u32) -> Options {
    let camera = Camera::framing(&scene.bounds());
    let options = Options::new(RaySource::Camera { camera, width: side, height: side });
    Options { shade: false, ..options }
}

/// Traces every configuration on every device; at most the share `ties` of all rays may be ties. Returns every ray's
/// triangle.
fn expect_no_errors(
    name: &str,
    scene: &Scene,
    options: &Options,
    configurations: &[Configuration],
    ties: f64,
) -> Vec<Vec<u32>> {
    let mut found = Vec::new();
    for (device_name, device) in devices() {
        for Checked { configuration, report, triangles } in check_each(scene, options, configurations, &device) {
            let label = format!("{name}, {device_name} {configuration}: {report}");
            assert_eq!(report.errors(), 0, "{label}\n{:#?}", report.mistakes);
            assert!(report.counts.ties as f64 <= ties * report.counts.rays() as f64, "{label}");
            found.push(triangles);
        }
    }
    found
}

#[test]
fn ten_thousand_identical_triangles_are_hit_as_the_first() {
    identical_triangles(
        10_000,
        &EVERY
            .into_iter()
            .filter(|configuration| configuration.steps > 1 || !configuration.is_stepped())
            .collect::<Vec<_>>(),
    );
    identical_triangles(1_000, &EVERY);
}

/// One step per pass: as many passes as there are triangles.
#[test]
#[ignore = "long: sh tests/full.sh"]
fn ten_thousand_identical_triangles_are_walked_step_by_step() {
    identical_triangles(10_000, &EVERY);
}

fn identical_triangles(count: usize, configurations: &[Configuration]) {
    let scene = made_of(vec![[[-1.0, -1.0, 0.3], [1.0, -0.8, -0.2], [0.1, 1.0, 0.4]]; count]);
    for triangles in expect_no_errors("identical", &scene, &picture(&scene, 12), configurations, 0.0) {
        let hit = triangles.iter().filter(|&&id| id == 0).count();
        assert!(hit > 20 && triangles.iter().all(|&id| id == 0 || id == NO_TRIANGLE), "{hit} hit the first");
    }
}

/// Degenerate triangles, lines and points, around one triangle with an area.
#[test]
fn ten_thousand_triangles_without_an_area_hide_no_other() {
    let mut random = Random::new(5);
    let mut whole = |n: usize| random.below(n) as f32 - (n / 2) as f32;
    // Integers, so that the vertices lie on a line exactly.
    let mut triangles: Vec<[[f32; 3]; 3]> = (0..10_000)
        .map(|i| {
            let start = [0; 3].map(|_| whole(512));
            let along = if i % 10 == 0 { [0.0; 3] } else { [0; 3].map(|_| whole(32)) };
            [0.0, 1.0, 3.0].map(|k| [0, 1, 2].map(|a| start[a] + k * along[a]))
        })
        .collect();
    triangles[4321] = [[-200.0, -180.0, 30.0], [220.0, -150.0, -40.0], [0.0, 230.0, 10.0]];
    let scene = made_of(triangles);
    expect_no_errors("without an area", &scene, &picture(&scene, 12), &EVERY, 0.01);
    // One step per pass through all triangles is tested above.
    let few: Vec<Configuration> =
        EVERY.into_iter().filter(|w| w.accelerator != Accelerator::None || w.steps > 1).collect();
    let given = Options::new(RaySource::Given(rays::random(&made_of(vec![scene.triangles[4321]]), 500, 2)));
    for triangles in expect_no_errors("without an area", &scene, &Options { shade: false, ..given }, &few, ON_SURFACE) {
        let hit = triangles.iter().filter(|&&id| id == 4321).count();
        assert!(hit > 100, "{hit} of 500 rays towards the one triangle hit it");
    }
}

#[test]
fn coordinates_at_the_limits_of_f32_are_traced() {
    let sphere = generate::icosphere(2).expect("a small mesh");
    let largest = f64::from(f32::MAX);
    let scales = if thorough() { &[1e-38, 1e-30, 1e30, largest][..] } else { &[1e-38, largest] };
    for &scale in scales {
        let at_scale = |p: [f32; 3]| p.map(|v| (f64::from(v) * scale) as f32);
        let scene = made_of(sphere.triangles.iter().map(|t| t.map(at_scale)).collect());
        let name = format!("scale {scale:e}");
        expect_no_errors(&name, &scene, &picture(&scene, 32), &EVERY, 0.01);
        // From inside, every ray hits the sphere.
        let inside = rays::random(&sphere, 1200, 9).into_iter().filter(|r| glam::Vec3::from(r.origin).length() < 0.8);
        let rays = inside.map(|r| Ray { origin: at_scale(r.origin), ..r }).collect();
        let given = Options { shade: false, ..Options::new(RaySource::Given(rays)) };
        for triangles in expect_no_errors(&name, &scene, &given, &EVERY, 0.02) {
            assert!(triangles.len() > 100 && !triangles.contains(&NO_TRIANGLE), "{name}: a ray got out");
        }
    }
}

#[test]
fn nothing_and_next_to_nothing_are_traced() {
    for file in ["empty.gltf", "single-triangle.gltf"] {
        let scene = scene(file);
        expect_no_errors(file, &scene, &picture(&scene, 32), &EVERY, 0.01);
        let origin = Random::new(3).direction().map(|v| 3.0 * v);
        let rays: Vec<_> = (0..200).map(|i| Ray::new(origin, Random::new(i).direction())).collect();
        let given = Options { shade: false, ..Options::new(RaySource::Given(rays)) };
        expect_no_errors(file, &scene, &given, &EVERY, 0.01);
    }
    let point = made_of(vec![[[1.0, 2.0, 3.0]; 3]]);
    expect_no_errors("a point", &point, &picture(&point, 32), &EVERY, 0.01);
}

/// A plane has no extent along one axis; its grid has a single layer of cells there, and its BVH flat boxes.
#[test]
fn flat_scenes_are_traced() {
    let terrain = generate::terrain(200, 1).expect("a small mesh");
    for axis in 0..3 {
        let turned = |p: [f32; 3]| {
            let mut flat = [p[0], p[2], 0.0];
            flat.swap(axis, 2);
            flat[axis] = 0.37;
            flat
        };
        let scene = made_of(terrain.triangles.iter().map(|t| t.map(turned)).collect());
        expect_no_errors(&format!("flat along {axis}"), &scene, &picture(&scene, 32), &EVERY, 0.01);
        let given = Options::new(RaySource::Given(rays::random(&scene, 300, 4)));
        expect_no_errors(&format!("flat along {axis}"), &scene, &Options { shade: false, ..given }, &EVERY, ON_SURFACE);
        // Rays in the plane see it edge-on, which is not a hit; rays along an axis meet it at vertices.
        let mut rays = rays::random(&scene, 150, 6);
        for (i, ray) in rays.iter_mut().enumerate() {
            let corner = scene.triangles[i][i % 3];
            match i % 2 {
                0 => (ray.origin[axis], ray.direction[axis]) = (0.37, 0.0),
                _ => {
                    (ray.origin, ray.direction) = (corner, [0.0; 3]);
                    (ray.origin[axis], ray.direction[axis]) = (1.0, -1.0);
                }
            }
        }
        let given = Options { shade: false, ..Options::new(RaySource::Given(rays)) };
        for triangles in expect_no_errors(&format!("edge-on to {axis}"), &scene, &given, &EVERY, 0.5) {
            let met = triangles.iter().skip(1).step_by(2).filter(|&&id| id != NO_TRIANGLE).count();
            assert_eq!(met, 75, "rays to a vertex that hit one of its triangles");
        }
    }
    let flat = scene("flat.gltf");
    expect_no_errors("flat.gltf", &flat, &picture(&flat, 32), &EVERY, 0.01);
}
