//! Shadow rays: every kernel against its twin, every ray against f64, and no light where none can come from.

use std::f32::consts::PI;

use crate::bounced::{Run, breaks_are_named, compare, takes_a_pass_for_each_triangle};
use glam::{Mat3, Vec3};
use raystep_kernels::options::Integrator;
use raystep_kernels::programs::closest_hit::states::{OCCLUDED, SHADOW_SETUP, VISIBLE};
use raystep_kernels::programs::closest_hit::streams::{
    BLOCKER, COLOR, HIT, HIT_TRIANGLE, SHADOW_DIRECTION, SHADOW_ORIGIN, STATE, STATE_T,
};
use raystep_kernels::programs::light::PROGRAM;
use raystep_kernels::tables::stream::STATE_TAG;
use raystep_kernels::{Accelerator, Device, Kernel, Options, Plan, Ray, RaySource, Renderer, Samples, ScheduleKind};
use raystep_lab::reference::Triangles;
use raystep_scenes::{Camera, Light, Projection, Scene};
use raystep_tests::configurations::Configuration;
use raystep_tests::{block_on, devices, gpu, gpu_of, options, parity, scene, scene_files, thorough, traced, values};

mod stiff;

fn with_shadows(options: Options) -> Options {
    Options { integrator: Integrator::Shadows, ..options }
}

#[test]
fn every_kernel_agrees_with_its_twin_after_every_pass() {
    let scenes = ["lights.gltf", "cornell-box.gltf", "textures.gltf"].map(|file| (file, scene(file)));
    // These take a pass for each triangle and light.
    let is_long = |configuration: &Configuration, scene: &Scene| {
        takes_a_pass_for_each_triangle(configuration, scene) && configuration.steps == 1 && scene.triangles.len() > 500
    };
    let runs = |options| -> Vec<Run> {
        let counted = Options { counters: true, ..with_shadows(options) };
        let sampled =
            Options { samples: Samples { count: 3, ..Samples::default() }, counters: false, ..counted.clone() };
        vec![(counted.clone(), None), (sampled, None), (counted, Some(6))]
    };
    compare(scenes.into(), [29, 21], 8, is_long, runs);
}

/// What shadow rays of a run found, judged by f64 from the exact rays.
#[derive(Debug, Default)]
struct Judged {
    rays: usize,
    occluded: usize,
    ties: usize,
    wrong: Vec<String>,
    /// Rays that hit the surface that they leave.
    own: usize,
}

/// Steps a run, and judges every shadow ray.
fn judged(scene: &Scene, options: &Options, device: &Device) -> Judged {
    block_on(gpu_of(device), async {
        let mut renderer = Renderer::new(scene, options, device).await.expect("a renderer");
        let vertices = renderer.data().vertices.clone();
        let triangles = Triangles::new(&vertices);
        let mut found = Judged::default();
        let mut ends: Option<Vec<f32>> = None;
        while let Some(kernel) = renderer.next_kernel() {
            let of_light = kernel.name() == "illuminate";
            if of_light && let Some(ends) = &ends {
                let streams = [STATE, SHADOW_ORIGIN, SHADOW_DIRECTION, BLOCKER, HIT];
                let mut values = Vec::new();
                for stream in streams {
                    values.push(renderer.values(stream).await.expect("values"));
                }
                let [state, origin, direction, blocker, hit] = &values[..] else { unreachable!() };
                for (ray, &tag) in state.layer(STATE_TAG).iter().enumerate() {
                    if !matches!(tag, OCCLUDED | VISIBLE) {
                        continue;
                    }
                    let of = |stream: &raystep_kernels::StreamData| [0, 1, 2].map(|layer| stream.get_f32(layer, ray));
                    let may_hit = triangles.candidates(of(origin), of(direction)).within([0.0, ends[ray].into()]);
                    let surely = may_hit.possible.iter().any(|possible| possible.is_definite);
                    let blocked_by = blocker.get(HIT_TRIANGLE, ray);
                    let is_possible = may_hit.possible.iter().any(|possible| possible.triangle == blocked_by);
                    found.rays += 1;
                    found.occluded += usize::from(tag == OCCLUDED);
                    // The surface that it leaves is no tie: the ray goes away from it.
                    let own = hit.get(HIT_TRIANGLE, ray);
                    found.ties += usize::from(!surely && may_hit.possible.iter().any(|p| p.triangle != own));
                    found.own += usize::from(tag == OCCLUDED && blocked_by == own);
                    if tag == VISIBLE && surely || tag == OCCLUDED && !is_possible {
                        found.wrong.push(format!("ray {ray} in state {tag}: blocker {blocked_by}, {may_hit:?}"));
                    }
                }
            }
            renderer.step().await.expect("a pass");
            if of_light {
                let state = renderer.values(STATE).await.expect("values");
                if state.layer(STATE_TAG).contains(&SHADOW_SETUP) {
                    ends = Some(state.layer(STATE_T).iter().map(|&t| f32::from_bits(t)).collect());
                }
            }
        }
        found
    })
}

#[test]
fn every_shadow_ray_of_every_scene_is_right_and_none_hits_the_surface_that_it_leaves() {
    let mut sum = Judged::default();
    for (place, file) in scene_files().into_iter().enumerate() {
        let scene = scene(&file);
        for (row, accelerator) in [Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh].into_iter().enumerate()
        {
            let side = if thorough() { 256 } else { 32 };
            let schedules = [ScheduleKind::Compact, ScheduleKind::Fused];
            for schedule in if thorough() { &schedules[..] } else { &schedules[(place + row) % 2..][..1] } {
                let of = Configuration::new(accelerator, *schedule, 64);
                let options = with_shadows(of.of(&options(&scene, side, side)));
                let (name, device) = &devices()[(place + row) % 2];
                let found = judged(&scene, &options, device);
                assert_eq!(found.wrong, [""; 0], "{file} {of} on {name}");
                assert_eq!(found.own, 0, "{file} {of} on {name}: rays hit the surface that they leave");
                sum.rays += found.rays;
                sum.occluded += found.occluded;
                sum.ties += found.ties;
            }
        }
    }
    println!("{} shadow rays, {} occluded, {} ties", sum.rays, sum.occluded, sum.ties);
    assert!(sum.rays > 20_000 && 20 * sum.occluded > sum.rays, "{sum:?}");
    // A light on a surface, and rays along one.
    assert!(100 * sum.ties < sum.rays, "{sum:?}");
}

/// A box with a camera inside of it and lights around it, turned and moved.
fn closed_box(size: Vec3, turn: Mat3, centre: Vec3) -> Scene {
    let corner = |i: usize| {
        let side = Vec3::new([-1.0, 1.0][i & 1], [-1.0, 1.0][i >> 1 & 1], [-1.0, 1.0][i >> 2 & 1]);
        (centre + turn * (side * size)).to_array()
    };
    // All face inwards.
    let quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).map(|t| t.map(corner)).collect();
    let lights = (0..24).map(|i| {
        let (up, around) = ((i as f32 + 0.5) / 12.0 - 1.0, i as f32 * PI * (3.0 - 5f32.sqrt()));
        let flat = (1.0 - up * up).sqrt();
        let away = Vec3::new(flat * around.cos(), flat * around.sin(), up);
        let position = (centre + away * 3.0 * size.max_element()).to_array();
        match i % 3 {
            0 => Light::Directional { direction: (-away).to_array(), color: [1.0; 3], intensity: 1.0 },
            _ => Light::Point { position, color: [1.0; 3], intensity: 1.0 },
        }
    });
    Scene { lights: lights.collect(), ..Scene::from_triangles(triangles) }
}

/// Rays from a point to the edges of all triangles, and so near to them that rounding decides.
fn to_edges(scene: &Scene, from: Vec3) -> Vec<Ray> {
    let mut rays = Vec::new();
    for triangle in scene.triangles.iter().map(|triangle| triangle.map(Vec3::from)) {
        for (edge, step) in (0..3).flat_map(|edge| (0..40).map(move |step| (edge, step))) {
            let (a, b) = (triangle[edge], triangle[(edge + 1) % 3]);
            let at = a + (b - a) * (step as f32 + 0.5) / 40.0;
            let inwards = (triangle[(edge + 2) % 3] - at) * 6e-8;
            for off in [0.0, 0.5, 1.0, 3.0] {
                rays.push(Ray::new(from.to_array(), (at + inwards * off - from).to_array()));
            }
        }
    }
    rays
}

/// No shadow ray leaves a closed box: not along its edges, not far from the origin, not in flat or tiny boxes.
#[test]
fn no_light_leaks_into_a_closed_box() {
    let turns = [Mat3::IDENTITY, Mat3::from_rotation_y(0.7) * Mat3::from_rotation_x(0.4)];
    let sizes = [Vec3::ONE, Vec3::new(1.0, 0.1, 3.0), Vec3::splat(1e-6), Vec3::splat(1e6)];
    let side = if thorough() { 512 } else { 64 };
    let mut rays = 0;
    for (place, (turn, size)) in turns.into_iter().flat_map(|turn| sizes.map(|size| (turn, size))).enumerate() {
        for centre in [Vec3::ZERO, Vec3::new(100.0, -30.0, 7.0) * size] {
            let scene = closed_box(size, turn, centre);
            for (row, accelerator) in
                [Accelerator::None, Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh].into_iter().enumerate()
            {
                if (place + row) % 2 > 0 && !thorough() {
                    continue;
                }
                let of = Configuration::new(accelerator, ScheduleKind::Fused, 1);
                // To every place inside, and to the edges.
                let eye = centre + turn * (size * 0.3);
                let projection = Projection::Perspective { vertical_fov: 2.4 };
                let camera = Camera { eye: eye.as_dvec3(), projection, ..Camera::framing(&scene.bounds()) };
                let sources =
                    [RaySource::Camera { camera, width: side, height: side }, RaySource::Given(to_edges(&scene, eye))];
                let (name, device) = &devices()[(place + row / 2) % 2];
                for source in sources {
                    let options = with_shadows(of.of(&Options::new(source)));
                    let renderer = traced(&scene, &options, device);
                    let color = values(&renderer, COLOR);
                    let lit = color.bits.iter().filter(|&&bits| bits != 0).count();
                    let on_edges = matches!(options.rays, RaySource::Given(_));
                    assert_eq!(lit, 0, "box of {size} at {centre}, edges: {on_edges}, {accelerator} on {name}");
                    let of_lights = renderer.passes().iter().filter(|pass| pass.kernel.name() == "shadow_fused");
                    rays += of_lights.map(|pass| u64::from(pass.rays_in)).sum::<u64>();
                }
            }
        }
    }
    println!("{rays} shadow rays");
    assert!(rays > 500_000, "{rays} shadow rays");
}

/// In a flat box, whose walls are needles, f32 cannot tell on which side of a wall a ray begins next to it: that is a tie,
/// and nothing worse.
#[test]
fn light_leaks_only_where_f32_cannot_decide() {
    let size = Vec3::new(1.0, 0.002, 3.0);
    let scene = closed_box(size, Mat3::from_rotation_y(0.7), Vec3::ZERO);
    let rays = to_edges(&scene, Mat3::from_rotation_y(0.7) * (size * 0.3));
    for (row, (name, device)) in devices().into_iter().enumerate() {
        let of = Configuration::new([Accelerator::Grid, Accelerator::Bvh][row], ScheduleKind::Fused, 1);
        let options = with_shadows(of.of(&Options::new(RaySource::Given(rays.clone()))));
        let found = judged(&scene, &options, &device);
        assert_eq!((&found.wrong[..], found.own), (&[][..], 0), "on {name}");
        assert!(found.rays > 5_000 && found.ties > 0, "{found:?} on {name}");
    }
}

/// Changes only a kernel's WGSL.
fn change(kernel: Kernel, from: &str, to: &str) -> impl FnOnce(&mut Plan) {
    move |plan| {
        let variant = plan.variants.iter_mut().find(|v| v.kernel == kernel).expect("in the plan");
        variant.source = parity::change(&variant.source, from, to);
    }
}

#[test]
fn a_broken_kernel_is_named() {
    let scene = scene("lights.gltf");
    let illuminate = PROGRAM.kernel("illuminate").expect("a kernel");
    let several = Configuration::new(Accelerator::Grid, ScheduleKind::Compact, 8).of(&options(&scene, 24, 24));
    let several = with_shadows(several);
    breaks_are_named(illuminate, &scene, &several);
    // More lights than a dispatch has loop iterations: without one to cast a ray to, the next waits.
    let whole = parity::compare_in_turns(&gpu(), &scene, &several, 1);
    assert!(!whole.is_broken(), "{:?} {:?}", whole.breaches, whole.miscounts);
    let (from, to) = ("LIGHTS_SUMMED + end", "LIGHTS_SUMMED + end + 1u");
    let found = parity::compare_broken_in_turns(&gpu(), &scene, &several, 1, change(illuminate, from, to));
    assert_eq!(found.breaches.first().map(|b| b.kernel), Some(illuminate), "lights are left out unnoticed");
    // Any hit before the light occludes it, whether the ray would be the nearest or not.
    for (accelerator, schedule, name, from, to) in [
        (Accelerator::Grid, ScheduleKind::Second, "shadow_intersect", "candidate.t < nearest_t", "true"),
        (Accelerator::Grid, ScheduleKind::Compact, "shadow_walk", "candidate.t < trace.t", "true"),
        (Accelerator::None, ScheduleKind::Fused, "shadow_fused", "candidate.t < trace.t", "true"),
    ] {
        let of = Configuration::new(accelerator, schedule, if schedule == ScheduleKind::Compact { 8 } else { 1 });
        let options = with_shadows(of.of(&options(&scene, 24, 24)));
        let kernel = PROGRAM.kernel(name).expect("a kernel");
        let found = parity::compare_broken(&gpu(), &scene, &options, change(kernel, from, to));
        assert_eq!(found.breaches.first().map(|b| b.kernel), Some(kernel), "{name}");
    }
}
