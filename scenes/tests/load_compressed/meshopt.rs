//! EXT_meshopt_compression and KHR_meshopt_compression.

use crate::load_common::*;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use raystep_scenes::Scene;
use serde_json::{Value, json};

/// 20 vertices of a strip of 18 triangles, vertex i at (i / 2, i % 2, i / 4), and its indices, by meshoptimizer 1.3:
/// positions in versions 0 and 1, the latter with and without rotated differences, by the filter of exponents, and
/// as integers (1000 (i / 2), 300 (i % 2), 7 i).
const FLOATS: [&str; 4] = [
    "oAAABQzMzMz//4CAQEBAzAAAAEAgBQyAAAB+gAAAAAAABwD/////////////////////AAAA/////wcAfn1+fX59fn1+fX59fn1+/wAAAH1+fX4AAAcA//+AgEBAQEAgICAgICAg/wAAACAQEBABOACAAHwAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA==",
    "oRraOgBAVYCAQEBABQBAIAEUAH8BAFRV/////////wUA//8Af35/fn9+f35/fn9+f35/fn9+fwAAAICAQEBAQCAgICAgICAgEBAQAQYAfQEAAAAAAAAAAAAAAAAAAAAAAAAAAAABAQE=",
    "oRrqaABAVYCAQEBABQBAIAEUAH8BAH9/f39/f39/f39/f39/f39/f38BAgEHDwIP+PTE8mLiYtAwGPwPAB4BAwEAAAAAAAAAAAAAAAAAAAAAAAAAAAABElI=",
    "oAAFDAzMzEAgHxAQEMwAAAAvCAAFMICAAMqAAAAAAAcAQD9APyAfIB8QDxAPEA8Q/wAAAA8IBwgABTCAgADKgAAAAAAGD//4iPREREQQEBAPF+oAAAAbAAUwgIAAyoAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAI4AAACOAAAAjg==",
];
const INTEGERS: [&str; 2] = [
    "oAUMzMzMLy8vLy8vL8wAAAAvLwYAYICAgICAgMwAAAAICAcAWFdYV1hXWFdYV1hXWFdY/wAAAFdYV1gFJmZmZmYAAAAKDu7u7u7u7u7u7gAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA",
    "odapAFRV+g4aBgo+CgUABhoBAExMTAMHAwUAAQ8AS0tLS0tLS0tLS0tLS0tLS0tLSwIO7u7u7u7u7g8ADg4ODgAAAAAAAAAAAAAAAAAAAAAAAAAAAABiAA==",
];
const TRIANGLES: &str = "4fAQABAAEAAQABAAEAAQABAAEAB2h1ZneKmGZYlomAFpAAA=";
const SEQUENCE: &str = "0QAEBAACCAIEBAACCAIEBAACCAIEBAACCAIEBAACCAIEBAACCAIEBAACCAIEBAACCAIEBAACCAAAAAA=";

const BOTH: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Adds a view that is decompressed from base64; what it replaces is in a buffer without bytes.
fn view(doc: &mut Doc, extension: &str, stream: &str, mode: &str, filter: &str, [count, stride]: [usize; 2]) -> usize {
    let from = doc.view(&STANDARD.decode(stream).unwrap());
    let from = doc.json["bufferViews"][from].clone();
    let meshopt = json!({"buffer": 0, "byteOffset": from["byteOffset"], "byteLength": from["byteLength"],
        "byteStride": stride, "count": count, "mode": mode, "filter": filter});
    let mut view = json!({"buffer": 1, "byteLength": count * stride, "extensions": {extension: meshopt}});
    if mode == "ATTRIBUTES" {
        view["byteStride"] = json!(stride);
    }
    doc.push("bufferViews", view)
}

/// The strip with these positions and indices.
fn strip(extension: &str, positions: (&str, &str), indices: (&str, &str)) -> Doc {
    let mut doc = Doc::new();
    let position = view(&mut doc, extension, positions.0, "ATTRIBUTES", positions.1, [20, 12]);
    let index = view(&mut doc, extension, indices.0, indices.1, "NONE", [54, 2]);
    doc.push("accessors", json!({"bufferView": position, "componentType": F32, "type": "VEC3", "count": 20}));
    doc.push("accessors", json!({"bufferView": index, "componentType": U16, "type": "SCALAR", "count": 54}));
    doc.push("meshes", json!({"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}));
    doc.push("nodes", json!({"mesh": 0}));
    doc.json["extensionsRequired"] = json!([extension]);
    doc
}

fn read(doc: &Doc) -> Result<Scene, String> {
    let mut json = doc.json.clone();
    json["buffers"] =
        json!([{"byteLength": doc.bin.len()}, {"byteLength": 1000, "extensions": {BOTH[0]: {"fallback": true}}}]);
    let scene = raystep_scenes::load("x", &glb(&json, &doc.bin), &Files::default(), &small());
    scene.map_err(|error| one_line(&error))
}

/// The triangles of the strip, whose every other one starts elsewhere.
fn expected(vertex: impl Fn(u16) -> [f32; 3]) -> Vec<[[f32; 3]; 3]> {
    (0..18).map(|t| if t % 2 == 1 { [t + 1, t, t + 2] } else { [t, t + 1, t + 2] }.map(&vertex)).collect()
}

/// A triangle may start at any corner: mode 1 keeps only the order.
fn sorted(mut triangles: Vec<[[f32; 3]; 3]>) -> Vec<[[f32; 3]; 3]> {
    for triangle in &mut triangles {
        let first = (0..3).min_by(|&a, &b| triangle[a].partial_cmp(&triangle[b]).unwrap()).unwrap();
        triangle.rotate_left(first);
    }
    triangles
}

fn float(i: u16) -> [f32; 3] {
    [f32::from(i / 2), f32::from(i % 2), f32::from(i) / 4.0]
}

#[test]
fn attributes_triangles_and_sequences_are_decompressed() {
    for extension in BOTH {
        for (k, stream) in FLOATS.into_iter().enumerate() {
            let filter = if k == 3 { "EXPONENTIAL" } else { "NONE" };
            for indices in [(TRIANGLES, "TRIANGLES"), (SEQUENCE, "INDICES")] {
                let scene = read(&strip(extension, (stream, filter), indices)).unwrap();
                assert_eq!(sorted(scene.triangles), sorted(expected(float)), "{extension} {k} {indices:?}");
                assert!(!scene.notes.iter().any(|note| note.0.contains("extension")), "{:?}", scene.notes);
            }
        }
    }
    for stream in INTEGERS {
        let mut doc = strip(BOTH[1], (FLOATS[0], "NONE"), (TRIANGLES, "TRIANGLES"));
        let position = view(&mut doc, BOTH[1], stream, "ATTRIBUTES", "NONE", [20, 8]);
        doc.json["accessors"][0] = json!({"bufferView": position, "componentType": U16, "type": "VEC3", "count": 20});
        let vertex = |i: u16| [f32::from(1000 * (i / 2)), f32::from(300 * (i % 2)), f32::from(7 * i)];
        assert_eq!(sorted(read(&doc).unwrap().triangles), sorted(expected(vertex)));
    }
}

#[test]
fn wide_indices_are_decompressed() {
    let indices = [0_u16, 1, 2, 19, 7, 3, 3, 7, 11, 2, 0, 1];
    let triangles: Vec<_> = indices.chunks(3).map(|t| [float(t[0]), float(t[1]), float(t[2])]).collect();
    let streams = [("4fD+D///JhcIdhEAdodWZ3iphmWJaJgBaQAA", "TRIANGLES"), ("0QAEBEQuDgAQECIGBAAAAAA=", "INDICES")];
    for (stream, mode) in streams {
        let mut doc = strip(BOTH[0], (FLOATS[0], "NONE"), (TRIANGLES, "TRIANGLES"));
        let index = view(&mut doc, BOTH[0], stream, mode, "NONE", [12, 4]);
        doc.json["accessors"][1] = json!({"bufferView": index, "componentType": U32, "type": "SCALAR", "count": 12});
        assert_eq!(sorted(read(&doc).unwrap().triangles), sorted(triangles.clone()), "{mode}");
    }
}

/// The elements of `stream`, which `filter` turns into vectors of this type, as vertex colours or positions.
fn filtered(stream: &str, filter: &str, stride: usize, component: u32, count: usize, attribute: &str) -> Vec<[f32; 3]> {
    let mut doc = Doc::new();
    let of = view(&mut doc, BOTH[1], stream, "ATTRIBUTES", filter, [count, stride]);
    doc.push("accessors", json!({"bufferView": of, "componentType": component, "type": if attribute == "COLOR_0" { "VEC4" } else { "VEC3" }, "count": count, "normalized": true}));
    doc.push("accessors", json!({"componentType": F32, "type": "VEC3", "count": count}));
    doc.push("meshes", json!({"primitives": [{"attributes": {"POSITION": 1, attribute: 0}, "mode": 5}]}));
    if attribute == "POSITION" {
        doc.json["meshes"][0]["primitives"][0]["attributes"] = json!({"POSITION": 0});
    }
    doc.push("nodes", json!({"mesh": 0}));
    let scene = read(&doc).unwrap();
    let triangles = scene.colors.unwrap_or(scene.triangles);
    triangles[0].into_iter().chain(triangles.get(1).map(|t| t[1])).collect()
}

/// Whether vectors are within a tolerance.
#[track_caller]
fn near(found: &[[f32; 3]], expected: &[[f32; 3]], tolerance: f32) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    let is_near = found.as_flattened().iter().zip(expected.as_flattened()).all(|(a, b)| (a - b).abs() <= tolerance);
    assert!(is_near, "{found:?} {expected:?}");
}

#[test]
fn filters_give_unit_vectors_and_colours() {
    // A strip's second triangle has its third vertex second.
    let unit = [[1., 0., 0.], [0., -1., 0.], [0.6, 0., -0.8], [0., 0., 1.]];
    // Octahedral, with 8 and 12 bits.
    let stream = "oAE/AAAA/f79AT8AAAD9b5EAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAB/AH8A";
    near(&filtered(stream, "OCTAHEDRAL", 4, I8, 4, "POSITION"), &unit, 2. / 127.);
    let stream = "oAEmAAAAAT8AAAANDg0BLwAAAN3cAT8AAAAPGAcAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA/wcAAP8HAAA=";
    near(&filtered(stream, "OCTAHEDRAL", 8, I16, 4, "POSITION"), &unit, 1. / 1024.);
    // The first three parts of quaternions.
    let stream =
        "oAEcAAAA+QE8AAAA/kkBDAAAAPsBDAAAALQBDAAAAPwBDAAAALUBHAAAAAMAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA/38=";
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let parts = [[0., 0., 0.], [0., 0., half], [0.5, 0.5, 0.5]];
    near(&filtered(stream, "QUATERNION", 8, I16, 3, "POSITION"), &parts, 2. / 32767.);
    let colors = [[1., 0., 0.], [0., 1., 0.], [0.2, 0.4, 0.6]];
    let stream = "ob8AfjEA/WUAg/0AAAAAAAAAAAAAAAAAAAAAAAAAQH/B/wA=";
    near(&filtered(stream, "COLOR", 4, U8, 3, "COLOR_0"), &colors, 2. / 255.);
    let stream = "of+vAAHOAH4xAAJlAP1nAAMCAIH9AAAAAAAAAAAAAAAAAAAAQP9/AcD//wAA";
    near(&filtered(stream, "COLOR", 8, U16, 3, "COLOR_0"), &colors, 2. / 32767.);
}

#[test]
fn a_stream_that_cannot_be_read_falls_back_or_costs_its_primitive() {
    let whole = || strip(BOTH[0], (FLOATS[1], "NONE"), (TRIANGLES, "TRIANGLES"));
    let meshopt = |k: usize, name: &str, value: Value| {
        let mut doc = whole();
        doc.json["bufferViews"][2 * k + 1]["extensions"][BOTH[0]][name] = value;
        doc
    };
    // Views 1 and 3 are those of positions and indices.
    for (k, name, value, words) in [
        (0, "mode", json!("TEXTURES"), "expected ATTRIBUTES, TRIANGLES or INDICES"),
        (0, "filter", json!("BLUR"), "its filter is unknown"),
        (0, "filter", json!("OCTAHEDRAL"), "not for elements of this size"),
        (0, "byteStride", json!(6), "byteStride: is 6"),
        (0, "byteStride", json!(260), "byteStride: is 260"),
        (0, "count", json!(5), "more data than elements"),
        (0, "count", json!(300), "the data ends too early"),
        (0, "byteLength", json!(3), "the data ends too early"),
        (0, "byteOffset", json!(1), "does not start with 0xa0 or 0xa1"),
        (0, "buffer", json!(7), "refers to buffer 7"),
        (1, "mode", json!("INDICES"), "does not start with 0xd1"),
        (1, "count", json!(53), "no multiple of 3"),
        (1, "count", json!(57), "the data"),
    ] {
        let error = read(&meshopt(k, name, value)).unwrap_err();
        assert!(error.contains("EXT_meshopt_compression") && error.contains(words), "{name}: {error}");
    }
    // Too many to fit into memory.
    let error = read(&meshopt(0, "count", json!(1_u64 << 40))).unwrap_err();
    assert!(error.contains("more bytes"), "{error}");
    // What the wrong stream takes the place of is there.
    let mut doc = meshopt(0, "byteLength", json!(3));
    let plain: Vec<f32> = (0..20).flat_map(float).collect();
    let bytes = doc.view(&f32s(&plain));
    doc.json["bufferViews"][1]["buffer"] = json!(0);
    doc.json["bufferViews"][1]["byteOffset"] = doc.json["bufferViews"][bytes]["byteOffset"].clone();
    assert_eq!(sorted(read(&doc).unwrap().triangles), sorted(expected(float)));
    // Beside another shape, one is missing.
    let mut doc = meshopt(0, "byteLength", json!(3));
    let position = doc.floats("VEC3", &[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
    doc.mesh(json!({"POSITION": position}));
    doc.push("nodes", json!({"mesh": 1}));
    let scene = read(&doc).unwrap();
    assert_eq!(scene.triangles.len(), 1);
    assert!(notes(&scene)[0].starts_with("1 of 2 primitives is missing: "), "{:?}", scene.notes);
}

#[test]
fn every_flipped_bit_ends_well() {
    for stream in FLOATS {
        let mut doc = strip(BOTH[1], (stream, "NONE"), (TRIANGLES, "TRIANGLES"));
        let mut wrong = 0;
        for bit in 0..doc.bin.len() * 8 {
            doc.bin[bit / 8] ^= 1 << (bit % 8);
            wrong += usize::from(read(&doc).is_err());
            doc.bin[bit / 8] ^= 1 << (bit % 8);
        }
        assert!(wrong > 0);
    }
}
