//! Light along paths on the CPU: closed boxes that glow, closed forms, and strategies that agree.

use std::f64::consts::PI;
use std::ops::ControlFlow;

use glam::DVec3;
use raystep_scenes::{Camera, Light, Material, Optics, Projection, Scene, generate};

use crate::history::RunSoFar;
use crate::history::light_tree::LightTree;
use crate::options::samples::Samples;
use crate::options::{Accelerator, Integrator, Options, RaySource, ScheduleKind, Strategy};
use crate::plan::{Limits, Plan};
use crate::programs::closest_hit::streams::{COLOR, HIT, RAY_DIRECTION};
use crate::renderer::{Device, RenderError, Renderer};
use crate::tables::stream::{Stream, StreamData};

const STRATEGIES: [Strategy; 3] = [Strategy::Mis, Strategy::Light, Strategy::Bsdf];

fn quad([a, b, c, d]: [[f32; 3]; 4]) -> [[[f32; 3]; 3]; 2] {
    [[a, b, c], [a, c, d]]
}

fn matte(base_color: [f32; 3], emissive: [f32; 3]) -> Material {
    Material { base_color, emissive, ..Material::default() }
}

/// A scene of quads, each of its own material.
fn of_quads(quads: &[([[f32; 3]; 4], Material)]) -> Scene {
    let mut scene = Scene::from_triangles(quads.iter().flat_map(|(corners, _)| quad(*corners)).collect());
    scene.materials = quads.iter().map(|(_, material)| material.clone()).collect();
    scene.triangle_materials = (0..quads.len() as u32).flat_map(|i| [i, i]).collect();
    scene
}

/// An image that looks from one point to another.
fn looking(from: [f64; 3], to: [f64; 3], fov: f64, side: u32) -> RaySource {
    let projection = Projection::Perspective { vertical_fov: fov };
    let up = if from[0] == to[0] && from[2] == to[2] { DVec3::X } else { DVec3::Y };
    let camera = Camera::look_at(from.into(), to.into(), up, projection).expect("a camera");
    RaySource::Camera { camera, width: side, height: side }
}

fn options(rays: RaySource, strategy: Strategy, max_depth: u32, count: u32, seed: u32) -> Options {
    let samples = Samples { count, seed, ..Samples::default() };
    let base = Options::new(rays);
    Options {
        integrator: Integrator::Path,
        accelerator: Accelerator::Bvh,
        schedule: ScheduleKind::Fused,
        strategy,
        max_depth,
        samples,
        ..base
    }
}

fn values<const N: usize>(scene: &Scene, options: &Options, streams: [Stream; N]) -> [StreamData; N] {
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

/// The mean of all pixels and channels.
fn mean(scene: &Scene, options: &Options) -> f64 {
    let [color] = values(scene, options, [COLOR]);
    let values = color.bits.iter().map(|&bits| f64::from(f32::from_bits(bits)));
    values.sum::<f64>() / color.bits.len() as f64
}

/// The mean over independent scrambles, and half of its 99% interval.
fn estimate(scene: &Scene, of: impl Fn(u32) -> Options) -> (f64, f64) {
    const SCRAMBLES: u32 = 16;
    // Student's t of 15 degrees of freedom.
    const T: f64 = 2.947;
    let means: Vec<f64> = (0..SCRAMBLES).map(|seed| mean(scene, &of(seed))).collect();
    let mean = means.iter().sum::<f64>() / f64::from(SCRAMBLES);
    let variance = means.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / f64::from(SCRAMBLES - 1);
    (mean, T * (variance / f64::from(SCRAMBLES)).sqrt())
}

/// A closed box of one albedo that glows everywhere.
fn furnace(albedo: f32, glow: f32) -> Scene {
    let mut scene = generate::icosphere(0).expect("a scene");
    scene.normals = None;
    // Seen from within.
    for [_, b, c] in &mut scene.triangles {
        std::mem::swap(b, c);
    }
    scene.lights.clear();
    scene.materials = vec![matte([albedo; 3], [glow; 3])];
    scene
}

/// In a closed box of albedo ρ that glows with e, everything has the radiance e (1 + ρ + ρ² + …), to as many bounces as there
/// are.
#[test]
fn a_furnace_glows_evenly() {
    let (albedo, glow) = (0.5f64, 0.25);
    let scene = furnace(albedo as f32, glow as f32);
    for strategy in STRATEGIES {
        for depth in [0, 1, 2, 12] {
            let expected = glow * (1.0 - albedo.powi(depth + 1)) / (1.0 - albedo);
            let rays = || looking([0.0; 3], [0.1, 0.2, 1.0], 1.0, 8);
            let (found, within) = estimate(&scene, |seed| options(rays(), strategy, depth as u32, 16, seed));
            // Without a random decision, only rounding is left.
            let bound = within + 1e-5;
            assert!((found - expected).abs() < bound, "{strategy}, depth {depth}: {found} ± {within}, not {expected}");
            assert!(within < 0.02 * expected, "{strategy}, depth {depth}: ± {within}");
        }
    }
}

/// A floor at y = 0, and one point of it.
fn floor() -> ([[f32; 3]; 4], Material) {
    let corners = [[-50.0, 0.0, -50.0], [-50.0, 0.0, 50.0], [50.0, 0.0, 50.0], [50.0, 0.0, -50.0]];
    (corners, matte([0.5; 3], [0.0; 3]))
}

fn at_origin() -> RaySource {
    looking([3.0, 4.0, 0.0], [0.0; 3], 0.001, 1)
}

const BACKGROUND: [f64; 3] = [0.015, 0.018, 0.024];

/// Of the sky, which the path leads to if no light is picked for it.
fn sky(depth: u32) -> f64 {
    if depth == 0 { 0.0 } else { 0.5 * BACKGROUND.iter().sum::<f64>() / 3.0 }
}

#[test]
fn lights_have_the_illuminance_of_closed_forms() {
    let at = [1.0f32, 2.0, -0.5];
    let squared = 1.0 + 4.0 + 0.25f64;
    let cosine = 2.0 / squared.sqrt();
    let toward = at.map(|v| -v / squared.sqrt() as f32);
    for (light, illuminance) in [
        (Light::Point { position: at, color: [1.0; 3], intensity: 3.0 }, 3.0 * cosine / squared),
        (Light::Directional { direction: toward, color: [1.0; 3], intensity: 3.0 }, 3.0 * cosine),
        (
            Light::Spot {
                position: at,
                direction: toward,
                color: [1.0; 3],
                intensity: 3.0,
                inner_cone: 0.2,
                outer_cone: 0.4,
            },
            3.0 * cosine / squared,
        ),
    ] {
        let mut scene = of_quads(&[floor()]);
        scene.lights = vec![light.clone()];
        let expected = 0.5 / PI * illuminance;
        // The sky is seen by chance: one bounce leads to it, or, at depth 1, adds exactly its radiance.
        let found = mean(&scene, &options(at_origin(), Strategy::Mis, 1, 1, 0)) - sky(1);
        assert!((found / expected - 1.0).abs() < 1e-4, "{light:?}: {found}, not {expected}");
        assert_eq!(mean(&scene, &options(at_origin(), Strategy::Mis, 0, 1, 0)), 0.0);
    }
}

/// Lambert's formula (1760) for the irradiance by a polygon of constant radiance: the sum over its edges of the angle that
/// each takes, times the cosine of the edge's plane.
fn lambert(corners: &[DVec3], normal: DVec3) -> f64 {
    let around = |i: usize| {
        let (a, b) = (corners[i].normalize(), corners[(i + 1) % corners.len()].normalize());
        a.dot(b).acos() * a.cross(b).normalize().dot(normal)
    };
    (0..corners.len()).map(around).sum::<f64>().abs() / 2.0
}

#[test]
fn polygons_and_spheres_have_the_irradiance_of_closed_forms() {
    let square = [[-0.5, 2.0, -0.3], [0.7, 2.0, -0.3], [0.7, 1.5, 0.9], [-0.5, 1.5, 0.9f32]];
    let irradiance = lambert(&square.map(|p| glam::Vec3::from(p).as_dvec3()), DVec3::Y);
    let of_square = of_quads(&[floor(), (square, matte([0.0; 3], [2.0; 3]))]);
    // Above the horizon, a sphere of constant radiance has the irradiance π sin² of its angle, times the cosine.
    let mut of_sphere = of_quads(&[floor()]);
    let (center, radius) = (DVec3::new(0.5, 2.0, 0.3), 0.6);
    let ball = generate::icosphere(5).expect("a scene");
    let corners = ball
        .triangles
        .iter()
        .map(|t| t.map(|p| (glam::Vec3::from(p).as_dvec3() * radius + center).as_vec3().to_array()));
    of_sphere.triangles.extend(corners);
    of_sphere.triangle_materials.extend(ball.triangles.iter().map(|_| 1));
    of_sphere.materials.push(matte([0.0; 3], [2.0; 3]));
    let of_ball = PI * (radius * radius / center.length_squared()) * center.y / center.length();
    // Its 20,480 triangles cover 1.0003 to 0.9997 of the sphere's disc.
    for (name, scene, irradiance, off) in
        [("square", of_square, irradiance, 1e-4), ("sphere", of_sphere, of_ball, 2e-3)]
    {
        let expected = 0.5 / PI * 2.0 * irradiance;
        for strategy in STRATEGIES {
            let (lit, within) = estimate(&scene, |seed| options(at_origin(), strategy, 1, 256, seed));
            // What the light covers of the sky is not seen, the rest is by chance.
            let most = sky(1);
            let shade = lambert_share(irradiance) * most;
            let found = lit - (most - shade);
            let bound = within + off * expected;
            assert!((found - expected).abs() < bound, "{name} by {strategy}: {found} ± {within}, not {expected}");
        }
    }
}

/// The share of a cosine-weighted hemisphere that has this irradiance by radiance 1.
fn lambert_share(irradiance: f64) -> f64 {
    irradiance / PI
}

/// Rooms with lamps of several sizes, glass and a mirror: all strategies have the same mean.
#[test]
fn strategies_agree_with_each_other() {
    let mut room = generate::cornell_box();
    room.lights.clear();
    room.materials.push(matte([0.2; 3], [6.0, 5.0, 4.0]));
    room.materials.push(matte([0.2; 3], [0.0, 1.0, 2.0]));
    let lamps = [
        [[-0.3, 0.98, -0.3], [0.3, 0.98, -0.3], [0.3, 0.98, 0.3], [-0.3, 0.98, 0.3]],
        [[0.95, -0.5, 0.0], [0.95, -0.5, 0.8], [0.95, 0.3, 0.8], [0.95, 0.3, 0.0]],
    ];
    for (lamp, corners) in (3..).zip(lamps) {
        room.triangles.extend(quad(corners));
        room.triangle_materials.extend([lamp; 2]);
    }
    let mut of_glass = room.clone();
    of_glass.materials[0].optics = Optics::Diffuse;
    of_glass.materials[1].optics = Optics::Mirror;
    of_glass.materials[2].optics = Optics::Dielectric { ior: 1.5, is_thin: true };
    for (name, scene) in [("room", room), ("glass", of_glass)] {
        let estimates = STRATEGIES.map(|strategy| {
            let rays = || looking([0.0, 0.0, 3.3], [0.0; 3], 0.75, 16);
            estimate(&scene, |seed| options(rays(), strategy, 6, 16, seed))
        });
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            let (a, b) = (estimates[i], estimates[j]);
            // 99% intervals of three pairs: each is one of 99.7%, as 1.2 of one of 99%.
            let within = 1.2 * a.1.hypot(b.1);
            assert!((a.0 - b.0).abs() < within, "{name}: {estimates:?}");
            assert!(within < 0.05 * a.0, "{name}: {estimates:?}");
        }
    }
}

/// The picture does not depend on the structure or schedule, and the camera's ray and hit are put back.
#[test]
fn every_structure_and_schedule_follows_the_same_paths() {
    let mut scene = generate::whitted(1).expect("a scene");
    scene.materials[0].emissive = [0.25, 0.5, 0.0];
    let rays = looking([0.0, 1.6, 5.2], [0.1, 0.85, 0.0], 0.7, 16);
    let base = options(rays, Strategy::Mis, 5, 2, 3);
    let mut first: Option<[StreamData; 3]> = None;
    let local = Options { integrator: Integrator::Local, max_depth: crate::options::MAX_DEPTH, ..base.clone() };
    let [of_camera] = values(&scene, &local, [HIT]);
    for accelerator in [Accelerator::None, Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh] {
        for (schedule, steps_per_pass) in
            [(ScheduleKind::Second, 1), (ScheduleKind::Compact, 8), (ScheduleKind::Fused, 8)]
        {
            if accelerator == Accelerator::None && steps_per_pass == 1 {
                continue;
            }
            let options = Options { accelerator, schedule, steps_per_pass, ..base.clone() };
            let found = values(&scene, &options, [COLOR, HIT, RAY_DIRECTION]);
            assert!(found[1] == of_camera, "{accelerator} {schedule}");
            let first = first.get_or_insert_with(|| found.clone());
            assert!(*first == found, "{accelerator} {schedule}");
        }
    }
}

/// Without anything that gives light, the sky is white: a convex white floor under it is white, too.
#[test]
fn without_light_the_sky_is_white() {
    let mut scene = of_quads(&[floor()]);
    scene.materials[0].base_color = [1.0; 3];
    assert!((mean(&scene, &options(at_origin(), Strategy::Mis, 1, 4, 0)) - 1.0).abs() < 1e-6);
}

/// Every pixel's light tree adds up to its colour.
#[test]
fn light_trees_add_up_to_the_picture() {
    let mut scene = generate::whitted(1).expect("a scene");
    scene.materials[0].emissive = [0.25, 0.5, 0.0];
    for (strategy, count) in [(Strategy::Mis, 1), (Strategy::Light, 2)] {
        let rays = looking([0.0, 1.6, 5.2], [0.1, 0.85, 0.0], 0.7, 12);
        let base = options(rays, strategy, 5, count, 3);
        let options = Options { schedule: ScheduleKind::Compact, ..base };
        let (plan, data) = Plan::new(&scene, &options, &Limits::CPU).expect("a plan");
        let run = RunSoFar { plan: &plan, data: &data, passes: &[], is_complete: false };
        let mut kinds = [0; 4];
        for pixel in (0..144).map(|i| [i % 12, i / 12]) {
            let life = run.follow::<f32>(pixel).expect("a ray");
            let tree = LightTree::of(&life.rows, plan.program, &data).expect("a tree");
            let color = life.rows.last().and_then(|row| row.after.color).expect("a finished ray");
            for (sum, color) in tree.sum().into_iter().zip(color) {
                // Each vertex adds one rounding of the sum so far.
                assert!((sum - f64::from(color)).abs() < 1e-5 * sum.max(1.0), "{pixel:?}: {sum} {color} {tree:#?}");
            }
            for vertex in &tree.vertices {
                kinds[vertex.kind as usize] += 1;
                assert!(vertex.ended.is_some() && !vertex.why.is_empty(), "{tree:#?}");
            }
        }
        assert!(kinds.iter().all(|&vertices| vertices > 50), "{kinds:?}");
    }
}
