//! One wrong part of a file costs only itself: the rest is drawn, and a counted note gives the first reason.

#![allow(clippy::unwrap_used, reason = "a test that cannot make its input has failed")]

mod placed;
mod textures;

use crate::load_common::*;
use raystep_scenes::{Scene, load};
use serde_json::{Value, json};

/// Checks that there is a note with all of these words.
#[track_caller]
fn noted(scene: &Scene, words: &[&str]) {
    let found = notes(scene).iter().any(|note| words.iter().all(|word| note.contains(word)));
    assert!(found, "no note says {words:?}: {:?}", scene.notes);
}

/// The triangle on two nodes; the second has a mesh of its own, with the same positions.
fn two() -> Doc {
    let mut doc = Doc::triangle();
    doc.mesh(json!({"POSITION": 0}));
    doc.push("nodes", json!({"mesh": 1}));
    doc
}

/// Replaces the value at a pointer, and expects one triangle of two, and a note that begins and goes on like this.
#[track_caller]
fn one_left(pointer: &str, value: Value, start: &str, words: &str) {
    let mut doc = two();
    *doc.json.pointer_mut(pointer).unwrap_or_else(|| panic!("no {pointer}")) = value;
    let scene = doc.scene();
    assert_eq!(scene.triangles.len(), 1, "{pointer}");
    assert!(notes(&scene)[0].starts_with(start), "{:?}", scene.notes);
    noted(&scene, &[start, words]);
}

#[test]
fn one_shape_that_is_wrong_costs_no_other() {
    let primitive = "1 of 2 primitives is missing: ";
    one_left("/nodes/1/mesh", json!(7), "1 node's mesh is missing: nodes[1].mesh", "refers to mesh 7");
    one_left("/nodes/1/mesh", json!("1"), "1 node's mesh is missing: nodes[1].mesh", "no whole number");
    one_left("/nodes/1", json!(null), "1 node is missing, with all below it: nodes[1]", "is missing");
    one_left("/nodes/1", json!({"mesh": 1, "matrix": [1]}), "1 node is missing", "nodes[1].matrix: has 1 numbers");
    one_left(
        "/nodes/1",
        json!({"mesh": 1, "scale": [1, 1, "x"]}),
        "1 node is missing",
        "nodes[1].scale: \"x\" is no number",
    );
    one_left("/meshes/1", json!(5), "1 node's mesh is missing: meshes[1]: invalid type", "integer");
    one_left("/meshes/1/primitives/0", json!(5), primitive, "meshes[1].primitives[0]: invalid type");
    one_left("/meshes/1/primitives/0/attributes", json!({"POSITION": 9}), primitive, "accessor 9");
    one_left("/meshes/1/primitives/0/attributes", json!({"POSITION": null}), primitive, "POSITION: is missing");
    one_left("/meshes/1/primitives/0", json!({"attributes": {"POSITION": 0}, "mode": 12}), primitive, "0 to 6");
    one_left("/meshes/1/primitives/0", json!({"attributes": {"POSITION": 0}, "indices": 4}), primitive, "accessor 4");
}

#[test]
fn what_is_wrong_is_counted_and_the_first_reason_is_given() {
    let mut doc = Doc::triangle();
    for k in 0..3 {
        doc.mesh(json!({"POSITION": 5 + k}));
        doc.push("nodes", json!({"mesh": k + 1}));
    }
    let scene = doc.scene();
    let note = "3 of 4 primitives are missing; the first: meshes[1].primitives[0].attributes.POSITION: refers to \
                accessor 5, but the file has 1 (counted from 0)";
    assert_eq!(notes(&scene)[0], note);
    // A node that cannot be placed is missing with what is below it; its own reason is given once.
    doc.json["nodes"] = json!([{"mesh": 0}, {"rotation": [1], "children": [2]}, {"mesh": 0}]);
    assert_eq!(doc.scene().triangles.len(), 1);
    noted(&doc.scene(), &["1 node is missing, with all below it: nodes[1].rotation: has 1 numbers; expected 4"]);
}

#[test]
fn triangles_with_wrong_corners_cost_no_others() {
    let nan = f32::NAN;
    let mut doc = Doc::new();
    let position = doc.floats("VEC3", &[0., 0., 0., 1., 0., 0., 0., 1., 0., nan, 0., 0.]);
    doc.mesh(json!({"POSITION": position}));
    let indices = doc.accessor("SCALAR", U8, 10, &[0, 1, 2, 0, 1, 9, 0, 1, 3, 0]);
    doc.primitive()["indices"] = json!(indices);
    doc.push("nodes", json!({"mesh": 0}));
    let scene = doc.scene();
    assert_eq!(scene.triangles, [[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]]]);
    noted(&scene, &["1 triangle has indices beyond the vertices: left out"]);
    noted(&scene, &["1 triangle has a vertex with parts that are no numbers: left out"]);
    noted(&scene, &["1 primitive has corners after its last triangle: meshes[0].primitives[0].indices", "10 corners"]);
    assert_eq!(scene.triangle_materials, [0]);
    // A shape that is moved beyond 32 bits beside one that is not.
    doc.json["nodes"] = json!([{"mesh": 0}, {"mesh": 0, "scale": [1e39, 1, 1]}]);
    let scene = doc.scene();
    assert_eq!(scene.triangles.len(), 1);
    noted(&scene, &["1 triangle has a position beyond 32-bit numbers: left out"]);
}

/// Sets an attribute to each wrong accessor, and expects the triangle and this note.
#[track_caller]
fn without(attribute: &str, start: &str, cases: &[(Value, &str)]) -> Vec<Scene> {
    let scenes = cases.iter().map(|(accessor, words)| {
        let mut doc = Doc::triangle();
        doc.view(&[0; 256]);
        doc.push("bufferViews", json!({"buffer": 1, "byteLength": 64}));
        let index = doc.push("accessors", accessor.clone());
        doc.primitive()["attributes"][attribute] = json!(index);
        doc.primitive()["material"] = json!(0);
        doc.push("materials", json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}));
        doc.push("textures", json!({"source": 0}));
        let view = doc.view(&png(2, 2, TEXELS.as_flattened()));
        doc.push("images", json!({"bufferView": view}));
        let mut json = doc.json.clone();
        json["buffers"] = json!([{"byteLength": doc.bin.len()}, {"byteLength": 64, "uri": "missing.bin"}]);
        let scene = load("x", &glb(&json, &doc.bin), &Files::default(), &small());
        let scene = scene.unwrap_or_else(|error| panic!("{attribute} {accessor}: {error}"));
        assert_eq!((scene.triangles.len(), scene.textures.len()), (1, 1));
        noted(&scene, &[start, words]);
        scene
    });
    scenes.collect()
}

#[test]
fn attributes_that_the_picture_does_not_need() {
    let of = |view: u32, component: u32, kind: &str, count: u64| json!({"bufferView": view, "componentType": component, "type": kind, "count": count});
    let cases = [
        (of(1, F32, "VEC3", 2), "2 elements, but POSITION has 3"),
        (of(1, F32, "VEC4", 3), "Vec4"),
        (of(1, U16, "VEC3", 3), "U16"),
        (of(2, F32, "VEC3", 3), "cannot read \"missing.bin\""),
        (of(9, F32, "VEC3", 3), "bufferView 9"),
        (of(1, F32, "VEC3", 1 << 40), "do not fit"),
        (json!({"componentType": F32, "type": "VEC3", "count": 1_u64 << 40}), "elements, but POSITION"),
        (json!({"type": "VEC3", "count": 3}), "componentType"),
        (json!("x"), "accessors[1]"),
    ];
    for scene in without("NORMAL", "1 primitive is drawn flat, without its normals: ", &cases) {
        assert_eq!(scene.normals, None);
    }
    let cases = [
        (of(1, U8, "VEC4", 3), "not normalized"),
        (of(1, F32, "VEC2", 3), "Vec2"),
        (of(2, F32, "VEC4", 3), "missing.bin"),
    ];
    for scene in without("COLOR_0", "1 primitive is drawn without its colours: ", &cases) {
        assert_eq!(scene.colors, None);
    }
    let cases =
        [(of(1, F32, "VEC3", 3), "Vec3"), (of(1, F32, "VEC2", 99), "2"), (of(2, F32, "VEC2", 3), "missing.bin")];
    for scene in without("TEXCOORD_0", "1 primitive is drawn with one texel of its texture: ", &cases) {
        assert_eq!(scene.texcoords.as_deref(), Some(&[[[0.; 2]; 3]][..]));
    }
    // What is not read cannot be wrong.
    without("TANGENT", "no camera", &[(of(9, F32, "VEC4", 3), "")]);
}
