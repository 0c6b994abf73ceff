//! Scenes that test surfaces and light: textures, lights, quantised attributes, deformed meshes.

use crate::gltf::{
    BYTE, Buffer, FLOAT, SHORT, UNSIGNED_BYTE, UNSIGNED_SHORT, data_uri, looking, matte, perspective, with,
};
use crate::shapes::{Mesh, block, cylinder, floor, globe, panel, surface, torus};
use serde_json::{Value, json};
use std::io::Cursor;

fn list(b: &mut Buffer, mesh: &Mesh, material: usize) -> Value {
    let attributes = json!({
        "POSITION": b.floats(&mesh.positions), "NORMAL": b.floats(&mesh.normals), "TEXCOORD_0": b.floats(&mesh.texcoords)
    });
    json!({ "attributes": attributes, "indices": b.indices(&mesh.indices), "material": material })
}

fn lit(index: usize) -> Value {
    json!({ "KHR_lights_punctual": { "light": index } })
}

fn png(width: u32, height: u32, at: impl Fn(u32, u32) -> [u8; 3]) -> Result<Vec<u8>, image::ImageError> {
    let mut out = Cursor::new(Vec::new());
    image::RgbImage::from_fn(width, height, |x, y| image::Rgb(at(x, y))).write_to(&mut out, image::ImageFormat::Png)?;
    Ok(out.into_inner())
}

/// Files beside `textures.gltf`: the URI of one is percent-encoded, the other's is not.
pub(crate) const CHESSBOARD: &str = "schach brett ü.png";
pub(crate) const DATA: &str = "textures-данные.bin";

/// Wrap modes and filters of an image, a factor over a texture, emission. Returns text, buffer and image.
pub(crate) fn textures() -> Result<(String, Vec<u8>, Vec<u8>), image::ImageError> {
    let mut b = Buffer::default();
    let chessboard = png(8, 8, |x, y| if (x + y) % 2 == 0 { [235, 220, 190] } else { [110, 60, 35] })?;
    // Four corners of different colours, so that mirroring is visible.
    let compass = png(16, 16, |x, y| match (x.min(15 - x).min(y.min(15 - y)) < 1, x < 8, y < 8) {
        (true, ..) => [40, 40, 40],
        (_, true, true) => [210, 60, 50],
        (_, false, true) => [240, 190, 60],
        (_, true, false) => [60, 140, 90],
        (_, false, false) => [50, 90, 180],
    })?;
    let ground = list(&mut b, &floor(3.5, 2), 0);
    let mut board = panel(1.5, 1.5);
    // Two and a half copies: outside [0, 1], the wrap mode matters.
    board.texcoords.iter_mut().for_each(|t| *t = t.map(|x| x * 2.5 - 0.75));
    let panels: Vec<Value> = (1..=4).map(|material| list(&mut b, &board, material)).collect();
    let ball = list(&mut b, &globe(32, 16, 0.5), 5);
    let lamp = list(&mut b, &globe(12, 6, 0.16), 6);
    let textured = |name: &str, texture: usize, factor: [f64; 3]| {
        let mut m = matte(name, factor);
        m["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": texture });
        m
    };
    let mut meshes = vec![json!({ "name": "floor", "primitives": [ground] })];
    meshes.extend(panels.into_iter().map(|p| json!({ "name": "panel", "primitives": [p] })));
    meshes.push(json!({ "name": "ball", "primitives": [ball] }));
    meshes.push(json!({ "name": "lamp", "primitives": [lamp] }));
    let scene = json!({
        "scene": 0,
        "scenes": [{ "name": "textures", "nodes": [0, 1, 2, 3, 4, 5, 6, 7, 8] }],
        "nodes": [
            { "name": "floor", "mesh": 0 },
            { "name": "repeat, nearest", "mesh": 1, "translation": [-2.4, 1, -1] },
            { "name": "mirror, nearest", "mesh": 2, "translation": [-0.8, 1, -1.4] },
            { "name": "clamp, nearest", "mesh": 3, "translation": [0.8, 1, -1.4] },
            { "name": "repeat and mirror, bilinear", "mesh": 4, "translation": [2.4, 1, -1] },
            { "name": "ball", "mesh": 5, "translation": [0, 0.5, 0.6] },
            { "name": "lamp", "mesh": 6, "translation": [1.2, 1.2, 0.6] },
            { "name": "light", "translation": [1.2, 1.6, 2.2], "extensions": lit(0) },
            with(looking([0.0, 2.1, 5.6], [0.0, 0.7, -0.2]), json!({ "name": "camera", "camera": 0 }))
        ],
        "meshes": meshes,
        "materials": [
            textured("floor", 0, [1.0, 1.0, 1.0]), textured("repeat", 1, [1.0, 1.0, 1.0]),
            textured("mirror", 2, [1.0, 1.0, 1.0]), textured("clamp", 3, [1.0, 1.0, 1.0]),
            textured("bilinear", 4, [1.0, 1.0, 1.0]), textured("tinted", 5, [0.4, 0.9, 0.7]),
            with(matte("lamp", [0.0, 0.0, 0.0]), json!({ "emissiveFactor": [1, 0.85, 0.5] }))
        ],
        "textures": [
            { "source": 0, "sampler": 0 }, { "source": 1, "sampler": 0 }, { "source": 1, "sampler": 1 },
            { "source": 1, "sampler": 2 }, { "source": 1, "sampler": 3 }, { "source": 0 }
        ],
        "samplers": [
            { "magFilter": 9728, "minFilter": 9728, "wrapS": 10497, "wrapT": 10497 },
            { "magFilter": 9728, "minFilter": 9984, "wrapS": 33648, "wrapT": 33648 },
            { "magFilter": 9728, "minFilter": 9986, "wrapS": 33071, "wrapT": 33071 },
            { "magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 33648 }
        ],
        "images": [
            { "name": "chessboard", "uri": "schach%20brett%20%C3%BC.png" },
            { "name": "compass", "uri": data_uri("image/png", &compass) }
        ],
        "cameras": [perspective("camera", 56.0)],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "point", "intensity": 60 }] } }
    });
    let text = crate::gltf::pretty(&b.document(scene, Some(DATA.to_owned()))) + "\n";
    Ok((text, b.bytes, chessboard))
}

/// All kinds of light and camera; double-sided, emissive and transparent materials.
pub(crate) fn lights() -> String {
    let mut b = Buffer::default();
    let ground = list(&mut b, &floor(3.5, 1), 0);
    let wall = list(&mut b, &panel(7.0, 4.0), 0);
    let ball = list(&mut b, &globe(24, 12, 0.6), 1);
    // Half a globe, open to the front, so that its inside is visible.
    let bowl = list(
        &mut b,
        &surface(20, 6, |u, v| {
            let (s, c) = (-u * std::f32::consts::TAU).sin_cos();
            let (t, d) = (v * std::f32::consts::FRAC_PI_2).sin_cos();
            [0.6 * d * c, 0.6 - 0.6 * t, 0.6 * d * s]
        }),
        2,
    );
    let bulb = list(&mut b, &globe(8, 4, 0.08), 3);
    let pane = list(&mut b, &panel(0.9, 1.4), 4);
    // A quarter turn about x, downwards.
    let half_turned = std::f64::consts::FRAC_1_SQRT_2;
    let orthographic = json!({
        "name": "plan", "type": "orthographic", "orthographic": { "xmag": 4, "ymag": 4, "znear": 0, "zfar": 20 }
    });
    b.text(json!({
        "scene": 0,
        "scenes": [{ "name": "lights", "nodes": [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11] }],
        "nodes": [
            { "name": "floor", "mesh": 0 },
            { "name": "wall", "mesh": 1, "translation": [0, 2, -2] },
            { "name": "ball", "mesh": 2, "translation": [-1.5, 0.6, 0] },
            { "name": "bowl", "mesh": 3, "translation": [0.2, 0.62, 0.3], "rotation": [0.5, 0, 0, 0.8660254038] },
            { "name": "bulb", "mesh": 4, "translation": [-0.5, 1.5, 0.3] },
            { "name": "pane", "mesh": 5, "translation": [1.9, 0.7, 0], "rotation": [0, -0.2588190451, 0, 0.9659258263] },
            { "name": "point", "translation": [-0.5, 1.5, 0.3], "extensions": lit(0) },
            with(looking([0.0, 4.0, 3.0], [1.0, 0.0, -3.0]), json!({ "name": "sun", "extensions": lit(1) })),
            with(looking([1.5, 3.6, 2.5], [1.3, 0.6, -1.2]), json!({ "name": "spot", "extensions": lit(2) })),
            with(looking([0.4, 2.2, 5.8], [0.0, 1.0, -0.6]), json!({ "name": "front", "camera": 0 })),
            { "name": "above", "camera": 1, "translation": [0, 8, 0], "rotation": [-half_turned, 0, 0, half_turned] },
            with(looking([-2.6, 0.9, 2.8], [0.4, 0.8, 0.0]), json!({ "name": "low", "camera": 2 }))
        ],
        "meshes": [
            { "primitives": [ground] }, { "primitives": [wall] }, { "primitives": [ball] }, { "primitives": [bowl] },
            { "primitives": [bulb] }, { "primitives": [pane] }
        ],
        "materials": [
            matte("wall", [0.7, 0.7, 0.68]), matte("ball", [0.75, 0.75, 0.75]),
            with(matte("bowl", [0.6, 0.62, 0.3]), json!({ "doubleSided": true })),
            with(matte("bulb", [0.0, 0.0, 0.0]), json!({ "emissiveFactor": [1, 0.8, 0.55] })),
            { "name": "pane", "alphaMode": "BLEND", "doubleSided": true, "pbrMetallicRoughness": {
                "baseColorFactor": [0.3, 0.6, 0.7, 0.4], "metallicFactor": 0, "roughnessFactor": 1
            } }
        ],
        "cameras": [perspective("front", 50.0), orthographic, perspective("low", 65.0)],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": [
            { "name": "bulb", "type": "point", "color": [1, 0.6, 0.3], "intensity": 30 },
            { "name": "sky", "type": "directional", "color": [0.12, 0.16, 0.28], "intensity": 2 },
            { "name": "stage", "type": "spot", "color": [0.5, 0.75, 0.9], "intensity": 80,
              "spot": { "innerConeAngle": 0.28, "outerConeAngle": 0.34 } }
        ] } }
    }))
}

/// Positions, normals, texture coordinates and colours in 8 and 16 bits; sparse and interleaved accessors.
pub(crate) fn quantized() -> Vec<u8> {
    let mut b = Buffer::default();
    let ring = torus(40, 20, 0.7, 0.28);
    // Interleaved, 20 bytes per vertex: position i16x3 + pad, normal i8x3 + pad, uv u16x2, colour u8x4.
    let mut bytes = Vec::new();
    for ((p, n), t) in ring.positions.iter().zip(&ring.normals).zip(&ring.texcoords) {
        bytes.extend(p.iter().flat_map(|v| ((v * 32767.0).round() as i16).to_le_bytes()));
        bytes.extend([0, 0]);
        bytes.extend(n.iter().flat_map(|v| ((v * 127.0).round() as i8).to_le_bytes()));
        bytes.push(0);
        bytes.extend(t.iter().flat_map(|v| ((v * 65535.0).round() as u16).to_le_bytes()));
        let stripe = if (t[0] * 10.0).fract() < 0.5 { [235, 170, 60, 255] } else { [170, 60, 40, 255] };
        bytes.extend(stripe);
    }
    let view = b.strided(&bytes, 20);
    let count = ring.positions.len();
    let mut attribute = |offset: usize, component: u32, kind: &str, bounds: Value| {
        b.accessor(with(
            json!({
                "bufferView": view, "byteOffset": offset, "componentType": component, "normalized": true,
                "count": count, "type": kind
            }),
            bounds,
        ))
    };
    let i16s = |pick: fn(f32, f32) -> f32| {
        let bound = |i: usize| ring.positions.iter().map(|p| p[i]).reduce(pick).unwrap_or(0.0);
        [0, 1, 2].map(|i| (bound(i) * 32767.0).round() as i16)
    };
    let position = attribute(0, SHORT, "VEC3", json!({ "min": i16s(f32::min), "max": i16s(f32::max) }));
    let normal = attribute(8, BYTE, "VEC3", json!({}));
    let texcoord = attribute(12, UNSIGNED_SHORT, "VEC2", json!({}));
    let color = attribute(16, UNSIGNED_BYTE, "VEC4", json!({}));
    let ring = json!({
        "attributes": { "POSITION": position, "NORMAL": normal, "TEXCOORD_0": texcoord, "COLOR_0": color },
        "indices": b.indices(&ring.indices), "material": 0
    });
    // A block with a whole-number unit: i8, not normalised; the node scales it.
    let cube = block([-100.0; 3], [100.0, -60.0, 100.0]);
    let bytes: Vec<u8> =
        cube.positions.iter().flat_map(|p| [p[0] as i8 as u8, p[1] as i8 as u8, p[2] as i8 as u8, 0]).collect();
    let view = b.strided(&bytes, 4);
    let position = b.accessor(json!({
        "bufferView": view, "componentType": BYTE, "count": 24, "type": "VEC3", "min": [-100, -100, -100], "max": [100, -60, 100]
    }));
    let cube = json!({ "attributes": { "POSITION": position }, "indices": b.indices(&cube.indices), "material": 1 });
    // A flat sheet with a few vertices raised by a sparse accessor.
    let sheet = floor(2.4, 12);
    let flat = b.floats(&sheet.positions);
    let pulled: Vec<(u16, [f32; 3])> = (0..169u16)
        .filter(|i| (i % 13 + i / 13) % 4 == 1)
        .map(|i| (i, sheet.positions[usize::from(i)]))
        .map(|(i, [x, _, z])| (i, [x, 0.3, z]))
        .collect();
    let at: Vec<u8> = pulled.iter().flat_map(|(i, _)| i.to_le_bytes()).collect();
    let to: Vec<u8> =
        pulled.iter().flat_map(|(_, p)| p.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>()).collect();
    let (at, to) = (b.view(&at), b.view(&to));
    b.accessors[flat]["max"] = json!([2.4, 0.3, 2.4].map(|v: f32| v));
    b.accessors[flat]["sparse"] = json!({
        "count": pulled.len(),
        "indices": { "bufferView": at, "componentType": UNSIGNED_SHORT },
        "values": { "bufferView": to }
    });
    // Sparse colours without a base: black except where given.
    let tips: Vec<u8> = pulled.iter().flat_map(|_| [0.25f32, 0.45, 0.6]).flat_map(f32::to_le_bytes).collect();
    let tips = b.view(&tips);
    let colors = b.accessor(json!({
        "componentType": FLOAT, "count": 169, "type": "VEC3",
        "sparse": {
            "count": pulled.len(),
            "indices": { "bufferView": at, "componentType": UNSIGNED_SHORT },
            "values": { "bufferView": tips }
        }
    }));
    let sheet = json!({
        "attributes": { "POSITION": flat, "COLOR_0": colors }, "indices": b.indices(&sheet.indices), "material": 0
    });
    b.glb(json!({
        "scene": 0,
        "scenes": [{ "name": "quantized", "nodes": [0, 1, 2, 3, 4, 5] }],
        "nodes": [
            { "name": "ring", "mesh": 0, "translation": [0, 1.25, 0], "rotation": [0.5735764364, 0, 0, 0.8191520443] },
            { "name": "block", "mesh": 1, "translation": [0, 0.9, 0], "scale": [0.008, 0.008, 0.008] },
            { "name": "sheet", "mesh": 2, "translation": [0, -0.2, 0] },
            with(looking([1.2, 2.6, 4.6], [0.0, 0.7, 0.0]), json!({ "name": "camera", "camera": 0 })),
            { "name": "light", "translation": [2, 4, 3], "extensions": lit(0) },
            with(looking([-3.0, 2.0, 1.0], [0.0, 0.0, 0.0]), json!({ "name": "fill", "extensions": lit(1) }))
        ],
        "meshes": [{ "primitives": [ring] }, { "primitives": [cube] }, { "primitives": [sheet] }],
        "materials": [matte("painted", [1.0, 1.0, 1.0]), matte("block", [0.5, 0.5, 0.52])],
        "cameras": [perspective("camera", 38.0)],
        "extensionsUsed": ["KHR_lights_punctual", "KHR_mesh_quantization"],
        "extensionsRequired": ["KHR_mesh_quantization"],
        "extensions": { "KHR_lights_punctual": { "lights": [
            { "type": "point", "intensity": 60 }, { "type": "directional", "color": [0.2, 0.22, 0.3], "intensity": 1 }
        ] } }
    }))
}

/// A skinned post in its rest pose, and a sheet with a morph target at its default weight.
pub(crate) fn skin_and_morph() -> String {
    let mut b = Buffer::default();
    let post = cylinder(20, 12, 0.35, 2.0);
    let mut skinned = list(&mut b, &post, 0);
    let bytes: Vec<u8> = post.positions.iter().flat_map(|_| [0u8, 1, 0, 0]).collect();
    let view = b.strided(&bytes, 4);
    let joints = b.accessor(json!({
        "bufferView": view, "componentType": UNSIGNED_BYTE, "count": post.positions.len(), "type": "VEC4"
    }));
    let weights: Vec<[f32; 4]> = post.positions.iter().map(|p| [1.0 - p[1] / 2.0, p[1] / 2.0, 0.0, 0.0]).collect();
    skinned["attributes"]["JOINTS_0"] = joints.into();
    skinned["attributes"]["WEIGHTS_0"] = b.floats(&weights).into();
    let mut inverse = [[0.0f32; 16]; 2];
    for (m, y) in inverse.iter_mut().zip([0.0, -1.0]) {
        (m[0], m[5], m[10], m[13], m[15]) = (1.0, 1.0, 1.0, y, 1.0);
    }
    let view = b.view(&inverse.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>());
    let inverse = b.accessor(json!({ "bufferView": view, "componentType": FLOAT, "count": 2, "type": "MAT4" }));

    let sheet = floor(0.9, 16);
    let wave: Vec<[f32; 3]> =
        sheet.positions.iter().map(|p| [0.0, 0.45 * (p[0] * 5.0).sin() * (p[2] * 5.0).cos(), 0.0]).collect();
    let target = json!({ "POSITION": b.floats(&wave) });
    // A morphed surface without normals is shaded flat, which shows its shape.
    let sheet = json!({
        "attributes": { "POSITION": b.floats(&sheet.positions) }, "indices": b.indices(&sheet.indices), "material": 1,
        "targets": [target]
    });
    let ground = list(&mut b, &floor(3.0, 1), 2);
    b.text(json!({
        "scene": 0,
        "scenes": [{ "name": "skin and morph", "nodes": [0, 1, 3, 4, 5, 6] }],
        "nodes": [
            { "name": "post", "mesh": 0, "skin": 0 },
            { "name": "root", "translation": [-1.1, 0, 0], "children": [2] },
            // The joint leans, so the rest pose differs from the stored mesh.
            { "name": "tip", "translation": [0, 1, 0], "rotation": [0, 0, -0.2588190451, 0.9659258263] },
            { "name": "sheet", "mesh": 1, "translation": [1.1, 0.7, 0] },
            { "name": "floor", "mesh": 2 },
            with(looking([0.3, 2.3, 5.2], [0.0, 0.8, 0.0]), json!({ "name": "camera", "camera": 0 })),
            { "name": "light", "translation": [2.5, 4, 3], "extensions": lit(0) }
        ],
        "meshes": [
            { "name": "post", "primitives": [skinned] },
            { "name": "sheet", "primitives": [sheet], "weights": [0.6] },
            { "name": "floor", "primitives": [ground] }
        ],
        "skins": [{ "joints": [1, 2], "inverseBindMatrices": inverse, "skeleton": 1 }],
        "materials": [
            with(matte("post", [0.25, 0.55, 0.5]), json!({ "doubleSided": true })),
            with(matte("sheet", [0.75, 0.35, 0.2]), json!({ "doubleSided": true })), matte("floor", [0.6, 0.6, 0.58])
        ],
        "cameras": [perspective("camera", 50.0)],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "point", "intensity": 60 }] } }
    }))
}
