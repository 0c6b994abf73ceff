//! The hierarchy of nodes, lights, cameras, materials, skins and morph targets.

use super::{noted, two};
use crate::load_common::*;
use raystep_scenes::{Light, Material, Projection};
use serde_json::{Value, json};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

#[test]
fn nodes_that_form_no_trees_are_mended() {
    let mesh = |children: Value| json!({"mesh": 0, "translation": [1, 0, 0], "children": children});
    for (nodes, triangles, reason) in [
        (json!([mesh(json!([0]))]), 1, "nodes[0]: is on a cycle"),
        (json!([mesh(json!([])), mesh(json!([2])), mesh(json!([1]))]), 3, "nodes[1]: is on a cycle"),
        (json!([mesh(json!([2])), mesh(json!([2])), mesh(json!([]))]), 3, "node 2 is a child of node 0 already"),
        (json!([mesh(json!([1, 1])), mesh(json!([]))]), 2, "nodes[0].children[1]: node 1 is a child of node 0"),
        (json!([mesh(json!([9]))]), 1, "nodes[0].children[0]: refers to node 9, but the file has 1"),
        (json!([mesh(json!("x"))]), 1, "nodes[0].children: invalid type"),
    ] {
        let mut doc = Doc::triangle();
        doc.json["nodes"] = nodes;
        let scene = doc.scene();
        assert_eq!(scene.triangles.len(), triangles, "{reason}");
        noted(&scene, &["1 link in the tree of nodes is mended: ", reason]);
    }
    // Everything below a cycle stays below it, however many nodes that are.
    let mut doc = Doc::triangle();
    let last = 100_000;
    let mut nodes = vec![json!({}); last];
    nodes[0] = json!({"mesh": 0});
    nodes.push(json!({"translation": [1, 0, 0], "children": (0..=last).collect::<Vec<_>>()}));
    doc.json["nodes"] = json!(nodes);
    let scene = doc.scene();
    assert_eq!(scene.triangles[0][0], [1., 0., 0.]);
    noted(&scene, &["1 link in the tree of nodes is mended: nodes[100000]: is on a cycle"]);
    let mut doc = Doc::triangle();
    doc.json["nodes"] = json!([{"children": [1], "translation": [1, 0, 0]}, {"mesh": 0}]);
    for (nodes, reason) in [
        (json!([0, 0]), "scenes[0].nodes[1]: node 0 is listed twice"),
        (json!([0, 1]), "scenes[0].nodes[1]: node 1 is a child of node 0"),
        (json!([1]), "scenes[0].nodes[0]: node 1 is a child of node 0"),
        (json!([0, 2]), "scenes[0].nodes[1]: refers to node 2, but the file has 2"),
    ] {
        doc.json["scenes"] = json!([{"nodes": nodes}]);
        let scene = doc.scene();
        // It stays where its parent puts it.
        assert_eq!((scene.triangles.len(), scene.triangles[0][0]), (1, [1., 0., 0.]), "{reason}");
        noted(&scene, &["1 link in the tree of nodes is mended: ", reason]);
    }
    doc.json["scene"] = json!(3);
    noted(&doc.scene(), &["1 choice of a scene is ignored: scene: refers to scene 3, but the file has 1"]);
}

#[test]
fn cameras_that_are_wrong_are_left_out() {
    let perspective = |yfov: f64| json!({"type": "perspective", "perspective": {"yfov": yfov, "znear": 1}});
    let ortho =
        |ymag: f64| json!({"type": "orthographic", "orthographic": {"xmag": 1, "ymag": ymag, "znear": 0, "zfar": 1}});
    for (camera, words) in [
        (perspective(0.), "perspective.yfov: is 0"),
        (perspective(3.2), "perspective.yfov"),
        (perspective(-1.), "perspective.yfov"),
        (perspective(1e300), "perspective.yfov"),
        (ortho(0.), "orthographic.ymag"),
        (ortho(-1.), "orthographic.ymag"),
        (json!({"type": "perspective"}), "no \"perspective\""),
        (json!({"type": "fisheye"}), "perspective or orthographic"),
        (json!(7), "invalid type"),
    ] {
        let mut doc = Doc::triangle();
        doc.json["cameras"] = json!([camera, perspective(1.0)]);
        doc.push("nodes", json!({"camera": 0}));
        doc.push("nodes", json!({"camera": 1}));
        let scene = doc.scene();
        assert_eq!((scene.triangles.len(), scene.cameras.len()), (1, 1));
        noted(&scene, &["1 camera is left out: cameras[0]", words]);
    }
    let mut doc = Doc::triangle();
    doc.push("cameras", perspective(0.7));
    doc.push("nodes", json!({"camera": 0, "scale": [0, 0, 0]}));
    doc.push("nodes", json!({"camera": 5}));
    noted(&doc.scene(), &["2 cameras are left out; the first: nodes[1]: its transform leaves its camera"]);
    // Clipping planes and the width are not used.
    doc.json["nodes"][1] = json!({"camera": 0});
    doc.json["nodes"][2] = json!({"camera": 1});
    doc.push("cameras", json!({"type": "orthographic", "orthographic": {"xmag": 0, "ymag": 2, "znear": 5, "zfar": 1}}));
    doc.json["cameras"][0]["perspective"]["znear"] = json!(-1);
    let scene = doc.scene();
    noted(&scene, &["2 cameras have clipping planes or a width out of range: not used"]);
    assert_eq!(scene.cameras[0].projection, Projection::Perspective { vertical_fov: 0.7 });
    assert_eq!(scene.cameras[1].projection, Projection::Orthographic { half_height: 2.0 });
}

/// A document with this light on node 1.
fn lit(light: Value) -> Doc {
    let mut doc = Doc::triangle();
    doc.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [light]}});
    doc.push("nodes", json!({"extensions": {"KHR_lights_punctual": {"light": 0}}}));
    doc
}

#[test]
fn lights_that_are_wrong_are_left_out() {
    for (light, words) in [
        (json!({"type": "sun"}), "directional, point or spot"),
        (json!({}), "type: is missing"),
        (json!({"type": "point", "color": [1e39, 0, 0]}), "color"),
        (json!({"type": "point", "color": [1, 0]}), "color: has 2 numbers"),
        (json!({"type": "point", "intensity": "bright"}), "intensity"),
        (json!({"type": "spot", "spot": {"outerConeAngle": 0}}), "outer cone angle 0"),
        (json!({"type": "spot", "spot": {"outerConeAngle": -1}}), "outer cone angle -1"),
    ] {
        let mut doc = lit(light);
        let lights = doc.json["extensions"]["KHR_lights_punctual"]["lights"].as_array_mut().unwrap();
        lights.push(json!({"type": "point"}));
        doc.push("nodes", json!({"extensions": {"KHR_lights_punctual": {"light": 1}}}));
        let scene = doc.scene();
        assert_eq!((scene.triangles.len(), scene.lights.len()), (1, 1));
        noted(&scene, &["1 light is left out: extensions.KHR_lights_punctual.lights[0]", words]);
    }
    let mut doc = lit(json!({"type": "directional"}));
    doc.json["nodes"][1]["scale"] = json!([0, 0, 0]);
    doc.push("nodes", json!({"extensions": {"KHR_lights_punctual": {"light": 5}}}));
    noted(&doc.scene(), &["2 lights are left out; the first: nodes[1]: its transform leaves its light"]);
    doc.json.as_object_mut().unwrap().remove("extensions");
    noted(&doc.scene(), &["2 lights are left out", "refers to light 0, but the file has 0"]);
}

#[test]
fn cones_of_spot_lights_are_mended() {
    let angles = |spot: Value| {
        let scene = lit(json!({"type": "spot", "spot": spot})).scene();
        let Light::Spot { inner_cone, outer_cone, .. } = scene.lights[0] else { panic!("{:?}", scene.lights) };
        assert!(0.0 <= inner_cone && inner_cone < outer_cone && outer_cone <= FRAC_PI_2, "{inner_cone} {outer_cone}");
        let is_noted = notes(&scene).contains(&"1 spot light has angles other than 0 <= inner < outer <= pi/2: mended");
        ([inner_cone, outer_cone], is_noted)
    };
    let sharp = |outer: f32| [outer.next_down(), outer];
    let cones = |inner: f64, outer: f64| json!({"innerConeAngle": inner, "outerConeAngle": outer});
    // Equal, as f64 or only as f32.
    assert_eq!(angles(cones(0.5, 0.5)), (sharp(0.5), true));
    let equal = cones(0.08968102931976317, 0.08968102931976318);
    assert_eq!(angles(equal), (sharp(0.08968102931976318_f64 as f32), true));
    assert_eq!(angles(cones(0.6, 0.3)), (sharp(0.3), true));
    assert_eq!(angles(cones(0.1, 1.7)), ([0.1, FRAC_PI_2], true));
    assert_eq!(angles(cones(2.0, 3.0)), (sharp(FRAC_PI_2), true));
    assert_eq!(angles(cones(-0.1, 0.5)), ([0.0, 0.5], true));
    assert_eq!(angles(json!({"outerConeAngle": 0.3})), ([0.0, 0.3], false));
    // Writers round pi/2 up.
    assert_eq!(angles(cones(0.1, 1.5707964)), ([0.1, FRAC_PI_2], false));
    assert_eq!(angles(cones(0.1, std::f64::consts::FRAC_PI_2)), ([0.1, FRAC_PI_2], false));
    assert_eq!(angles(json!(null)), ([0.0, FRAC_PI_4], true));
}

#[test]
fn materials_have_defaults_where_they_are_wrong() {
    let grey = json!({"baseColorFactor": [0.5, 0.5, 0.5, 1]});
    for (material, expected, words) in [
        (json!(5), Material::default(), "materials[0]: invalid type"),
        (
            json!({"pbrMetallicRoughness": {"baseColorFactor": [1, 1]}, "doubleSided": true}),
            Material { double_sided: true, ..Material::default() },
            "materials[0].pbrMetallicRoughness.baseColorFactor: has 2 numbers; expected 3",
        ),
        (
            json!({"pbrMetallicRoughness": grey, "alphaMode": "GLASS"}),
            Material { base_color: [0.5; 3], ..Material::default() },
            "OPAQUE, MASK or BLEND",
        ),
        (
            json!({"pbrMetallicRoughness": grey, "emissiveFactor": [1e39, 0, 0]}),
            Material { base_color: [0.5; 3], ..Material::default() },
            "materials[0].emissiveFactor",
        ),
        (
            json!({"emissiveFactor": [1, 0, 0], "doubleSided": "yes"}),
            Material { emissive: [1., 0., 0.], ..Material::default() },
            "materials[0].doubleSided",
        ),
    ] {
        let mut doc = Doc::triangle();
        doc.primitive()["material"] = json!(0);
        doc.push("materials", material);
        let scene = doc.scene();
        assert_eq!(scene.materials, [expected]);
        noted(&scene, &["1 property of a material has its default: ", words]);
    }
    // Three numbers are enough for a colour.
    let mut doc = Doc::triangle();
    doc.primitive()["material"] = json!(0);
    doc.push("materials", json!({"name": "\u{1}", "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3]}}));
    assert_eq!(doc.scene().materials[0].base_color, [0.1, 0.2, 0.3]);
    for material in [json!(7), json!(-1), json!("red")] {
        doc.primitive()["material"] = material;
        let scene = doc.scene();
        assert_eq!(scene.materials, [Material::default()]);
        noted(&scene, &["1 property of a material has its default: ", "material"]);
    }
}

#[test]
fn skins_and_morph_targets_that_are_wrong_are_left_out() {
    let mut doc = two();
    let joints = doc.accessor("VEC4", U8, 3, &[0, 0, 0, 0, 0, 0, 0, 0, 3, 0, 0, 0]);
    let weights = doc.floats("VEC4", &[1., 0., 0., 0.].repeat(3));
    doc.primitive()["attributes"] = json!({"POSITION": 0, "JOINTS_0": joints, "WEIGHTS_0": weights});
    doc.json["skins"] = json!([{"joints": [2]}]);
    doc.json["nodes"][0] = json!({"mesh": 0, "skin": 0, "translation": [0, 0, 1]});
    doc.push("nodes", json!({"translation": [9, 9, 9]}));
    let check = |change: &dyn Fn(&mut Doc), words: &str| {
        let mut doc = doc.clone();
        change(&mut doc);
        let scene = doc.scene();
        // It is drawn where its node is.
        assert_eq!((scene.triangles.len(), scene.triangles[0][0]), (2, [0., 0., 1.]), "{words}");
        noted(&scene, &["1 primitive is drawn without its skin: ", words]);
    };
    check(&|_| {}, "vertex 2 names joint 3, but the skin has 1");
    check(&|doc| doc.json["skins"] = json!([{"joints": [7]}]), "skins[0].joints[0]: node 7 has no transform");
    check(&|doc| doc.json["skins"] = json!([{"joints": [2], "inverseBindMatrices": 9}]), "accessor 9");
    check(&|doc| doc.json["skins"] = json!([4]), "skins[0]: invalid type");
    check(&|doc| doc.json["nodes"][0]["skin"] = json!(3), "refers to skin 3, but the file has 1");
    check(&|doc| doc.json["nodes"][2]["matrix"] = json!([1]), "skins[0].joints[0]: node 2 has no transform");
    check(&|doc| doc.json["accessors"][weights]["count"] = json!(2), "has 2 elements, but POSITION has 3");
    check(&|doc| doc.json["accessors"][joints]["type"] = json!("SCALAR"), "Scalar of U8");

    let mut doc = Doc::triangle();
    let good = doc.floats("VEC3", &[0., 0., 4.].repeat(3));
    let nan = doc.floats("VEC3", &[f32::NAN; 9]);
    doc.json["meshes"][0]["weights"] = json!([0.5, 1, 1, 1]);
    doc.primitive()["targets"] = json!([{"POSITION": good}, {"POSITION": 99}, {"POSITION": nan}, 5]);
    let scene = doc.scene();
    assert_eq!(scene.triangles[0][0], [0., 0., 2.]);
    noted(&scene, &["1 primitive is drawn without a morph target: meshes[0].primitives[0].targets[1].POSITION"]);
}
