//! What `write_glb` writes, and that `load` reads the same bits back.

#![allow(clippy::unwrap_used, reason = "a test that cannot make its input has failed")]

use glam::DVec3;
use raystep_scenes::generate::{self, GENERATORS};
use raystep_scenes::{
    Camera, Light, LoadOptions, Material, NoFiles, Optics, Projection, Scene, Texture, Wrap, WriteError, load,
    write_glb,
};
use serde_json::Value;

fn reload(scene: &Scene) -> Scene {
    load("test.glb", &write_glb(scene).unwrap(), &NoFiles, &LoadOptions::default()).unwrap()
}

fn bits(triangles: &[[[f32; 3]; 3]]) -> Vec<u32> {
    triangles.as_flattened().as_flattened().iter().map(|v| v.to_bits()).collect()
}

fn json(glb: &[u8]) -> Value {
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&glb[20..20 + length]).unwrap()
}

/// Three materials in mixed order, a texture, all attributes, all kinds of lights and cameras.
fn everything() -> Scene {
    let corner = |i: usize, k: usize| [i as f32 * 0.1, k as f32 / 3.0, -0.0];
    let count = 9;
    let all = || 0..count;
    let texture = Texture {
        width: 3,
        height: 2,
        texels: (0..6).map(|i| [i * 40, 255 - i, 7, 255]).collect(),
        wrap_u: Wrap::Mirror,
        wrap_v: Wrap::Clamp,
        linear: true,
    };
    let material = |name: &str, texture, optics| Material {
        name: name.into(),
        base_color: [0.73, 0.1, 1.0 / 3.0],
        emissive: [0.0, 0.3, 6.1],
        texture,
        double_sided: texture.is_some(),
        optics,
    };
    let axes = |projection, eye| Camera {
        name: "view".into(),
        ..Camera::look_at(eye, DVec3::new(0.3, 0.1, 0.0), DVec3::Y, projection).unwrap()
    };
    let direction = [0.6, -0.8, 0.0];
    Scene {
        offset: DVec3::ZERO,
        name: "everything".into(),
        triangles: all().map(|i| [0, 1, 2].map(|k| corner(i, k))).collect(),
        normals: Some(all().map(|i| [[0.0, if i % 2 == 0 { 1.0 } else { -1.0 }, 0.0]; 3]).collect()),
        texcoords: Some(all().map(|i| [0, 1, 2].map(|k| [i as f32 / 7.0, k as f32 - 0.5])).collect()),
        colors: Some(all().map(|i| [[i as f32 / 9.0, 0.5, 1.0]; 3]).collect()),
        triangle_materials: all().map(|i| (i % 3) as u32).collect(),
        materials: vec![
            material("a", None, Optics::Dielectric { ior: 1.45, is_thin: false }),
            material("b", Some(0), Optics::Mirror),
            material("c", None, Optics::Dielectric { ior: 2.4, is_thin: true }),
        ],
        textures: vec![texture],
        lights: vec![
            Light::Point { position: [1.0, 2.0, 3.0], color: [1.0, 0.5, 0.25], intensity: 10.0 },
            Light::Directional { direction, color: [0.1, 0.2, 0.3], intensity: 2.0 },
            Light::Spot {
                position: [-1.0, 0.5, 2.0],
                direction,
                color: [1.0; 3],
                intensity: 5.0,
                inner_cone: 0.2,
                outer_cone: 0.4,
            },
        ],
        cameras: vec![
            axes(Projection::Perspective { vertical_fov: 0.7 }, DVec3::new(1.0, 2.0, 3.0)),
            axes(Projection::Orthographic { half_height: 2.5 }, DVec3::new(0.0, 5.0, 0.5)),
        ],
        notes: vec![],
    }
}

#[test]
fn positions_come_back_bit_for_bit() {
    for generator in GENERATORS {
        let scene = generator.make(&[]).unwrap();
        let again = reload(&scene);
        assert_eq!(bits(&again.triangles), bits(&scene.triangles), "{}", generator.name);
        assert_eq!(again.triangle_materials, scene.triangle_materials, "{}", generator.name);
        assert_eq!(again.colors, scene.colors, "{}", generator.name);
    }
}

#[test]
fn everything_comes_back_grouped_by_material() {
    let scene = everything();
    let again = reload(&scene);
    let order: Vec<usize> = (0..3).flat_map(|m| (0..9).filter(move |i| i % 3 == m)).collect();
    let picked: Vec<_> = order.iter().map(|&i| scene.triangles[i]).collect();
    // Loading turns −0 into 0, even with the identity transform; the file contains the −0 (see below).
    let zero = |v: u32| if v == 1 << 31 { 0 } else { v };
    assert!(bits(&again.triangles).into_iter().eq(bits(&picked).into_iter().map(zero)));
    assert_eq!(again.triangle_materials, [0, 0, 0, 1, 1, 1, 2, 2, 2]);
    let pick = |list: &Option<Vec<[[f32; 3]; 3]>>| order.iter().map(|&i| list.as_ref().unwrap()[i]).collect::<Vec<_>>();
    assert_eq!(again.normals.as_ref().unwrap(), &pick(&scene.normals));
    assert_eq!(again.colors.as_ref().unwrap(), &pick(&scene.colors));
    // If no material has a texture, the loader may omit coordinates; b has one.
    let coordinates = again.texcoords.as_ref().unwrap();
    assert_eq!(
        coordinates[3..6],
        order[3..6].iter().map(|&i| scene.texcoords.as_ref().unwrap()[i]).collect::<Vec<_>>()
    );
    assert_eq!(again.materials, scene.materials);
    assert_eq!(again.textures, scene.textures);
    for (a, b) in again.cameras.iter().zip(&scene.cameras) {
        // glTF's matrices are f32, so an axis may change by an ulp of 1.
        for (a, b) in [(a.eye, b.eye), (a.right, b.right), (a.up, b.up), (a.forward, b.forward)] {
            assert!((a - b).length() < 1e-6, "{a} {b}");
        }
        match (a.projection, b.projection) {
            (Projection::Perspective { vertical_fov: a }, Projection::Perspective { vertical_fov: b })
            | (Projection::Orthographic { half_height: a }, Projection::Orthographic { half_height: b }) => {
                assert!((a - b).abs() < 1e-6, "{a} {b}");
            }
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(again.cameras.len(), 2);
    assert_eq!(again.lights.len(), 3);
    assert_eq!(again.lights[0], scene.lights[0]);
    for (a, b) in again.lights.iter().zip(&scene.lights).skip(1) {
        let direction = |l: &Light| match *l {
            Light::Directional { direction, .. } | Light::Spot { direction, .. } => glam::Vec3::from(direction),
            Light::Point { .. } => panic!("a point light"),
        };
        assert!((direction(a) - direction(b)).length() < 1e-6, "{a:?} {b:?}");
    }
}

#[test]
fn a_glb_is_laid_out_as_the_specification_says() {
    let glb = write_glb(&everything()).unwrap();
    let word = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&glb[..4], word(4), word(8)), (&b"glTF"[..], 2, glb.len()));
    assert_eq!(&glb[16..20], b"JSON");
    let (json_length, binary) = (word(12), 20 + word(12));
    assert_eq!(json_length % 4, 0);
    assert_eq!(&glb[binary + 4..binary + 8], b"BIN\0");
    assert_eq!(binary + 8 + word(binary), glb.len());
    let document = json(&glb);
    assert_eq!(document["buffers"][0]["byteLength"], word(binary));
    assert_eq!(document["meshes"][0]["primitives"].as_array().unwrap().len(), 3);
    assert_eq!(document["extensionsUsed"][0], "KHR_lights_punctual");
    let mut end = 0;
    for view in document["bufferViews"].as_array().unwrap() {
        let at = view["byteOffset"].as_u64().unwrap();
        assert!(at % 4 == 0 && at >= end, "views overlap or are not aligned");
        end = at + view["byteLength"].as_u64().unwrap();
    }
    assert!(end as usize <= word(binary));
    let first = &document["accessors"][0]["bufferView"];
    let at = document["bufferViews"][first.as_u64().unwrap() as usize]["byteOffset"].as_u64().unwrap() as usize;
    assert_eq!(word(binary + 8 + at + 8), 1 << 31, "the first vertex has z = −0");
    for primitive in document["meshes"][0]["primitives"].as_array().unwrap() {
        let position = &document["accessors"][primitive["attributes"]["POSITION"].as_u64().unwrap() as usize];
        assert_eq!(position["min"].as_array().map(Vec::len), Some(3));
        assert_eq!(position["max"].as_array().map(Vec::len), Some(3));
        assert_eq!(position["max"][1].as_f64().unwrap() as f32, 2.0 / 3.0);
    }
}

#[test]
fn vertices_are_shared_where_that_saves_space() {
    let sphere = json(&write_glb(&generate::icosphere(5).unwrap()).unwrap());
    assert_eq!(sphere["accessors"][0]["count"], 10 * 1024 + 2);
    let soup = json(&write_glb(&generate::soup(1_000, 1).unwrap()).unwrap());
    assert!(soup["meshes"][0]["primitives"][0].get("indices").is_none());
    // 65,536 vertices would need the index that 16 bits reserve; one more subdivision has 163,842.
    let index =
        |s: &Value| s["accessors"][s["meshes"][0]["primitives"][0]["indices"].as_u64().unwrap() as usize].clone();
    assert_eq!(index(&sphere)["componentType"], 5123);
    assert_eq!(index(&json(&write_glb(&generate::icosphere(7).unwrap()).unwrap()))["componentType"], 5125);
}

#[test]
fn a_scene_of_nothing_can_be_written_and_read() {
    let again = reload(&Scene::default());
    assert!(again.triangles.is_empty() && again.lights.is_empty() && again.cameras.is_empty());
}

#[test]
fn what_gltf_cannot_hold_is_refused() {
    let refused = |change: fn(&mut Scene)| {
        let mut scene = everything();
        change(&mut scene);
        write_glb(&scene).unwrap_err()
    };
    let invalid = |list, index| move |e: &WriteError| matches!(e, WriteError::Invalid { list: l, index: i, .. } if *l == list && *i == index);
    assert!(invalid("triangles", 4)(&refused(|s| s.triangles[4][1][2] = f32::NAN)));
    assert!(invalid("triangles", 0)(&refused(|s| s.triangles[0][0][0] = f32::INFINITY)));
    assert!(invalid("triangle_materials", 8)(&refused(|s| s.triangle_materials[8] = 3)));
    assert!(invalid("materials", 1)(&refused(|s| s.materials[1].texture = Some(1))));
    assert!(invalid("materials", 2)(&refused(|s| s.materials[2].emissive[0] = -0.5)));
    assert!(invalid("materials", 2)(&refused(|s| s.materials[2].emissive[0] = f32::MAX)));
    assert!(invalid("colors", 3)(&refused(|s| s.colors.as_mut().unwrap()[3][0][0] = -0.1)));
    assert!(invalid("cameras", 0)(&refused(|s| s.cameras[0].eye.x = f64::NAN)));
    assert!(invalid("lights", 2)(&refused(|s| {
        if let Light::Spot { inner_cone, .. } = &mut s.lights[2] {
            *inner_cone = 0.5;
        }
    })));
    let wrong = refused(|s| s.normals.as_mut().unwrap().truncate(2));
    assert_eq!(wrong.to_string(), "the scene's normals has 2 entries for 9 triangles or texels");
    assert!(matches!(refused(|s| s.textures[0].width = 4), WriteError::WrongLength { expected: 8, actual: 6, .. }));
}
