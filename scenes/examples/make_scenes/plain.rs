//! Scenes that test geometry: kinds of primitives, instances, tiny and flat scenes.

use crate::gltf::{Buffer, TRIANGLE_FAN, TRIANGLE_STRIP, UNSIGNED_BYTE, looking, matte, perspective, with};
use crate::shapes::{Mesh, block, floor};
use raystep_scenes::generate;
use serde_json::{Value, json};
use std::f32::consts::TAU;

fn point_light(color: [f64; 3]) -> Value {
    json!({ "type": "point", "color": color, "intensity": 100 })
}

fn lit(index: usize) -> Value {
    json!({ "KHR_lights_punctual": { "light": index } })
}

fn lights(lights: &[Value]) -> Value {
    json!({ "KHR_lights_punctual": { "lights": lights } })
}

fn list(buffer: &mut Buffer, mesh: &Mesh, material: usize) -> Value {
    let (p, n) = (buffer.floats(&mesh.positions), buffer.floats(&mesh.normals));
    json!({ "attributes": { "POSITION": p, "NORMAL": n }, "indices": buffer.indices(&mesh.indices), "material": material })
}

/// Lists, strips and fans, each with and without indices, on nodes with TRS and with matrices.
pub(crate) fn primitives() -> String {
    let mut b = Buffer::default();
    // A pyramid: a list without indices and without normals.
    let (top, base) = ([0.0, 1.2, 0.0], [[0.5, 0.0, 0.5], [0.5, 0.0, -0.5], [-0.5, 0.0, -0.5], [-0.5, 0.0, 0.5]]);
    let pyramid: Vec<[f32; 3]> = (0..4).flat_map(|i| [base[i], base[(i + 1) % 4], top]).collect();
    let pyramid = json!({ "attributes": { "POSITION": b.floats(&pyramid) }, "material": 1 });
    // An octahedron: a list with 8-bit indices, and vertex colours of 8 bits.
    let corners =
        [[0.6, 0.0, 0.0], [0.0, 0.0, 0.6], [-0.6, 0.0, 0.0], [0.0, 0.0, -0.6], [0.0, 0.8, 0.0], [0.0, -0.8, 0.0]];
    let bytes: Vec<u8> = [[230, 60, 40], [240, 180, 40], [60, 160, 80], [40, 90, 180], [250, 250, 240], [30, 30, 30]]
        .iter()
        .flat_map(|[r, g, b]: &[u8; 3]| [*r, *g, *b, 255])
        .collect();
    let view = b.strided(&bytes, 4);
    let colors = b.accessor(json!({
        "bufferView": view, "componentType": UNSIGNED_BYTE, "normalized": true, "count": 6, "type": "VEC4"
    }));
    let octahedron = json!({
        "attributes": { "POSITION": b.floats(&corners), "COLOR_0": colors },
        "indices": b.byte_indices(&[0, 4, 1, 1, 4, 2, 2, 4, 3, 3, 4, 0, 1, 5, 0, 2, 5, 1, 3, 5, 2, 0, 5, 3]),
        "material": 0
    });
    // A pleated screen: a strip without indices.
    let screen: Vec<[f32; 3]> = (0..18)
        .map(|i| [0.14 * (i / 2) as f32 - 0.56, 1.3 * (i % 2) as f32, if i / 2 % 2 == 0 { 0.0 } else { 0.22 }])
        .map(|[x, y, z]| [x, 1.3 - y, z])
        .collect();
    let screen = json!({ "attributes": { "POSITION": b.floats(&screen) }, "mode": TRIANGLE_STRIP, "material": 3 });
    // A tower: a strip with indices, one lap of 16 columns, smooth.
    let ring =
        |y: f32, r: f32| (0..16).map(move |i| (i as f32 / 16.0 * TAU).sin_cos()).map(move |(s, c)| [r * c, y, r * s]);
    let wall: Vec<[f32; 3]> = ring(1.1, 0.4).chain(ring(0.0, 0.4)).collect();
    let out: Vec<[f32; 3]> = ring(0.0, 1.0).chain(ring(0.0, 1.0)).collect();
    let lap: Vec<u16> = (0..=16).flat_map(|i| [i % 16, i % 16 + 16]).collect();
    let tower = json!({
        "attributes": { "POSITION": b.floats(&wall), "NORMAL": b.floats(&out) },
        "indices": b.indices(&lap), "mode": TRIANGLE_STRIP, "material": 4
    });
    // Its roof, a cone: a fan without indices.
    let roof: Vec<[f32; 3]> = std::iter::once([0.0, 1.8, 0.0])
        .chain((0..=16).rev().map(|i| {
            let (s, c) = (i as f32 / 16.0 * TAU).sin_cos();
            [0.55 * c, 1.1, 0.55 * s]
        }))
        .collect();
    let roof = json!({ "attributes": { "POSITION": b.floats(&roof) }, "mode": TRIANGLE_FAN, "material": 5 });
    // A star: a fan with indices.
    let star: Vec<[f32; 3]> = std::iter::once([0.0; 3])
        .chain((0..10).map(|i| {
            let (s, c) = (i as f32 / 10.0 * TAU).sin_cos();
            let r = if i % 2 == 0 { 0.6 } else { 0.26 };
            [r * s, r * c, 0.0]
        }))
        .collect();
    let order: Vec<u16> = std::iter::once(0).chain((0..=10).rev().map(|i| i % 10 + 1)).collect();
    let star = json!({
        "attributes": { "POSITION": b.floats(&star) }, "indices": b.indices(&order), "mode": TRIANGLE_FAN, "material": 2
    });
    let ground = list(&mut b, &floor(4.0, 4), 0);
    let (s, c) = 0.5f64.sin_cos();
    b.text(json!({
        "scene": 0,
        "scenes": [{ "name": "primitives", "nodes": [0, 1, 2, 3, 4, 5, 6, 7, 8] }],
        "nodes": [
            { "name": "floor", "mesh": 0 },
            { "name": "pyramid", "mesh": 1, "translation": [-2.2, 0, 0.3], "rotation": [0, 0.2588190451, 0, 0.9659258263] },
            { "name": "octahedron", "mesh": 2, "translation": [-0.9, 0.8, 0.9], "scale": [0.9, 1, 0.9] },
            { "name": "screen", "mesh": 3, "matrix": [1.2, 0, 0, 0, 0, 1.2, 0, 0, 0, 0, 1.2, 0, -0.7, 0, -1.2, 1] },
            { "name": "tower", "mesh": 4, "translation": [1.1, 0, -0.6] },
            { "name": "star", "mesh": 5, "matrix": [c, 0, -s, 0, 0, 1, 0, 0, s, 0, c, 0, 2.2, 0.75, 0.7, 1] },
            with(looking([0.6, 2.4, 6.4], [0.0, 0.55, 0.0]), json!({ "name": "camera", "camera": 0 })),
            { "name": "key", "translation": [3.0, 4.5, 4.0], "extensions": lit(0) },
            { "name": "fill", "translation": [-5.0, 2.0, 3.0], "extensions": lit(1) }
        ],
        "meshes": [
            { "name": "floor", "primitives": [ground] },
            { "name": "pyramid", "primitives": [pyramid] },
            { "name": "octahedron", "primitives": [octahedron] },
            { "name": "screen", "primitives": [screen] },
            { "name": "tower", "primitives": [tower, roof] },
            { "name": "star", "primitives": [star] }
        ],
        "materials": [
            matte("plain", [0.75, 0.75, 0.72]), matte("sand", [0.72, 0.52, 0.26]), matte("yellow", [0.85, 0.65, 0.08]),
            with(matte("paper", [0.30, 0.50, 0.62]), json!({ "doubleSided": true })),
            matte("stone", [0.55, 0.50, 0.45]), matte("brick", [0.55, 0.14, 0.08])
        ],
        "cameras": [perspective("camera", 47.0)],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": lights(&[point_light([0.85, 0.82, 0.76]), point_light([0.2, 0.24, 0.32])])
    }))
}

/// One letter on many nodes: rotated, scaled unevenly, mirrored, nested; two scenes, the second default.
pub(crate) fn instances() -> String {
    let mut b = Buffer::default();
    // An R-like shape has no symmetry, so mirroring is visible.
    let letter = block([-0.3, 0.0, -0.1], [-0.1, 1.0, 0.1])
        .and(block([-0.1, 0.8, -0.1], [0.3, 1.0, 0.1]))
        .and(block([-0.1, 0.4, -0.1], [0.2, 0.58, 0.1]));
    let letter = list(&mut b, &letter, 0);
    let ground = list(&mut b, &floor(4.5, 1), 1);
    let mut nodes = vec![
        with(looking([0.0, 3.4, 6.6], [0.0, 0.3, 0.0]), json!({ "name": "camera", "camera": 0 })),
        json!({ "name": "light", "translation": [2.5, 4.0, 3.5], "extensions": lit(0) }),
        json!({ "name": "floor", "mesh": 1 }),
        json!({ "name": "letter", "mesh": 0 }),
        json!({ "name": "mirrored", "mesh": 0, "translation": [1.2, 0, 0], "scale": [-1, 1, 1] }),
        json!({ "name": "tall", "mesh": 0, "translation": [-1.2, 0, 0], "scale": [1, 1.8, 1] }),
    ];
    let mut ring = vec![0, 1, 2];
    for i in 0..12 {
        let half = f64::from(i) * std::f64::consts::PI / 12.0;
        let mirror = if i % 2 == 0 { 1.0 } else { -1.0 };
        let child = nodes.len() + 1;
        nodes.push(json!({
            "name": format!("arm {i}"), "children": [child], "rotation": [0, half.sin(), 0, half.cos()]
        }));
        nodes.push(json!({
            "name": format!("letter {i}"), "mesh": 0, "translation": [0, 0, 2.6], "scale": [mirror, 1.0, 1.0]
        }));
        ring.push(child - 1);
    }
    // A mirrored child of a mirrored parent is not a mirror image.
    let parent = nodes.len();
    nodes.push(json!({ "name": "mirror", "children": [parent + 1], "scale": [1, 1, -1] }));
    nodes.push(json!({ "name": "twice mirrored", "mesh": 0, "scale": [-1.6, 1.6, 1.6] }));
    ring.push(parent);
    b.text(json!({
        "scene": 1,
        "scenes": [{ "name": "row", "nodes": [0, 1, 2, 3, 4, 5] }, { "name": "ring", "nodes": ring }],
        "nodes": nodes,
        "meshes": [{ "name": "letter", "primitives": [letter] }, { "name": "floor", "primitives": [ground] }],
        "materials": [matte("letter", [0.75, 0.30, 0.12]), matte("floor", [0.45, 0.52, 0.55])],
        "cameras": [perspective("camera", 50.0)],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": lights(&[point_light([1.0, 0.97, 0.92])])
    }))
}

/// No camera, no light, no material, no names.
pub(crate) fn bare() -> String {
    let mut b = Buffer::default();
    let mesh = generate::icosphere(0).map(|s| s.triangles.concat()).unwrap_or_default();
    let position = b.floats(&mesh);
    b.text(json!({
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": position } }] }]
    }))
}

/// The smallest scene with a triangle.
pub(crate) fn single_triangle() -> String {
    let mut b = Buffer::default();
    let attributes = json!({
        "POSITION": b.floats(&[[-1.0, -0.6, 0.0], [1.0, -0.6, 0.0], [0.0, 1.0, 0.0]]),
        "COLOR_0": b.floats(&[[1.0, 0.1, 0.1], [0.1, 1.0, 0.1], [0.1, 0.1, 1.0]])
    });
    b.text(json!({
        "scene": 0,
        "scenes": [{ "nodes": [0, 1] }],
        "nodes": [{ "mesh": 0 }, { "camera": 0, "translation": [0, 0.15, 3.2] }],
        "meshes": [{ "name": "triangle", "primitives": [{ "attributes": attributes }] }],
        "cameras": [perspective("camera", 40.0)]
    }))
}

/// A mosaic in the plane z = 0.25: the scene's bounds have no depth.
pub(crate) fn flat() -> String {
    let mut b = Buffer::default();
    let (mut positions, mut colors) = (Vec::new(), Vec::new());
    for (row, column) in (0..12).flat_map(|r| (0..12).map(move |c| (r, c))) {
        let at = |x: usize, y: usize| [(column + x) as f32 / 6.0 - 1.0, (row + y) as f32 / 6.0 - 1.0, 0.25];
        let r = (column as f32 - 5.5).hypot(row as f32 - 5.5);
        for (k, t) in [[(0, 0), (1, 0), (1, 1)], [(0, 0), (1, 1), (0, 1)]].into_iter().enumerate() {
            positions.extend(t.map(|(x, y)| at(x, y)));
            let tint = if (column + row + k) % 2 == 0 { 0.85 } else { 0.35 };
            colors.extend([[tint, tint * (1.0 - r / 9.0), tint * r / 9.0]; 3]);
        }
    }
    let attributes = json!({ "POSITION": b.floats(&positions), "COLOR_0": b.floats(&colors) });
    b.text(json!({
        "scene": 0,
        "scenes": [{ "nodes": [0, 1, 2] }],
        "nodes": [
            { "mesh": 0 }, { "camera": 0, "translation": [0, 0, 3.4] },
            { "translation": [0.4, 0.5, 1.6], "extensions": lit(0) }
        ],
        "meshes": [{ "name": "mosaic", "primitives": [{ "attributes": attributes }] }],
        "cameras": [perspective("camera", 40.0)],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": lights(&[point_light([1.0, 1.0, 1.0])])
    }))
}

/// A scene without a single triangle.
pub(crate) fn empty() -> String {
    Buffer::default()
        .text(json!({ "scene": 0, "scenes": [{ "name": "empty", "nodes": [0] }], "nodes": [{ "name": "nothing" }] }))
}
