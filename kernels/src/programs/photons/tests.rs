//! Photon maps on the CPU: energy that is conserved, lists that are those of the host, the nearest of all photons, and light
//! of closed forms.

mod converging;

use glam::{DVec3, Vec3 as Point};
use raystep_scenes::{Camera, Light, Material, Optics, Projection, Scene, generate};

use crate::options::samples::Samples;
use crate::options::{
    Accelerator, Gather, Integrator, Neighbours, Options, PhotonSort, Photons, RaySource, ScheduleKind,
};
use crate::plan::{Limits, Plan};
use crate::program::schedule::Schedule;
use crate::programs::closest_hit::elements::{MAP_CELLS, RECORDS};
use crate::programs::closest_hit::states::PHOTON_DONE;
use crate::programs::closest_hit::streams::{
    COLOR, GATHERED_POWER, GATHERING, HIT, PHOTON_BOUNCE, PHOTON_ENERGY, PHOTON_FIRST, PHOTON_KEY, PHOTON_POWER,
    PHOTON_RECORDS, PHOTON_STATE, RAY_DIRECTION,
};
use crate::programs::path::scattered::{BY_ESCAPE, BY_ROULETTE};
use crate::renderer::{Device, Renderer};
use crate::shared::constants::{NO_CELL, NO_TRIANGLE, RECORD};
use crate::tables::stream::{Stream, StreamData};

fn matte(base_color: [f32; 3]) -> Material {
    Material { base_color, ..Material::default() }
}

/// A scene of quads, each of its own material.
fn of_quads(quads: &[([[f32; 3]; 4], Material)]) -> Scene {
    let two = |[a, b, c, d]: [[f32; 3]; 4]| [[a, b, c], [a, c, d]];
    let mut scene = Scene::from_triangles(quads.iter().flat_map(|(corners, _)| two(*corners)).collect());
    scene.materials = quads.iter().map(|(_, material)| material.clone()).collect();
    scene.triangle_materials = (0..quads.len() as u32).flat_map(|i| [i, i]).collect();
    scene
}

fn looking(from: [f64; 3], to: [f64; 3], fov: f64, side: u32) -> RaySource {
    let projection = Projection::Perspective { vertical_fov: fov };
    let camera = Camera::look_at(from.into(), to.into(), DVec3::Y, projection).expect("a camera");
    RaySource::Camera { camera, width: side, height: side }
}

/// The room, with a lamp that glows, a mirror and glass.
fn room() -> Scene {
    let mut room = generate::whitted(1).expect("a scene");
    room.materials[0].emissive = [0.25, 0.5, 0.0];
    room
}

fn options(photons: Photons) -> Options {
    let rays = looking([0.0, 1.6, 5.2], [0.1, 0.85, 0.0], 0.7, 12);
    Options { integrator: Integrator::Photons, accelerator: Accelerator::Bvh, photons, ..Options::new(rays) }
}

fn few() -> Photons {
    Photons { count: 1000, radius: 60, nearest: 20, ..Photons::default() }
}

fn run(scene: &Scene, options: &Options, mut after_pass: impl AsyncFnMut(&Renderer)) -> Renderer {
    pollster::block_on(async {
        let mut renderer = Renderer::new(scene, options, &Device::Cpu(None)).await.expect("a plan");
        while renderer.step().await.expect("a pass").is_some() {
            after_pass(&renderer).await;
        }
        renderer
    })
}

fn values(renderer: &Renderer, stream: Stream) -> StreamData {
    pollster::block_on(renderer.values(stream)).expect("values")
}

/// After every pass, what was emitted is what photons carry, what surfaces have absorbed, and what has left the scene.
#[test]
fn energy_is_conserved_photon_by_photon_in_every_pass() {
    let mut passes = 0;
    let renderer = run(&room(), &options(few()), async |renderer| {
        let energy = renderer.values(PHOTON_ENERGY).await.expect("values");
        let power = renderer.values(PHOTON_POWER).await.expect("values");
        for photon in 0..energy.layer(0).len() {
            for part in 0..3 {
                let of = |first: usize| f64::from(energy.get_f32(first + part, photon));
                let left = of(0) - of(3) - of(6) - f64::from(power.get_f32(part, photon));
                assert!(left.abs() <= 1e-5 * of(0), "photon {photon} of pass {}: {left:e}", renderer.pass_count());
            }
        }
        passes += 1;
    });
    let (state, bounce, energy) =
        (values(&renderer, PHOTON_STATE), values(&renderer, PHOTON_BOUNCE), values(&renderer, PHOTON_ENERGY));
    assert!(state.layer(0).iter().all(|&tag| tag == PHOTON_DONE) && passes > 20);
    for why in [BY_ESCAPE, BY_ROULETTE] {
        assert!(bounce.layer(2).contains(&why), "none has ended by {why}");
    }
    let sum = |layer| energy.layer(layer).iter().map(|&bits| f64::from(f32::from_bits(bits))).sum::<f64>();
    // The floor glows, and most of what it emits leaves the scene.
    assert!(sum(3) > 0.01 * sum(0) && sum(6) > 0.5 * sum(0), "{} {} {}", sum(0), sum(3), sum(6));
}

/// The power of all photons is the flux of all lights, in traced units.
#[test]
fn photons_carry_the_flux_of_the_lights() {
    let floor = [[-1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0f32]];
    let lamp = [[-0.5, 1.0, -0.5], [0.5, 1.0, -0.5], [0.5, 1.0, 0.5], [-0.5, 1.0, 0.5f32]];
    let glows = Material { emissive: [2.0, 1.0, 0.5], ..matte([0.0; 3]) };
    let mut scene = of_quads(&[(floor, matte([0.5; 3])), (lamp, glows)]);
    let point = Light::Point { position: [0.0, 0.5, 0.0], color: [1.0, 0.5, 0.25], intensity: 0.75 };
    scene.lights = vec![point];
    let renderer = run(&scene, &options(Photons { count: 1 << 14, ..few() }), async |_| {});
    let area = f64::from(renderer.data().units.to_traced(1.0)).powi(2);
    let energy = values(&renderer, PHOTON_ENERGY);
    for (part, (radiance, intensity)) in [(2.0, 0.75), (1.0, 0.375), (0.5, 0.1875)].into_iter().enumerate() {
        let expected = std::f64::consts::PI * (radiance + 4.0 * intensity) * area;
        let sum: f64 = energy.layer(part).iter().map(|&bits| f64::from(f32::from_bits(bits))).sum();
        assert!((sum / expected - 1.0).abs() < 0.01, "{part}: {sum}, not {expected}");
    }
}

/// The cells of all places where photons are stored, in the order of the records, by the host.
fn cells(renderer: &Renderer) -> Vec<(u32, u32)> {
    let (map, records) = (renderer.data().photon_map, values(renderer, PHOTON_RECORDS));
    (0..map.records)
        .map(|record| {
            let (photon, first) = ((record % map.photons) as usize, (record / map.photons * RECORD) as usize);
            let at = crate::numbers::real::Vec3::from([0, 1, 2].map(|axis| records.get_f32(first + axis, photon)));
            let of = records.get(first + 9, photon);
            (if of == NO_CELL { NO_CELL } else { map.index_of(of, map.cell_of(map.place_of(at))) }, record)
        })
        .collect()
}

/// Both ways to sort give the lists of a stable sort by cell.
#[test]
fn sorted_lists_are_those_of_a_stable_sort() {
    let floor = [[-1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0f32]];
    // From there, photons leave the scene: all keys are all ones.
    let mut open = of_quads(&[(floor, matte([0.5; 3]))]);
    open.lights = vec![Light::Point { position: [0.0, 1.0, 0.0], color: [1.0; 3], intensity: 1.0 }];
    let (room, closed) = (room(), generate::cornell_box());
    for (scene, count, depth, radius) in [
        (&room, 1, 2, 60),
        (&room, 60, 8, 15),
        (&room, 1000, 3, 60),
        (&closed, 5000, 5, 1),
        // All in a few cells.
        (&closed, 300, 4, 1000),
        (&open, 500, 3, 60),
    ] {
        let photons = Photons { count, radius, ..few() };
        let mut found = Vec::new();
        for sort in [PhotonSort::Bitonic, PhotonSort::Scan] {
            let options = Options { max_depth: depth, ..options(Photons { sort, ..photons }) };
            let renderer = run(scene, &options, async |_| {});
            let [records, cells_in_all] =
                [&RECORDS, &MAP_CELLS].map(|set| renderer.size(set).expect("a size").count as usize);
            let (key, first) = (values(&renderer, PHOTON_KEY), values(&renderer, PHOTON_FIRST));
            let keys: Vec<(u32, u32)> =
                key.layer(0).iter().copied().zip(key.layer(1).iter().copied()).take(records).collect();
            let mut expected = cells(&renderer);
            expected.sort_by_key(|&(cell, _)| cell);
            assert!(keys == expected, "{count} photons by {sort}");
            let starts: Vec<u32> =
                (0..cells_in_all as u32).map(|cell| expected.partition_point(|&(of, _)| of < cell) as u32).collect();
            assert_eq!(first.layer(0)[..cells_in_all], starts, "{count} photons by {sort}");
            let stored = expected.iter().filter(|(cell, _)| *cell != NO_CELL).count() as u32;
            assert_eq!(starts.last(), Some(&stored), "the last list ends with the last photon");
            let is_open = scene.lights == open.lights;
            assert!(if is_open { stored == 0 } else { stored > 0 || count <= 60 }, "{count} photons, {stored} stored");
            found.push((keys, values(&renderer, COLOR)));
        }
        assert!(found[0] == found[1], "{count} photons");
    }
}

/// Squared distances of the photons that count at a pixel's hit, in f64, ascending; `None` if it sees none.
fn distances(renderer: &Renderer, [hit, direction, records]: &[StreamData; 3], pixel: usize) -> Option<Vec<f64>> {
    let triangle = hit.get(2, pixel);
    if triangle == NO_TRIANGLE {
        return None;
    }
    let along = Point::from_array([0, 1, 2].map(|axis| direction.get_f32(axis, pixel))).normalize();
    let corners = renderer.data().corners::<f32>(triangle);
    let start = crate::shared::start::start_of(
        corners,
        [0, 1].map(|weight| hit.get_f32(weight, pixel)),
        crate::numbers::real::Vec3::from(along.to_array()),
    );
    let [point, normal] = [start.point, start.normal].map(|v| DVec3::from(v.to_f64()));
    let map = renderer.data().photon_map;
    let vec3 = |first, photon| DVec3::from([0, 1, 2].map(|axis| f64::from(records.get_f32(first + axis, photon))));
    let mut all = Vec::new();
    for record in 0..map.records {
        let (photon, first) = ((record % map.photons) as usize, (record / map.photons * RECORD) as usize);
        if records.get(first + 9, photon) != NO_CELL && vec3(first + 3, photon).dot(normal) < 0.0 {
            all.push(vec3(first, photon).distance_squared(point));
        }
    }
    all.sort_by(f64::total_cmp);
    Some(all)
}

/// By brute force in f64: the exact search finds the nearest, the kNN-grid all within some distance, and both no fewer than
/// there are within the radius. With RAYSTEP_THOROUGH, for more than 10⁵ searches by each.
#[test]
fn the_photons_that_count_are_the_nearest() {
    let scene = generate::cornell_box();
    let side = if std::env::var_os("RAYSTEP_THOROUGH").is_some_and(|value| !value.is_empty()) { 190 } else { 12 };
    let rays = looking([0.0, 0.0, 3.3], [0.0; 3], 0.75, side);
    for neighbours in [Neighbours::Exact, Neighbours::KnnGrid] {
        for nearest in [1, 7, 50] {
            let photons = Photons { count: 4000, radius: 150, nearest, neighbours, ..Photons::default() };
            let renderer = run(&scene, &Options { rays: rays.clone(), ..options(photons) }, async |_| {});
            let (gathering, gathered) = (values(&renderer, GATHERING), values(&renderer, GATHERED_POWER));
            let radius = f64::from(renderer.data().photon_map.radius).powi(2);
            let streams = [HIT, RAY_DIRECTION, PHOTON_RECORDS].map(|stream| values(&renderer, stream));
            let (mut enough, mut taken, mut farther) = (0, 0, 0.0);
            for pixel in 0..(side * side) as usize {
                let Some(all) = distances(&renderer, &streams, pixel) else { continue };
                let (found, farthest) = (gathering.get(3, pixel) as usize, f64::from(gathered.get_f32(3, pixel)));
                // What f32 makes of a distance: the places have some roundings of their own size.
                let off = 1e-5 * farthest + 1e-12;
                let at_most = all.partition_point(|&squared| squared <= farthest + off);
                let at_least = all.partition_point(|&squared| squared < farthest - off);
                assert!((at_least..=at_most).contains(&found), "{neighbours} {nearest}, pixel {pixel}: {found}");
                let there = all.partition_point(|&squared| squared <= radius * (1.0 - 1e-5));
                assert!(found >= there.min(nearest as usize), "{neighbours} {nearest}, pixel {pixel}: {found}");
                if found >= nearest as usize {
                    (enough, taken) = (enough + 1, taken + found);
                    farther += (farthest / all[nearest as usize - 1]).sqrt();
                    let wanted = all[nearest as usize - 1];
                    match neighbours {
                        Neighbours::Exact => assert!((farthest - wanted).abs() <= off, "{nearest}, pixel {pixel}"),
                        Neighbours::KnnGrid => assert!(farthest >= wanted - off, "{nearest}, pixel {pixel}"),
                    }
                }
            }
            let of = |sum: f64| sum / f64::from(enough);
            println!(
                "{neighbours} {nearest}: {enough} searches, {} taken, {} times as far",
                of(taken as f64),
                of(farther)
            );
            assert!(enough > 60 * side * side / 144, "{neighbours} {nearest}: {enough}");
        }
    }
}

/// What a mirror reflects to a floor is the light of the lamp's image: a caustic, which nothing but photons brings.
#[test]
fn a_mirror_lights_the_floor_as_the_image_of_its_lamp() {
    const RUNS: u32 = 8;
    let floor = [[-2.0, 0.0, -2.0], [-2.0, 0.0, 2.0], [2.0, 0.0, 2.0], [2.0, 0.0, -2.0f32]];
    // Across z = -2, from below the floor up.
    let wall = [[-4.0, -0.5, -2.0], [4.0, -0.5, -2.0], [4.0, 4.0, -2.0], [-4.0, 4.0, -2.0f32]];
    let mirror = Material { optics: Optics::Mirror, ..matte([1.0; 3]) };
    let mut scene = of_quads(&[(floor, matte([0.5; 3])), (wall, mirror)]);
    let at = [0.25f32, 1.0, -1.5];
    scene.lights = vec![Light::Point { position: at, color: [1.0; 3], intensity: 3.0 }];
    let of = |lamp: DVec3| 0.5 / std::f64::consts::PI * 3.0 * lamp.y / lamp.length().powi(3);
    let (direct, reflected) = (of(DVec3::from(at.map(f64::from))), of(DVec3::new(0.25, 1.0, -2.5)));
    for neighbours in [Neighbours::KnnGrid, Neighbours::Exact] {
        // All within the radius count, in which there are about 340; the floor's own light is not stored with one bounce.
        let photons = Photons { count: 300_000, nearest: 1000, radius: 30, neighbours, ..Photons::default() };
        let found = |seed| {
            let samples = Samples { seed, ..Samples::default() };
            let rays = looking([0.5, 3.0, 3.0], [0.0; 3], 0.001, 1);
            let options = Options { rays, samples, max_depth: 2, ..options(photons) };
            f64::from(values(&run(&scene, &options, async |_| {}), COLOR).get_f32(0, 0)) - direct
        };
        let mean = (0..RUNS).map(found).sum::<f64>() / f64::from(RUNS);
        // Three times the deviation of such a mean, if photons were independent.
        assert!((mean / reflected - 1.0).abs() < 0.07, "{neighbours}: {mean}, not {reflected}");
    }
}

/// The picture does not depend on the structure, the schedule or how photons are sorted.
#[test]
fn every_structure_and_schedule_gathers_the_same_photons() {
    let mut first: Option<StreamData> = None;
    for accelerator in [Accelerator::None, Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh] {
        for (schedule, steps_per_pass) in
            [(ScheduleKind::Second, 1), (ScheduleKind::Compact, 8), (ScheduleKind::Fused, 8)]
        {
            if accelerator == Accelerator::None && steps_per_pass == 1 {
                continue;
            }
            let photons = Photons { gather: Gather::Final, ..few() };
            let samples = Samples { count: 2, ..Samples::default() };
            let options = Options { accelerator, schedule, steps_per_pass, samples, ..options(photons) };
            let color = values(&run(&room(), &options, async |_| {}), COLOR);
            let first = first.get_or_insert_with(|| color.clone());
            assert!(*first == color, "{accelerator} {schedule}");
        }
    }
}

#[test]
fn what_does_not_go_together_with_photons_is_refused() {
    let refused = |change: fn(&mut Options)| {
        let mut options = options(few());
        change(&mut options);
        match Plan::new(&room(), &options, &Limits::CPU) {
            Ok(_) => String::new(),
            Err(error) => error.to_string(),
        }
    };
    assert_eq!(refused(|_| ()), "");
    assert!(refused(|o| o.samples = Samples { count: 2, first: 16, ..o.samples }).contains("shared among machines"));
    assert!(refused(|o| o.rays = RaySource::Given(Vec::new())).contains("input rays cannot be used"));
    assert!(refused(|o| o.any_hit = true).contains("any hit"));
    assert!(refused(|o| o.max_depth = 9).contains("bounces at most 8 times"));
    assert!(refused(|o| o.photons.count = 1 << 21).contains("use fewer photons"));
}

/// Without light there is no picture; with no bounce before the last there is no map, and nothing but what shadow rays find.
#[test]
fn a_run_without_a_map_has_no_photons() {
    let mut dark = room();
    dark.lights.clear();
    dark.materials.iter_mut().for_each(|material| material.emissive = [0.0; 3]);
    let refused = Plan::new(&dark, &options(few()), &Limits::CPU).map(|_| ()).expect_err("no light").to_string();
    assert!(refused.contains("nothing in the scene gives light"), "{refused}");
    let renderer = run(&room(), &Options { max_depth: 1, ..options(few()) }, async |_| {});
    let Schedule { steps } = &renderer.plan().schedule;
    assert!(!renderer.plan().features.mapped && steps.len() == 2, "{steps:?}");
    assert!(!renderer.plan().has_stream(PHOTON_RECORDS));
}
