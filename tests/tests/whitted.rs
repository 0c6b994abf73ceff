//! Rays that mirrors and glass send on: every kernel against its twin, every ray against f64, and pictures in parts.

use raystep_kernels::options::Integrator;
use raystep_kernels::options::mapping::{Fragment, Mapping};
use raystep_kernels::programs::closest_hit::states::{BACKGROUND, SHADE};
use raystep_kernels::programs::closest_hit::streams::{
    BOUNCE, COLOR, HIT, HIT_TRIANGLE, RAY_DIRECTION, RAY_ORIGIN, STATE, STATE_T, SURFACE,
};
use raystep_kernels::programs::light::PROGRAM;
use raystep_kernels::shared::constants::INF;
use raystep_kernels::tables::stream::STATE_TAG;
use raystep_kernels::{
    Accelerator, Device, Options, Plan, Ray, RaySource, Renderer, Samples, ScheduleKind, StreamData,
};
use raystep_lab::reference::{Triangles, Verdict};
use raystep_scenes::{Optics, Scene, generate};
use raystep_tests::configurations::{COVERING, Configuration, STEPPED};
use raystep_tests::{block_on, devices, gpu, gpu_of, options, parity, scene, scene_files, thorough, traced, values};

fn with_mirrors(options: Options) -> Options {
    Options { integrator: Integrator::Whitted, max_depth: 4, ..options }
}

/// The glass ball and the mirror, with few triangles.
pub(crate) fn balls() -> Scene {
    generate::whitted(1).expect("a scene")
}

/// A scene of which every other material is a mirror or glass.
pub(crate) fn glazed(mut scene: Scene) -> Scene {
    let kinds = [
        Optics::Dielectric { ior: 1.5, is_thin: false },
        Optics::Mirror,
        Optics::Diffuse,
        Optics::Dielectric { ior: 1.3, is_thin: true },
    ];
    for (material, optics) in scene.materials.iter_mut().zip(kinds.into_iter().cycle()) {
        material.optics = optics;
    }
    scene
}

#[test]
fn every_kernel_agrees_with_its_twin_after_every_pass() {
    let (mut failures, mut passes) = (Vec::new(), 0);
    let scenes = [("balls", balls()), ("lights", glazed(scene("lights.gltf")))];
    for (place, (name, scene)) in scenes.into_iter().enumerate() {
        for (row, configuration) in COVERING.into_iter().enumerate() {
            // Without a structure, these take a pass for each triangle of each ray.
            let is_long = configuration.is_stepped() && configuration.accelerator == Accelerator::None;
            if is_long || (row + place) % 4 > 0 && !thorough() {
                continue;
            }
            let options = with_mirrors(configuration.of(&options(&scene, 19, 15)));
            let counted = Options { counters: true, ..options.clone() };
            let sampled = Options { samples: Samples { count: 2, ..Samples::default() }, ..options };
            let runs = [(&counted, None), (&sampled, None), (&counted, Some(6))];
            for &(options, turns) in if thorough() { &runs[..] } else { &runs[(row / 4 + place) % 3..][..1] } {
                let found = match turns {
                    Some(turns) => parity::compare_in_turns(&gpu(), &scene, options, turns),
                    None => parity::compare(&gpu(), &scene, options),
                };
                let label = format!("{name} {configuration} turns {turns:?}");
                failures.extend(found.breaches.iter().map(|breach| format!("{label}: {breach}")));
                failures.extend(found.miscounts.iter().map(|miscount| format!("{label}: {miscount}")));
                passes += found.compared.total().passes;
            }
        }
    }
    assert!(passes > 1_000, "{passes} passes");
    assert!(failures.is_empty(), "{} failures:\n{}", failures.len(), failures[..failures.len().min(9)].join("\n"));
}

/// What the rays of a run found that surfaces sent on, judged by f64 from the exact rays.
#[derive(Debug, Default)]
pub(crate) struct Judged {
    pub(crate) rays: usize,
    pub(crate) ties: usize,
    pub(crate) wrong: Vec<String>,
    /// Rays that hit the surface that they leave.
    pub(crate) own: usize,
    pub(crate) deepest: u32,
}

/// Steps a run, and judges every ray that a surface sent on, before the kernel with this name takes it.
pub(crate) fn judged(scene: &Scene, options: &Options, device: &Device, taken_by: &str) -> Judged {
    block_on(gpu_of(device), async {
        let mut renderer = Renderer::new(scene, options, device).await.expect("a renderer");
        let vertices = renderer.data().vertices.clone();
        let triangles = Triangles::new(&vertices);
        let mut found = Judged::default();
        let mut is_walked = false;
        while let Some(kernel) = renderer.next_kernel() {
            let is_of_shadows = kernel.name().starts_with("shadow");
            if kernel.name() == taken_by && is_walked {
                is_walked = false;
                let mut streams = Vec::new();
                for stream in [STATE, BOUNCE, RAY_ORIGIN, RAY_DIRECTION, HIT, SURFACE] {
                    streams.push(renderer.values(stream).await.expect("values"));
                }
                let [state, bounce, origin, direction, hit, surface] = &streams[..] else { unreachable!() };
                for (ray, &tag) in state.layer(STATE_TAG).iter().enumerate() {
                    let depth = bounce.get(0, ray);
                    if !matches!(tag, SHADE | BACKGROUND) || depth == 0 {
                        continue;
                    }
                    let of = |stream: &StreamData| [0, 1, 2].map(|layer| stream.get_f32(layer, ray));
                    let t = f32::from_bits(state.get(STATE_T, ray));
                    let triangle = hit.get(HIT_TRIANGLE, ray);
                    let hit = (t < INF).then_some((triangle, t.into()));
                    let candidates = triangles.candidates(of(origin), of(direction));
                    let (mistake, _) = triangles.judge(ray, of(origin), of(direction), &candidates, hit);
                    found.rays += 1;
                    found.deepest = found.deepest.max(depth);
                    found.own += usize::from(triangle == surface.get(0, ray));
                    found.ties += usize::from(mistake.verdict != Verdict::Same);
                    if mistake.verdict.is_error() {
                        found.wrong.push(format!("at depth {depth}: {mistake:?}"));
                    }
                }
            }
            is_walked |= !is_of_shadows && kernel.is_walk();
            is_walked |= kernel.name() == "fused";
            renderer.step().await.expect("a pass");
        }
        found
    })
}

#[test]
fn every_ray_that_goes_on_is_right_and_none_hits_the_surface_that_it_leaves() {
    let mut sum = Judged::default();
    for (place, file) in scene_files().into_iter().enumerate() {
        let scene = glazed(scene(&file));
        for (row, accelerator) in [Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh].into_iter().enumerate()
        {
            if (place + row) % 3 > 0 && !thorough() {
                continue;
            }
            let side = if thorough() { 128 } else { 32 };
            let of = Configuration::new(accelerator, ScheduleKind::Fused, 1);
            let options = with_mirrors(of.of(&options(&scene, side, side)));
            let (name, device) = &devices()[place % 2];
            let found = judged(&scene, &options, device, "illuminate");
            assert_eq!(found.wrong, [""; 0], "{file} {of} on {name}");
            assert_eq!(found.own, 0, "{file} {of} on {name}: rays hit the surface that they leave");
            sum.rays += found.rays;
            sum.ties += found.ties;
            sum.deepest = sum.deepest.max(found.deepest);
        }
    }
    println!("{} rays, {} ties", sum.rays, sum.ties);
    assert!(sum.rays > 10_000 && sum.deepest == 4, "{sum:?}");
    assert!(20 * sum.ties < sum.rays, "{sum:?}");
}

/// A picture has the same bytes by every structure and schedule on one device, and of many samples in parts.
#[test]
fn pictures_are_the_same_however_they_are_traced() {
    let scene = balls();
    for (name, device) in devices() {
        let mut first: Option<StreamData> = None;
        for accelerator in [Accelerator::None, Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh] {
            for schedule in [ScheduleKind::Compact, ScheduleKind::Fused] {
                let of = Configuration::new(accelerator, schedule, 8);
                let color = values(&traced(&scene, &with_mirrors(of.of(&options(&scene, 24, 24))), &device), COLOR);
                let first = first.get_or_insert_with(|| color.clone());
                assert!(*first == color, "{of} on {name}");
            }
        }
    }
}

#[test]
fn what_cannot_be_sent_on_is_refused_with_what_would_work() {
    let scene = balls();
    let refused = |options: &Options| Plan::new(&scene, options, &(&*gpu()).into()).expect_err("refused").to_string();
    let drawn =
        Options { mapping: Mapping::Fragment(Fragment::default()), ..with_mirrors(STEPPED.of(&options(&scene, 8, 8))) };
    let why = refused(&drawn);
    assert!(why.contains("--mapping compute"), "{why}");
    let rays = vec![Ray { t_min: 0.5, ..Ray::new([0.0, 1.0, 5.0], [0.0, 0.0, -1.0]) }];
    let why = refused(&with_mirrors(Options::new(RaySource::Given(rays))));
    assert!(why.contains("t_min"), "{why}");
    // Without mirrors, rays are drawn.
    let mut matte = scene.clone();
    matte.materials.iter_mut().for_each(|material| material.optics = Optics::Diffuse);
    let [drawn, computed] = [drawn.mapping, Mapping::Compute].map(|mapping| {
        let options = Options { mapping, ..with_mirrors(STEPPED.of(&options(&matte, 8, 8))) };
        values(&traced(&matte, &options, &Device::Gpu(gpu())), COLOR)
    });
    assert!(drawn == computed);
}

#[test]
fn a_broken_kernel_is_named() {
    let scene = balls();
    let scatter = PROGRAM.kernel("scatter").expect("a kernel");
    for broken in scatter.info().breaks {
        let mut options = Configuration::new(Accelerator::Bvh, ScheduleKind::Fused, 1).of(&options(&scene, 24, 24));
        (broken.run)(&mut options);
        let found = parity::compare_broken(&gpu(), &scene, &options, |plan| {
            let variant = plan.variants.iter_mut().find(|v| v.kernel == scatter).expect("in the plan");
            variant.source = parity::change(&variant.source, broken.from, broken.to);
        });
        assert_eq!(found.breaches.first().map(|b| b.kernel), Some(scatter), "with {:?}", broken.to);
    }
}
