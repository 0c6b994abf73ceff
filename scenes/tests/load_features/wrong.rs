//! Faults that do not prevent loading: one note of each kind, with its count.

use crate::load_common::*;
use serde_json::json;

/// The notes, without the two that every scene without camera and lights has.
fn counted(doc: &Doc) -> Vec<String> {
    let scene = doc.scene();
    let own = |n: &&str| !n.starts_with("no camera") && !n.starts_with("no lights in");
    notes(&scene).into_iter().filter(own).map(str::to_owned).collect()
}

#[test]
fn what_is_right_has_no_note() {
    let mut doc = Doc::triangle();
    let normal = doc.floats("VEC3", &[0., 0., 1.].repeat(3));
    // 0.1 and its nearest f32 differ.
    let color = doc.floats("VEC3", &[0.1, 1., 0.].repeat(3));
    doc.json["accessors"][color]["min"] = json!([0.1, 1, 0]);
    doc.json["accessors"][color]["max"] = json!([0.1, 1, 0]);
    doc.json["accessors"][0]["min"] = json!([0, 0, 0]);
    doc.json["accessors"][0]["max"] = json!([1, 1, 0]);
    doc.primitive()["attributes"] = json!({"POSITION": 0, "NORMAL": normal, "COLOR_0": color});
    doc.json["nodes"][0]["rotation"] = json!([0.0, 0.707, 0.0, 0.707]);
    assert_eq!(counted(&doc), [""; 0]);
}

#[test]
fn normals_and_colours_that_are_none_are_counted() {
    let mut doc = Doc::triangle();
    let nan = f32::NAN;
    let normal = doc.floats("VEC3", &[0., nan, 1., 0., 0., 0., 0., 0., 2.]);
    let color = doc.floats("VEC4", &[nan, nan, 0., 1., 2., 0., 0., 1., 0., -0.5, 0., 1.]);
    doc.primitive()["attributes"] = json!({"POSITION": 0, "NORMAL": normal, "COLOR_0": color});
    // Two primitives that share vertices do not add to the count.
    let again = doc.primitive().clone();
    doc.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(again);
    let expected = [
        "2 normals have no direction (zeros, NaN or infinities): drawn flat there",
        "1 vertex colour has parts that are no numbers: drawn as 1",
        "2 vertex colours have parts outside of 0 to 1: drawn as they are",
    ];
    assert_eq!(counted(&doc), expected);
    let scene = doc.scene();
    assert_eq!(scene.normals.unwrap()[0], [[0., 0., 1.]; 3]);
    assert_eq!(scene.colors.unwrap()[0], [[1., 1., 0.], [2., 0., 0.], [0., -0.5, 0.]]);
}

#[test]
fn texture_coordinates_that_are_no_numbers_are_counted() {
    let mut doc = Doc::triangle();
    let uv = doc.floats("VEC2", &[f32::NAN, 0.5, 1., f32::INFINITY, 0.25, 1.]);
    doc.primitive()["attributes"]["TEXCOORD_0"] = json!(uv);
    doc.primitive()["material"] = json!(0);
    doc.push("materials", json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}));
    doc.push("textures", json!({"source": 0}));
    let view = doc.view(&png(1, 1, &[9, 8, 7, 255]));
    doc.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
    assert_eq!(counted(&doc), ["2 texture coordinates have parts that are no numbers: drawn as 0"]);
    assert_eq!(doc.scene().texcoords.unwrap()[0], [[0., 0.5], [1., 0.], [0.25, 1.]]);
}

#[test]
fn transforms_that_are_wrong_are_counted() {
    let matrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1];
    let mut doc = Doc::triangle();
    doc.json["nodes"] = json!([
        {"mesh": 0, "matrix": matrix, "translation": [9, 9, 9]},
        {"mesh": 0, "matrix": matrix},
        {"mesh": 0, "rotation": [0, 0, 0, 2]},
        {"mesh": 0, "rotation": [0, 0, 0, 1]},
        {"mesh": 0, "rotation": [0, 0, 0, 0.5]},
    ]);
    let expected = [
        "1 node has a matrix beside a translation, rotation or scale: drawn by the matrix",
        "2 nodes have a rotation of another length than 1: drawn as if it were 1",
    ];
    assert_eq!(counted(&doc), expected);
    let scene = doc.scene();
    assert_eq!(
        scene.triangles.iter().map(|t| t[1]).collect::<Vec<_>>()[..3],
        [[6., 0., 0.], [6., 0., 0.], [1., 0., 0.]]
    );
    // Faults that are not shown do not matter.
    doc.json["scenes"] = json!([{"nodes": [1, 3]}]);
    assert_eq!(counted(&doc), [""; 0]);
}

#[test]
fn colours_of_materials_and_lights_out_of_range_are_counted() {
    let mut doc = Doc::triangle();
    doc.push(
        "materials",
        json!({"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1.5, 1]}, "emissiveFactor": [2, 0, 0]}),
    );
    doc.push("materials", json!({"pbrMetallicRoughness": {"baseColorFactor": [-1, 1, 1, 1]}}));
    doc.primitive()["material"] = json!(0);
    let light = |red: f32| json!({"type": "point", "color": [red, 1, 1]});
    doc.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [light(3.0), light(1.0)]}});
    for light in [0, 0, 1] {
        doc.push("nodes", json!({"extensions": {"KHR_lights_punctual": {"light": light}}}));
    }
    let expected = [
        "2 material factors have parts outside of 0 to 1: drawn as they are",
        "1 light has a colour outside of 0 to 1: drawn as it is",
    ];
    assert_eq!(counted(&doc), expected);
    assert_eq!(doc.scene().materials[0].base_color, [1., 1., 1.5]);
}

#[test]
fn bounds_that_do_not_hold_are_counted() {
    let mut doc = Doc::triangle();
    doc.json["accessors"][0]["max"] = json!([0.5, 1, 0]);
    let color = doc.accessor("VEC3", U8, 3, &[0, 128, 255, 7, 0, 0, 0, 0, 0]);
    doc.json["accessors"][color]["normalized"] = json!(true);
    doc.json["accessors"][color]["min"] = json!([0, 0, 0]);
    doc.json["accessors"][color]["max"] = json!([7, 128, 255]);
    let indices = doc.accessor("SCALAR", U8, 3, &[0, 1, 2]);
    doc.json["accessors"][indices]["min"] = json!([1]);
    doc.primitive()["attributes"]["COLOR_0"] = json!(color);
    doc.primitive()["indices"] = json!(indices);
    let two = "2 accessors have elements outside of min and max: drawn as they are";
    assert_eq!(counted(&doc), [two]);
    doc.json["accessors"][color]["max"] = json!([6, 128, 255]);
    doc.json["accessors"][indices]["min"] = json!([0]);
    assert_eq!(counted(&doc), [two]);
    assert_eq!(doc.scene().triangles, [[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]]]);
}
