//! Materials: their factors, and what surfaces they are.

use crate::load_common::*;
use raystep_scenes::{Material, Optics};
use serde_json::json;

#[test]
fn materials_and_their_defaults() {
    let mut doc = Doc::triangle();
    assert_eq!(doc.scene().materials, [Material::default()]);
    // Of three materials two are used, one of them twice; one mesh has none.
    for name in ["first", "unused", "glowing"] {
        doc.push("materials", json!({"name": name}));
    }
    doc.json["materials"][2] = json!({"name": "glowing", "doubleSided": true, "emissiveFactor": [0.5, 0, 1],
        "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 0.4]},
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4}}});
    for material in [Some(2), Some(0), None, Some(2)] {
        let mut primitive = doc.primitive().clone();
        if let Some(material) = material {
            primitive["material"] = json!(material);
        }
        let mesh = doc.push("meshes", json!({"primitives": [primitive]}));
        doc.push("nodes", json!({"mesh": mesh}));
    }
    let scene = doc.scene();
    let names: Vec<&str> = scene.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["", "first", "glowing"]);
    assert_eq!(scene.triangle_materials, [0, 2, 1, 0, 2]);
    let glowing = &scene.materials[2];
    assert_eq!((glowing.base_color, glowing.emissive), ([0.1, 0.2, 0.3], [2., 0., 4.]));
    assert!(glowing.double_sided && !scene.materials[1].double_sided);
}

/// The surface of a material with this JSON, and the notes about it.
fn optics_of(material: serde_json::Value) -> (Optics, Vec<String>) {
    let mut doc = Doc::triangle();
    doc.push("materials", material);
    doc.primitive()["material"] = json!(0);
    let scene = doc.scene();
    let about = notes(&scene).into_iter().filter(|note| note.contains("material")).map(str::to_owned);
    (scene.materials[0].optics, about.collect())
}

#[test]
fn smooth_metals_are_mirrors_and_smooth_transmission_is_glass() {
    let pbr = |metallic: f64, roughness: f64| json!({"metallicFactor": metallic, "roughnessFactor": roughness});
    let glass = |roughness: f64, extensions: serde_json::Value| {
        let transmission = json!({"transmissionFactor": 1});
        let mut all = extensions;
        all["KHR_materials_transmission"] = transmission;
        json!({"pbrMetallicRoughness": pbr(0.0, roughness), "extensions": all})
    };
    let solid = json!({"KHR_materials_ior": {"ior": 1.33}, "KHR_materials_volume": {"thicknessFactor": 0.1}});
    for (material, expected) in [
        (json!({}), Optics::Diffuse),
        (json!({"pbrMetallicRoughness": pbr(0.0, 0.0)}), Optics::Diffuse),
        (json!({"pbrMetallicRoughness": pbr(1.0, 0.0)}), Optics::Mirror),
        (json!({"pbrMetallicRoughness": pbr(1.0, 0.2)}), Optics::Rough),
        (json!({"pbrMetallicRoughness": pbr(0.5, 0.0)}), Optics::Rough),
        (glass(0.0, json!({})), Optics::Dielectric { ior: 1.5, is_thin: true }),
        (glass(0.0, solid.clone()), Optics::Dielectric { ior: 1.33, is_thin: false }),
        (glass(0.4, solid), Optics::Rough),
    ] {
        let text = material.to_string();
        assert_eq!(optics_of(material), (expected, vec![]), "{text}");
    }
    let (optics, notes) = optics_of(glass(0.0, json!({"KHR_materials_ior": {"ior": 0.5}})));
    assert_eq!(optics, Optics::Diffuse);
    assert!(notes.len() == 1 && notes[0].contains("index of refraction of 0.5"), "{notes:?}");
}

#[test]
fn alpha_modes_are_opaque_with_one_note() {
    let mut doc = Doc::triangle();
    doc.json["materials"] = json!([{"alphaMode": "OPAQUE"}, {"alphaMode": "MASK"}, {"alphaMode": "BLEND"}]);
    let primitive = doc.primitive().clone();
    let mut primitives = vec![primitive; 3];
    (0..3).for_each(|i| primitives[i]["material"] = json!(i));
    doc.json["meshes"][0]["primitives"] = json!(primitives);
    assert_eq!(notes(&doc.scene()).iter().filter(|n| n.contains("MASK and BLEND")).count(), 1);
}
