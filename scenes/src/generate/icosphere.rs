//! A closed sphere.

use super::draft::{Attributes, add, camera, check, draft, lamp, matte};
use super::{GenerateError, Parameter};
use crate::Scene;
use glam::{DVec3, Vec3};

pub(super) const SUBDIVISIONS: Parameter = Parameter {
    name: "subdivisions",
    summary: "how often every triangle is cut in four: 20 * 4^N triangles",
    default: 4,
    range: 0..=11,
};

/// A unit sphere around the origin: an icosahedron whose triangles are split in four `subdivisions` times, with the new
/// vertices moved onto the sphere. 20·4^`subdivisions` triangles, all facing outward, smooth normals.
///
/// Watertight: a vertex has the same bits in each of its triangles.
///
/// # Errors
/// More than 11 subdivisions.
pub fn icosphere(subdivisions: u64) -> Result<Scene, GenerateError> {
    const NAME: &str = "icosphere";
    check(NAME, &SUBDIVISIONS, subdivisions)?;
    let attributes = Attributes { normals: true, colors: false };
    let mut scene = draft(NAME, triangles(subdivisions), attributes, vec![matte("sphere", [0.62, 0.68, 0.75])])?;
    sphere(subdivisions, |corners| add(&mut scene, 0, corners, corners));
    scene.lights =
        vec![lamp([2.5, 3.0, 4.0], [1.0, 0.96, 0.9], 30.0), lamp([-4.0, -0.5, 1.5], [0.12, 0.16, 0.25], 20.0)];
    scene.cameras = camera("camera", DVec3::new(0.0, 0.6, 3.6), DVec3::ZERO, 38.0).into_iter().collect();
    Ok(scene)
}

/// The number of triangles of [`sphere`].
pub(super) fn triangles(subdivisions: u64) -> u64 {
    u32::try_from(2 * subdivisions).ok().and_then(|s| 20u64.checked_shl(s)).unwrap_or(u64::MAX)
}

/// Adds a ball to a draft with normals.
pub(super) fn ball(scene: &mut Scene, material: u32, subdivisions: u64, center: Vec3, radius: f32) {
    sphere(subdivisions, |corners| {
        add(scene, material, corners.map(|corner| center + corner * radius), corners);
    });
}

/// Calls `each` with every triangle, counter-clockwise from outside.
pub(super) fn sphere(subdivisions: u64, mut each: impl FnMut([Vec3; 3])) {
    // The icosahedron's vertices are the vertices of three golden rectangles.
    let golden = f32::midpoint(1.0, 5f32.sqrt());
    let corner = |i: usize| {
        let long = if i & 1 == 0 { golden } else { -golden };
        let short = if i & 2 == 0 { 1.0 } else { -1.0 };
        match i >> 2 {
            0 => Vec3::new(0.0, short, long),
            1 => Vec3::new(short, long, 0.0),
            _ => Vec3::new(long, 0.0, short),
        }
        .normalize()
    };
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                let t = [a, b, c].map(corner);
                // An icosahedron's edge is 1.05 radii long and other vertices are at least 1.7 apart: three mutual
                // neighbours form a face.
                if (0..3).all(|k| t[k].distance_squared(t[(k + 1) % 3]) < 1.5) {
                    let outward = (t[1] - t[0]).cross(t[2] - t[0]).dot(t[0]) > 0.0;
                    divide(if outward { t } else { [t[0], t[2], t[1]] }, subdivisions, &mut each);
                }
            }
        }
    }
}

fn divide([a, b, c]: [Vec3; 3], times: u64, each: &mut impl FnMut([Vec3; 3])) {
    if times == 0 {
        return each([a, b, c]);
    }
    // a + b and b + a have the same bits, so the two triangles at an edge agree on its midpoint without a table of
    // edges.
    let [ab, bc, ca] = [a + b, b + c, c + a].map(Vec3::normalize);
    for t in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
        divide(t, times - 1, each);
    }
}
