//! KHR_draco_mesh_compression.

use crate::load_common::*;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use raystep_scenes::{LoadError, LoadOptions, NoFiles};
use serde_json::json;

/// A 3 × 3 grid of vertices with a bump of 0.5 in the middle, with normals, texture coordinates and colours, whose red
/// is 255; written by Google's encoder 1.5.7: edgebreaker with and without quantisation, and sequentially.
const EDGEBREAKER: &str = "RFJBQ08CAgEBAAAACQgDCAEAA+/TGv8BEf8CiED/AohA/wKIQAT/AAAAAAABAAACAAABAAkDAAACAQEJAwABAwEDCQIAAgIBAgIEAAMBAQEBAAwDOQ4fdRxVFQTd/s6N//8/AP/v//8BoP8AACCA/wEAAP8DAMD/AADwPwAAAAAA/wcAAAAAAAAAAAAAAAAAAAAAAEALBgMBAQPWAVUVMx0HFx0HFx0H///fWRUHF+GfKOKCkv8AAAB/AAAA/wKZQAgFAQEACwM5Dg85Dh0HOQ4DPQ4F9cauXYX///+//0DuPAEbAPjLFgAHAAAAJQP1BYEAAAAA/wMAAAAAAAAAAAAAAACAPwoBAQEBA4EBjTORA//zkQNVBQei7uHslV2FAAAAAP8AAAA=";
const LOSSLESS: &str = "RFJBQ08CAgEBAAAACQgACAEAA+/TGv8BEQH/AAAEAAkDAAABCQMAAQMJAgACAgIEAAMAAAABAACAPwAAgD8AAAA/AAAAAAAAAEAAAAAAAAAAAAAAgD8AAAAAAACAPwAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAQAAAAAAAAAAAAAAAQAAAgD8AAAAAAACAPwAAAEAAAAAAAAAAQAAAAEAAAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/AAAAPwAAAD8AAAAAAACAPwAAAAAAAAA/AAAAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAACAPwAAAD8AAAA/AACAPwAAgD8AAIA/AQEBAQGBAY0zkQP/85EDVQUHou7h7JVdhQAAAAD/AAAA";
const SEQUENTIAL: &str = "RFJBQ08CAgEAAAAICQEAAQMBBAMBAgQCBQQDBAYEBwYEBQcFCAcBBAAJAwAAAQkDAAEDCQIAAgICBAADAgMCAQABAQAMAx0HI+U4AwTghfg/AADgfwAAQAD/B8D/AQBA/wPgfwLwPwD+DwAA+B8AAAAAAAAA/wcAAAADAQEBgAFxPP/3kQMDoMyK/wAAAH8AAAAAAQEACwMdBx/lOAME4IX8D4D/AAjw//8A+A+AAP7/D4D/AAAAAAAA/wMAAAABAQECgAKpKpED//c5Dv/3kQMIAkmDxsgQ+0oAAAAA/wAAAAAAAAAAAAAAAAAAAAAAAEALCAAAAAAAAAAAAACAPwo=";

/// The grid on one node, without other bytes.
fn grid(stream: &[u8]) -> Doc {
    let mut doc = Doc::new();
    let view = doc.view(stream);
    let kinds = [("VEC3", F32), ("VEC3", F32), ("VEC2", F32), ("VEC4", U8)];
    for (kind, component) in kinds {
        doc.push(
            "accessors",
            json!({"componentType": component, "type": kind, "count": 9, "normalized": component == U8}),
        );
    }
    doc.push("accessors", json!({"componentType": U16, "type": "SCALAR", "count": 24}));
    let names = json!({"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2, "COLOR_0": 3});
    doc.push(
        "meshes",
        json!({"primitives": [{"attributes": names, "indices": 4,
        "extensions": {"KHR_draco_mesh_compression": {"bufferView": view, "attributes": names}}}]}),
    );
    doc.push("nodes", json!({"mesh": 0}));
    doc.json["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
    doc.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    doc
}

/// The corners of all triangles, rounded to the grid, sorted.
fn rounded(triangles: &[[[f32; 3]; 3]]) -> Vec<[[i32; 3]; 3]> {
    let mut corners: Vec<_> = triangles.iter().map(|t| t.map(|p| p.map(|c| (c * 2.0).round() as i32))).collect();
    for triangle in &mut corners {
        // Each may start at any corner.
        let first = (0..3).min_by_key(|&k| triangle[k]).unwrap();
        triangle.rotate_left(first);
    }
    corners.sort();
    corners
}

/// The grid's triangles in half units.
fn expected() -> Vec<[[i32; 3]; 3]> {
    let vertex = |x: usize, y: usize| [x as f32, y as f32, if x == 1 && y == 1 { 0.5 } else { 0.0 }];
    let mut triangles = Vec::new();
    for (x, y) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        triangles.push([vertex(x, y), vertex(x + 1, y), vertex(x, y + 1)]);
        triangles.push([vertex(x + 1, y), vertex(x + 1, y + 1), vertex(x, y + 1)]);
    }
    rounded(&triangles)
}

#[test]
fn every_encoding_gives_the_grid() {
    for (stream, tolerance) in [(EDGEBREAKER, 1e-3), (LOSSLESS, 0.0), (SEQUENTIAL, 1e-3)] {
        let scene = grid(&STANDARD.decode(stream).unwrap()).scene();
        assert_eq!(rounded(&scene.triangles), expected());
        // 11 bits over 2 units; nothing is lost without quantisation.
        for c in scene.triangles.as_flattened().as_flattened() {
            assert!((c * 2.0 - (c * 2.0).round()).abs() <= tolerance, "{c}");
        }
        assert!(scene.normals.unwrap().as_flattened().iter().all(|n| n[2] > 0.99));
        assert!(scene.colors.unwrap().as_flattened().iter().all(|c| c[0] == 1.0));
        assert!(!scene.notes.iter().any(|n| n.0.contains("primitive")), "{:?}", scene.notes);
    }
}

#[test]
fn what_is_not_compressed_is_used_first() {
    let mut doc = grid(b"no stream");
    let position = doc.floats("VEC3", &[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
    let indices = doc.accessor("SCALAR", U8, 3, &[0, 1, 2]);
    *doc.primitive() = json!({"attributes": {"POSITION": position}, "indices": indices,
        "extensions": doc.primitive()["extensions"]});
    assert_eq!(doc.scene().triangles, [[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]]]);
    // Positions that have bytes do not help if the indices have none.
    doc.primitive()["indices"] = json!(4);
    assert!(doc.error().contains("KHR_draco_mesh_compression: cannot be decompressed"));
}

#[test]
fn a_stream_that_cannot_be_read_costs_only_its_primitive() {
    let stream = STANDARD.decode(EDGEBREAKER).unwrap();
    for (bytes, words) in [
        (&b"x"[..], "cannot be decompressed"),
        (&stream[..stream.len() / 2], "cannot be decompressed"),
        (&[], "cannot be decompressed"),
    ] {
        let mut doc = grid(bytes);
        let path = "meshes[0].primitives[0].extensions.KHR_draco_mesh_compression";
        let error = doc.error();
        assert!(error.starts_with(path) && error.contains(words), "{error}");
        // Beside another one, it is missing, and never drawn as zeros.
        let position = doc.floats("VEC3", &[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
        doc.mesh(json!({"POSITION": position}));
        doc.push("nodes", json!({"mesh": 1}));
        let scene = doc.scene();
        assert_eq!(scene.triangles.len(), 1);
        assert!(notes(&scene)[0].starts_with(&format!("1 of 2 primitives is missing: {path}")), "{:?}", scene.notes);
    }
    let mut doc = grid(&stream);
    doc.primitive()["extensions"] = json!({"KHR_draco_mesh_compression": 5});
    assert!(doc.error().contains("KHR_draco_mesh_compression: invalid type"));
    // Positions that are nowhere are not zeros.
    let mut doc = grid(&stream);
    doc.primitive()["extensions"]["KHR_draco_mesh_compression"]["attributes"] = json!({"NORMAL": 1});
    assert!(doc.error().contains("has no POSITION, and the file has no other positions"));
    // Wrong ids: of positions, and of what is not needed.
    let mut doc = grid(&stream);
    doc.primitive()["extensions"]["KHR_draco_mesh_compression"]["attributes"]["POSITION"] = json!(9);
    assert!(doc.error().contains("attributes.POSITION: 9 is not the id of a compressed attribute"));
    let mut doc = grid(&stream);
    doc.primitive()["extensions"]["KHR_draco_mesh_compression"]["attributes"]["NORMAL"] = json!(2);
    let scene = doc.scene();
    assert_eq!((scene.triangles.len(), scene.normals.is_none()), (8, true));
    assert!(notes(&scene)[0].starts_with("1 primitive is drawn flat"), "{:?}", scene.notes);
}

#[test]
fn every_flipped_bit_ends_well() {
    for stream in [EDGEBREAKER, LOSSLESS, SEQUENTIAL] {
        let mut doc = grid(&STANDARD.decode(stream).unwrap());
        let mut wrong = 0;
        for bit in 0..doc.bin.len() * 8 {
            doc.bin[bit / 8] ^= 1 << (bit % 8);
            wrong += usize::from(doc.load_with(&NoFiles, &small()).is_err());
            doc.bin[bit / 8] ^= 1 << (bit % 8);
        }
        assert!(wrong > 0);
    }
}

#[test]
fn memory_is_limited() {
    let doc = grid(&STANDARD.decode(EDGEBREAKER).unwrap());
    let bytes = doc.glb().len() as u64;
    let error = (0..200).find_map(|k| {
        let options = LoadOptions { max_bytes: bytes + 100 * k, ..LoadOptions::default() };
        doc.load_with(&NoFiles, &options).err().filter(|error| error.to_string().contains("draco"))
    });
    assert!(matches!(error, Some(LoadError::Invalid { .. } | LoadError::TooLarge { .. })), "{error:?}");
}
