//! Invalid or inconsistent values: a one-line error that says where.

#![allow(clippy::unwrap_used, reason = "a test that cannot make its input has failed")]

use crate::load_common::*;
use raystep_scenes::{NoFiles, load};
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
        ("/nodes/0", json!({"mesh": 0, "skin": 5}), vec!["nodes[0].skin", "skin 5", "has 0"]),
        ("/nodes/0", json!({"camera": 5}), vec!["nodes[0].camera", "has 0"]),
        ("/nodes/0", json!({"extensions": {"KHR_lights_punctual": {"light": 5}}}), vec!["light 5", "has 0"]),
        ("/nodes/0", json!({"children": [9]}), vec!["nodes[0].children[0]", "node 9", "has 1"]),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(9), vec![position, "accessor 9", "has 1"]),
        ("/meshes/0/primitives/0", json!({"attributes": {"POSITION": 0}, "indices": 9}), vec!["primitives[0].indices"]),
        (
            "/meshes/0/primitives/0",
            json!({"attributes": {"POSITION": 0}, "material": 9}),
            vec!["primitives[0].material"],
        ),
        (
            "/meshes/0/primitives/0",
            json!({"attributes": {"POSITION": 0}, "mode": 9}),
            vec!["primitives[0].mode", "0 to 6"],
        ),
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
fn attributes_that_do_not_fit() {
    let path = "meshes[0].primitives[0]";
    let attribute = |name: &str, accessor: Value, words: &[&str]| {
        let mut doc = Doc::triangle();
        doc.view(&[1; 64]);
        doc.view(&[0, 1, 3]);
        let index = doc.push("accessors", accessor);
        match name {
            "indices" => doc.primitive()["indices"] = json!(index),
            _ => doc.primitive()["attributes"][name] = json!(index),
        }
        let error = doc.error();
        for word in words.iter().chain(&[path, name]) {
            assert!(error.contains(word), "{name}: {error:?} does not say {word:?}");
        }
    };
    let of = |component: u32, kind: &str, count: u32| json!({"bufferView": 1, "componentType": component, "type": kind, "count": count});
    attribute("NORMAL", of(F32, "VEC3", 2), &["2 elements", "POSITION has 3"]);
    attribute("NORMAL", of(F32, "VEC4", 3), &["Vec4", "VEC3"]);
    attribute("NORMAL", of(U16, "VEC3", 3), &["U16", "F32"]);
    attribute("COLOR_0", of(U8, "VEC4", 3), &["not normalized"]);
    attribute("COLOR_0", of(F32, "VEC2", 3), &["Vec2", "VEC3 or VEC4"]);
    attribute("indices", of(F32, "SCALAR", 3), &["F32", "U8"]);
    attribute("indices", of(U8, "VEC3", 3), &["Vec3", "SCALAR"]);
    attribute("indices", of(U16, "SCALAR", 3), &["element 0 is 257", "3 vertices"]);
    attribute(
        "indices",
        json!({"bufferView": 2, "componentType": U8, "type": "SCALAR", "count": 3}),
        &["element 2 is 3", "3 vertices"],
    );
    attribute("indices", of(U8, "SCALAR", 4), &["4 corners", "multiple of 3"]);
}

#[test]
fn positions_that_are_no_numbers() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut doc = Doc::triangle();
        doc.bin[16..20].copy_from_slice(&bad.to_le_bytes());
        let error = doc.error();
        assert!(error.contains("attributes.POSITION (accessors[0]): element 1 is"), "{error}");
    }
    // Finite numbers that become infinite by a transform or when read.
    let mut doc = Doc::triangle();
    doc.json["nodes"] = json!([{"scale": [1e30, 1, 1], "children": [1]}, {"mesh": 0, "scale": [1e30, 1, 1]}]);
    assert!(doc.error().contains("nodes[1]"));
    for (field, value) in [
        ("translation", json!([1e39, 0, 0])),
        ("scale", json!([0, 0, 1e300])),
        ("rotation", json!([0, 0, 0, 0])),
        ("rotation", json!([0, 0, 0, 1e40])),
        ("matrix", json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 1e39, 1])),
        ("matrix", json!([1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])),
    ] {
        broken("/nodes/0", json!({"mesh": 0, field: value}), &[&format!("nodes[0].{field}")]);
    }
    broken("/nodes/0", json!({"translation": [1, 2]}), &["nodes[0].translation"]);
    let no_number = Doc::triangle().json.to_string().replace("{\"mesh\":0}", "{\"translation\":[1e999,0,0]}");
    assert!(no_number.contains("1e999"));
    one_line(&load("x", no_number.as_bytes(), &NoFiles, &small()).unwrap_err());
}

#[test]
fn nodes_that_form_no_trees() {
    let cases = [
        (json!([{"children": [0]}]), "nodes[0]: is on a cycle"),
        (json!([{}, {"children": [2]}, {"children": [3]}, {"children": [1]}]), "nodes[1]: is on a cycle"),
        (
            json!([{"children": [2]}, {"children": [2]}, {}]),
            "nodes[1].children[0]: node 2 is a child of node 0 already",
        ),
        (json!([{"children": [1, 1]}, {}]), "nodes[0].children[1]: node 1 is a child of node 0 already"),
    ];
    for (nodes, message) in cases {
        broken("/nodes", nodes, &[message]);
    }
    let mut doc = Doc::triangle();
    doc.json["nodes"] = json!([{"children": [1]}, {"mesh": 0}]);
    for (scenes, scene, message) in [
        (json!([{"nodes": [0, 0]}]), 0, "scenes[0].nodes[1]: node 0 is listed twice"),
        (json!([{"nodes": [1]}]), 0, "scenes[0].nodes[0]: node 1 is a child of node 0"),
        (json!([{"nodes": [2]}]), 0, "scenes[0].nodes[0]: refers to node 2, but the file has 2"),
        (json!([{"nodes": [0]}]), 1, "scene: refers to scene 1, but the file has 1"),
    ] {
        doc.json["scenes"] = scenes;
        doc.json["scene"] = json!(scene);
        assert_eq!(&doc.error()[..message.len()], message);
    }
}

#[test]
fn cameras_and_lights_out_of_range() {
    let perspective =
        |yfov: f64, znear: f64| json!({"type": "perspective", "perspective": {"yfov": yfov, "znear": znear}});
    let ortho = |xmag: f64, ymag: f64| json!({"type": "orthographic", "orthographic": {"xmag": xmag, "ymag": ymag, "znear": 0, "zfar": 1}});
    for (camera, word) in [
        (perspective(0., 1.), "yfov"),
        (perspective(3.2, 1.), "yfov"),
        (perspective(-1., 1.), "yfov"),
        (perspective(1e300, 1.), "yfov"),
        (perspective(1., 0.), "znear"),
        (json!({"type": "perspective", "perspective": {"yfov": 1, "znear": 2, "zfar": 1}}), "zfar"),
        (ortho(1., 0.), "ymag"),
        (ortho(1., -1.), "ymag"),
        (ortho(0., 1.), "xmag"),
        (json!({"type": "perspective"}), "no \"perspective\""),
        (json!({"type": "fisheye"}), "perspective or orthographic"),
    ] {
        let mut doc = Doc::triangle();
        doc.push("cameras", camera);
        doc.push("nodes", json!({"camera": 0}));
        let error = doc.error();
        assert!(error.starts_with("cameras[0]") && error.contains(word), "{error:?} does not say {word:?}");
    }
    let spot =
        |inner: f64, outer: f64| json!({"type": "spot", "spot": {"innerConeAngle": inner, "outerConeAngle": outer}});
    for (light, word) in [
        (spot(0.5, 0.5), "cone"),
        (spot(-0.1, 0.5), "cone"),
        (spot(0.1, 1.7), "cone"),
        (json!({"type": "spot"}), "spot"),
        (json!({"type": "sun"}), "directional"),
        (json!({"type": "point", "color": [1e39, 0, 0]}), "color"),
    ] {
        let mut doc = Doc::triangle();
        doc.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [light]}});
        doc.push("nodes", json!({"extensions": {"KHR_lights_punctual": {"light": 0}}}));
        let error = doc.error();
        assert!(error.contains("KHR_lights_punctual.lights[0]") && error.contains(word), "{error:?}: {word:?}");
    }
    // Neither can have a direction if its node has zero scale.
    let mut doc = Doc::triangle();
    doc.push("cameras", perspective(1., 1.));
    doc.push("nodes", json!({"camera": 0, "scale": [0, 0, 0]}));
    assert!(doc.error().starts_with("nodes[1]"));
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
        ("data:;base64", "comma"),
        ("data:;base64,!!!!", "base64"),
        ("data:;base64,AAAAA", "base64"),
        ("data:,AAAA", "fewer than its byteLength"),
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

#[test]
fn images_that_are_none_or_too_large() {
    let picture = png(2, 2, TEXELS.as_flattened());
    // A decompression bomb: the header declares 60,000 x 60,000 texels, with a matching checksum.
    let sized = |side: u32| {
        let mut bomb = picture.clone();
        bomb[16..20].copy_from_slice(&side.to_be_bytes());
        bomb[20..24].copy_from_slice(&side.to_be_bytes());
        let crc = !bomb[12..29].iter().fold(!0_u32, |crc, &byte| {
            (0..8).fold(crc ^ u32::from(byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 })
        });
        bomb[29..33].copy_from_slice(&crc.to_be_bytes());
        bomb
    };
    for (bytes, word) in [
        (b"GIF89a".to_vec(), "neither a PNG nor a JPEG"),
        (Vec::new(), "neither a PNG nor a JPEG"),
        (picture[..picture.len() - 20].to_vec(), "cannot be decoded"),
        (sized(60_000), "60000 x 60000"),
        (sized(30_000), "30000 x 30000 texels, and 900000000 texels with all images before it; at most 536870912"),
        (sized(20_000), "this takes 4800000000 more bytes"),
        (sized(900), "cannot be decoded"),
    ] {
        let mut doc = Doc::triangle();
        doc.primitive()["material"] = json!(0);
        doc.push("materials", json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}));
        doc.push("textures", json!({"source": 0}));
        let view = doc.view(&bytes);
        doc.push("images", json!({"bufferView": view}));
        let error = one_line(&doc.load_with(&NoFiles, &small()).unwrap_err());
        assert!(error.starts_with("images[0]") && error.contains(word), "{error:?} does not say {word:?}");
    }
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
