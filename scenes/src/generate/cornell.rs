//! The Cornell box (Goral, Torrance, Greenberg and Battaile 1984) with the paper's 26 triangles.

use super::draft::{camera, lamp, matte};
use crate::{Material, Scene};
use glam::DVec3;

/// The room's half width and half height, and the positions of its back wall and open front.
const HALF: f32 = 1.0;
const BACK: f32 = -1.0;
const FRONT: f32 = 3.6;

/// The blocks' footprints (x, z), seen from above: front left, front right, back right, back left.
/// They are Cornell's measured corners, scaled to a room two units wide.
const SHORT: [[f32; 2]; 4] = [[-0.045, 0.592], [0.532, 0.767], [0.705, 0.195], [0.135, 0.027]];
const TALL: [[f32; 2]; 4] = [[-0.524, 0.116], [0.045, -0.059], [-0.132, -0.631], [-0.701, -0.453]];
const SHORT_TOP: f32 = -0.4;
const TALL_TOP: f32 = 0.2;

/// The room of the paper's Figure 6: 26 triangles, flat shaded, one point light.
///
/// Floor, ceiling, back and side walls (10 triangles) and two blocks without their bottoms and backs (8 each). The
/// walls are the scene's bounds, and they extend past the camera, because the paper's setup kernel cannot start a ray
/// outside the grid. All triangles face the camera, so no material is double-sided.
#[must_use]
pub fn cornell_box() -> Scene {
    const WHITE: u32 = 0;
    const RED: u32 = 1;
    const GREEN: u32 = 2;
    let mut scene = Scene {
        name: "cornell-box".to_owned(),
        materials: vec![
            matte("white", [0.73, 0.73, 0.73]),
            matte("red", [0.65, 0.05, 0.05]),
            matte("green", [0.12, 0.45, 0.15]),
        ],
        lights: vec![lamp([0.0, 0.8, 1.0], [1.0; 3], 4.0)],
        cameras: camera("camera", DVec3::new(0.0, 0.0, 3.3), DVec3::ZERO, 43.0).into_iter().collect(),
        ..Scene::default()
    };
    let mut quad = |material, [a, b, c, d]: [[f32; 3]; 4]| {
        // Counter-clockwise as seen from inside the room.
        scene.triangles.extend([[a, b, c], [a, c, d]]);
        scene.triangle_materials.extend([material; 2]);
    };
    let (l, r, bottom, top) = (-HALF, HALF, -HALF, HALF);
    quad(WHITE, [[l, bottom, FRONT], [r, bottom, FRONT], [r, bottom, BACK], [l, bottom, BACK]]);
    quad(WHITE, [[l, top, BACK], [r, top, BACK], [r, top, FRONT], [l, top, FRONT]]);
    quad(WHITE, [[l, bottom, BACK], [r, bottom, BACK], [r, top, BACK], [l, top, BACK]]);
    for (foot, height) in [(SHORT, SHORT_TOP), (TALL, TALL_TOP)] {
        let at = |i: usize, y: f32| [foot[i][0], y, foot[i][1]];
        quad(WHITE, [at(0, height), at(1, height), at(2, height), at(3, height)]);
        // Front, right and left; the back of each block is never visible.
        for (i, j) in [(0, 1), (1, 2), (3, 0)] {
            quad(WHITE, [at(i, bottom), at(j, bottom), at(j, height), at(i, height)]);
        }
    }
    quad(RED, [[l, bottom, FRONT], [l, bottom, BACK], [l, top, BACK], [l, top, FRONT]]);
    quad(GREEN, [[r, bottom, BACK], [r, bottom, FRONT], [r, top, FRONT], [r, top, BACK]]);
    scene
}

/// The radiance of the lamp of [`cornell_lamp`].
const RADIANCE: f32 = 15.0;

/// The same room with Cornell's lamp instead of a point light: a square in its ceiling that glows, 28 triangles in all.
#[must_use]
pub fn cornell_lamp() -> Scene {
    let mut scene = Scene { name: "cornell-lamp".to_owned(), lights: Vec::new(), ..cornell_box() };
    let lamp = u32::try_from(scene.materials.len()).unwrap_or(u32::MAX);
    scene.materials.push(Material { emissive: [RADIANCE; 3], ..matte("lamp", [0.0; 3]) });
    // Just below the ceiling, and facing down.
    let at = |x: f32, z: f32| [x, 0.99 * HALF, z];
    let [a, b, c, d] = [at(-0.25, -0.25), at(0.25, -0.25), at(0.25, 0.25), at(-0.25, 0.25)];
    scene.triangles.extend([[a, b, c], [a, c, d]]);
    scene.triangle_materials.extend([lamp; 2]);
    scene
}
