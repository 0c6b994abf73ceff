//! Extensions that change which shapes are in the picture, and where.

use crate::load_common::*;
use raystep_scenes::Scene;
use serde_json::{Value, json};
use std::f32::consts::FRAC_1_SQRT_2;

/// The first corner of each triangle.
fn firsts(scene: &Scene) -> Vec<[f32; 3]> {
    scene.triangles.iter().map(|triangle| triangle[0]).collect()
}

/// The triangle with instances of these attributes.
fn instanced(doc: &mut Doc, attributes: Value) {
    doc.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    doc.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    doc.json["nodes"][0]["extensions"] = json!({"EXT_mesh_gpu_instancing": {"attributes": attributes}});
}

#[test]
fn a_mesh_is_shown_at_each_of_its_instances() {
    let mut doc = Doc::triangle();
    let translation = doc.floats("VEC3", &[0., 0., 0., 3., 0., 0., 6., 0., 0.]);
    instanced(&mut doc, json!({"TRANSLATION": translation}));
    assert_eq!(firsts(&doc.scene()), [[0.; 3], [3., 0., 0.], [6., 0., 0.]]);
    // Below the node's own transform, which comes last.
    doc.json["nodes"] = json!([{"mesh": 0, "extensions": doc.json["nodes"][0]["extensions"]},
        {"children": [0], "translation": [0, 0, 5], "scale": [2, 1, 1]}]);
    assert_eq!(firsts(&doc.scene()), [[0., 0., 5.], [6., 0., 5.], [12., 0., 5.]]);
    // Without attributes, and without a mesh, there are no instances.
    instanced(&mut doc, json!({}));
    assert_eq!(doc.scene().triangles.len(), 1);
}

#[test]
fn instances_are_scaled_rotated_and_moved_in_this_order() {
    // A quarter turn about Z in every allowed type.
    let s = FRAC_1_SQRT_2;
    let (bytes, shorts) = (i8s(&[0, 0, 90, 90]), i16s(&[0, 0, 23170, 23170]));
    for (component, bytes) in [(F32, f32s(&[0., 0., s, s])), (I8, bytes), (I16, shorts)] {
        let mut doc = Doc::triangle();
        let rotation = doc.accessor("VEC4", component, 1, &bytes);
        doc.json["accessors"][rotation]["normalized"] = json!(component != F32);
        let translation = doc.floats("VEC3", &[10., 0., 0.]);
        let scale = doc.floats("VEC3", &[2., 3., 1.]);
        instanced(&mut doc, json!({"TRANSLATION": translation, "ROTATION": rotation, "SCALE": scale, "_ID": 99}));
        let [triangle] = doc.scene().triangles[..] else { panic!("one") };
        close(&triangle.concat(), &[10., 0., 0., 10., 2., 0., 7., 0., 0.]);
    }
    // Instances that mirror keep their front, where their normals point.
    let mut doc = Doc::triangle();
    let normal = doc.floats("VEC3", &[0., 0., 1.].repeat(3));
    doc.primitive()["attributes"]["NORMAL"] = json!(normal);
    let scale = doc.floats("VEC3", &[-1., 1., 1.]);
    instanced(&mut doc, json!({"SCALE": scale}));
    let scene = doc.scene();
    assert_eq!(scene.triangles, [[[0., 0., 0.], [0., 1., 0.], [-1., 0., 0.]]]);
    assert_eq!(scene.normals.unwrap(), [[[0., 0., 1.]; 3]]);
}

#[test]
fn instances_may_be_sparse_or_nearly_all_zeros() {
    let mut doc = Doc::triangle();
    let (indices, values) = (doc.view(&u32s(&[69_999])), doc.view(&f32s(&[0., 0., 7.])));
    let translation = doc.push("accessors", json!({"componentType": F32, "type": "VEC3", "count": 70_000,
        "sparse": {"count": 1, "indices": {"bufferView": indices, "componentType": U32}, "values": {"bufferView": values}}}));
    instanced(&mut doc, json!({"TRANSLATION": translation}));
    let scene = doc.scene();
    assert_eq!(
        (scene.triangles.len(), scene.triangles[0][0], scene.triangles[69_999][0]),
        (70_000, [0.; 3], [0., 0., 7.])
    );
    // As many as memory allows.
    doc.json["accessors"][translation]["count"] = json!(1_u64 << 40);
    assert!(doc.error().contains("more bytes"));
}

#[test]
fn instances_with_different_counts_or_no_numbers_are_noted() {
    let mut doc = Doc::triangle();
    let translation = doc.floats("VEC3", &[1., 0., 0., f32::NAN, 0., 0., 3., 0., 0.]);
    let rotation = doc.floats("VEC4", &[0.; 16]);
    instanced(&mut doc, json!({"TRANSLATION": translation, "ROTATION": rotation}));
    let scene = doc.scene();
    assert_eq!(firsts(&scene), [[1., 0., 0.], [3., 0., 0.]]);
    for note in [
        "1 node has instances with different numbers of attributes: as many drawn as have all of them",
        "1 instance has a transform with parts that are no numbers: left out",
        "2 nodes have a rotation of length 0: drawn without it",
    ] {
        assert!(notes(&scene).contains(&note), "{:?}", scene.notes);
    }
    // Instances that are nowhere cost their mesh, and no other.
    doc.json["accessors"][translation]["count"] = json!(99);
    assert!(doc.error().contains("nodes[0].extensions.EXT_mesh_gpu_instancing.attributes.TRANSLATION"));
    doc.push("nodes", json!({"mesh": 0}));
    let scene = doc.scene();
    assert_eq!(scene.triangles.len(), 1);
    assert!(notes(&scene)[0].starts_with("1 node's mesh is missing: nodes[0].extensions"), "{:?}", scene.notes);
}

#[test]
fn instances_far_away_are_placed_in_f64() {
    let mut doc = Doc::triangle();
    let translation = doc.floats("VEC3", &[0., 0., 0., 0.25, 0., 0.]);
    instanced(&mut doc, json!({"TRANSLATION": translation}));
    doc.json["nodes"][0]["translation"] = json!([1e9, 0, 0]);
    let scene = doc.scene();
    let [a, b] = firsts(&scene)[..] else { panic!("two") };
    assert_eq!((b[0] - a[0], scene.triangles[0][1][0] - a[0]), (0.25, 1.));
}

#[test]
fn instances_of_skins_keep_their_shape() {
    let mut doc = Doc::triangle();
    let joints = doc.accessor("VEC4", U8, 3, &[0; 12]);
    let weights = doc.floats("VEC4", &[1., 0., 0., 0.].repeat(3));
    doc.primitive()["attributes"]["JOINTS_0"] = json!(joints);
    doc.primitive()["attributes"]["WEIGHTS_0"] = json!(weights);
    doc.json["skins"] = json!([{"joints": [1]}]);
    // The node's own transform does not move its skin; the joint does, and then each instance.
    doc.json["nodes"] = json!([{"mesh": 0, "skin": 0, "translation": [100, 0, 0]}, {"translation": [0, 0, 2]}]);
    let translation = doc.floats("VEC3", &[0., 0., 0., 5., 0., 0.]);
    instanced(&mut doc, json!({"TRANSLATION": translation}));
    assert_eq!(firsts(&doc.scene()), [[0., 0., 2.], [5., 0., 2.]]);
    // The same far from the origin.
    doc.json["nodes"][1]["translation"] = json!([1e9, 0, 2]);
    let scene = doc.scene();
    let [a, b] = firsts(&scene)[..] else { panic!("two") };
    assert_eq!(([b[0] - a[0], a[2] - b[2]], scene.offset.x + f64::from(a[0])), ([5., 0.], 1e9));
}

#[test]
fn hidden_nodes_hide_all_below_but_their_cameras() {
    let mut doc = Doc::triangle();
    doc.json["extensionsRequired"] = json!(["KHR_node_visibility", "KHR_lights_punctual"]);
    doc.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
    doc.push("cameras", json!({"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.01}}));
    let visible = |visible: bool| json!({"KHR_node_visibility": {"visible": visible}});
    doc.json["nodes"] = json!([
        {"mesh": 0},
        {"mesh": 0, "translation": [3, 0, 0], "extensions": visible(false), "children": [2, 3]},
        // Visible below what is hidden is hidden.
        {"mesh": 0, "extensions": visible(true)},
        {"camera": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}},
        {"mesh": 0, "translation": [0, 5, 0], "extensions": visible(true)},
        {"mesh": 0, "translation": [0, 6, 0], "extensions": {"KHR_node_visibility": {}}},
    ]);
    let scene = doc.scene();
    assert_eq!(firsts(&scene), [[0.; 3], [0., 5., 0.], [0., 6., 0.]]);
    assert_eq!((scene.lights.len(), scene.cameras.len()), (0, 1));
    assert_eq!(scene.cameras[0].eye.x, 3.0);
    let note = "1 node has \"visible\": false (KHR_node_visibility): left out, with all below";
    assert!(notes(&scene).contains(&note), "{:?}", scene.notes);
    // All of it hidden is an empty scene, not a wrong one.
    doc.json["nodes"] = json!([{"mesh": 0, "extensions": visible(false)}]);
    assert_eq!(doc.scene().triangles.len(), 0);
    // A value that is none hides nothing.
    doc.json["nodes"] = json!([{"mesh": 0, "extensions": {"KHR_node_visibility": {"visible": "no"}}}]);
    assert_eq!(doc.scene().triangles.len(), 1);
}
