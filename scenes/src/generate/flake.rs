//! Spheres on spheres.

use super::draft::{Attributes, camera, check, draft, lamp, matte, sun};
use super::icosphere::{sphere, triangles};
use super::{GenerateError, Parameter};
use crate::{Material, Scene};
use glam::{DVec3, Quat, Vec3};

const NAME: &str = "sphere-flake";

pub(super) const DEPTH: Parameter = Parameter {
    name: "depth",
    summary: "how often spheres carry smaller ones: 10 spheres at 1, 91 at 2, 820 at 3",
    default: 3,
    range: 0..=6,
};

pub(super) const SUBDIVISIONS: Parameter = Parameter {
    name: "subdivisions",
    summary: "how fine a sphere is: 20 * 4^N triangles each",
    default: 2,
    range: 0..=8,
};

const COLORS: [[f32; 3]; 7] = [
    [0.75, 0.62, 0.35],
    [0.70, 0.30, 0.18],
    [0.20, 0.45, 0.50],
    [0.80, 0.72, 0.55],
    [0.35, 0.20, 0.42],
    [0.30, 0.55, 0.25],
    [0.80, 0.80, 0.80],
];

/// The sphere flake of Haines, "A Proposal for Standard Graphics Environments", 1987: a sphere surrounded by nine
/// spheres with a third of its radius, and so on `depth` times; six are around the equator, three around the pole away
/// from the parent. Every sphere is an icosphere with smooth normals; each generation has its own colour.
///
/// # Errors
/// A parameter out of its range, or more than [`MAX_TRIANGLES`](super::MAX_TRIANGLES) together.
pub fn sphere_flake(depth: u64, subdivisions: u64) -> Result<Scene, GenerateError> {
    check(NAME, &DEPTH, depth)?;
    check(NAME, &SUBDIVISIONS, subdivisions)?;
    let spheres = (9u64.pow(depth as u32 + 1) - 1) / 8;
    let count = spheres * triangles(subdivisions);
    let materials: Vec<Material> = COLORS
        .iter()
        .take(depth as usize + 1)
        .enumerate()
        .map(|(i, &c)| matte(&format!("generation {i}"), c))
        .collect();
    let mut scene = draft(NAME, count, Attributes { normals: true, colors: false }, materials)?;
    let mut normals = scene.normals.take().unwrap_or_default();
    let mut unit = Vec::new();
    sphere(subdivisions, |t| unit.push(t));

    // One generation after the other, so that triangles of one material are contiguous.
    let mut generation = vec![Ball { center: Vec3::ZERO, radius: 1.0, away: Quat::IDENTITY }];
    for level in 0..=depth {
        for ball in &generation {
            for t in &unit {
                scene.triangles.push(t.map(|n| (ball.center + n * ball.radius).to_array()));
                normals.push(t.map(<[f32; 3]>::from));
                scene.triangle_materials.push(level as u32);
            }
        }
        if level < depth {
            generation = generation.iter().flat_map(Ball::children).collect();
        }
    }
    scene.normals = Some(normals);
    scene.lights =
        vec![lamp([4.0, 5.0, 5.0], [1.0, 0.95, 0.86], 60.0), sun(Vec3::new(1.0, 0.3, -0.6), [0.10, 0.14, 0.24])];
    scene.cameras = camera("camera", DVec3::new(1.9, 2.3, 4.4), DVec3::new(0.0, 0.12, 0.0), 36.0).into_iter().collect();
    Ok(scene)
}

struct Ball {
    center: Vec3,
    radius: f32,
    /// Rotates +Y to the direction away from the parent.
    away: Quat,
}

impl Ball {
    fn children(&self) -> [Self; 9] {
        std::array::from_fn(|i| {
            // Six on the equator, then three at 55 degrees above it, rotated by half a step.
            let (turn, rise) = if i < 6 { (i as f32 * 60.0, 0.0) } else { (i as f32 * 120.0 + 30.0, 55.0) };
            let (sin_turn, cos_turn) = turn.to_radians().sin_cos();
            let (sin_rise, cos_rise) = f32::to_radians(rise).sin_cos();
            let out = self.away * Vec3::new(cos_rise * cos_turn, sin_rise, cos_rise * sin_turn);
            let radius = self.radius / 3.0;
            let away = Quat::from_rotation_arc(Vec3::Y, out.normalize());
            Self { center: self.center + out * (self.radius + radius), radius, away }
        })
    }
}
