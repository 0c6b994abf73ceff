//! What the picture needs and cannot be mended: a one-line error that says where.

#![allow(clippy::unwrap_used, reason = "a test that cannot make its input has failed")]

use crate::load_common::*;
use raystep_scenes::{LoadError, NoFiles, load};
use serde_json::{Value, json};

/// Merges `value` into the triangle's document at a JSON pointer, and expects an error with these words.
fn broken(pointer: &str, value: Value, words: &[&str]) {
    let mut doc = Doc::triangle();
    *doc.json.pointer_mut(pointer).unwrap_or_else(|| panic!("no {pointer}")) = value;
    let error = doc.error();
    for word in words {
        assert!(error.contains(word), "{pointer}: {error:?} does not say {word:?}");
    }
}

#[test]
fn wrong_indices_counts_and_types() {
    let position = "meshes[0].primitives[0].attributes.POSITION";
    let accessor = |change: Value| {
        let mut accessor = json!({"bufferView": 0, "componentType": F32, "count": 3, "type": "VEC3"});
        accessor.as_object_mut().unwrap().extend(change.as_object().unwrap().clone());
        accessor
    };
    let cases = [
        ("/nodes/0/mesh", json!(1), vec!["nodes[0].mesh", "mesh 1", "has 1"]),
        ("/nodes/0/mesh", json!(-1), vec!["nodes[0].mesh"]),
        ("/nodes/0/mesh", json!(4_294_967_296_u64), vec!["4294967296", "mesh"]),
        ("/nodes/0", json!(3), vec!["nodes[0]: invalid type"]),
        ("/meshes/0", json!({"primitives": 3}), vec!["meshes[0].primitives: invalid type"]),
        ("/meshes/0/primitives/0", json!({"attributes": 3}), vec!["primitives[0].attributes"]),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(9), vec![position, "accessor 9", "has 1"]),
        ("/meshes/0/primitives/0", json!({"attributes": {"POSITION": 0}, "indices": 9}), vec!["primitives[0].indices"]),
        (
            "/meshes/0/primitives/0",
            json!({"attributes": {"POSITION": 0}, "mode": 9}),
            vec!["primitives[0].mode", "0 to 6"],
        ),
        ("/accessors/0", json!({"count": 3, "type": "VEC3"}), vec![position, "componentType: is missing"]),
        ("/accessors/0", accessor(json!({"bufferView": 9})), vec![position, "accessors[0]", "bufferView 9"]),
        ("/accessors/0", accessor(json!({"count": 2})), vec![position, "accessors[0]", "2 corners", "multiple of 3"]),
        ("/accessors/0", accessor(json!({"count": 6})), vec![position, "6 elements of 12 bytes", "36 bytes"]),
        ("/accessors/0", accessor(json!({"byteOffset": 4})), vec![position, "from byte 4", "36 bytes"]),
        ("/accessors/0", accessor(json!({"byteOffset": u64::MAX})), vec![position, "36 bytes"]),
        ("/accessors/0", accessor(json!({"count": u64::MAX})), vec![position, "36 bytes"]),
        ("/accessors/0", accessor(json!({"count": 3_u64 << 61})), vec![position, "36 bytes"]),
        ("/accessors/0", accessor(json!({"type": "VEC2"})), vec![position, "Vec2", "VEC3"]),
        ("/accessors/0", accessor(json!({"type": "VEC5"})), vec![position, "SCALAR"]),
        ("/accessors/0", accessor(json!({"componentType": 5124})), vec![position, "componentType"]),
        ("/accessors/0", accessor(json!({"componentType": U32})), vec![position, "U32", "F32"]),
        ("/bufferViews/0", json!({"buffer": 0, "byteLength": 36, "byteStride": 8}), vec!["byteStride 8", "12 bytes"]),
        ("/bufferViews/0", json!({"buffer": 0, "byteLength": 36, "byteStride": 0}), vec!["byteStride 0", "12 bytes"]),
        ("/bufferViews/0", json!({"buffer": 0, "byteLength": 36, "byteStride": u64::MAX}), vec![position, "36 bytes"]),
        ("/bufferViews/0", json!({"buffer": 0, "byteLength": 40}), vec!["bufferViews[0]", "byteLength 40", "36 bytes"]),
        ("/bufferViews/0", json!({"buffer": 0, "byteOffset": u64::MAX, "byteLength": 36}), vec!["bufferViews[0]"]),
        ("/bufferViews/0", json!({"buffer": 7, "byteLength": 36}), vec!["bufferViews[0].buffer", "buffer 7"]),
        ("/asset/version", json!("1.0"), vec!["asset", "1.0", "2.0"]),
        (
            "/asset",
            json!({"version": "2.0", "minVersion": "2.1"}),
            vec!["asset.minVersion", "2.1", "raystep cannot read"],
        ),
        ("/nodes", json!(3), vec!["nodes", "sequence"]),
    ];
    for (pointer, value, words) in cases {
        broken(pointer, value, &words);
    }
}

#[test]
fn indices_that_do_not_fit() {
    let path = "meshes[0].primitives[0].indices";
    let indices = |accessor: Value, words: &[&str]| {
        let mut doc = Doc::triangle();
        doc.view(&[1; 64]);
        doc.view(&[0, 1, 3]);
        let index = doc.push("accessors", accessor);
        doc.primitive()["indices"] = json!(index);
        let error = doc.error();
        for word in words.iter().chain(&[path]) {
            assert!(error.contains(word), "{error:?} does not say {word:?}");
        }
    };
    let of = |component: u32, kind: &str, count: u32| json!({"bufferView": 1, "componentType": component, "type": kind, "count": count});
    indices(of(F32, "SCALAR", 3), &["F32", "U8"]);
    indices(of(U8, "VEC3", 3), &["Vec3", "SCALAR"]);
    indices(of(U16, "SCALAR", 3), &["index 257", "3 vertices"]);
    indices(of(U8, "SCALAR", 2), &["2 corners", "multiple of 3"]);
    indices(
        json!({"bufferView": 2, "componentType": U8, "type": "SCALAR", "count": 3}),
        &["triangle 0 has the index 3", "3 vertices"],
    );
}

#[test]
fn positions_that_are_no_numbers() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut doc = Doc::triangle();
        doc.bin[16..20].copy_from_slice(&bad.to_le_bytes());
        let error = doc.error();
        assert!(error.contains("attributes.POSITION: element 1 is"), "{error}");
    }
    // Finite numbers that become infinite by a transform or when read.
    let mut doc = Doc::triangle();
    doc.json["nodes"] = json!([{"scale": [1e30, 1, 1], "children": [1]}, {"mesh": 0, "scale": [1e30, 1, 1]}]);
    assert!(doc.error().starts_with("nodes[1]: its transform moves triangle 0"));
    for (field, value) in [
        ("translation", json!([1, 2])),
        ("scale", json!([1, 2, 3, 4])),
        ("scale", json!("1 1 1")),
        ("matrix", json!([1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])),
    ] {
        broken("/nodes/0", json!({"mesh": 0, field: value}), &[&format!("nodes[0].{field}")]);
    }
    // Shapes farther apart than 32 bits reach, whatever is subtracted.
    let mut doc = Doc::triangle();
    doc.json["nodes"] = json!([{"mesh": 0, "scale": [1e39, 1, 1]}]);
    assert!(doc.error().starts_with("nodes[0]: its transform moves triangle 0"));
    let beyond = Doc::triangle().json.to_string().replace("{\"mesh\":0}", "{\"mesh\":0,\"translation\":[1e999,0,0]}");
    assert!(beyond.contains("1e999"));
    let error = one_line(&load("x", beyond.as_bytes(), &NoFiles, &small()).unwrap_err());
    assert!(error.contains("nodes[0].translation: inf is not a finite number"), "{error}");
}

#[test]
fn uris_that_are_not_read() {
    for (uri, word) in [
        ("http://example.com/a.bin", "http: URI"),
        ("HTTPS://example.com/a.bin", "HTTPS: URI"),
        ("file:///etc/passwd", "file: URI"),
        ("C:/a.bin", "absolute path"),
        ("c:\\a.bin", "absolute path"),
        ("C%3A%5Ca.bin", "absolute path"),
        ("%43:/a.bin", "absolute path"),
        ("/etc/passwd", "absolute"),
        ("%2Fetc/passwd", "absolute"),
        ("\\\\server\\a.bin", "absolute"),
        ("%FF.bin", "UTF-8"),
        ("a%00.bin", "zero byte"),
        ("", "empty"),
        ("missing.bin", "cannot read \"missing.bin\""),
        ("sub\\missing.bin", "cannot read \"sub\\missing.bin\""),
        ("data:;base64", "comma"),
        ("data:;base64,!!!!", "base64"),
        ("data:;base64,AAAAA", "base64"),
        ("data:,AAAA", "has 4 bytes, fewer than its byteLength"),
    ] {
        let mut doc = Doc::triangle().json;
        doc["buffers"] = json!([{"byteLength": 36, "uri": uri}]);
        let error = one_line(&load("x", doc.to_string().as_bytes(), &Files::default(), &small()).unwrap_err());
        assert!(error.starts_with("buffers[0]") && error.contains(word), "{uri}: {error}");
    }
    let mut doc = Doc::triangle().json;
    doc["buffers"] = json!([{"byteLength": 36}]);
    let error = one_line(&load("x", doc.to_string().as_bytes(), &NoFiles, &small()).unwrap_err());
    assert!(error.contains("has no uri"), "{error}");
}

/// A picture without what is in a missing file would not be that of the scene.
#[test]
fn a_missing_buffer_of_one_shape_among_others_is_an_error() {
    let mut doc = Doc::triangle();
    doc.json["buffers"] = json!([{"byteLength": 36}, {"byteLength": 36, "uri": "missing.bin"}]);
    doc.push("bufferViews", json!({"buffer": 1, "byteLength": 36}));
    let other = doc.push("accessors", json!({"bufferView": 1, "componentType": F32, "count": 3, "type": "VEC3"}));
    doc.mesh(json!({"POSITION": other}));
    doc.push("nodes", json!({"mesh": 1}));
    let load = |json: &Value| load("x", &glb(json, &doc.bin), &Files::default(), &small());
    assert!(matches!(load(&doc.json).unwrap_err(), LoadError::External { file, .. } if file == "missing.bin"));
    // A file that is too short lacks the bytes of some views.
    let mut json = doc.json.clone();
    json["buffers"][1] = json!({"byteLength": 36, "uri": "data:,AAAA"});
    let error = one_line(&load(&json).unwrap_err());
    assert_eq!(error, "buffers[1]: has 4 bytes, fewer than its byteLength of 36");
    json["bufferViews"][1]["byteLength"] = json!(4);
    json["accessors"][other]["count"] = json!(0);
    assert_eq!(load(&json).unwrap().triangles.len(), 1);
}

#[test]
fn sparse_accessors_that_do_not_fit() {
    for (count, indices, words) in [
        (1, [3_u8, 0], "sparse index 0 is 3, but there are 3"),
        (2, [1, 1], "strictly increase"),
        (2, [2, 1], "strictly increase"),
        (4, [0, 1], "sparse.count 4"),
        (3, [0, 1], "3 elements of 1 bytes"),
    ] {
        let mut doc = Doc::triangle();
        let (indices, values) = (doc.view(&indices), doc.view(&f32s(&[0.; 9])));
        doc.json["accessors"][0]["sparse"] = json!({"count": count,
            "indices": {"bufferView": indices, "componentType": U8}, "values": {"bufferView": values}});
        let error = doc.error();
        assert!(error.contains(words) && error.contains("attributes.POSITION (accessors[0])"), "{error}");
    }
}
