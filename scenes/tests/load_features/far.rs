//! Scenes far from the origin, and numbers that 32 bits do not hold.

use crate::load_common::*;
use glam::DVec3;
use raystep_scenes::{Light, Scene, load, offset_for, write_glb};
use raystep_scenes::{LoadOptions, NoFiles};
use serde_json::{Value, json};

/// Where web maps have the centre of Berlin, in metres.
const FAR: [f64; 3] = [12_958_095.124851028, 4_865_499.469870342, 0.0];

/// A square of 0.4 on each side as mesh 0, without a node.
fn square() -> Doc {
    let mut doc = Doc::new();
    let (a, b) = (0.0, 0.4);
    let position = doc.floats("VEC3", &[a, a, a, b, a, a, a, b, a, b, a, a, b, b, a, a, b, a]);
    doc.mesh(json!({"POSITION": position}));
    doc
}

fn no_lattice_note(scene: &Scene) {
    assert!(!scene.notes.iter().any(|note| note.0.contains("round their shape")), "{:?}", scene.notes);
}

#[test]
fn a_small_square_far_away_keeps_its_shape() {
    let mut doc = square();
    doc.json["nodes"] = json!([{"children": [1, 2, 3, 4], "translation": FAR}, {"mesh": 0},
        {"camera": 0, "translation": [0.2, 0.2, 1]},
        {"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [0.1, 0.2, 3]},
        {"extensions": {"KHR_lights_punctual": {"light": 1}}, "translation": [0.1, 0.2, 3]}]);
    doc.push("cameras", json!({"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.01}}));
    let lights = json!({"lights": [{"type": "point"}, {"type": "spot", "spot": {}}]});
    doc.json["extensions"] = json!({ "KHR_lights_punctual": lights });
    let scene = doc.scene();
    // The square's own coordinates, to the bit: all shapes share the translation, which is the offset.
    assert_eq!(scene.offset.to_array(), FAR);
    assert_eq!(scene.triangles[0], [[0., 0., 0.], [0.4, 0., 0.], [0., 0.4, 0.]]);
    assert_eq!(scene.cameras[0].eye, DVec3::new(0.2, 0.2, 1.0));
    for light in &scene.lights {
        let (Light::Point { position, .. } | Light::Spot { position, .. }) = light else { panic!("{light:?}") };
        assert_eq!(*position, [0.1, 0.2, 3.]);
    }
    no_lattice_note(&scene);
    let [min, max] = scene.bounds_in_file().unwrap();
    assert_eq!(
        (min, max - min),
        (DVec3::from(FAR), DVec3::new(0.4_f32.into(), 0.4_f32.into(), 0.0).map(|size| (min.x + size) - min.x))
    );
}

#[test]
fn shapes_that_are_moved_apart_share_an_offset() {
    let moved = |dx: f64| json!({"mesh": 0, "translation": [FAR[0] + dx, FAR[1], 0]});
    let mut doc = square();
    doc.json["nodes"] = json!([moved(0.0), moved(1.0 / 3.0)]);
    let scene = doc.scene();
    let size = DVec3::new(1.0 / 3.0 + f64::from(0.4_f32), f64::from(0.4_f32), 0.0);
    assert_eq!(scene.offset, offset_for(DVec3::from(FAR), DVec3::from(FAR) + size));
    assert!(scene.offset != DVec3::ZERO);
    // Rounded once: the nearest f32 of what is left. f64 has steps of 1.9e-9 at this distance.
    for (triangle, dx) in [(0, 0.0), (2, 1.0 / 3.0)] {
        let exact = (FAR[0] + dx) - scene.offset.x;
        assert_eq!(scene.triangles[triangle][0][0], exact as f32, "{dx}");
        let width = scene.triangles[triangle][1][0] - scene.triangles[triangle][0][0];
        // One step of f32 at 1, where both corners are rounded.
        assert!((width - 0.4).abs() <= f32::EPSILON, "{width}");
    }
}

#[test]
fn translations_that_cancel_lose_nothing() {
    let mut doc = Doc::triangle();
    doc.json["nodes"] = json!([{"children": [1], "translation": FAR},
        {"mesh": 0, "translation": [-12_958_090, -4_865_490, 0]}]);
    let scene = doc.scene();
    // Nine times its size away, the triangle has an offset of its own.
    assert_eq!(scene.bounds_in_file().unwrap()[0].to_array(), [5.12485102750361, 9.469870341941714, 0.]);
    assert_eq!(scene.triangles, [[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]]]);
    // A larger one has none, and is rounded once.
    doc.json["nodes"][1]["scale"] = json!([4, 4, 1]);
    let scene = doc.scene();
    assert_eq!(scene.offset, DVec3::ZERO);
    assert_eq!(scene.triangles[0][0], [5.12485102750361_f64 as f32, 9.469870341941714_f64 as f32, 0.]);
    assert_eq!(scene.triangles[0][1][0], 9.12485102750361_f64 as f32);
    // The same as matrices, and as integers that are not written as such.
    let matrix = |size: f64, x: f64, y: f64| json!([size, 0, 0, 0, 0, size, 0, 0, 0, 0, 1, 0, x, y, 0, 1]);
    doc.json["nodes"] = json!([{"children": [1], "matrix": matrix(1.0, FAR[0], FAR[1])},
        {"mesh": 0, "matrix": matrix(4.0, -12_958_090.0, -4_865_490.0)}]);
    assert_eq!(doc.scene().triangles, scene.triangles);
    let text = doc.json.to_string().replace("-12958090.0", "-1.295809e7").replace("-4865490.0", "-4865490000e-3");
    assert!(text.contains("-1.295809e7") && text.contains("000e-3"), "{text}");
    let again = load("x", &glb(&buffered(&serde_json::from_str(&text).unwrap(), &doc), &doc.bin), &NoFiles, &small());
    assert_eq!(again.unwrap().triangles, scene.triangles);
}

/// The document with its buffer.
fn buffered(json: &Value, doc: &Doc) -> Value {
    let mut json = json.clone();
    json["buffers"] = json!([{"byteLength": doc.bin.len()}]);
    json
}

#[test]
fn numbers_beyond_32_bits_may_cancel() {
    let mut doc = Doc::triangle();
    doc.json["nodes"] =
        json!([{"children": [1], "scale": [1e60, 1e60, 1e60]}, {"mesh": 0, "scale": [1e-60, 1e-60, 1e-60]}]);
    for corner in doc.scene().triangles[0].concat() {
        // Each product is rounded to 53 bits.
        assert!((corner - corner.round()).abs() <= f32::EPSILON, "{corner}");
    }
    // A huge shape far away: 32 bits hold its coordinates only after the offset is subtracted.
    doc.json["nodes"] = json!([{"mesh": 0, "scale": [1e38, 1e38, 1], "translation": [1e40, 0, 0]}]);
    let scene = doc.scene();
    assert_eq!(scene.offset.to_array(), [1e40, 0., 0.]);
    assert_eq!(scene.triangles[0], [[0.; 3], [1e38, 0., 0.], [0., 1e38, 0.]]);
}

#[test]
fn normalised_integers_are_rounded_once() {
    // 1/3 of 65535 is exact, but 21845/65535 is not as f32; times 3, only f64 gives 1.
    let mut doc = Doc::new();
    let position = doc.accessor("VEC3", U16, 3, &u16s(&[0, 0, 0, 0, 21845, 0, 0, 0, 0, 21845, 0, 0]));
    doc.json["accessors"][position]["normalized"] = json!(true);
    doc.json["bufferViews"][0]["byteStride"] = json!(8);
    doc.mesh(json!({"POSITION": position}));
    doc.json["nodes"] = json!([{"mesh": 0, "scale": [3e7, 3e7, 1], "translation": [-1e7, -1e7, 0]}]);
    assert_eq!(doc.scene().triangles[0], [[-1e7, -1e7, 0.], [0., -1e7, 0.], [-1e7, 0., 0.]]);
}

#[test]
fn morphed_and_skinned_vertices_are_rounded_once() {
    // 1 + 2^-30 is no f32; times 2^30 minus 2^30, it is 1.
    let scale = (1_u64 << 30) as f64;
    let mut doc = Doc::triangle();
    let delta = doc.floats("VEC3", &[(-30_f32).exp2(), 0., 0.].repeat(3));
    doc.primitive()["targets"] = json!([{"POSITION": delta}]);
    doc.json["meshes"][0]["weights"] = json!([1]);
    doc.json["nodes"] = json!([{"mesh": 0, "scale": [scale, 1, 1], "translation": [-scale, 0, 0]}]);
    assert_eq!(doc.scene().triangles[0][1], [1., 0., 0.]);

    let joints = doc.accessor("VEC4", U8, 3, &[0; 12]);
    let weights = doc.floats("VEC4", &[1., 0., 0., 0.].repeat(3));
    doc.primitive()["attributes"]["JOINTS_0"] = json!(joints);
    doc.primitive()["attributes"]["WEIGHTS_0"] = json!(weights);
    doc.json["skins"] = json!([{"joints": [1]}]);
    doc.json["nodes"] = json!([{"mesh": 0, "skin": 0}, {"scale": [scale, 1, 1], "translation": [-scale, 0, 0]}]);
    assert_eq!(doc.scene().triangles[0][1], [1., 0., 0.]);
    // Far away, with a vertex that no joint moves, and so stays where it is: at the origin.
    doc.primitive().as_object_mut().unwrap().remove("targets");
    doc.json["nodes"][1] = json!({"translation": FAR});
    let scene = doc.scene();
    let [a, b, _] = scene.triangles[0];
    assert_eq!([b[0] - a[0], b[1] - a[1]], [1., 0.]);
    let place = scene.offset + DVec3::from(a.map(f64::from));
    // Steps of f32 beside a triangle of 1.
    assert!((place - DVec3::from(FAR)).length() <= 1e-7, "{place}");
}

#[test]
fn positions_that_their_writer_has_rounded_are_noted() {
    let at = |x: f32, size: f32| {
        let mut doc = Doc::new();
        let position = doc.floats("VEC3", &[x, 0., 0., x + size, 0., 0., x, size, 0.]);
        doc.mesh(json!({"POSITION": position}));
        doc.push("nodes", json!({"mesh": 0}));
        let scene = doc.scene();
        (scene.notes.iter().any(|note| note.0.starts_with("1 accessor has positions so far from the origin")), scene)
    };
    // f32 has steps of 1 at 1.3e7, and of 1/16 at 1e6.
    assert!(at(1.3e7, 0.4).0);
    assert!(at(1e6, 100.0).0);
    assert!(!at(1e6, 1000.0).0, "4,096 steps are enough");
    assert!(!at(100.0, 1.0).0 && !at(0.0, 1e-30).0 && !at(0.0, 0.0).0);
    // What is left of the shape is drawn, near the origin.
    let scene = at(1e6, 1.0).1;
    assert!(scene.offset.x > 9e5 && scene.triangles[0][0][0].abs() <= 1.0, "{scene:?}");
}

#[test]
fn an_offset_is_written_and_read_bit_for_bit() {
    let bits =
        |scene: &Scene| scene.triangles.as_flattened().as_flattened().iter().map(|c| c.to_bits()).collect::<Vec<_>>();
    // Sizes at powers of two and offsets at half steps, where a rounded box gives another offset.
    let nodes = [
        json!([{"mesh": 0, "translation": FAR}]),
        json!([{"mesh": 0, "translation": FAR}, {"mesh": 0, "translation": [FAR[0] + 0.7, FAR[1] + 0.1, 0.3]}]),
        json!([{"mesh": 0, "scale": [2.5, 2.5, 1], "translation": [1e7 + 1.0 / 3.0, 4.4, 0]}, {"mesh": 0, "translation": [1e7, 4, 0]}]),
        json!([{"mesh": 0, "rotation": [0.1, 0.2, 0.3, 0.9273618495495703], "translation": [-5e6, 7e6, 1e12]}]),
        json!([{"mesh": 0, "scale": [2.5, 2.5, 2.5], "translation": [4.03125, 0, 0]}, {"mesh": 0, "translation": [4.0, 0.1, 0]}]),
    ];
    for nodes in nodes {
        let mut doc = square();
        doc.json["nodes"] = nodes.clone();
        let near = |x: f64| json!({"translation": [x, 1e-3, 0.1], "extensions": {"KHR_lights_punctual": {"light": 0}}, "camera": 0});
        let x = nodes[0]["translation"][0].as_f64().unwrap();
        doc.push("nodes", near(x + 0.25));
        doc.push("cameras", json!({"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.01}}));
        doc.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
        let scene = doc.scene();
        let again = load("test.glb", &write_glb(&scene).unwrap(), &NoFiles, &LoadOptions::default()).unwrap();
        assert_eq!(again.offset, scene.offset, "{nodes}");
        assert_eq!(bits(&again), bits(&scene), "{nodes}");
        assert_eq!(again.lights, scene.lights, "{nodes}");
        assert_eq!(again.cameras[0].eye, scene.cameras[0].eye, "{nodes}");
    }
}
