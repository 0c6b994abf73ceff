//! The history of one ray: whether its explanations are correct, and whether it is the same when traced alone as with
//! all other rays.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use raystep_kernels::export::trace::{Rays, Trace, TraceRow, trace};
use raystep_kernels::programs::closest_hit::states::DONE;
use raystep_kernels::{Accelerator, Device, Numerics, Options, Ray, RaySource, Renderer, Samples, ScheduleKind};
use raystep_scenes::Scene;
use raystep_tests::configurations::{Configuration, STEPPED};
use raystep_tests::{block_on, camera, devices, gpu_of, options, rays, scene, scene_files, words};

/// Sources of rays, whether any hit ends them, and which of them to follow: spread over the image, or alternately from
/// inside the scene, outside it and its surface.
fn followed(scene: &Scene) -> Vec<(RaySource, bool, Vec<[u32; 2]>)> {
    let camera = RaySource::Camera { camera: camera(scene), width: 64, height: 48 };
    let pixels = vec![[32, 24], [20, 30], [45, 17], [11, 40], [52, 36], [3, 3]];
    if scene.triangles.is_empty() {
        return vec![(camera, false, pixels)];
    }
    let random = RaySource::Given(rays::random(scene, 24, 5));
    let nine = || (0..9).map(|i| [i, 0]).collect();
    vec![(camera, false, pixels), (random.clone(), false, nine()), (random, true, nine())]
}

/// A triangle too small for the paper's threshold in a scene with a large one, and a ray that hits it.
fn small_triangle() -> (Scene, RaySource) {
    let mut scene = scene("single-triangle.gltf");
    let [a, b, c] = scene.triangles[0].map(glam::Vec3::from);
    let [u, v] = [(b - a) / 2000.0, (c - a) / 2000.0];
    scene.triangles.push([a, a + u, a + v].map(|corner| corner.to_array()));
    scene.triangle_materials.push(0);
    (scene.normals, scene.texcoords, scene.colors) = (None, None, None);
    let normal = u.cross(v).normalize();
    let origin = a + (u + v) * 0.25 + normal;
    (scene, RaySource::Given(vec![Ray::new(origin.to_array(), (-normal).to_array())]))
}

async fn life(renderer: &mut Renderer, [x, y]: [u32; 2], rays: Rays) -> Trace {
    trace(renderer, x, y, rays, |_| ControlFlow::Continue(())).await.expect("a trace")
}

#[test]
fn the_words_of_every_pass_say_what_the_streams_say() {
    use Accelerator::{Bvh, Grid, None};
    use ScheduleKind::{Compact, Second};
    let configurations = [
        Configuration::new(Grid, Second, 1),
        Configuration::new(Grid, Compact, 1).skipping(),
        Configuration::new(Grid, Compact, 8).skipping(),
        Configuration::new(Grid, Compact, 8),
        Configuration::new(Grid, Second, 1).paper(),
        Configuration::new(Bvh, Compact, 1),
        Configuration::new(Bvh, Compact, 2),
        Configuration::new(None, Second, 1),
        Configuration::new(None, Compact, 8),
        Configuration::new(None, Second, 1).paper(),
    ];
    let mut seen = BTreeMap::<&str, usize>::new();
    let mut hear = |label: &str, scene: &Scene, options: &Options, device: &Device, rays: &[[u32; 2]]| {
        block_on(gpu_of(device), async {
            let mut renderer = Renderer::new(scene, options, device).await.expect("a renderer");
            for &ray in rays {
                let life = life(&mut renderer, ray, Rays::One).await;
                let kinds = words::check(&life, renderer.data());
                for kind in kinds.unwrap_or_else(|why| panic!("{label}, ray {ray:?}: {why}")) {
                    *seen.entry(kind).or_default() += 1;
                }
            }
        });
    };
    for file in scene_files() {
        let scene = scene(&file);
        for configuration in configurations
            .iter()
            .filter(|configuration| configuration.accelerator != None || scene.triangles.len() <= 200)
        {
            for (source, any_hit, rays) in followed(&scene) {
                let is_camera = matches!(source, RaySource::Camera { .. });
                if any_hit && configuration.numerics == Numerics::Paper {
                    continue;
                }
                let options = Options {
                    shade: is_camera,
                    any_hit,
                    ..configuration.of(&Options::new(if any_hit { source.until(1.0) } else { source }))
                };
                // On the adapter, the explanations describe the adapter's results, with values computed by the host.
                let on_adapter = is_camera && configuration.steps == 1 && file == "teapot.glb";
                for (name, device) in devices().into_iter().filter(|(name, _)| *name == "cpu" || on_adapter) {
                    hear(&format!("{file} {name} {configuration}"), &scene, &options, &device, &rays);
                }
            }
        }
    }
    let (scene, source) = small_triangle();
    let options = Options { shade: false, ..Configuration::new(None, Second, 1).paper().of(&Options::new(source)) };
    hear("a small triangle", &scene, &options, &Device::Cpu(Option::None), &[[0, 0]]);
    println!("{seen:?}");
    let all = [
        "generated",
        "started",
        "starts inside",
        "misses the grid",
        "starts outside",
        "steps",
        "steps out",
        "leaps",
        "leaps out",
        "wraps",
        "empty cell",
        "list ended",
        "kept",
        "accepted",
        "accepted in its cell",
        "hit",
        "not nearer",
        "again",
        "outside",
        "outside of the cell",
        "behind",
        "edge-on",
        "small determinant",
        "box met",
        "box missed",
        "node done",
        "leaf",
        "leaf done",
        "down",
        "up",
        "sibling",
        "tree done",
        "last accepted",
        "last missed",
        "no triangles",
        "walk goes on",
        "walk found",
        "walk hit",
        "walk missed",
        "any hit",
        "ray ended",
        "beyond the end",
        "shaded",
        "background",
    ];
    let unseen: Vec<_> = all.into_iter().filter(|kind| !seen.contains_key(kind)).collect();
    assert!(unseen.is_empty(), "explanations that no ray had: {unseen:?}");
}

#[test]
fn a_ray_alone_does_what_it_does_beside_all_others() {
    use Accelerator::{Bvh, Grid, None};
    use ScheduleKind::{Compact, First, Second};
    let configurations = [
        Configuration::new(Grid, Compact, 1).skipping(),
        Configuration::new(Grid, Second, 1),
        Configuration::new(Grid, Compact, 8),
        Configuration::new(Grid, Second, 1).paper(),
        Configuration::new(Bvh, Second, 1),
        Configuration::new(Bvh, Compact, 1),
        Configuration::new(None, Compact, 4),
        Configuration::new(None, First, 1),
    ];
    for file in scene_files() {
        let scene = scene(&file);
        for configuration in configurations
            .iter()
            .filter(|configuration| configuration.accelerator != None || scene.triangles.len() <= 200)
        {
            let on_adapter = ["cornell-box.gltf", "flat.gltf"].contains(&file.as_str());
            for (name, device) in devices().into_iter().filter(|(name, _)| *name == "cpu" || on_adapter) {
                let options = configuration.of(&options(&scene, 22, 17));
                block_on(gpu_of(&device), async {
                    let mut renderer = Renderer::new(&scene, &options, &device).await.expect("a renderer");
                    for pixel in [[11, 8], [4, 12], [21, 0]] {
                        let label = format!("{file} {name} {configuration}, ray {pixel:?}");
                        let whole = life(&mut renderer, pixel, Rays::All).await;
                        let alone = life(&mut renderer, pixel, Rays::One).await;
                        let others = renderer.passes().iter().filter(|p| p.rays_in > 1).count();
                        assert_eq!((others, alone.rays, alone.passes), (0, 1, Option::None), "{label}");
                        assert_eq!((whole.rays, whole.rows.len()), (22 * 17, alone.rows.len()), "{label}");
                        let last = whole.passes.map(|passes| passes - 1);
                        for (alone, whole) in alone.rows.iter().zip(&whole.rows) {
                            // Debug prints every float so that it reads back as the same bits.
                            let expected = if alone.kernel == "shade" { last } else { alone.pass };
                            assert_eq!(whole.pass, expected, "{label}");
                            let alone = TraceRow { pass: expected, ..alone.clone() };
                            assert_eq!(format!("{alone:?}"), format!("{whole:?}"), "{label}");
                        }
                        assert!(alone.rows.last().is_some_and(|row| row.pass.is_none()), "{label}");
                    }
                    // All rays again, as no single ray is requested.
                    renderer.restart();
                    renderer.run(|_| ControlFlow::Continue(())).await.expect("a run");
                    assert_eq!(renderer.live()[DONE as usize], 22 * 17);
                });
            }
        }
    }
}

#[test]
fn where_a_ray_depends_on_the_others_all_are_traced() {
    let scene = scene("cornell-box.gltf");
    let samples = Samples { count: 2, ..Default::default() };
    let of = |configuration: Configuration| configuration.of(&options(&scene, 12, 10));
    let first = of(Configuration::new(Accelerator::Grid, ScheduleKind::First, 1));
    for options in [first, Options { samples, ..of(STEPPED) }] {
        block_on(None, async {
            let mut renderer = Renderer::new(&scene, &options, &Device::Cpu(None)).await.expect("a renderer");
            assert!(!renderer.can_go_alone());
            let [one, all] =
                [life(&mut renderer, [5, 5], Rays::One).await, life(&mut renderer, [5, 5], Rays::All).await];
            assert_eq!((one.rays, one.passes), (120, Some(renderer.passes().len())));
            assert_eq!(one, all);
            words::check(&one, renderer.data()).unwrap_or_else(|why| panic!("{why}"));
        });
    }
}
