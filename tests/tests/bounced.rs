//! What tests of light share: scenes with mirrors and glass, and comparisons of runs whose rays go on from hits.

use raystep_kernels::options::Integrator;
use raystep_kernels::programs::closest_hit::states::{BACKGROUND, SHADE};
use raystep_kernels::programs::closest_hit::streams::{
    BOUNCE, COLOR, HIT, HIT_TRIANGLE, RAY_DIRECTION, RAY_ORIGIN, STATE, STATE_T, SURFACE,
};
use raystep_kernels::shared::constants::INF;
use raystep_kernels::tables::stream::STATE_TAG;
use raystep_kernels::{Accelerator, Device, Kernel, Options, Renderer, ScheduleKind, StreamData};
use raystep_lab::reference::{Triangles, Verdict};
use raystep_scenes::{Optics, Scene, generate};
use raystep_tests::configurations::{COVERING, Configuration};
use raystep_tests::{block_on, devices, gpu, gpu_of, options, parity, scene, scene_files, thorough, traced, values};

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

/// Options of a run, and the most loop iterations of a dispatch, if they are few.
pub(crate) type Run = (Options, Option<u32>);

/// Compares every kernel with its twin after every pass, in scenes by configurations. Of these, one in `every` is taken, and of
/// the runs of each one, unless the tests are thorough.
pub(crate) fn compare(
    scenes: Vec<(&str, Scene)>,
    size: [u32; 2],
    every: usize,
    is_long: fn(&Configuration, &Scene) -> bool,
    runs: fn(Options) -> Vec<Run>,
) {
    let (mut failures, mut passes) = (Vec::new(), 0);
    for (place, (name, scene)) in scenes.into_iter().enumerate() {
        for (row, configuration) in COVERING.into_iter().enumerate() {
            if is_long(&configuration, &scene) || (row + place) % every > 0 && !thorough() {
                continue;
            }
            let mut runs = runs(configuration.of(&options(&scene, size[0], size[1])));
            if !thorough() {
                runs = vec![runs.swap_remove((row / every + place) % runs.len())];
            }
            for (options, turns) in runs {
                let found = match turns {
                    Some(turns) => parity::compare_in_turns(&gpu(), &scene, &options, turns),
                    None => parity::compare(&gpu(), &scene, &options),
                };
                let label = format!("{name} {configuration} {} turns {turns:?}", options.strategy);
                failures.extend(found.breaches.iter().map(|breach| format!("{label}: {breach}")));
                failures.extend(found.miscounts.iter().map(|miscount| format!("{label}: {miscount}")));
                passes += found.compared.total().passes;
            }
        }
    }
    assert!(passes > 1_000, "{passes} passes");
    assert!(failures.is_empty(), "{} failures:\n{}", failures.len(), failures[..failures.len().min(9)].join("\n"));
}

/// Without a structure, a run with one step a pass takes a pass for each triangle of each ray.
pub(crate) fn takes_a_pass_for_each_triangle(configuration: &Configuration, _: &Scene) -> bool {
    configuration.is_stepped() && configuration.accelerator == Accelerator::None
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
fn judged(scene: &Scene, options: &Options, device: &Device, taken_by: &str) -> Judged {
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

/// The same in every scene: none is wrong, and none hits the surface that it leaves.
pub(crate) fn judge_all(prepare: fn(Scene) -> Scene, of: fn(Options) -> Options, taken_by: &str) -> Judged {
    let mut sum = Judged::default();
    for (place, file) in scene_files().into_iter().enumerate() {
        let scene = prepare(scene(&file));
        for (row, accelerator) in [Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh].into_iter().enumerate()
        {
            if (place + row) % 3 > 0 && !thorough() {
                continue;
            }
            let side = if thorough() { 128 } else { 32 };
            let configuration = Configuration::new(accelerator, ScheduleKind::Fused, 1);
            let mut options = of(configuration.of(&options(&scene, side, side)));
            if options.integrator == Integrator::Path {
                // Whose rays are seen between passes.
                options.schedule = ScheduleKind::Compact;
            }
            let (name, device) = &devices()[place % 2];
            let found = judged(&scene, &options, device, taken_by);
            assert_eq!(found.wrong, [""; 0], "{file} {configuration} on {name}");
            assert_eq!(found.own, 0, "{file} {configuration} on {name}: rays hit the surface that they leave");
            sum.rays += found.rays;
            sum.ties += found.ties;
            sum.deepest = sum.deepest.max(found.deepest);
        }
    }
    println!("{} rays, {} ties", sum.rays, sum.ties);
    assert!(sum.rays > 10_000, "{sum:?}");
    sum
}

/// A picture has the same bytes by every structure and schedule on one device.
pub(crate) fn have_one_picture(scene: &Scene, of: fn(Options) -> Options) {
    for (name, device) in devices() {
        let mut first: Option<StreamData> = None;
        for accelerator in [Accelerator::None, Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh] {
            for schedule in [ScheduleKind::Compact, ScheduleKind::Fused] {
                let configuration = Configuration::new(accelerator, schedule, 8);
                let options = of(configuration.of(&options(scene, 24, 24)));
                let color = values(&traced(scene, &options, &device), COLOR);
                let first = first.get_or_insert_with(|| color.clone());
                assert!(*first == color, "{configuration} on {name}");
            }
        }
    }
}

/// Every deliberate defect of a kernel is found, and by its name.
pub(crate) fn breaks_are_named(kernel: Kernel, scene: &Scene, base: &Options) {
    let mut missed = Vec::new();
    for broken in kernel.info().breaks {
        let mut options = base.clone();
        (broken.run)(&mut options);
        let found = parity::compare_broken(&gpu(), scene, &options, |plan| {
            let variant = plan.variants.iter_mut().find(|v| v.kernel == kernel).expect("in the plan");
            variant.source = parity::change(&variant.source, broken.from, broken.to);
        });
        let named = found.breaches.first().map(|breach| breach.kernel);
        if named != Some(kernel) {
            missed.push(format!("{:?} for {:?}: {named:?} is named", broken.to, broken.from));
        }
    }
    assert_eq!(missed, [""; 0], "{}", kernel.name());
}
