//! Rays cast through a structure that is kept hit what a run of them alone hits, bit for bit, in slices of any length.

use std::sync::Arc;

use raystep_kernels::{
    Accelerator, CastHit, Caster, Device, Numerics, Options, Ray, RaySource, RenderError, ScheduleKind,
};
use raystep_lab::rays::Random;
use raystep_scenes::Scene;
use raystep_tests::{block_on, devices, gpu_of, rays, scene, traced};

/// What a run of these rays alone hits.
fn alone(scene: &Scene, rays: &[Ray], options: &Options, device: &Device) -> Vec<CastHit> {
    let options = Options { rays: RaySource::Given(rays.to_vec()), shade: false, ..options.clone() };
    let renderer = traced(scene, &options, device);
    let hits = block_on(gpu_of(device), renderer.hits()).expect("hits");
    let cast = |hit: Option<raystep_kernels::RayHit>| {
        hit.map_or(CastHit::MISS, |hit| CastHit {
            t: hit.t as f32,
            u: hit.u,
            v: hit.v,
            triangle: hit.triangle,
            material: scene.triangle_materials[hit.triangle as usize],
        })
    };
    hits.into_iter().map(cast).collect()
}

fn caster(scene: &Arc<Scene>, options: &Options, device: &Device) -> Caster {
    block_on(gpu_of(device), Caster::new(scene.clone(), options, device)).expect("a caster")
}

fn cast(caster: &mut Caster, device: &Device, rays: &[Ray]) -> Result<Vec<CastHit>, RenderError> {
    block_on(gpu_of(device), caster.cast(rays))
}

fn bits(hits: &[CastHit]) -> Vec<[u32; 5]> {
    let of = |hit: &CastHit| [hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), hit.triangle, hit.material];
    hits.iter().map(of).collect()
}

/// Random rays, each with another interval.
fn with_intervals(rays: &[Ray], any_hit: bool) -> Vec<Ray> {
    let cut = |(i, ray): (usize, &Ray)| {
        let mut random = Random::of(i as u32, 3);
        let t_min = if any_hit && i % 2 == 0 { 0.0 } else { random.unit() as f32 };
        ray.between(t_min, if i % 3 == 0 { f32::INFINITY } else { t_min + 2.0 * random.unit() as f32 })
    };
    rays.iter().enumerate().map(cut).collect()
}

#[test]
fn slices_of_any_length_hit_what_a_run_alone_hits() {
    let scene = Arc::new(scene("primitives.gltf"));
    let whole = rays::random(&scene, 9000, 4);
    for (name, device) in devices().into_iter().chain([("f64", Device::CpuF64(None))]) {
        for (accelerator, schedule) in [
            (Accelerator::Bvh, ScheduleKind::Fused),
            (Accelerator::Bvh, ScheduleKind::Compact),
            (Accelerator::Grid, ScheduleKind::Fused),
            (Accelerator::Grid, ScheduleKind::Compact),
            (Accelerator::Irregular, ScheduleKind::Fused),
            (Accelerator::None, ScheduleKind::Fused),
        ] {
            for any_hit in [false, true] {
                let options = Options { accelerator, schedule, any_hit, ..Caster::options() };
                let label = format!("{name} {accelerator} {schedule}, any hit {any_hit}");
                let mut caster = caster(&scene, &options, &device);
                let mut check = |rays: &[Ray], what: &str| {
                    let found = cast(&mut caster, &device, rays).expect("hits");
                    let expected = alone(&scene, rays, &options, &device);
                    // Which of several hits is found first depends on the structure, and that on the origins.
                    let is_hit = |hits: &[CastHit]| hits.iter().map(CastHit::is_hit).collect::<Vec<_>>();
                    assert_eq!(is_hit(&found), is_hit(&expected), "{label}, {what}");
                    assert!(any_hit || bits(&found) == bits(&expected), "{label}, {what}");
                    let hits = found.iter().filter(|hit| hit.is_hit()).count();
                    assert!(rays.is_empty() || 8 * hits > rays.len(), "{label}, {what}: {hits} hit");
                };
                check(&whole[..5000], "no interval");
                check(&whole[5000..5007], "few");
                check(&[], "none");
                check(&with_intervals(&whole, any_hit), "intervals");
                check(&whole, "no interval any more");
            }
        }
    }
}

#[test]
fn batches_change_nothing() {
    let scene = Arc::new(scene("teapot.glb"));
    let rays = with_intervals(&rays::random(&scene, 7001, 4), false);
    for (name, device) in devices() {
        let mut caster = caster(&scene, &Caster::options(), &device);
        let whole = cast(&mut caster, &device, &rays).expect("hits");
        for batch in [1000, 3500, 7000] {
            caster.set_batch(batch);
            assert_eq!(caster.batch(), batch);
            let hits = cast(&mut caster, &device, &rays).expect("hits");
            assert!(bits(&hits) == bits(&whole), "{name}, batches of {batch}");
        }
        caster.set_batch(u64::MAX);
        assert!(caster.batch() < u64::from(u32::MAX), "{name} has no limit");
        assert_eq!(caster.unfinished(), 0);
    }
}

/// Rays from far away need larger growth of cells and boxes: the structure is built for it, and stays.
#[test]
fn rays_from_afar_are_not_lost() {
    let scene = Arc::new(scene("teapot.glb"));
    let device = Device::Cpu(None);
    let bounds = scene.bounds();
    let (center, size) = ((bounds.min + bounds.max) * 0.5, (bounds.max - bounds.min).max_element());
    let far = |distance: f32| -> Vec<Ray> {
        (0..400)
            .map(|i| {
                let mut random = Random::of(i, 9);
                let away = glam::Vec3::from(random.direction()).normalize() * distance * size;
                let target = center + glam::Vec3::from(random.direction()) * 0.1 * size;
                Ray::new((center + away).to_array(), (target - center - away).to_array())
            })
            .collect()
    };
    for accelerator in [Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh] {
        let options = Options { accelerator, ..Caster::options() };
        let mut caster = caster(&scene, &options, &device);
        let mut growth = vec![caster.data().growth];
        for distance in [1.0, 1e3, 10.0, 1e5] {
            let rays = far(distance);
            let hits = cast(&mut caster, &device, &rays).expect("hits");
            assert!(bits(&hits) == bits(&alone(&scene, &rays, &options, &device)), "{accelerator} {distance}");
            growth.push(caster.data().growth);
        }
        let rays = with_intervals(&far(2e5), false);
        let hits = cast(&mut caster, &device, &rays).expect("hits");
        assert!(bits(&hits) == bits(&alone(&scene, &rays, &options, &device)), "{accelerator}, then with intervals");
        assert_eq!(growth[0], growth[1], "{accelerator}: rays from near need no other structure");
        if accelerator == Accelerator::Bvh {
            // A growth for such distances would be larger than the triangles: it follows the rays.
            assert!(growth[1] > 0.0 && growth[2..] == [0.0; 3] && caster.data().features.ray_padding, "{growth:?}");
            continue;
        }
        assert!(growth[1] < growth[2] && growth[2] == growth[3] && growth[3] < growth[4], "{growth:?}");
        // What a plan for the farthest of these rays would grow it by.
        let alone = Options { rays: RaySource::Given(far(1e5)), ..options };
        let (_, data) = raystep_kernels::Plan::new(&scene, &alone, &raystep_kernels::Limits::CPU).expect("a plan");
        assert!(growth[4] >= data.growth, "{growth:?} {}", data.growth);
    }
}

#[test]
fn a_ray_that_cannot_be_traced_is_named_and_the_next_slice_is_traced() {
    let scene = Arc::new(scene("cornell-box.gltf"));
    let rays = rays::random(&scene, 300, 4);
    let device = Device::Cpu(None);
    let mut caster = caster(&scene, &Caster::options(), &device);
    caster.set_batch(100);
    for (broken, why) in [
        (Ray::new([f32::NAN, 0.0, 0.0], [1.0; 3]), "not finite"),
        (Ray::new([1e20, 0.0, 0.0], [1.0; 3]), "too far"),
        (Ray::new([0.0; 3], [0.0; 3]), "direction is 0"),
        (rays[0].between(2.0, 1.0), "t_max is below"),
    ] {
        let mut all = rays.clone();
        all[250] = broken;
        let mut hits = Vec::new();
        let error = block_on(None, caster.cast_into(&all, &mut hits)).expect_err(why).to_string();
        assert!(error.contains("ray 250") && error.contains(why), "{error}");
        assert!(hits.is_empty(), "nothing is traced");
    }
    let hits = cast(&mut caster, &device, &rays).expect("hits");
    assert!(bits(&hits) == bits(&alone(&scene, &rays, &Caster::options(), &device)));
}

#[test]
fn the_papers_rules_and_an_empty_scene_can_be_cast_through() {
    let device = Device::Cpu(None);
    let empty = Arc::new(Scene::from_triangles(Vec::new()));
    let ray = Ray::new([0.5; 3], [0.0, 0.0, -1.0]);
    let mut nothing = caster(&empty, &Caster::options(), &device);
    assert_eq!(cast(&mut nothing, &device, &[ray]).expect("hits"), [CastHit::MISS]);
    // As far from the origin as a scene can be, and as large: rays from three times as far would be outside of f32.
    for corner in
        [[[1e8, 0.0, 0.0], [1e8 + 8.0, 0.0, 0.0], [1e8, 8.0, 0.0]], [[0.0; 3], [3e38, 0.0, 0.0], [0.0, 3e38, 0.0]]]
    {
        let scene = Arc::new(Scene::from_triangles(vec![corner]));
        let [a, b, c] = corner.map(|p| glam::Vec3::from(p) / 4.0);
        let above = a * 2.0 + b + c + glam::Vec3::Z * (b - a).max_element();
        let ray = Ray::new(above.to_array(), [0.0, 0.0, -1.0]);
        let mut caster = caster(&scene, &Caster::options(), &device);
        let hits = cast(&mut caster, &device, &[ray]).expect("hits");
        assert!(hits[0].is_hit() && hits[0].t == above.z, "{hits:?} {above}");
    }
    let room = Arc::new(scene("cornell-box.gltf"));
    let rays = rays::random(&room, 500, 4);
    let options = Options { accelerator: Accelerator::Grid, numerics: Numerics::Paper, ..Caster::options() };
    let mut paper = caster(&room, &options, &device);
    let hits = cast(&mut paper, &device, &rays).expect("hits");
    assert!(bits(&hits) == bits(&alone(&room, &rays, &options, &device)));
}

/// The t of a hit at a distance along a direction: not smaller, positive and finite.
fn t_of(distance: f64, length: f64) -> f32 {
    let t = distance / length;
    let nearest = t as f32;
    (if f64::from(nearest) < t { nearest.next_up() } else { nearest }).min(f32::MAX)
}

#[test]
fn a_direction_of_any_length_has_its_t() {
    let wall = vec![[[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]]];
    let scene = Arc::new(Scene::from_triangles(wall));
    // Distances and lengths are powers of two, some times 1.5: each t is exact wherever f32 has it.
    let lengths = (-149..=127).map(|k| 2f64.powi(k)).chain((-148..=127).map(|k| 1.5 * 2f64.powi(k)));
    let lengths: Vec<f32> = lengths.map(|length| length as f32).collect();
    let distances = [1.0f32, 3.0, 2f32.powi(-20), 3.0 * 2f32.powi(-40)];
    let rays: Vec<(Ray, f32)> = distances
        .into_iter()
        .flat_map(|z| lengths.iter().map(move |&length| (z, length)))
        .map(|(z, length)| (Ray::new([0.0, 0.0, z], [0.0, 0.0, -length]), t_of(z.into(), length.into())))
        .collect();
    for (name, device) in devices() {
        for any_hit in [false, true] {
            let mut caster = caster(&scene, &Options { any_hit, ..Caster::options() }, &device);
            let mut of = |rays: Vec<Ray>| cast(&mut caster, &device, &rays).expect("hits");
            let hits = of(rays.iter().map(|(ray, _)| *ray).collect());
            for ((ray, t), hit) in rays.iter().zip(&hits) {
                assert_eq!((hit.t.to_bits(), hit.triangle), (t.to_bits(), 0), "{name}: {ray:?}: {} for {t}", hit.t);
            }
            // A ray that starts at its hit does not find it again; one that ends there does not find it.
            let starting = of(rays.iter().map(|(ray, t)| ray.between(*t, f32::INFINITY)).collect());
            let ending = of(rays.iter().map(|(ray, t)| ray.between(0.0, *t)).collect());
            for ((ray, t), (after, before)) in rays.iter().zip(starting.iter().zip(&ending)) {
                assert!(!after.is_hit() && !before.is_hit(), "{name}: {ray:?} has a hit besides {t}");
            }
            let around = rays.iter().filter(|(_, t)| *t > 1e-44 && *t < 3e38);
            let around: Vec<Ray> = around.map(|(ray, t)| ray.between(t.next_down(), t.next_up())).collect();
            assert!(of(around).iter().all(CastHit::is_hit), "{name}: lost between its neighbours");
        }
    }
}

#[test]
fn components_of_very_different_size_are_traced() {
    let wall = [[[-4.0, -4.0, 0.0], [4.0, -4.0, 0.0], [0.0, 4.0, 0.0]]];
    for scale in [1e-30f32, 1.0, 1e30] {
        let wall = wall.iter().map(|t: &[[f32; 3]; 3]| t.map(|corner| corner.map(|v| v * scale))).collect();
        let scene = Arc::new(Scene::from_triangles(wall));
        let rays: Vec<Ray> = (-126..=126)
            .step_by(6)
            .flat_map(|k| {
                let d = 2f32.powi(k);
                let origin = [0.0, 0.0, scale];
                [[1e-45, 0.0, -d], [d * 1e-30, d * 1e-10, -d], [d * 0.5, 1e-45, -d]].map(|dir| Ray::new(origin, dir))
            })
            .collect();
        for (name, device) in devices() {
            let mut caster = caster(&scene, &Caster::options(), &device);
            let hits = cast(&mut caster, &device, &rays).expect("hits");
            for (ray, hit) in rays.iter().zip(hits) {
                let expected = t_of(scale.into(), f64::from(-ray.direction[2]));
                // A hit's t is within some units in the last place; what f32 cannot hold is at an end of its range.
                let is_near = hit.t == expected || (f64::from(hit.t) / f64::from(expected) - 1.0).abs() < 1e-5;
                assert!(hit.is_hit() && hit.t > 0.0 && hit.t.is_finite() && is_near, "{name}: {ray:?}: {hit:?}");
            }
        }
    }
}
