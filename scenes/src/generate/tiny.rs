//! The teapot in the stadium.

use super::draft::{Attributes, camera, check, draft, lamp, matte};
use super::{GenerateError, MAX_TRIANGLES, Parameter};
use crate::Scene;
use glam::{DVec3, Vec3};
use std::f32::consts::TAU;

const NAME: &str = "tiny-in-room";

pub(super) const TRIANGLES: Parameter = Parameter {
    name: "triangles",
    summary: "how many the object has, at most; the room adds 12",
    default: 20_000,
    range: 18..=MAX_TRIANGLES - 12,
};

pub(super) const RATIO: Parameter = Parameter {
    name: "ratio",
    summary: "how many times larger than the object the room is",
    default: 500,
    range: 4..=1_000_000,
};

/// A torus knot two units wide, closed and smooth, of at most `triangles` triangles, on the floor in the middle of a
/// room with sides `ratio` times as long: the "teapot in a stadium" (Haines, Ray Tracing News 1988), a bad case for a
/// uniform grid because it falls into a few cells. With the defaults, an edge of the knot is about 1e-5 of the room.
/// The first camera sees the knot, the second the room.
///
/// # Errors
/// A parameter out of its range.
pub fn tiny_in_room(triangles: u64, ratio: u64) -> Result<Scene, GenerateError> {
    check(NAME, &TRIANGLES, triangles)?;
    check(NAME, &RATIO, ratio)?;
    let (around, along) = facets(triangles);
    let materials = vec![
        matte("knot", [0.78, 0.42, 0.14]),
        matte("floor", [0.42, 0.45, 0.42]),
        matte("ceiling", [0.65, 0.65, 0.62]),
        matte("wall", [0.30, 0.38, 0.50]),
    ];
    let mut scene = draft(NAME, 2 * around * along + 12, Attributes { normals: true, colors: false }, materials)?;
    let mut normals = scene.normals.take().unwrap_or_default();
    let tube = Tube { around, along };
    for i in 0..along {
        for k in 0..around {
            let [a, b, c, d] = [(i, k), (i + 1, k), (i + 1, k + 1), (i, k + 1)].map(|(i, k)| tube.corner(i, k));
            for t in [[a, b, c], [a, c, d]] {
                scene.triangles.push(t.map(|(p, _)| p.to_array()));
                normals.push(t.map(|(_, n)| n.to_array()));
                scene.triangle_materials.push(0);
            }
        }
    }
    let half = ratio as f32;
    room(half, |t, normal, material| {
        scene.triangles.push(t);
        normals.push([normal; 3]);
        scene.triangle_materials.push(material);
    });
    scene.normals = Some(normals);
    let far = f64::from(half);
    scene.lights = vec![
        lamp([3.0, 5.0, 4.0], [0.85, 0.82, 0.78], 50.0),
        lamp([-0.3 * half, 0.8 * half, 0.4 * half], [0.3, 0.32, 0.36], half * half),
    ];
    scene.cameras = [
        camera("at the knot", DVec3::new(0.9, 2.0, 4.4), DVec3::new(0.0, 0.75, 0.0), 38.0),
        camera("the whole room", DVec3::new(0.0, far * 0.5, far * 0.98), DVec3::new(0.0, far * 0.3, 0.0), 60.0),
    ]
    .into_iter()
    .flatten()
    .collect();
    Ok(scene)
}

/// Numbers of facets around and along the tube, in a ratio of about 1 to 8, with at most `triangles` triangles.
fn facets(triangles: u64) -> (u64, u64) {
    let around = (triangles / 16).isqrt().max(3);
    (around, (triangles / (2 * around)).max(3))
}

struct Tube {
    around: u64,
    along: u64,
}

impl Tube {
    /// Position and normal of vertex `k` around and `i` along; both wrap to the bits of 0.
    fn corner(&self, i: u64, k: u64) -> (Vec3, Vec3) {
        let turn = |n: u64, of: u64| (n % of) as f32 / of as f32 * TAU;
        let (t, around) = (turn(i, self.along), turn(k, self.around));
        // The trefoil on a torus; its tangent is the derivative, and the tube's frame is based on the axis of the
        // torus, so it closes without a twist.
        let (r, tube) = (0.62, 0.2);
        let (s3, c3) = (3.0 * t).sin_cos();
        let (s2, c2) = (2.0 * t).sin_cos();
        let reach = r + 0.24 * c3;
        let center = Vec3::new(reach * c2, 0.24 * s3 + 0.5, reach * s2);
        let tangent =
            Vec3::new(-0.72 * s3 * c2 - 2.0 * reach * s2, 0.72 * c3, -0.72 * s3 * s2 + 2.0 * reach * c2).normalize();
        let side = tangent.cross(Vec3::new(c2 * c3, s3, s2 * c3)).normalize();
        let up = side.cross(tangent);
        let (sin, cos) = around.sin_cos();
        let normal = side * cos + up * sin;
        (center + normal * tube, normal)
    }
}

/// A cube from the floor at y = 0, `2·half` wide, visible from inside.
fn room(half: f32, mut each: impl FnMut([[f32; 3]; 3], [f32; 3], u32)) {
    let (l, h, top) = (-half, half, half * 2.0);
    let mut quad = |material, normal, [a, b, c, d]: [[f32; 3]; 4]| {
        each([a, b, c], normal, material);
        each([a, c, d], normal, material);
    };
    quad(1, [0.0, 1.0, 0.0], [[l, 0.0, h], [h, 0.0, h], [h, 0.0, l], [l, 0.0, l]]);
    quad(2, [0.0, -1.0, 0.0], [[l, top, l], [h, top, l], [h, top, h], [l, top, h]]);
    quad(3, [0.0, 0.0, 1.0], [[l, 0.0, l], [h, 0.0, l], [h, top, l], [l, top, l]]);
    quad(3, [0.0, 0.0, -1.0], [[h, 0.0, h], [l, 0.0, h], [l, top, h], [h, top, h]]);
    quad(3, [1.0, 0.0, 0.0], [[l, 0.0, h], [l, 0.0, l], [l, top, l], [l, top, h]]);
    quad(3, [-1.0, 0.0, 0.0], [[h, 0.0, l], [h, 0.0, h], [h, top, h], [h, top, l]]);
}
