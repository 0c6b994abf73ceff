//! Scenes with caustics: those of Purcell, Donner, Cammarano, Jensen and Hanrahan, *Photon Mapping on Programmable
//! Graphics Hardware* (2003), from descriptions. Each has a small surface that glows, so that paths find its light as well.

use super::cornell::cornell_lamp;
use super::draft::{Attributes, add, camera, check, draft, matte, specular};
use super::icosphere::{ball, triangles};
use super::{GenerateError, Parameter};
use crate::{Material, Optics, Scene};
use glam::{DVec3, Vec3};
use std::f32::consts::TAU;

pub(super) use super::whitted::SUBDIVISIONS;

pub(super) const SIDES: Parameter =
    Parameter { name: "sides", summary: "sides of the ring: 2 triangles each", default: 128, range: 3..=1_000_000 };

const ALL: Attributes = Attributes { normals: true, colors: false };
/// What the lamps of the open scenes emit, and half the side of their squares.
const RADIANCE: f32 = 120.0;
const HALF_LAMP: f32 = 0.1;

fn glass() -> Material {
    specular("glass", [1.0; 3], Optics::Dielectric { ior: 1.5, is_thin: false })
}

/// A square around a point that faces along `normal`, whose length is 1.
fn square(scene: &mut Scene, material: u32, center: Vec3, normal: Vec3, half: f32) {
    let across = if normal.y.abs() < 1.0 { Vec3::Y.cross(normal).normalize() } else { Vec3::X } * half;
    let up = normal.cross(across);
    let [a, b, c, d] = [-across - up, across - up, across + up, up - across].map(|corner| center + corner);
    add(scene, material, [a, b, c], [normal; 3]);
    add(scene, material, [a, c, d], [normal; 3]);
}

/// A white floor, with room for `more` triangles of material 1, and then for a lamp, whose material is 2.
fn over_a_floor(name: &'static str, more: u64, of: Material) -> Result<Scene, GenerateError> {
    let lamp = Material { emissive: [RADIANCE; 3], ..matte("lamp", [0.0; 3]) };
    let mut scene = draft(name, more + 4, ALL, vec![matte("floor", [0.7, 0.7, 0.7]), of, lamp])?;
    square(&mut scene, 0, Vec3::ZERO, Vec3::Y, 1.5);
    scene.cameras = camera("camera", DVec3::new(0.0, 2.4, 2.4), DVec3::new(0.0, 0.15, 0.0), 42.0).into_iter().collect();
    Ok(scene)
}

/// Adds the lamp of such a scene, which faces `target`.
fn lit(mut scene: Scene, from: Vec3, target: Vec3) -> Scene {
    square(&mut scene, 2, from, (target - from).normalize(), HALF_LAMP);
    scene
}

/// A ball of glass above a white floor, under a small lamp: it focuses the light to a spot within its shadow.
///
/// # Errors
/// More than 10 subdivisions.
pub fn glass_ball(subdivisions: u64) -> Result<Scene, GenerateError> {
    const NAME: &str = "glass-ball";
    const CENTER: Vec3 = Vec3::new(0.0, 0.65, 0.0);
    check(NAME, &SUBDIVISIONS, subdivisions)?;
    let mut scene = over_a_floor(NAME, triangles(subdivisions), glass())?;
    ball(&mut scene, 1, subdivisions, CENTER, 0.5);
    Ok(lit(scene, Vec3::new(-0.7, 2.2, -0.5), CENTER))
}

/// A ring of metal, an open cylinder that is a mirror, on a white floor beside a small lamp: its inside gathers the light
/// in a curve with a cusp.
///
/// # Errors
/// Fewer than 3 sides, or too many.
pub fn ring(sides: u64) -> Result<Scene, GenerateError> {
    const NAME: &str = "ring";
    const RADIUS: f32 = 0.8;
    const HEIGHT: f32 = 0.35;
    check(NAME, &SIDES, sides)?;
    let mut scene = over_a_floor(NAME, 2 * sides, specular("metal", [0.95, 0.8, 0.5], Optics::Mirror))?;
    // The last side ends where the first begins, bit for bit.
    let outward = |side: u64| {
        let (sin, cos) = (TAU * ((side % sides) as f32 / sides as f32)).sin_cos();
        Vec3::new(cos, 0.0, sin)
    };
    for side in 0..sides {
        let [m, n] = [outward(side), outward(side + 1)];
        let [a, b] = [m * RADIUS, n * RADIUS];
        let top = Vec3::Y * HEIGHT;
        add(&mut scene, 1, [a, a + top, b + top], [m, m, n]);
        add(&mut scene, 1, [a, b + top, b], [m, n, n]);
    }
    Ok(lit(scene, Vec3::new(-1.4, 1.3, 1.1), Vec3::ZERO))
}

/// The Cornell box with its lamp, and with a ball that is a mirror and one of glass instead of the blocks.
///
/// # Errors
/// More than 10 subdivisions.
pub fn cornell_balls(subdivisions: u64) -> Result<Scene, GenerateError> {
    const NAME: &str = "cornell-balls";
    check(NAME, &SUBDIVISIONS, subdivisions)?;
    let room = cornell_lamp();
    let first = room.materials.len() as u32;
    let optics = [specular("mirror", [0.95; 3], Optics::Mirror), glass()];
    let materials = room.materials.into_iter().chain(optics).collect();
    let mut scene = draft(NAME, 12 + 2 * triangles(subdivisions), ALL, materials)?;
    for (i, (corners, material)) in room.triangles.into_iter().zip(room.triangle_materials).enumerate() {
        // The blocks come after floor, ceiling and back.
        if !(6..22).contains(&i) {
            let [a, b, c] = corners.map(Vec3::from);
            add(&mut scene, material, [a, b, c], [(b - a).cross(c - a).normalize(); 3]);
        }
    }
    ball(&mut scene, first, subdivisions, Vec3::new(-0.42, -0.62, -0.35), 0.36);
    ball(&mut scene, first + 1, subdivisions, Vec3::new(0.42, -0.62, 0.3), 0.36);
    scene.cameras = room.cameras;
    Ok(scene)
}
