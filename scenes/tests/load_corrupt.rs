//! Damaged and hostile files: never a panic, a hang or a large allocation.

#![allow(clippy::unwrap_used, reason = "a test that cannot make its input has failed")]

use crate::load_common::*;
use raystep_scenes::{LoadError, LoadOptions, NoFiles, load};
use serde_json::{Value, json};
use std::time::{Duration, Instant};

/// A GLB that uses most features.
fn rich() -> Vec<u8> {
    let mut doc = Doc::triangle();
    let normal = doc.floats("VEC3", &[0., 0., 1.].repeat(3));
    let uv = doc.floats("VEC2", &[0., 0., 1., 0., 0., 1.]);
    let color = doc.accessor("VEC4", U8, 3, &[255; 12]);
    doc.json["accessors"][color]["normalized"] = json!(true);
    let indices = doc.accessor("SCALAR", U8, 3, &[0, 1, 2]);
    let joints = doc.accessor("VEC4", U8, 3, &[0; 12]);
    let weights = doc.floats("VEC4", &[1., 0., 0., 0.].repeat(3));
    let picture = doc.view(&png(2, 2, TEXELS.as_flattened()));
    let (sparse, value) = (doc.view(&[1]), doc.view(&f32s(&[2., 0., 0.])));
    doc.json["accessors"][0]["sparse"] = json!({"count": 1,
        "indices": {"bufferView": sparse, "componentType": U8}, "values": {"bufferView": value}});
    *doc.primitive() = json!({"material": 0, "indices": indices, "targets": [{"POSITION": 1}],
        "attributes": {"POSITION": 0, "NORMAL": normal, "TEXCOORD_0": uv, "COLOR_0": color,
            "JOINTS_0": joints, "WEIGHTS_0": weights}});
    doc.push("materials", json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}));
    doc.push("textures", json!({"source": 0}));
    doc.push("images", json!({"bufferView": picture}));
    doc.push("skins", json!({"joints": [1]}));
    doc.push("cameras", json!({"type": "perspective", "perspective": {"yfov": 1, "znear": 1}}));
    doc.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "spot", "spot": {}}]}});
    doc.json["nodes"] = json!([{"mesh": 0, "skin": 0, "weights": [1]},
        {"camera": 0, "rotation": [0, 0, 0, 1], "extensions": {"KHR_lights_punctual": {"light": 0}}}, {"mesh": 0}]);
    let bytes = doc.glb();
    assert_eq!(doc.scene().triangles.len(), 2);
    bytes
}

#[test]
fn truncated_at_every_length() {
    let whole = rich();
    for length in 0..whole.len() {
        let error = load("x", &whole[..length], &NoFiles, &small()).expect_err("truncated");
        one_line(&error);
    }
    let text = Doc::triangle().json.to_string();
    for length in 0..text.len() {
        let error = load("x", &text.as_bytes()[..length], &NoFiles, &small()).expect_err("truncated");
        one_line(&error);
    }
}

#[test]
fn every_single_bit_flipped() {
    let mut bytes = rich();
    let mut refused = 0_usize;
    for bit in 0..bytes.len() * 8 {
        bytes[bit / 8] ^= 1 << (bit % 8);
        let start = Instant::now();
        match load("x", &bytes, &NoFiles, &small()) {
            Ok(scene) => assert!(scene.triangles.iter().flatten().flatten().all(|c| c.is_finite())),
            Err(error) => {
                one_line(&error);
                refused += 1;
            }
        }
        // Loading these 3 kB takes microseconds; a second is a hang on any machine.
        assert!(start.elapsed() < Duration::from_secs(1), "bit {bit}");
        bytes[bit / 8] ^= 1 << (bit % 8);
    }
    assert!(refused > bytes.len(), "{refused} of {} flips noticed", bytes.len() * 8);
}

#[test]
fn claims_beyond_the_file_are_refused_before_memory_is_taken() {
    // 4 GiB of vertices, of zeros, of buffer, and of instances, each declared by a few hundred bytes.
    let mut doc = Doc::triangle();
    doc.json["accessors"][0]["count"] = json!(357_913_941);
    assert!(doc.error().contains("do not fit"));
    doc.json["accessors"][0] = json!({"componentType": F32, "type": "VEC3", "count": 357_913_941});
    assert!(matches!(doc.load().unwrap_err(), LoadError::TooLarge { needed: 4_294_967_292, .. }));

    let text = |uri: &str| {
        let mut doc = Doc::triangle().json;
        doc["buffers"] = json!([{"byteLength": 1_u64 << 32, "uri": uri}]);
        doc.to_string()
    };
    let error = load("x", text("data:;base64,AAAA").as_bytes(), &NoFiles, &LoadOptions::default()).unwrap_err();
    assert!(one_line(&error).contains("buffers[0]: has 3 bytes, fewer than its byteLength of 4294967296"), "{error}");
    assert!(text("").len() < 500);

    // Nodes of three bytes each, which take hundreds when parsed.
    let nodes = json!({"asset": {"version": "2.0"}, "nodes": vec![json!({}); 100_000]}).to_string();
    let error = one_line(&load("x", nodes.as_bytes(), &NoFiles, &small()).unwrap_err());
    assert!(error.starts_with("the file's JSON: this takes") && nodes.len() < 400_000, "{error}");

    // A mesh of 20,000 triangles on 300,000 nodes.
    let mut doc = Doc::triangle();
    let indices = doc.accessor("SCALAR", U8, 60_000, &[0, 1, 2].repeat(20_000));
    doc.primitive()["indices"] = json!(indices);
    doc.json["nodes"] = json!(vec![json!({"mesh": 0}); 300_000]);
    assert!(doc.error().contains("6000000000 triangles"));
    // A number of triangles that fits a u64 but not max_bytes.
    doc.json["nodes"] = json!(vec![json!({"mesh": 0}); 100]);
    let error = doc.load_with(&NoFiles, &small()).unwrap_err();
    assert!(matches!(error, LoadError::TooLarge { needed: 72_000_000, limit: 16_777_216, .. }), "{error}");
    one_line(&error);
    assert_eq!(
        doc.load_with(&NoFiles, &LoadOptions { max_bytes: 1 << 28, ..Default::default() }).unwrap().triangles.len(),
        2_000_000
    );
}

#[test]
fn chains_of_a_hundred_thousand_nodes_load() {
    let mut doc = Doc::triangle();
    let last = 100_000_u32;
    let mut nodes: Vec<Value> = (1..=last).map(|i| json!({"children": [i], "translation": [1, 0, 0]})).collect();
    nodes.push(json!({"mesh": 0}));
    doc.json["nodes"] = json!(nodes);
    let scene = doc.scene();
    assert_eq!((scene.triangles[0][0], scene.offset.x), ([0.; 3], f64::from(last)));
    // Closed to a ring, without any root.
    doc.json["nodes"][last as usize] = json!({"children": [0]});
    assert!(doc.error().contains("cycle"));
}

#[test]
fn text_that_is_no_gltf() {
    // JSON nested too deeply for a recursive reader's stack is skipped, or wrong where it stands.
    let deep = |key: &str| {
        let (open, close) = ("[".repeat(200_000), "]".repeat(200_000));
        format!("{{\"asset\":{{\"version\":\"2.0\"}},\"{key}\":{open}{close}}}").into_bytes()
    };
    for key in ["extras", "other", "materials", "nodes"] {
        assert!(load("x", &deep(key), &NoFiles, &small()).is_ok(), "{key}");
    }
    for (bytes, word) in [
        (&b""[..], "empty"),
        (b"  \n", "empty"),
        (b"\xff\xfe{}", "UTF-16"),
        (b"{\"asset\":{\"version\":\"\xc3\x28\"}}", "UTF-8"),
        (b"cube", "not a scene: raystep reads glTF"),
        (b"{}", "asset"),
        (b"{\"asset\":{\"version\":\"2.0\"}} x", "trailing"),
        (b"{\"asset\":{\"version\":\"2.0\"},\"meshes\": }", "meshes: expected value"),
        (b"{\"asset\":{\"version\":\"1.0\"},\"meshes\":{\"a\":{}}}", "glTF 1.0"),
        (b"{\"asset\":{},\"meshes\":{\"a\":{}}}", "asset.version: is missing"),
        (b"glTF\x01\0\0\0\x14\0\0\0\0\0\0\0JSON", "glTF 1.0"),
        (b"glTF\x02\0\0\0\x0c\0\0\0", "no chunks"),
        (b"glTF\x02\0\0\0\x14\0\0\0\0\0\0\0BIN\0", "first chunk is not JSON"),
        (b"glTF\x02\0\0\0\x14\0\0\0\xff\xff\xff\xffJSON", "chunk 0 says 4294967295 bytes"),
        (b"glTF\x02\0\0\0\0\0\0\0\0\0\0\0JSON", "header says 0 bytes"),
    ] {
        let error = one_line(&load("x", bytes, &NoFiles, &small()).unwrap_err());
        assert!(error.contains(word), "{error:?} does not say {word:?}");
    }
}
