//! Which format a file has, and what is said of files that are not read.

#![allow(clippy::unwrap_used, reason = "a test that cannot make its input has failed")]

use crate::load_common::Doc;
use crate::mesh_common::{TRIANGLE, error, read, scene};
use raystep_scenes::{ENDINGS, LoadError, LoadOptions, NoFiles, external_files, load};

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
const STL: &str =
    "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";

#[test]
fn contents_decide_where_they_are_certain() {
    let glb = Doc::triangle().glb();
    for name in ["a", "a.obj", "a.ply", "a.stl", "a.gltf", "a.glb", "a.txt", "a.b.OBJ"] {
        for bytes in [glb.as_slice(), PLY.as_bytes(), STL.as_bytes()] {
            assert_eq!(scene(name, bytes).triangles, TRIANGLE, "{name}");
        }
    }
}

#[test]
fn an_obj_is_known_by_the_ending_of_its_name() {
    for name in ["a.obj", "a.OBJ", "a.b.Obj", ".obj"] {
        assert_eq!(scene(name, OBJ.as_bytes()).triangles, TRIANGLE, "{name}");
    }
    for name in ["a", "obj", "a.objx", "a.gltf", "a.glb", "a.mtl"] {
        assert_eq!(read(name, OBJ.as_bytes()), Err(LoadError::UnknownFormat), "{name}");
    }
    let wanted =
        "not a scene: raystep reads glTF, GLB, PLY and STL by what they contain, and OBJ if its name ends in .obj";
    assert_eq!(error("a.txt", OBJ.as_bytes()), wanted);
}

#[test]
fn a_scene_is_named_after_its_file_without_its_ending() {
    for (name, wanted) in
        [("a.b.ply", "a.b"), ("a.PLY", "a"), ("a.txt", "a.txt"), ("a", "a"), ("ü.stl", "ü"), (".obj", "")]
    {
        assert_eq!(scene(name, PLY.as_bytes()).name, wanted, "{name}");
    }
    assert_eq!(ENDINGS, ["gltf", "glb", "obj", "ply", "stl"]);
}

#[test]
fn files_of_other_kinds_are_named() {
    let mut mesh_of_3ds = b"MM\x08\0\0\0\0\0".to_vec();
    mesh_of_3ds[2] = 8;
    for (bytes, kind) in [
        (&b"Kaydara FBX Binary  \0\x1a\0"[..], "FBX"),
        (b"; FBX 7.7.0 project file\n", "FBX"),
        (&mesh_of_3ds, "3DS"),
        (b"PXR-USDC\0\0", "USD"),
        (b"#usda 1.0\n", "USD"),
        (b"<?xml version=\"1.0\"?>\n<COLLADA xmlns=\"x\">", "Collada"),
        (b"\xef\xbb\xbf<?xml?><x3d>", "X3D"),
        (b"<!doctype HTML>", "HTML"),
        (b"<svg>", "XML"),
        (b"PK\x03\x04\x14\0", "a ZIP archive"),
        (b"\x1f\x8b\x08\0", "compressed by gzip"),
        (b"\x28\xb5\x2f\xfd\0", "compressed by Zstandard"),
        (b"BLENDER-v300", "a file of Blender"),
        (b"version https://git-lfs.github.com/spec/v1\n", "a pointer of Git LFS, not the file itself"),
        (b"\x89PNG\r\n", "a PNG image"),
    ] {
        for name in ["a.obj", "a.stl", "a.bin"] {
            let wanted = format!("the file is {kind}; raystep reads glTF 2.0, GLB, OBJ, PLY and STL");
            assert_eq!(error(name, bytes), wanted);
        }
    }
    assert_eq!(read("a.bin", b"MM\x09\0\0\0\0\0"), Err(LoadError::UnknownFormat));
}

#[test]
fn gltf_1_is_named() {
    for file in [
        r#"{"asset": {"version": "1.0"}, "meshes": {"a": {"primitives": []}}, "nodes": {}}"#,
        r#"{"nodes": {"a": {"children": []}}, "asset": {"version": "1.1", "premultipliedAlpha": true}}"#,
        r#"{"asset": {"version": 1.0}, "scene": "main"}"#,
        "glTF\x01\0\0\0\x14\0\0\0\0\0\0\0\0\0\0\0",
    ] {
        let wanted = "the file is glTF 1.0; raystep reads glTF 2.0, GLB, OBJ, PLY and STL";
        assert_eq!(error("a.gltf", file.as_bytes()), wanted, "{file}");
    }
    assert!(error("a.gltf", br#"{"asset": {"version": "3.0"}}"#).contains("3.0"));
}

#[test]
fn utf_16_is_named_whatever_the_format() {
    for text in ["{\"asset\": {\"version\": \"2.0\"}}", OBJ, PLY, STL] {
        for name in ENDINGS.map(|ending| format!("a.{ending}")) {
            let units = format!("\u{feff}{text}").encode_utf16().collect::<Vec<_>>();
            let bytes: Vec<u8> = units.iter().flat_map(|unit| unit.to_le_bytes()).collect();
            assert_eq!(error(&name, &bytes), "the file is UTF-16 text; save it as UTF-8");
        }
    }
}

#[test]
fn only_gltf_has_several_scenes_and_external_files() {
    let load = |name: &str, text: &str, scene| {
        load(name, text.as_bytes(), &NoFiles, &LoadOptions { scene, ..LoadOptions::default() })
    };
    for (name, text) in [("a.obj", OBJ), ("a.ply", PLY), ("a.stl", STL)] {
        assert_eq!(load(name, text, Some(1)), Err(LoadError::NoSuchScene { asked: 1, count: 1 }));
        assert_eq!(load(name, text, Some(0)), load(name, text, None));
        assert_eq!(external_files(text.as_bytes(), 1 << 20), Ok(Vec::new()), "{name}");
        assert!(matches!(external_files(text.as_bytes(), 10), Err(LoadError::TooLarge { .. })));
    }
    assert_eq!(external_files(b"anything", 100), Ok(Vec::new()));
}

#[test]
fn the_limit_of_memory_holds_for_every_format() {
    for (name, text) in [("a.obj", OBJ), ("a.ply", PLY), ("a.stl", STL)] {
        let with = |max_bytes| {
            let options = LoadOptions { max_bytes, ..LoadOptions::default() };
            load(name, text.as_bytes(), &NoFiles, &options)
        };
        let least = (0..).find(|&bytes| with(bytes).is_ok()).unwrap();
        for bytes in 0..least {
            assert!(matches!(with(bytes), Err(LoadError::TooLarge { .. })), "{name} {bytes}");
        }
        // The file, three positions, three indices, a size, and a triangle with its material.
        assert!(least >= text.len() as u64 + 3 * 24 + 3 * 4 + 4 + 36 + 4 && least < 1000, "{name} {least}");
    }
}
