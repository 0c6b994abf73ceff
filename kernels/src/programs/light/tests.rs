//! The program on the CPU: the same picture by every structure and schedule, and the local one where nothing is occluded.

use std::ops::ControlFlow;

use glam::Vec3;
use raystep_scenes::{Camera, Light, Scene, generate};

use crate::options::{Accelerator, Integrator, Numerics, Options, RaySource, ScheduleKind};
use crate::programs::closest_hit::streams::{BLOCKER, COLOR, HIT, STATE};
use crate::renderer::{Device, RenderError, Renderer};
use crate::shared::constants::NO_TRIANGLE;
use crate::tables::stream::{Stream, StreamData};

/// The Cornell box with lights of each kind, of which the last is behind its back wall.
pub(crate) fn room() -> Scene {
    let mut scene = generate::cornell_box();
    let bounds = scene.bounds();
    let at = |x: f32, y: f32, z: f32| (bounds.min + (bounds.max - bounds.min) * Vec3::new(x, y, z)).to_array();
    let down = Vec3::new(0.2, -0.4, -1.0).normalize().to_array();
    scene.lights = vec![
        Light::Point { position: at(0.3, 0.9, 0.5), color: [0.5, 0.6, 0.7], intensity: 1.0 },
        Light::Directional { direction: down, color: [0.3; 3], intensity: 1.0 },
        Light::Spot {
            position: at(0.8, 0.8, 0.4),
            direction: [0.0, -1.0, 0.0],
            color: [0.9, 0.2, 0.2],
            intensity: 1.0,
            inner_cone: 0.4,
            outer_cone: 0.9,
        },
        Light::Point { position: at(0.5, 0.5, -0.4), color: [1.0; 3], intensity: 1.0 },
    ];
    scene
}

pub(crate) fn options(scene: &Scene, width: u32, height: u32) -> Options {
    let camera = scene.cameras.first().cloned().unwrap_or_else(|| Camera::framing(&scene.bounds()));
    let rays = RaySource::Camera { camera, width, height };
    Options { integrator: Integrator::Shadows, ..Options::new(rays) }
}

/// Streams at the end of a run on the CPU.
fn run<const N: usize>(scene: &Scene, options: &Options, streams: [Stream; N]) -> [StreamData; N] {
    let outcome = pollster::block_on(async {
        let mut renderer = Renderer::new(scene, options, &Device::Cpu(None)).await?;
        renderer.run(|_| ControlFlow::Continue(())).await?;
        let mut values = Vec::new();
        for stream in streams {
            values.push(renderer.values(stream).await?);
        }
        Ok::<_, RenderError>(values)
    });
    outcome.expect("a run").try_into().expect("as many")
}

#[test]
fn every_structure_and_schedule_gives_the_same_light() {
    let scene = room();
    let mut first: Option<[StreamData; 3]> = None;
    for accelerator in [Accelerator::None, Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh] {
        for (schedule, steps_per_pass) in [
            (ScheduleKind::First, 1),
            (ScheduleKind::Second, 1),
            (ScheduleKind::Compact, 1),
            (ScheduleKind::Compact, 8),
            (ScheduleKind::Fused, 8),
        ] {
            let options = Options { accelerator, schedule, steps_per_pass, ..options(&scene, 40, 40) };
            let [color, hit, mut state] = run(&scene, &options, [COLOR, HIT, STATE]);
            // Cell and item depend on the structure; the tag and t do not.
            state.bits.truncate(2 * 40 * 40);
            let found = [color, hit, state];
            let first = first.get_or_insert_with(|| found.clone());
            assert!(*first == found, "{accelerator} {schedule} {steps_per_pass}");
        }
    }
}

/// Each light alone: a pixel has the local colour where a shadow ray reaches it, and is black where not.
#[test]
fn a_light_counts_as_in_the_local_colour_or_not_at_all() {
    let room = room();
    for (light, fewest) in [(0, 100), (1, 100), (2, 30), (3, 0)] {
        let mut scene = room.clone();
        scene.lights = vec![room.lights[light].clone()];
        let shadows = options(&scene, 40, 40);
        let [color, blocker] = run(&scene, &shadows, [COLOR, BLOCKER]);
        let [local] = run(&scene, &Options { integrator: Integrator::Local, ..shadows }, [COLOR]);
        let rgb = |of: &StreamData, i: usize| [0, 1, 2].map(|layer| of.get(layer, i));
        let (mut lit, mut dark) = (0, 0);
        for i in 0..40 * 40 {
            if rgb(&color, i) == rgb(&local, i) {
                lit += usize::from(rgb(&local, i) != [0; 3]);
            } else {
                assert_eq!(rgb(&color, i), [0; 3], "pixel {i} of light {light}");
                assert_ne!(blocker.get(2, i), NO_TRIANGLE, "pixel {i} of light {light}");
                dark += 1;
            }
        }
        // The box is open in front; through its walls nothing shines.
        assert!(lit >= fewest && dark >= 30 && (light != 3 || lit == 0), "light {light}: {lit} lit, {dark} dark");
    }
}

/// The paper's rules lose some rays, and light nothing else.
#[test]
fn the_papers_rules_give_nearly_the_same_light() {
    let scene = room();
    let robust = options(&scene, 40, 40);
    let [color] = run(&scene, &robust, [COLOR]);
    let paper = Options { numerics: Numerics::Paper, ..robust.clone() };
    for accelerator in [Accelerator::Grid, Accelerator::Bvh, Accelerator::None] {
        let [of_paper] = run(&scene, &Options { accelerator, ..paper.clone() }, [COLOR]);
        let off = |i: usize| (0..3).any(|c| (color.get_f32(c, i) - of_paper.get_f32(c, i)).abs() > 1e-4);
        let differ = (0..40 * 40).filter(|&i| off(i)).count();
        // The paper's test loses rays at the cracks between cells, and its box is entered from outside.
        assert!(differ < 80, "{accelerator}: {differ} of 1600 pixels");
    }
}

/// Each kind of surface in a room whose walls emit their own colour, and its light at the hit of a ray.
mod mirrors {
    use glam::DVec3;
    use raystep_scenes::{Material, Optics, Projection};

    use super::*;
    use crate::programs::closest_hit::streams::{COUNTERS, RAY_DIRECTION, RAY_ORIGIN};

    /// Two walls that face each other at z = -3 and 3, of which the first emits red and the other green, and a pane
    /// between them at z = 0.
    fn pane(optics: Optics) -> Scene {
        let square = |z: f32, size: f32, is_turned: bool| {
            let corner = |x: f32, y: f32| [x * size, y * size, z];
            let [a, b, c, d] = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
            if is_turned { [[a, c, b], [a, d, c]] } else { [[a, b, c], [a, c, d]] }
        };
        let glowing = |emissive| Material { base_color: [0.0; 3], emissive, ..Material::default() };
        let of_pane = Material { base_color: [0.5, 0.25, 1.0], optics, ..Material::default() };
        let triangles = [square(-3.0, 90.0, false), square(3.0, 90.0, true), square(0.0, 2.0, false)].concat();
        let mut scene = Scene::from_triangles(triangles);
        scene.materials = vec![glowing([1.0, 0.0, 0.5]), glowing([0.0, 1.0, 0.25]), of_pane];
        scene.triangle_materials = vec![0, 0, 1, 1, 2, 2];
        scene
    }

    /// One pixel that looks at the pane along a direction, from its front.
    fn looking(scene: &Scene, along: DVec3, max_depth: u32) -> Options {
        let at = DVec3::new(0.1, 0.2, 0.0);
        let projection = Projection::Perspective { vertical_fov: 0.01 };
        let camera = Camera::look_at(at - along * 2.0, at, DVec3::Y, projection).expect("a camera");
        let rays = RaySource::Camera { camera, width: 1, height: 1 };
        let options = Options { integrator: Integrator::Whitted, max_depth, ..Options::new(rays) };
        assert!(scene.lights.is_empty());
        options
    }

    fn color(scene: &Scene, options: &Options) -> [f32; 3] {
        let [color] = run(scene, options, [COLOR]);
        [0, 1, 2].map(|layer| color.get_f32(layer, 0))
    }

    #[track_caller]
    fn assert_close(found: [f32; 3], expected: [f64; 3]) {
        // Some tens of roundings of values below 1.
        let is_close = (0..3).all(|c| (f64::from(found[c]) - expected[c]).abs() < 4e-6);
        assert!(is_close, "{found:?}, expected {expected:?}");
    }

    #[test]
    fn a_mirror_shows_what_is_in_front_of_it_in_its_colour() {
        let scene = pane(Optics::Mirror);
        for along in [DVec3::NEG_Z, DVec3::new(0.3, -0.2, -0.9).normalize()] {
            assert_close(color(&scene, &looking(&scene, along, 5)), [0.0, 0.25, 0.25]);
        }
        // Without depth, a mirror is black.
        assert_close(color(&scene, &looking(&scene, DVec3::NEG_Z, 0)), [0.0; 3]);
        // From behind, too.
        assert_close(color(&scene, &looking(&scene, DVec3::Z, 1)), [0.5, 0.0, 0.5]);
    }

    /// Fresnel's reflectance in f64, with the angle of refraction by Snell's law.
    fn fresnel(ratio: f64, cosine: f64) -> f64 {
        let (inside, angle) = (ratio * (1.0 - cosine * cosine).sqrt(), cosine.acos());
        if inside >= 1.0 {
            return 1.0;
        }
        let beyond = inside.asin();
        if angle == 0.0 {
            return ((ratio - 1.0) / (ratio + 1.0)).powi(2);
        }
        let [across, along] = [
            ((angle - beyond).sin() / (angle + beyond).sin()).powi(2),
            ((angle - beyond).tan() / (angle + beyond).tan()).powi(2),
        ];
        f64::midpoint(across, along)
    }

    /// The two walls as seen through the front of the pane.
    fn seen(reflectance: f64) -> [f64; 3] {
        [(1.0 - reflectance) * 0.5, reflectance, (1.0 - reflectance) * 0.5 + reflectance * 0.25]
    }

    #[test]
    fn a_dielectric_splits_light_by_fresnels_equations() {
        for is_thin in [false, true] {
            let scene = pane(Optics::Dielectric { ior: 1.5, is_thin });
            for tilt in [0.0, 0.2, 0.8, 1.2f64] {
                let along = DVec3::new(tilt.sin(), 0.0, -tilt.cos());
                let found = color(&scene, &looking(&scene, along, 5));
                assert_close(found, seen(fresnel(1.0 / 1.5, tilt.cos())));
            }
        }
    }

    #[test]
    fn beyond_the_critical_angle_all_light_is_reflected_and_in_a_sheet_never() {
        let solid = pane(Optics::Dielectric { ior: 1.5, is_thin: false });
        let sheet = pane(Optics::Dielectric { ior: 1.5, is_thin: true });
        for (tilt, is_total) in [(0.70f64, false), (0.75, true)] {
            // From behind, light leaves the solid: sin 0.7297 = 1 / 1.5.
            let along = DVec3::new(tilt.sin(), 0.0, tilt.cos());
            let [r, g, _] = color(&solid, &looking(&solid, along, 5));
            assert_eq!((r == 1.0, g == 0.0), (is_total, is_total), "tilt {tilt}: r {r} g {g}");
            let reflectance = fresnel(1.5, tilt.cos());
            assert!((f64::from(r) - reflectance).abs() < 1e-5, "{r} {reflectance}");
            assert!(color(&sheet, &looking(&sheet, along, 5))[1] > 0.2);
        }
    }

    /// Two mirrors that face each other: each bounce multiplies by their colour, until the depth is reached.
    #[test]
    fn depth_counts_reflections() {
        let mut scene = pane(Optics::Mirror);
        scene.materials[1] =
            Material { base_color: [0.5; 3], emissive: [0.125; 3], optics: Optics::Mirror, ..Material::default() };
        for depth in 0..=8u32 {
            // Every other hit is on the wall that glows.
            let of_channel = |tint: f64| {
                let mut sum = 0.0;
                let mut carried = 1.0;
                for bounce in 0..depth {
                    carried *= if bounce % 2 == 0 { tint } else { 0.5 };
                    sum += if bounce % 2 == 0 { carried * 0.125 } else { 0.0 };
                }
                sum
            };
            let found = color(&scene, &looking(&scene, DVec3::NEG_Z, depth));
            assert_close(found, [0.5, 0.25, 1.0].map(of_channel));
        }
    }

    /// The camera's ray and its hit are put back, the cost is that of all rays, and the image is the same by every
    /// structure and schedule, also by samples.
    #[test]
    fn every_structure_and_schedule_sees_the_same_in_mirrors() {
        let scene = generate::whitted(1).expect("a scene");
        let mut first: Option<[StreamData; 5]> = None;
        let shadows = Options { counters: true, ..options(&scene, 24, 24) };
        let [_, of_first, ..] = run(&scene, &shadows, [COLOR, COUNTERS]);
        for accelerator in [Accelerator::None, Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh] {
            for (schedule, steps_per_pass) in
                [(ScheduleKind::Second, 1), (ScheduleKind::Compact, 8), (ScheduleKind::Fused, 8)]
            {
                if accelerator == Accelerator::None && steps_per_pass == 1 {
                    continue;
                }
                let whitted = Options {
                    integrator: Integrator::Whitted,
                    accelerator,
                    schedule,
                    steps_per_pass,
                    ..shadows.clone()
                };
                let [color, hit, origin, direction, mut state] =
                    run(&scene, &whitted, [COLOR, HIT, RAY_ORIGIN, RAY_DIRECTION, STATE]);
                state.bits.truncate(2 * 24 * 24);
                let found = [color, hit, origin, direction, state];
                let [_, expected_hit, expected_origin, expected_direction, _] =
                    run(&scene, &shadows, [COLOR, HIT, RAY_ORIGIN, RAY_DIRECTION, STATE]);
                assert!(found[1..4] == [expected_hit, expected_origin, expected_direction], "{accelerator} {schedule}");
                let first = first.get_or_insert_with(|| found.clone());
                assert!(*first == found, "{accelerator} {schedule} {steps_per_pass}");
                if accelerator == Accelerator::Grid && schedule == ScheduleKind::Compact {
                    let [_, cost] = run(&scene, &whitted, [COLOR, COUNTERS]);
                    let tests = |counters: &StreamData| counters.layer(1).iter().map(|&n| u64::from(n)).sum::<u64>();
                    assert!(tests(&cost) > tests(&of_first), "{} of {}", tests(&cost), tests(&of_first));
                }
            }
        }
    }

    /// A picture of several samples is the mean of pictures of one.
    #[test]
    fn samples_begin_again_at_the_camera() {
        let scene = generate::whitted(1).expect("a scene");
        let base = Options { integrator: Integrator::Whitted, ..options(&scene, 12, 12) };
        let of = |count, first| {
            let samples = crate::options::samples::Samples { count, first, ..base.samples };
            let [color] = run(&scene, &Options { samples, ..base.clone() }, [COLOR]);
            color
        };
        let both = of(2, 1);
        let parts = [of(1, 1), of(1, 2)];
        assert_ne!(parts[0].bits, parts[1].bits);
        for pixel in 0..144 {
            for layer in 0..3 {
                let [a, b] = [0, 1].map(|part: usize| parts[part].get_f32(layer, pixel));
                let mean = both.get_f32(layer, pixel);
                assert!((mean - f32::midpoint(a, b)).abs() < 1e-6, "pixel {pixel}: {a} and {b} give {mean}");
            }
        }
    }
}
