//! A height field.

use super::draft::{Attributes, camera, check, draft, matte, sun};
use super::random::mix;
use super::{GenerateError, MAX_TRIANGLES, Parameter};
use crate::Scene;
use glam::{DVec3, Vec3};

pub(super) const TRIANGLES: Parameter = Parameter {
    name: "triangles",
    summary: "how many at most: the largest square grid with two triangles a cell is taken",
    default: 20_000,
    range: 2..=MAX_TRIANGLES,
};

/// Half the side of the square of land.
const HALF: f32 = 4.0;
/// Everything lower is water.
const WATER: f32 = 0.0;

/// A square of land, 8 by 8 units, of 2·n² triangles with n = ⌊√(`triangles`/2)⌋: fractional Brownian motion
/// (Mandelbrot and Van Ness 1968) of lattice noise (Perlin 1985), with valleys flattened to lakes. Smooth normals;
/// vertex colours by height and slope.
///
/// # Errors
/// Fewer than two triangles, or more than [`MAX_TRIANGLES`].
pub fn terrain(triangles: u64, seed: u64) -> Result<Scene, GenerateError> {
    const NAME: &str = "terrain";
    check(NAME, &TRIANGLES, triangles)?;
    let n = (triangles / 2).isqrt();
    let attributes = Attributes { normals: true, colors: true };
    let mut scene = draft(NAME, 2 * n * n, attributes, vec![matte("land", [1.0; 3])])?;
    let n = n as usize;
    let field = Field::new(n, seed);
    let (mut normals, mut colors) = (scene.normals.take().unwrap_or_default(), scene.colors.take().unwrap_or_default());
    // Two rows of shaded vertices at a time: each is computed once, and the whole grid is never stored.
    let shaded = |row: usize| (0..=n).map(|column| field.corner(column, row)).collect::<Vec<_>>();
    let mut far = shaded(0);
    for row in 1..=n {
        let near = shaded(row);
        for i in 0..n {
            let (a, b, c, d) = (&near[i], &near[i + 1], &far[i + 1], &far[i]);
            // The diagonals alternate, so that ridges have no preferred direction.
            let cell = if (i + row) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
            for t in cell {
                scene.triangles.push(t.map(|c| c.position.to_array()));
                normals.push(t.map(|c| c.normal.to_array()));
                colors.push(t.map(|c| c.color.to_array()));
            }
        }
        far = near;
    }
    scene.triangle_materials.resize(scene.triangles.len(), 0);
    (scene.normals, scene.colors) = (Some(normals), Some(colors));
    scene.lights =
        vec![sun(Vec3::new(-0.8, -0.55, -0.3), [1.0, 0.92, 0.78]), sun(Vec3::new(0.4, -1.0, 0.3), [0.12, 0.18, 0.3])];
    scene.cameras = camera("camera", DVec3::new(1.6, 3.2, 8.6), DVec3::new(0.2, 0.0, 0.3), 46.0).into_iter().collect();
    Ok(scene)
}

struct Corner {
    position: Vec3,
    normal: Vec3,
    color: Vec3,
}

/// The heights at the grid's corners.
struct Field {
    cells: usize,
    heights: Vec<f32>,
}

impl Field {
    fn new(cells: usize, seed: u64) -> Self {
        // Detail finer than the grid would alias.
        let octaves = (cells.max(2).ilog2()).clamp(3, 12);
        let mut heights = Vec::with_capacity((cells + 1) * (cells + 1));
        for row in 0..=cells {
            for column in 0..=cells {
                let at = |i: usize| i as f32 / cells as f32 * 4.0;
                heights.push(height(at(column), at(row), octaves, mix(seed)));
            }
        }
        Self { cells, heights }
    }

    fn raw(&self, column: usize, row: usize) -> f32 {
        self.heights[row * (self.cells + 1) + column]
    }

    fn corner(&self, column: usize, row: usize) -> Corner {
        let side = 2.0 * HALF / self.cells as f32;
        let (west, east) = (column.saturating_sub(1), (column + 1).min(self.cells));
        let (north, south) = (row.saturating_sub(1), (row + 1).min(self.cells));
        let level = |c, r| self.raw(c, r).max(WATER);
        let dx = (level(east, row) - level(west, row)) / ((east - west) as f32 * side);
        let dz = (level(column, south) - level(column, north)) / ((south - north) as f32 * side);
        let normal = Vec3::new(-dx, 1.0, -dz).normalize();
        let h = self.raw(column, row);
        let position = Vec3::new(-HALF + column as f32 * side, h.max(WATER), -HALF + row as f32 * side);
        Corner { position, normal, color: color(h, normal.y) }
    }
}

fn color(h: f32, upright: f32) -> Vec3 {
    const DEEP: Vec3 = Vec3::new(0.02, 0.10, 0.20);
    const SHALLOW: Vec3 = Vec3::new(0.08, 0.30, 0.36);
    const SAND: Vec3 = Vec3::new(0.62, 0.52, 0.32);
    const GRASS: Vec3 = Vec3::new(0.16, 0.32, 0.09);
    const ROCK: Vec3 = Vec3::new(0.30, 0.26, 0.23);
    const SNOW: Vec3 = Vec3::new(0.86, 0.88, 0.92);
    if h <= WATER {
        return DEEP.lerp(SHALLOW, smooth(-0.35, 0.0, h));
    }
    let ground = SAND.lerp(GRASS, smooth(0.03, 0.14, h));
    let ground = ground.lerp(ROCK, smooth(0.45, 0.7, h).max(smooth(0.80, 0.62, upright)));
    ground.lerp(SNOW, smooth(0.62, 0.8, h) * smooth(0.45, 0.7, upright))
}

/// 0 below `from`, 1 above `to`, a cubic in between; also for `from > to`.
fn smooth(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn height(x: f32, z: f32, octaves: u32, seed: u64) -> f32 {
    let (mut sum, mut size, mut scale) = (0.0, 1.0, 1.0);
    for octave in 0..octaves {
        let n = noise(x * scale, z * scale, seed ^ u64::from(octave));
        // The lower octaves form ridges, the higher ones add roughness.
        sum += size * if octave < 3 { 0.8 - 1.9 * n.abs() } else { n };
        size *= 0.46;
        scale *= 2.0;
    }
    0.5 * sum
}

/// Lattice noise in [-1, 1] with a quintic blend.
fn noise(x: f32, z: f32, seed: u64) -> f32 {
    let (cell_x, cell_z) = (x.floor(), z.floor());
    let blend = |t: f32| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let (u, v) = (blend(x - cell_x), blend(z - cell_z));
    let at = |i: i64, k: i64| {
        let key = (cell_x as i64 + i) as u64 ^ ((cell_z as i64 + k) as u64).rotate_left(32);
        (mix(mix(key) ^ seed) >> 40) as f32 * (2.0 / 16_777_216.0) - 1.0
    };
    let near = at(0, 0) + (at(1, 0) - at(0, 0)) * u;
    let far = at(0, 1) + (at(1, 1) - at(0, 1)) * u;
    near + (far - near) * v
}
