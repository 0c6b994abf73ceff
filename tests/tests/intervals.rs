//! Rays with a t_min and a t_max: what lies outside of their interval does not count, in every configuration.

use raystep_kernels::programs::closest_hit::{kernels, streams};
use raystep_kernels::shared::constants::NO_TRIANGLE;
use raystep_kernels::{Accelerator, Device, Kernel, Limits, Options, Plan, Ray, RaySource, ScheduleKind};
use raystep_lab::rays::Random;
use raystep_scenes::Scene;
use raystep_tests::configurations::{Configuration, EVERY};
use raystep_tests::parity::{self, Parity};
use raystep_tests::{block_on, check, devices, gpu, hits, rays, scene, traced, values};

/// Random rays through a scene, cut at and between the t of their own hits: at the nearest hit, before it and behind
/// it, and with ends of any size.
fn cut_rays(scene: &Scene, count: usize, any_hit: bool) -> Vec<Ray> {
    let whole = rays::random(scene, count, 5);
    let options = Options { shade: false, ..Options::new(RaySource::Given(whole.clone())) };
    let renderer = traced(scene, &options, &Device::Cpu(None));
    let hits = block_on(None, renderer.hits()).expect("hits");
    let cut = |(i, (ray, hit)): (usize, (Ray, _))| {
        let t = Option::map_or(hit, 1.0, |hit: raystep_kernels::RayHit| hit.t as f32);
        let share = Random::of(i as u32, 8).unit() as f32;
        match i % 8 {
            0 => ray.between(t, f32::INFINITY),
            1 => ray.between(0.0, t),
            2 => ray.between(0.0, t.next_up()),
            3 => ray.between(t.next_down().max(0.0), f32::INFINITY),
            4 => ray.between(0.0, t * share),
            5 => ray.between(t * share, t * (1.0 + share)),
            6 if !any_hit => ray,
            6 => ray.between(t * share, t * share),
            _ => ray.between(t * (1.0 + share), 3.0 * t),
        }
    };
    whole.into_iter().zip(hits).enumerate().map(cut).collect()
}

fn given(rays: Vec<Ray>, any_hit: bool) -> Options {
    Options { shade: false, any_hit, ..Options::new(RaySource::Given(rays)) }
}

#[test]
fn hits_outside_of_a_rays_interval_do_not_count() {
    for file in ["cornell-box.gltf", "primitives.gltf", "teapot.glb"] {
        let scene = scene(file);
        let options = given(cut_rays(&scene, 1200, false), false);
        for (name, device) in devices() {
            let mut first: Option<[Vec<u32>; 4]> = None;
            for configuration in EVERY {
                if configuration.accelerator == Accelerator::None && scene.triangles.len() > 500 {
                    continue;
                }
                let renderer = traced(&scene, &configuration.of(&options), &device);
                let report = check(&renderer);
                assert_eq!(report.errors(), 0, "{file} {name} {configuration}: {report}\n{:#?}", report.mistakes);
                assert!(5 * report.counts.same > 3 * report.counts.rays(), "{file} {name} {configuration}: {report}");
                let found = hits(&renderer);
                let hit = found[3].iter().filter(|&&triangle| triangle != NO_TRIANGLE).count();
                assert!((200..1000).contains(&hit), "{file} {name} {configuration}: {hit} rays hit");
                assert!(
                    first.get_or_insert_with(|| found.clone()) == &found,
                    "{file} {name} {configuration} finds other hits"
                );
            }
        }
    }
}

#[test]
fn the_ends_of_an_interval_do_not_count_themselves() {
    let scene = Scene::from_triangles(vec![
        [[-1.0, -1.0, -2.0], [1.0, -1.0, -2.0], [0.0, 1.0, -2.0]],
        [[-1.0, -1.0, -3.0], [1.0, -1.0, -3.0], [0.0, 1.0, -3.0]],
    ]);
    let ray = |t_min, t_max| Ray::new([0.0; 3], [0.0, 0.0, -0.5]).between(t_min, t_max);
    let (in_0, in_1, missed) = (0, 1, NO_TRIANGLE);
    let expected = [
        (ray(0.0, f32::INFINITY), in_0),
        (ray(4.0, f32::INFINITY), in_1),
        (ray(4f32.next_down(), f32::INFINITY), in_0),
        (ray(0.0, 4.0), missed),
        (ray(0.0, 4f32.next_up()), in_0),
        (ray(4.0, 6.0), missed),
        (ray(4.0, 6f32.next_up()), in_1),
        (ray(6.0, f32::INFINITY), missed),
        (ray(5.0, 5.0), missed),
    ];
    let rays: Vec<Ray> = expected.iter().map(|(ray, _)| *ray).collect();
    let triangles: Vec<u32> = expected.iter().map(|(_, triangle)| *triangle).collect();
    let twins = [("f32 twins", Device::Cpu(None)), ("f64 twins", Device::CpuF64(None))];
    for (name, device) in devices().into_iter().chain(twins) {
        for configuration in EVERY.into_iter().chain(
            EVERY
                .into_iter()
                .filter(|configuration| configuration.skip == Default::default())
                .map(Configuration::paper),
        ) {
            let mut kinds = vec![false];
            kinds.extend((configuration.numerics == Default::default()).then_some(true));
            for any_hit in kinds {
                let renderer = traced(&scene, &configuration.of(&given(rays.clone(), any_hit)), &device);
                let found = values(&renderer, streams::HIT);
                let found: Vec<u32> = (0..rays.len()).map(|ray| found.get(2, ray)).collect();
                if any_hit {
                    let is_hit = |all: &[u32]| all.iter().map(|&t| t != missed).collect::<Vec<_>>();
                    assert_eq!(is_hit(&found), is_hit(&triangles), "{name} {configuration}, any hit");
                } else {
                    assert_eq!(found, triangles, "{name} {configuration}");
                }
            }
        }
    }
}

fn changed(scene: &Scene, options: &Options, kernel: Kernel, [from, to]: [&str; 2]) -> Parity {
    parity::compare_broken(&gpu(), scene, options, |plan: &mut Plan| {
        let variant = plan.variants.iter_mut().find(|v| v.kernel == kernel).expect("the kernel");
        variant.source = parity::change(&variant.source, from, to);
    })
}

#[test]
fn kernels_and_twins_agree_on_intervals_and_a_broken_one_is_named() {
    let scene = scene("teapot.glb");
    let scene = &scene;
    for any_hit in [false, true] {
        for configuration in EVERY.into_iter().filter(|configuration| configuration.accelerator != Accelerator::None) {
            let options = configuration.of(&given(cut_rays(scene, 500, any_hit), any_hit));
            let found = parity::compare(&gpu(), scene, &options);
            assert!(!found.is_broken(), "{configuration}, any hit {any_hit}: {:#?}", found.breaches);
            let turns = parity::compare_in_turns(&gpu(), scene, &options, 40);
            assert!(!turns.is_broken(), "{configuration} in turns, any hit {any_hit}: {:#?}", turns.breaches);
        }
    }
    use Accelerator::{Bvh, Grid};
    use ScheduleKind::{Compact, Fused, Second};
    let min = ["candidate.t > interval.x", "candidate.t >= interval.x"];
    for (kernel, configuration, change) in [
        (kernels::INTERSECT, Configuration::new(Grid, Second, 1), min),
        (
            kernels::INTERSECT,
            Configuration::new(Grid, Second, 1),
            ["load_interval(texel).y <= exit", "2.0 * load_interval(texel).y <= exit"],
        ),
        (
            kernels::TRAVERSE_BVH,
            Configuration::new(Bvh, Second, 1),
            ["min(latest_of(texel, nearest_t), load_interval(texel).y)", "nearest_t"],
        ),
        (kernels::WALK, Configuration::new(Grid, Compact, 8), ["trace.interval.y <= exit", "false"]),
        (kernels::WALK, Configuration::new(Bvh, Compact, 8), ["min(latest(trace), trace.interval.y)", "0.5 * trace.t"]),
        (
            kernels::FUSED,
            Configuration::new(Grid, Fused, 1),
            ["trace.interval = load_interval(texel)", "trace.interval = load_interval(texel).yx"],
        ),
        (kernels::FUSED, Configuration::new(Bvh, Fused, 1), ["candidate.t < interval.y", "candidate.t <= interval.y"]),
    ] {
        let options = configuration.of(&given(cut_rays(scene, 500, false), false));
        let found = changed(scene, &options, kernel, change);
        assert_eq!(found.breaches.first().map(|b| b.kernel), Some(kernel), "{configuration} {change:?}");
    }
}

/// The WGSL of every kernel of a run.
fn sources(scene: &Scene, options: &Options) -> Vec<String> {
    let (plan, _) = Plan::new(scene, options, &Limits::CPU).expect("a plan");
    plan.variants.into_iter().map(|variant| variant.source).collect()
}

#[test]
fn without_an_interval_nothing_of_it_is_compiled_or_kept() {
    let scene = scene("cornell-box.gltf");
    let whole = rays::random(&scene, 60, 5);
    for configuration in EVERY {
        for any_hit in [false, true] {
            let cut = |t_min, t_max| whole.iter().map(|ray| ray.between(t_min, t_max)).collect::<Vec<_>>();
            let without = configuration.of(&given(whole.clone(), any_hit));
            let plain = sources(&scene, &without);
            assert!(plain.iter().all(|source| !source.contains("interval")), "{configuration}");
            // The end of a ray that any hit ends is where it begins, in its t.
            assert_eq!(
                sources(&scene, &configuration.of(&given(cut(0.0, 2.0), any_hit))) == plain,
                any_hit,
                "{configuration} t_max"
            );
            assert_ne!(
                sources(&scene, &configuration.of(&given(cut(1.0, f32::INFINITY), any_hit))),
                plain,
                "{configuration} t_min"
            );
            let (plan, _) = Plan::new(&scene, &without, &Limits::CPU).expect("a plan");
            let left_out = plan.left_out.iter().find(|item| item.what == "stream ray_interval").expect("left out");
            assert_eq!(left_out.reason, "needed only for rays with a t_min or a t_max");
        }
    }
}

#[test]
fn an_interval_that_is_none_is_refused_with_the_rays_number() {
    let scene = scene("cornell-box.gltf");
    for (t_min, t_max, why) in [
        (-1.0, 1.0, "t_min"),
        (f32::NAN, 1.0, "t_min"),
        (f32::INFINITY, f32::INFINITY, "t_min"),
        (1.0, 0.5, "t_max"),
        (0.0, f32::NAN, "t_max"),
        (0.0, f32::NEG_INFINITY, "t_max"),
    ] {
        let mut rays = rays::random(&scene, 3, 5);
        rays[2] = rays[2].between(t_min, t_max);
        let error = Plan::new(&scene, &given(rays, false), &Limits::CPU).map(|_| ()).expect_err("no interval");
        let error = error.to_string();
        assert!(error.contains("ray 2 ") && error.contains(why), "{t_min} {t_max}: {error}");
    }
}
