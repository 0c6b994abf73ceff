//! Scenes and rays of the families of light.

use std::f64::consts::PI;

use glam::DVec3;
use raystep_scenes::{Light, Material, Optics, Scene};

use crate::Error;
use crate::rays::Random;
use crate::stability::Workload;
use crate::stability::make::{drawn, given, quad, scene_of, sphere, towards};

use super::scenes::{on_surface, squares};

type Made = Result<Workload, Error>;

/// The normal of the plane x = z, on the side from which rays come.
const UP: DVec3 = DVec3::new(-std::f64::consts::FRAC_1_SQRT_2, 0.0, std::f64::consts::FRAC_1_SQRT_2);
/// In the plane.
const ALONG: DVec3 = DVec3::new(std::f64::consts::FRAC_1_SQRT_2, 0.0, std::f64::consts::FRAC_1_SQRT_2);
/// A point of the plane, in no corner of its squares.
const FOOT: DVec3 = DVec3::new(0.637, 0.341, 0.637);
const RADIUS: f64 = 0.15;

/// A plane of 5,000 triangles, and a sphere of 320 on it.
fn stage() -> Result<Scene, Error> {
    let mut triangles = squares();
    let centre = DVec3::new(0.45, 0.55, 0.45) + UP * RADIUS;
    triangles.extend(sphere(2, |p| p * RADIUS + centre)?.triangles);
    Ok(scene_of(triangles))
}

/// Rays from above to points of the stage, with these lights.
fn under(lights: Vec<Light>, count: usize, seed: u32) -> Made {
    Ok(from_above(Scene { lights, ..stage()? }, count, seed))
}

fn from_above(scene: Scene, count: usize, seed: u32) -> Workload {
    let rays = drawn(count, seed, |_, random: &mut Random| {
        let target = on_surface(&scene, random);
        let aside = ALONG * (random.unit() - 0.5) + DVec3::Y * (random.unit() - 0.5);
        towards(target, target + UP * (0.5 + random.unit()) + aside)
    });
    given(scene, rays)
}

fn point(position: DVec3, brightness: f64) -> Light {
    let color = [1.0, 1.0, 1.0].map(|of: f64| (of * brightness) as f32);
    Light::Point { position: position.as_vec3().to_array(), color, intensity: 1.0 }
}

/// A light above a point of the plane.
pub(super) fn distance(distance: f64, count: usize, seed: u32) -> Made {
    under(vec![point(FOOT + UP * distance, 1.0)], count, seed)
}

/// The bright one from one side of the sphere, the dim one from another.
pub(super) fn ratio(ratio: f64, count: usize, seed: u32) -> Made {
    let [bright, dim] = [ALONG, DVec3::Y].map(|aside| FOOT + UP * 0.8 + aside * 0.7);
    under(vec![point(bright, ratio.sqrt()), point(dim, 1.0 / ratio.sqrt())], count, seed)
}

/// Lights evenly around the middle of the plane, by a spiral of the golden angle.
pub(super) fn many(lights: f64, count: usize, seed: u32) -> Made {
    let light = |i: u32| {
        let (up, around) =
            (1.0 - (2.0 * f64::from(i) + 1.0) / lights.max(2.0), f64::from(i) * PI * (3.0 - 5f64.sqrt()));
        let flat = (1.0 - up * up).max(0.0).sqrt();
        let away = UP * up + (ALONG * around.cos() + DVec3::Y * around.sin()) * flat;
        point(DVec3::splat(0.5) + away * 2.0, 1.0 / lights)
    };
    under((0..lights as u32).map(light).collect(), count, seed)
}

/// Directional light, neither along an edge of the squares nor along a diagonal.
pub(super) fn grazing(inverse_sine: f64, count: usize, seed: u32) -> Made {
    let (sine, cosine) = (1.0 / inverse_sine, (1.0 - inverse_sine.powi(-2)).max(0.0).sqrt());
    let aside = (ALONG * 0.8 + DVec3::Y * 0.6) * cosine;
    let direction = (aside - UP * sine).as_vec3().to_array();
    under(vec![Light::Directional { direction, color: [1.0; 3], intensity: 1.0 }], count, seed)
}

fn glowing(radiance: f64) -> Material {
    Material { base_color: [0.0; 3], emissive: [radiance as f32; 3], double_sided: true, ..Material::default() }
}

/// Inside a sphere, between it and a mirror: directions diverge at each bounce off the ball.
pub(super) fn depth(_bounces: f64, count: usize, seed: u32) -> Made {
    const GLOW: usize = 8;
    let mut scene = sphere(3, |p| p)?;
    let around = scene.triangles.len();
    scene.triangles.extend(sphere(2, |p| p * 0.4 + ALONG * 0.1)?.triangles);
    let bright = Material { base_color: [0.9; 3], ..Material::default() };
    let mirror = Material { optics: Optics::Mirror, ..bright.clone() };
    scene.materials = vec![bright, glowing(20.0), mirror];
    let material = |i: usize| if i < GLOW { 1 } else { 2 * u32::from(i >= around) };
    scene.triangle_materials = (0..scene.triangles.len()).map(material).collect();
    let rays = drawn(count, seed, |_, random: &mut Random| {
        let origin = random.on_sphere() * 0.7;
        towards(on_surface(&scene, random), origin)
    });
    Ok(given(scene, rays))
}

/// One lamp as large as the plane, and one whose side is shorter by the parameter.
pub(super) fn pdfs(ratio: f64, count: usize, seed: u32) -> Made {
    let mut scene = stage()?;
    let lamp = |center: DVec3, side: f64| {
        let corner = |[x, y]: [f64; 2]| (center + (ALONG * x + DVec3::Y * y) * (0.5 * side)).as_vec3().to_array();
        quad([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(corner))
    };
    // Above where rays begin.
    for (aside, side) in [(0.7, 1.0), (-0.7, 1.0 / ratio)] {
        scene.triangle_materials.extend([scene.materials.len() as u32; 2]);
        scene.materials.push(glowing(side.powi(-2)));
        scene.triangles.extend(lamp(FOOT + UP * 2.5 + ALONG * aside, side));
    }
    Ok(from_above(scene, count, seed))
}
