//! Unordered triangles.

use super::draft::{Attributes, camera, check, draft, lamp, matte, sun};
use super::random::Random;
use super::{GenerateError, MAX_TRIANGLES, Parameter};
use crate::{Material, Scene};
use glam::{DVec3, Vec3};

pub(super) const TRIANGLES: Parameter = Parameter {
    name: "triangles",
    summary: "how many, exactly; their size goes with 1 / cube root of it",
    default: 10_000,
    range: 1..=MAX_TRIANGLES,
};

const COLORS: [[f32; 3]; 6] = [
    [0.80, 0.22, 0.16],
    [0.90, 0.60, 0.15],
    [0.85, 0.80, 0.62],
    [0.25, 0.55, 0.42],
    [0.16, 0.36, 0.62],
    [0.46, 0.28, 0.55],
];

/// `triangles` small triangles in the unit cube, with uniformly distributed centres and vertices uniformly distributed
/// in a box of side 1.5 · `triangles`^(−1/3) around them: the overlap does not depend on their number. Flat shaded,
/// double-sided, in six colours.
///
/// # Errors
/// Zero triangles, or more than [`MAX_TRIANGLES`].
pub fn soup(triangles: u64, seed: u64) -> Result<Scene, GenerateError> {
    const NAME: &str = "soup";
    check(NAME, &TRIANGLES, triangles)?;
    let materials: Vec<_> = COLORS
        .iter()
        .enumerate()
        .map(|(i, &c)| Material { double_sided: true, ..matte(&format!("colour {i}"), c) })
        .collect();
    let colors = materials.len() as u64;
    let mut scene = draft(NAME, triangles, Attributes { normals: false, colors: false }, materials)?;
    let mut random = Random::new(seed);
    let half = (0.75 / cube_root(triangles as f64)).min(0.35) as f32;
    for i in 0..triangles {
        // Triangles of one colour are contiguous, so that a file keeps the order of the ids; since positions are
        // random, this is not visible.
        scene.triangle_materials.push((i * colors / triangles) as u32);
        let center = Vec3::splat(0.5) + random.signed3() * (0.5 - half);
        scene.triangles.push([(); 3].map(|()| (center + random.signed3() * half).to_array()));
    }
    scene.lights = vec![lamp([0.9, 2.2, 2.4], [1.0, 0.97, 0.92], 8.0), sun(Vec3::new(1.0, -0.2, -0.4), [0.25; 3])];
    scene.cameras =
        camera("camera", DVec3::new(1.35, 1.15, 2.3), DVec3::new(0.5, 0.46, 0.5), 40.0).into_iter().collect();
    Ok(scene)
}

/// Newton's method: `cbrt` is a library function whose last bit may differ.
fn cube_root(x: f64) -> f64 {
    let mut root = x.max(1.0);
    for _ in 0..200 {
        root -= (root - x / (root * root)) / 3.0;
    }
    root
}
