//! Long thin triangles.

use super::draft::{Attributes, camera, check, draft, lamp, matte, sun};
use super::icosphere::sphere;
use super::random::Random;
use super::{GenerateError, MAX_TRIANGLES, Parameter};
use crate::{Material, Scene};
use glam::{DVec3, Vec3};

const NAME: &str = "hair";
/// Segments of a strand; the last ends in a point, so a strand has 2·8 − 1 triangles.
const PIECES: usize = 8;
const PER_STRAND: u64 = 2 * PIECES as u64 - 1;
const SCALP_SUBDIVISIONS: u64 = 4;
const SCALP_TRIANGLES: u64 = 20 << (2 * SCALP_SUBDIVISIONS);

pub(super) const STRANDS: Parameter = Parameter {
    name: "strands",
    summary: "how many hairs, 15 triangles each, on a ball of 5,120",
    default: 4_000,
    range: 0..=(MAX_TRIANGLES - SCALP_TRIANGLES) / PER_STRAND,
};

const COLORS: [[f32; 3]; 4] = [[0.42, 0.20, 0.08], [0.55, 0.29, 0.11], [0.66, 0.40, 0.17], [0.33, 0.14, 0.06]];

/// A ball of radius 1 with `strands` hairs: ribbons along quadratic Bézier curves that leave the ball at right angles
/// to its surface, sway, hang down, and taper to a point. A ribbon is dozens of times longer than wide, or more if
/// there are more of them, and not aligned with any axis, so boxes and cells around its triangles are nearly empty.
///
/// # Errors
/// More than [`MAX_TRIANGLES`].
pub fn hair(strands: u64, seed: u64) -> Result<Scene, GenerateError> {
    check(NAME, &STRANDS, strands)?;
    let materials: Vec<Material> = std::iter::once(matte("scalp", [0.30, 0.19, 0.13]))
        .chain(
            COLORS
                .iter()
                .enumerate()
                .map(|(i, &c)| Material { double_sided: true, ..matte(&format!("strand {i}"), c) }),
        )
        .collect();
    let count = SCALP_TRIANGLES + strands * PER_STRAND;
    let mut scene = draft(NAME, count, Attributes { normals: true, colors: false }, materials)?;
    let mut normals = scene.normals.take().unwrap_or_default();
    sphere(SCALP_SUBDIVISIONS, |t| {
        scene.triangles.push(t.map(<[f32; 3]>::from));
        normals.push(t.map(<[f32; 3]>::from));
        scene.triangle_materials.push(0);
    });
    let mut random = Random::new(seed);
    // Thinner if there are more, so that it remains a ball of hair; never below f32's resolution at this distance from
    // the origin.
    let width = (0.9 / (strands.max(1) as f32).sqrt()).clamp(2e-4, 0.02);
    for i in 0..strands {
        let material = 1 + (i * COLORS.len() as u64 / strands) as u32;
        let ribbon = Ribbon::grow(&mut random, width);
        for k in 0..PIECES {
            let ((a, b, n), (d, c, m)) = (ribbon.rung(k), ribbon.rung(k + 1));
            let mut push = |t: [Vec3; 3], n: [Vec3; 3]| {
                scene.triangles.push(t.map(<[f32; 3]>::from));
                normals.push(n.map(<[f32; 3]>::from));
                scene.triangle_materials.push(material);
            };
            push([a, b, c], [n, n, m]);
            if k + 1 < PIECES {
                push([a, c, d], [n, m, m]);
            }
        }
    }
    scene.normals = Some(normals);
    scene.lights =
        vec![lamp([3.0, 4.0, 4.0], [1.0, 0.96, 0.9], 40.0), sun(Vec3::new(1.0, -0.1, -0.5), [0.25, 0.27, 0.35])];
    scene.cameras =
        camera("camera", DVec3::new(0.9, 0.9, 5.0), DVec3::new(0.0, -0.15, 0.0), 40.0).into_iter().collect();
    Ok(scene)
}

/// A Bézier curve's three points, its side and its half width at the root.
struct Ribbon {
    curve: [Vec3; 3],
    side: Vec3,
    half: f32,
}

impl Ribbon {
    fn grow(random: &mut Random, width: f32) -> Self {
        let root = random.direction();
        let length = 0.55 + 0.35 * random.unit();
        let bend = root + random.signed3() * 0.25;
        let tip = root * (1.0 + 0.75 * length) + random.signed3() * 0.22 + Vec3::NEG_Y * (0.45 * length);
        let (curve, growth) = ([root * 0.99, bend + root * (0.55 * length), tip], tip - root);
        // The ribbon lies flat on the ball.
        let side = growth.cross(root).normalize_or(root.any_orthonormal_vector());
        Self { curve, side, half: width * 0.5 }
    }

    /// Left and right edge and the normal at joint `k` of 0..=PIECES.
    fn rung(&self, k: usize) -> (Vec3, Vec3, Vec3) {
        let t = k as f32 / PIECES as f32;
        let [p, q, r] = self.curve;
        let middle = p * ((1.0 - t) * (1.0 - t)) + q * (2.0 * t * (1.0 - t)) + r * (t * t);
        let along = (q - p) * (1.0 - t) + (r - q) * t;
        let normal = self.side.cross(along).normalize_or(Vec3::Y);
        let reach = self.side * (self.half * (1.0 - t));
        (middle - reach, middle + reach, normal)
    }
}
