//! Every glTF feature that the loader reads, in one tiny document each.

#![allow(clippy::unwrap_used, reason = "a test that cannot make its input has failed")]

mod extensions;
mod far;
mod materials;
mod valid;
mod wrong;

use crate::load_common::*;
use glam::DVec3;
use raystep_scenes::{Light, LoadOptions, NoFiles, Projection, load};
use serde_json::json;
use std::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_4};

const A: [f32; 3] = [0., 0., 0.];
const B: [f32; 3] = [1., 0., 0.];
const C: [f32; 3] = [0., 1., 0.];
const D: [f32; 3] = [1., 1., 0.];

#[test]
fn lists_strips_and_fans_with_every_index_type() {
    // Two triangles that share an edge, both facing +Z, from six, four and four vertices.
    let cases = [
        (4, vec![A, B, C, C, B, D], vec![[A, B, C], [C, B, D]]),
        (5, vec![A, B, C, D], vec![[A, B, C], [B, D, C]]),
        (6, vec![A, B, D, C], vec![[B, D, A], [D, C, A]]),
    ];
    for (mode, corners, expected) in cases {
        for index_type in [0, U8, U16, U32] {
            let mut doc = Doc::new();
            // Indexed, with the vertices reversed.
            let mut vertices = corners.clone();
            if index_type != 0 {
                vertices.reverse();
            }
            let position = doc.floats("VEC3", &vertices.concat());
            doc.mesh(json!({"POSITION": position}));
            doc.primitive()["mode"] = json!(mode);
            let n = corners.len();
            let indices: Vec<u32> = (0..n as u32).rev().collect();
            let bytes = match index_type {
                U8 => indices.iter().map(|&i| i as u8).collect(),
                U16 => u16s(&indices.iter().map(|&i| i as u16).collect::<Vec<_>>()),
                _ => u32s(&indices),
            };
            if index_type != 0 {
                let indices = doc.accessor("SCALAR", index_type, n, &bytes);
                doc.primitive()["indices"] = json!(indices);
            }
            doc.push("nodes", json!({"mesh": 0}));
            assert_eq!(doc.scene().triangles, expected, "mode {mode}, indices {index_type}");
        }
    }
}

#[test]
fn points_and_lines_are_left_out_with_one_note() {
    let mut doc = Doc::triangle();
    for mode in 0..4 {
        let mut primitive = doc.primitive().clone();
        primitive["mode"] = json!(mode);
        doc.push("meshes", json!({"primitives": [primitive]}));
        doc.push("nodes", json!({"mesh": mode + 1}));
    }
    let scene = doc.scene();
    assert_eq!(scene.triangles, [[A, B, C]]);
    assert_eq!(notes(&scene).iter().filter(|n| n.contains("points and lines")).count(), 1);
}

#[test]
fn nodes_transform_their_meshes() {
    // A quarter turn about Z, a scale and a shift, once as TRS on two nodes and once as a matrix.
    let mut doc = Doc::triangle();
    let (s, c) = FRAC_PI_4.sin_cos();
    doc.json["nodes"] = json!([
        {"translation": [10, 0, 0], "rotation": [0, 0, s, c], "children": [1]},
        {"mesh": 0, "scale": [2, 3, 1]},
        {"mesh": 0, "matrix": [0, 2, 0, 0, -3, 0, 0, 0, 0, 0, 1, 0, 10, 0, 0, 1]},
    ]);
    let scene = doc.scene();
    for triangle in &scene.triangles {
        close(&triangle.concat(), &[10., 0., 0., 10., 2., 0., 7., 0., 0.]);
    }
    assert_eq!(scene.triangles.len(), 2);
    assert_eq!(scene.normals, None);
}

#[test]
fn normals_follow_by_the_inverse_transpose() {
    let mut doc = Doc::triangle();
    let slanted = [FRAC_1_SQRT_2, 0., FRAC_1_SQRT_2];
    let normal = doc.floats("VEC3", &slanted.repeat(3));
    doc.primitive()["attributes"]["NORMAL"] = json!(normal);
    doc.json["nodes"][0]["scale"] = json!([2, 1, 1]);
    let scene = doc.scene();
    // (1, 0, 1) with x halved, not doubled.
    close(&scene.normals.unwrap()[0][0], &[1. / 5f32.sqrt(), 0., 2. / 5f32.sqrt()]);
}

#[test]
fn mirrored_meshes_keep_their_front_where_their_normals_point() {
    for scale in [[-1., 1., 1.], [1., -2., 1.], [1., 1., -1.], [-1., -1., -1.], [-1., -1., 1.], [1e-30, -1e-30, 1e-30]]
    {
        let mut doc = Doc::triangle();
        let normal = doc.floats("VEC3", &[0., 0., 1.].repeat(3));
        let color = doc.floats("VEC3", &[1., 0., 0., 0., 1., 0., 0., 0., 1.]);
        doc.primitive()["attributes"]["NORMAL"] = json!(normal);
        doc.primitive()["attributes"]["COLOR_0"] = json!(color);
        doc.json["nodes"][0]["scale"] = json!(scale);
        let scene = doc.scene();
        let [a, b, c] = scene.triangles[0].map(|p| DVec3::from_array(p.map(f64::from)));
        let front = (b - a).cross(c - a).normalize();
        let normal = DVec3::from_array(scene.normals.unwrap()[0][0].map(f64::from));
        assert!(front.dot(normal) > 0.999, "{scale:?}: front {front}, normal {normal}");
        assert!((normal - DVec3::Z * f64::signum(scale[2])).length() < 1e-6, "{scale:?}: {normal}");
        // Colours stay with their vertices: green is at +X of the mesh.
        let green = scene.colors.unwrap()[0].iter().position(|c| *c == [0., 1., 0.]).unwrap();
        assert_eq!(scene.triangles[0][green], [scale[0] as f32, 0., 0.], "{scale:?}");
    }
}

#[test]
fn one_mesh_on_many_nodes_and_several_scenes() {
    let mut doc = Doc::triangle();
    doc.json["nodes"] = json!((0..4).map(|i| json!({"mesh": 0, "translation": [i, 0, 0]})).collect::<Vec<_>>());
    doc.json["scenes"] = json!([{"nodes": [0]}, {"nodes": [1, 2, 3]}, {"name": "empty"}]);
    let xs = |doc: &Doc, scene| {
        let scene = doc.load_with(&NoFiles, &LoadOptions { scene, ..Default::default() }).unwrap();
        scene.triangles.iter().map(|t| t[0][0]).collect::<Vec<_>>()
    };
    assert_eq!(xs(&doc, None), [0.]);
    assert_eq!(xs(&doc, Some(1)), [1., 2., 3.]);
    assert_eq!(xs(&doc, Some(2)), [0f32; 0]);
    doc.json["scene"] = json!(1);
    assert_eq!(xs(&doc, None), [1., 2., 3.]);
    let error = doc.load_with(&NoFiles, &LoadOptions { scene: Some(3), ..Default::default() }).unwrap_err();
    assert!(one_line(&error).contains("the file has 3"), "{error}");
    doc.json["scenes"] = json!([]);
    doc.json.as_object_mut().unwrap().remove("scene");
    assert_eq!(xs(&doc, None), [0., 1., 2., 3.]);
}

#[test]
fn normals_are_flat_where_there_are_none() {
    let mut doc = Doc::triangle();
    let normal = doc.floats("VEC3", &[0., 0., 0., f32::NAN, 0., 0., 0., 3., 4.]);
    doc.primitive()["attributes"]["NORMAL"] = json!(normal);
    // A second mesh without normals, and a triangle of it without area.
    let position = doc.floats("VEC3", &[A, C, B, A, A, A].concat());
    doc.mesh(json!({"POSITION": position}));
    doc.push("nodes", json!({"mesh": 1}));
    let normals = doc.scene().normals.unwrap();
    assert_eq!(normals[0][..2], [[0., 0., 1.]; 2]);
    close(&normals[0][2], &[0., 0.6, 0.8]);
    assert_eq!(normals[1], [[0., 0., -1.]; 3]);
    assert_eq!(normals[2], [[0., 0., 1.]; 3]);
}

#[test]
fn vertex_colors_of_every_type() {
    let float = f32s(&[1., 0., 0.25, 0., 1., 0., 0., 0., 1.]);
    let float4 = f32s(&[1., 0., 0.25, 0.5, 0., 1., 0., 0.5, 0., 0., 1., 0.5]);
    let bytes = [255, 0, 64, 9, 0, 255, 0, 9, 0, 0, 255, 9];
    let shorts = u16s(&[65535, 0, 16384, 0, 65535, 0, 0, 0, 65535]);
    let cases = [
        ("VEC3", F32, &float[..], 0.25),
        ("VEC4", F32, &float4, 0.25),
        ("VEC4", U8, &bytes, 64. / 255.),
        ("VEC3", U16, &shorts, 16384. / 65535.),
    ];
    for (kind, component, bytes, blue) in cases {
        let mut doc = Doc::triangle();
        let color = doc.accessor(kind, component, 3, bytes);
        doc.json["accessors"][color]["normalized"] = json!(component != F32);
        doc.primitive()["attributes"]["COLOR_0"] = json!(color);
        // Meshes without colours are white.
        doc.mesh(json!({"POSITION": 0}));
        doc.push("nodes", json!({"mesh": 1}));
        let colors = doc.scene().colors.unwrap();
        assert_eq!(colors[0], [[1., 0., blue], [0., 1., 0.], [0., 0., 1.]], "{kind} {component}");
        assert_eq!(colors[1], [[1.; 3]; 3]);
    }
}

#[test]
fn colors_that_are_no_numbers_are_white() {
    let mut doc = Doc::triangle();
    let color = doc.floats("VEC3", &[f32::NAN, 0., 0., 0., f32::INFINITY, 0., 0., 0., 1.]);
    doc.primitive()["attributes"]["COLOR_0"] = json!(color);
    assert_eq!(doc.scene().colors.unwrap(), [[[1., 0., 0.], [0., 1., 0.], [0., 0., 1.]]]);
}

#[test]
fn lights_stand_where_their_nodes_do() {
    let mut doc = Doc::triangle();
    doc.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    doc.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "point", "color": [1, 0.5, 0], "intensity": 7},
        {"type": "directional"},
        {"type": "spot", "spot": {"innerConeAngle": 0.25, "outerConeAngle": 0.5}},
        {"type": "spot", "spot": {}},
    ]}});
    let link = |light: u32| json!({"KHR_lights_punctual": {"light": light}});
    // A half turn about Y: -Z becomes +Z.
    doc.push(
        "nodes",
        json!({"translation": [1, 2, 3], "rotation": [0, 1, 0, 0], "scale": [2, 2, 2], "children": [2, 3, 4, 5]}),
    );
    for light in 0..4 {
        doc.push("nodes", json!({"translation": [0, 0, 1], "extensions": link(light)}));
    }
    let scene = doc.scene();
    let (position, color) = ([1., 2., 1.], [1.; 3]);
    let [point, directional, spot, wide] = &scene.lights[..] else { panic!("{:?}", scene.lights) };
    assert_eq!(*point, Light::Point { position, color: [1., 0.5, 0.], intensity: 7. });
    let Light::Directional { direction, intensity: 1., .. } = *directional else { panic!("{directional:?}") };
    close(&direction, &[0., 0., 1.]);
    let (inner_cone, outer_cone) = (0.25, 0.5);
    assert_eq!(*spot, Light::Spot { position, direction, color, intensity: 1., inner_cone, outer_cone });
    assert!(matches!(*wide, Light::Spot { inner_cone: 0., outer_cone: FRAC_PI_4, .. }), "{wide:?}");
    assert_eq!(notes(&scene).iter().filter(|n| n.contains("intensities")).count(), 1);

    doc.json["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"] = json!(1);
    assert!(!notes(&doc.scene()).iter().any(|n| n.contains("intensities")));
}

#[test]
fn cameras_look_where_their_nodes_do() {
    let mut doc = Doc::triangle();
    doc.json["cameras"] = json!([
        {"name": "eye", "type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}},
        {"type": "orthographic", "orthographic": {"xmag": 3, "ymag": 2, "znear": 0, "zfar": 10}},
    ]);
    // A quarter turn about Y: -Z becomes -X. Scaled, sheared and mirrored matrices still give axes.
    let s = FRAC_1_SQRT_2;
    doc.push("nodes", json!({"camera": 0, "translation": [1, 2, 3], "rotation": [0, s, 0, s], "scale": [3, 2, 5]}));
    doc.push("nodes", json!({"camera": 1, "matrix": [-1, 0, 0, 0, 0, 4, 3, 0, 0, 0, 2, 0, 0, 0, 0, 1]}));
    let cameras = doc.scene().cameras;
    assert_eq!(cameras[0].name, "eye");
    assert_eq!(cameras[0].projection, Projection::Perspective { vertical_fov: 0.5 });
    let near = |a: DVec3, b: DVec3| assert!((a - b).length() < 1e-6, "{a} and {b}");
    near(cameras[0].eye, DVec3::new(1., 2., 3.));
    near(cameras[0].forward, DVec3::NEG_X);
    near(cameras[0].right, DVec3::NEG_Z);
    near(cameras[0].up, DVec3::Y);
    assert_eq!(cameras[1].projection, Projection::Orthographic { half_height: 2. });
    near(cameras[1].forward, DVec3::NEG_Z);
    near(cameras[1].up, DVec3::Y);
    near(cameras[1].right, DVec3::X);
}

#[test]
fn notes_say_what_is_left_out_or_assumed() {
    let mut doc = Doc::triangle();
    doc.json["extensionsUsed"] = json!(["KHR_materials_unlit", "KHR_materials_unlit", "KHR_texture_transform"]);
    doc.json["animations"] = json!([{"channels": [], "samplers": []}]);
    let scene = doc.scene();
    let expected = [
        "the extension KHR_materials_unlit is ignored",
        "no camera in the file: using one that frames the scene",
        "no lights in the file: using a headlight at the eye",
        "animations are ignored",
    ];
    assert_eq!(notes(&scene), expected);
    assert_eq!(scene.name, "test");
    // Without these, every shape is in its place.
    doc.json["extensionsRequired"] =
        json!(["KHR_materials_unlit", "KHR_texture_basisu", "KHR_animation_pointer", "KHR_techniques_webgl"]);
    assert_eq!(notes(&doc.scene()).iter().filter(|n| n.contains("is ignored")).count(), 4);
    doc.json["extensionsRequired"] = json!(["KHR_mesh_quantization", "KHR_gaussian_splatting"]);
    assert!(doc.error().contains("requires the extension KHR_gaussian_splatting"));
}

#[test]
fn morph_targets_apply_their_weights() {
    let mut doc = Doc::triangle();
    let up = doc.floats("VEC3", &[0., 0., 2.].repeat(3));
    let aside = doc.floats("VEC3", &[4., 0., 0.].repeat(3));
    doc.primitive()["targets"] = json!([{"POSITION": up}, {"POSITION": aside}]);
    doc.json["meshes"][0]["weights"] = json!([0.5, 0]);
    // The node's own weights come before the mesh's.
    doc.push("nodes", json!({"mesh": 0, "weights": [0, 0.25]}));
    doc.push("nodes", json!({"mesh": 0, "translation": [0, 0, 5]}));
    let scene = doc.scene();
    let first: Vec<[f32; 3]> = scene.triangles.iter().map(|t| t[0]).collect();
    assert_eq!(first, [[0., 0., 1.], [1., 0., 0.], [0., 0., 6.]]);
    assert_eq!(notes(&scene).iter().filter(|n| n.contains("morph")).count(), 1);
}

#[test]
fn skins_take_their_joints_rest_pose() {
    let mut doc = Doc::triangle();
    let joints = doc.accessor("VEC4", U8, 3, &[0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0]);
    let weights = doc.floats("VEC4", &[1., 0., 0., 0., 1., 0., 0., 0., 0.5, 0.5, 0., 0.]);
    let mut bind = vec![1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.];
    bind.extend([1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., -1., 0., 0., 1.]);
    let bind = doc.floats("MAT4", &bind);
    let normal = doc.floats("VEC3", &[0., 0., 1.].repeat(3));
    doc.primitive()["attributes"] = json!({"POSITION": 0, "NORMAL": normal, "JOINTS_0": joints, "WEIGHTS_0": weights});
    doc.json["skins"] = json!([{"joints": [1, 2], "inverseBindMatrices": bind}]);
    // The mesh's own node must not matter.
    doc.json["nodes"] = json!([
        {"mesh": 0, "skin": 0, "translation": [100, 0, 0]},
        {"translation": [0, 0, 3], "children": [2]},
        {"translation": [1, 4, 0]},
    ]);
    let scene = doc.scene();
    // Joint 0 moves by 3 in z, joint 1 also by 4 in y; the last vertex is halfway.
    assert_eq!(scene.triangles, [[[0., 0., 3.], [1., 4., 3.], [0., 3., 3.]]]);
    assert_eq!(notes(&scene).iter().filter(|n| n.contains("skin")).count(), 1);

    // Mirrored joints would turn the skin inside out if its vertices were not swapped.
    doc.json["nodes"][1]["scale"] = json!([-1, 1, 1]);
    let scene = doc.scene();
    let [a, b, c] = scene.triangles[0].map(|p| DVec3::from_array(p.map(f64::from)));
    assert!((b - a).cross(c - a).z > 0.);
    assert_eq!(scene.normals.unwrap()[0], [[0., 0., 1.]; 3]);
}

#[test]
fn names_and_json_files() {
    let mut doc = Doc::triangle();
    doc.json["buffers"] = json!([{"byteLength": doc.bin.len(), "uri": "data:application/gltf-buffer;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]);
    // A byte order mark and zero padding are not allowed, but occur.
    let text = format!("\u{feff}{}\0\0", doc.json);
    let scene = load("Zimmer ü.gltf", text.as_bytes(), &NoFiles, &LoadOptions::default()).unwrap();
    assert_eq!((scene.name.as_str(), &scene.triangles[..]), ("Zimmer ü", &[[A, B, C]][..]));
}
