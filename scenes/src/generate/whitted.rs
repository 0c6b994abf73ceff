//! A glass ball and a mirror over a checkered floor, after the picture of Whitted (1980).

use super::draft::{Attributes, add, camera, check, draft, lamp, matte, specular};
use super::icosphere::ball;
use super::{GenerateError, Parameter};
use crate::{Optics, Scene};
use glam::{DVec3, Vec3};

pub(super) const SUBDIVISIONS: Parameter = Parameter {
    name: "subdivisions",
    summary: "how often every triangle of a ball is cut in four: 20 * 4^N triangles each",
    default: 3,
    range: 0..=10,
};

/// Tiles along a side of the floor.
const TILES: u64 = 12;
/// Each ball: its material, centre and radius.
const BALLS: [(u32, Vec3, f32); 2] = [(2, Vec3::new(-0.45, 1.2, 1.1), 0.7), (3, Vec3::new(0.75, 0.95, -0.55), 0.9)];

/// A ball of glass in front of one that is a mirror, over a floor of red and yellow tiles, under one lamp.
///
/// # Errors
/// More than 10 subdivisions.
pub fn whitted(subdivisions: u64) -> Result<Scene, GenerateError> {
    const NAME: &str = "whitted";
    check(NAME, &SUBDIVISIONS, subdivisions)?;
    let materials = vec![
        matte("yellow", [0.8, 0.7, 0.1]),
        matte("red", [0.7, 0.06, 0.04]),
        specular("glass", [0.97, 0.99, 0.98], Optics::Dielectric { ior: 1.5, is_thin: false }),
        specular("mirror", [0.8, 0.82, 0.85], Optics::Mirror),
    ];
    let count = 2 * TILES * TILES + 2 * super::icosphere::triangles(subdivisions);
    let mut scene = draft(NAME, count, Attributes { normals: true, colors: false }, materials)?;
    let at = |i: u64| i as f32 - 0.5 * TILES as f32;
    let tiles = || (0..TILES).flat_map(|i| (0..TILES).map(move |j| (i, j)));
    for material in [0, 1] {
        for (i, j) in tiles().filter(|(i, j)| (i + j) % 2 == u64::from(material)) {
            let corner = |x, z| Vec3::new(at(x), 0.0, at(z) - 2.0);
            let [a, b, c, d] = [corner(i, j), corner(i, j + 1), corner(i + 1, j + 1), corner(i + 1, j)];
            add(&mut scene, material, [a, b, c], [Vec3::Y; 3]);
            add(&mut scene, material, [a, c, d], [Vec3::Y; 3]);
        }
    }
    for (material, center, radius) in BALLS {
        ball(&mut scene, material, subdivisions, center, radius);
    }
    scene.lights = vec![lamp([2.5, 6.0, 4.0], [1.0, 0.98, 0.92], 40.0)];
    let (eye, target) = (DVec3::new(0.0, 1.6, 5.2), DVec3::new(0.1, 0.85, 0.0));
    scene.cameras = camera("camera", eye, target, 42.0).into_iter().collect();
    Ok(scene)
}
