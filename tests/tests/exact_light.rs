//! With `--order exact`, every ray of the light finds what rational arithmetic finds: shadow rays, reflected and refracted ones,
//! paths and photons; so a picture is the same by every structure and schedule.

use std::collections::BTreeSet;
use std::ops::RangeInclusive;

use raystep_kernels::options::{Integrator, Photons};
use raystep_kernels::programs::closest_hit::states::{
    BACKGROUND, EXACT, OCCLUDED, PHOTON_ARRIVED, PHOTON_EXACT, PHOTON_LEAVES, PHOTON_SETUP, SHADE, SHADOW_EXACT,
    SHADOW_SETUP, TRAV_SETUP, VISIBLE,
};
use raystep_kernels::programs::closest_hit::streams::{
    BLOCKER, COLOR, HIT, HIT_TRIANGLE, PHOTON_AT, PHOTON_DIRECTION, PHOTON_ORIGIN, PHOTON_STATE, PHOTON_SURFACE,
    RAY_DIRECTION, RAY_ORIGIN, SHADOW_DIRECTION, SHADOW_ORIGIN, STATE, STATE_T, SURFACE,
};
use raystep_kernels::programs::{light, path, photons};
use raystep_kernels::shared::constants::NO_TRIANGLE;
use raystep_kernels::tables::state::Tag;
use raystep_kernels::tables::stream::{STATE_TAG, Stream};
use raystep_kernels::{Accelerator, Device, Kernel, Options, Order, RaySource, Renderer, ScheduleKind, StreamData};
use raystep_lab::reference::Triangles;
use raystep_scenes::{Light, Scene, generate};
use raystep_tests::configurations::Configuration;
use raystep_tests::{block_on, devices, gpu, gpu_of, options, parity, scene, thorough, traced, values};

use crate::bounced::{balls, glazed};

/// A scene with each triangle twice, closer together than rounding tells, in other materials; and lights on two of them.
fn doubled(mut scene: Scene) -> Scene {
    let bounds = scene.bounds();
    let size = (bounds.max - bounds.min).max_element();
    let materials = scene.materials.len() as u32;
    let off = [1e-7, -6e-8, 9e-8].map(|share| share * size);
    let again: Vec<_> =
        scene.triangles.iter().map(|corners| corners.map(|corner| [0, 1, 2].map(|i| corner[i] + off[i]))).collect();
    for place in [0, again.len() / 2] {
        let [a, b, c] = again[place];
        let position = [0, 1, 2].map(|i| (a[i] + b[i] + c[i]) / 3.0);
        scene.lights.push(Light::Point { position, color: [1.0, 0.8, 0.6], intensity: 0.5 * size * size });
    }
    scene.triangles.extend(again);
    let others: Vec<u32> = scene.triangle_materials.iter().map(|material| (material + 1) % materials).collect();
    scene.triangle_materials.extend(others);
    fn twice<T: Clone>(list: &mut Option<Vec<T>>) {
        list.iter_mut().for_each(|list| list.extend_from_within(..));
    }
    twice(&mut scene.normals);
    twice(&mut scene.texcoords);
    twice(&mut scene.colors);
    scene
}

/// Light in each of these scenes, by each integrator.
fn runs() -> Vec<(String, Scene, Options)> {
    let of = |integrator, name: &str, scene: Scene| {
        let side = if thorough() { 48 } else { 10 };
        let scene = doubled(scene);
        let photons = Photons { count: 100, nearest: 8, radius: 100, ..Photons::default() };
        let options = Options { integrator, order: Order::Exact, max_depth: 3, photons, ..options(&scene, side, side) };
        (format!("{integrator} in {name}"), scene, options)
    };
    vec![
        of(Integrator::Shadows, "lights", scene("lights.gltf")),
        of(Integrator::Whitted, "glass", glazed(balls())),
        of(Integrator::Path, "lamp", generate::cornell_lamp()),
        of(Integrator::Photons, "lamp", glazed(generate::cornell_lamp())),
    ]
}

const CONFIGURATIONS: [(Accelerator, ScheduleKind, u32); 9] = [
    (Accelerator::None, ScheduleKind::Compact, 64),
    (Accelerator::None, ScheduleKind::Fused, 1),
    (Accelerator::Grid, ScheduleKind::Fused, 1),
    (Accelerator::Grid, ScheduleKind::Second, 1),
    (Accelerator::Irregular, ScheduleKind::Fused, 1),
    (Accelerator::Irregular, ScheduleKind::Compact, 8),
    (Accelerator::Bvh, ScheduleKind::Fused, 1),
    (Accelerator::Bvh, ScheduleKind::Compact, 8),
    (Accelerator::Bvh, ScheduleKind::First, 1),
];

fn configured(options: &Options, (accelerator, schedule, steps): (Accelerator, ScheduleKind, u32)) -> Options {
    Configuration::new(accelerator, schedule, steps).of(options)
}

#[test]
fn pictures_are_the_same_by_every_structure_and_schedule() {
    for (name, scene, options) in runs() {
        for (on, device) in devices() {
            let mut first: Option<StreamData> = None;
            for configuration in CONFIGURATIONS {
                let options = configured(&options, configuration);
                let label = format!("{name}, {configuration:?} on {on}");
                let color = values(&traced(&scene, &options, &device), COLOR);
                let first = first.get_or_insert_with(|| color.clone());
                assert!(*first == color, "{label}");
            }
            // Otherwise nothing would have been tested.
            let rounded = Options { order: Order::Rounded, ..configured(&options, CONFIGURATIONS[0]) };
            assert!(first != Some(values(&traced(&scene, &rounded, &device), COLOR)), "{name} on {on}");
        }
    }
}

/// A kind of rays: their streams, and their states.
struct Kind {
    streams: [Stream; 5],
    walking: RangeInclusive<Tag>,
    open: Tag,
    ended: [Tag; 2],
    is_any: bool,
}

const KINDS: [Kind; 3] = [
    Kind {
        streams: [STATE, RAY_ORIGIN, RAY_DIRECTION, HIT, SURFACE],
        walking: TRAV_SETUP..=EXACT,
        open: EXACT,
        ended: [SHADE, BACKGROUND],
        is_any: false,
    },
    Kind {
        streams: [STATE, SHADOW_ORIGIN, SHADOW_DIRECTION, BLOCKER, SURFACE],
        walking: SHADOW_SETUP..=SHADOW_EXACT,
        open: SHADOW_EXACT,
        ended: [OCCLUDED, VISIBLE],
        is_any: true,
    },
    Kind {
        streams: [PHOTON_STATE, PHOTON_ORIGIN, PHOTON_DIRECTION, PHOTON_AT, PHOTON_SURFACE],
        walking: PHOTON_SETUP..=PHOTON_EXACT,
        open: PHOTON_EXACT,
        ended: [PHOTON_ARRIVED, PHOTON_LEAVES],
        is_any: false,
    },
];

/// How many rays of a kind were judged, hit something, and were left to integers.
#[derive(Clone, Copy, Debug, Default)]
struct Judged {
    rays: usize,
    hits: usize,
    open: usize,
}

/// Steps a run, and compares every ray whose walk has ended with rational arithmetic.
fn judged(label: &str, scene: &Scene, options: &Options, device: &Device) -> [Judged; 3] {
    block_on(gpu_of(device), async {
        let mut renderer = Renderer::new(scene, options, device).await.expect("a renderer");
        let vertices = renderer.data().vertices.clone();
        let triangles = Triangles::new(&vertices);
        let mut judged = [Judged::default(); 3];
        // The tags and t of each kind's elements after the pass before.
        let mut before: [Vec<(Tag, f32)>; 3] = Default::default();
        while renderer.step().await.expect("a pass").is_some() {
            for ((kind, before), judged) in KINDS.iter().zip(&mut before).zip(&mut judged) {
                if !kind.streams.iter().all(|&stream| renderer.plan().has_stream(stream) || stream == SURFACE) {
                    continue;
                }
                let state = renderer.values(kind.streams[0]).await.expect("values");
                let [tags, t] = [STATE_TAG, STATE_T].map(|layer| state.layer(layer));
                let now: Vec<(Tag, f32)> = tags.iter().zip(t).map(|(&tag, &t)| (tag, f32::from_bits(t))).collect();
                judged.open += now.iter().filter(|(tag, _)| *tag == kind.open).count();
                let was = std::mem::replace(before, now);
                let ends = |(was, now): (&(Tag, f32), &(Tag, f32))| {
                    kind.walking.contains(&was.0) && kind.ended.contains(&now.0)
                };
                let ended: Vec<usize> =
                    was.iter().zip(&*before).enumerate().filter_map(|(i, both)| ends(both).then_some(i)).collect();
                if ended.is_empty() {
                    continue;
                }
                let mut streams = Vec::new();
                for &stream in &kind.streams[1..] {
                    streams.push(match renderer.plan().has_stream(stream) {
                        true => Some(renderer.values(stream).await.expect("values")),
                        false => None,
                    });
                }
                let [Some(origin), Some(direction), Some(hit), surface] = &streams[..] else { unreachable!() };
                for ray in ended {
                    let [origin, direction] =
                        [origin, direction].map(|stream| [0, 1, 2].map(|layer| stream.get_f32(layer, ray)));
                    let leaves = surface.as_ref().map_or(NO_TRIANGLE, |surface| surface.get(0, ray));
                    let candidates = triangles.candidates(origin, direction).without(leaves);
                    let found = before[ray].0 == kind.ended[0];
                    judged.rays += 1;
                    judged.hits += usize::from(found);
                    let label = format!("{label}: ray {ray} from {origin:?} along {direction:?}");
                    if kind.is_any {
                        let end = was[ray].1;
                        let is_hit = triangles.are_hit_before(end, origin, direction, &candidates);
                        assert_eq!(found, is_hit, "{label} to {end}");
                    } else {
                        let found = found.then(|| hit.get(HIT_TRIANGLE, ray));
                        assert_eq!(found, candidates.exact.map(|(triangle, _)| triangle), "{label}");
                    }
                }
            }
        }
        judged
    })
}

#[test]
fn every_ray_finds_what_rational_arithmetic_finds() {
    let mut sum = [Judged::default(); 3];
    for (place, (name, scene, options)) in runs().into_iter().enumerate() {
        for (row, configuration) in CONFIGURATIONS.into_iter().enumerate() {
            // A device takes many passes of one step, after each of which streams are read.
            let is_stepped = configuration.1 != ScheduleKind::Fused && configuration.2 == 1;
            if (row + place) % 2 > 0 && !thorough() {
                continue;
            }
            let (on, device) = if is_stepped { ("CPU", Device::Cpu(None)) } else { devices().swap_remove(row % 2) };
            let label = format!("{name}, {configuration:?} on {on}");
            let found = judged(&label, &scene, &configured(&options, configuration), &device);
            for (sum, found) in sum.iter_mut().zip(found) {
                *sum = Judged { rays: sum.rays + found.rays, hits: sum.hits + found.hits, open: sum.open + found.open };
            }
        }
    }
    println!("{sum:?}");
    for of in sum {
        assert!(of.rays > 500 && of.hits > 100 && of.rays - of.hits > 20 && of.open > 100, "{sum:?}");
    }
}

/// Pass by pass, a device leaves what the CPU reference kernels leave, also where rays wait for another dispatch.
#[test]
fn integers_decide_alike_on_a_device_and_on_the_cpu() {
    let mut seen = BTreeSet::new();
    for (place, (name, scene, options)) in runs().into_iter().enumerate() {
        let of_passes = |of: &&(Accelerator, ScheduleKind, u32)| of.1 == ScheduleKind::Fused || of.2 > 1;
        for (row, &configuration) in CONFIGURATIONS.iter().filter(of_passes).enumerate() {
            if (row + place) % 2 > 0 && !thorough() {
                continue;
            }
            let RaySource::Camera { camera, .. } = &options.rays else { unreachable!() };
            let rays = RaySource::Camera { camera: camera.clone(), width: 8, height: 6 };
            let photons = Photons { count: 30, ..options.photons };
            let options = Options { counters: true, rays, photons, ..configured(&options, configuration) };
            // So few that every decision takes a dispatch.
            let found = parity::compare_in_turns(&gpu(), &scene, &options, 40);
            assert_eq!((found.breaches, found.miscounts), (vec![], vec![]), "{name}, {configuration:?}");
            seen.extend(found.transitions.into_iter().filter(|(_, kernel, _)| is_deciding(*kernel)));
        }
    }
    let programs = [&*light::PROGRAM, &path::PROGRAM, &photons::PROGRAM];
    let listed: BTreeSet<_> = programs
        .into_iter()
        .flat_map(|program| program.kernels().filter(|&kernel| is_deciding(kernel)))
        .flat_map(|kernel| kernel.sends().iter().map(move |sent| (sent.from, kernel, sent.to)))
        .collect();
    assert_eq!(seen, listed, "where decided rays go");
}

fn is_deciding(kernel: Kernel) -> bool {
    kernel.info().name == "decide"
}
