//! Where a file's bytes may be and how they may be encoded: accessors, buffers, URIs, images.

#![allow(clippy::unwrap_used, reason = "a test that cannot make its input has failed")]

mod images;

use crate::load_common::*;
use base64::Engine as _;
use base64::engine::general_purpose::{STANDARD, STANDARD_NO_PAD};
use raystep_scenes::{LoadOptions, NoFiles, Scene, Wrap, load};
use serde_json::{Value, json};
use std::f32::consts::FRAC_PI_2;

#[test]
fn sparse_accessors_change_what_lies_below() {
    for index_type in [U8, U16, U32] {
        for dense in [true, false] {
            let mut doc = Doc::triangle();
            let indices = match index_type {
                U8 => vec![0, 2],
                U16 => u16s(&[0, 2]),
                _ => u32s(&[0, 2]),
            };
            let indices = doc.view(&indices);
            let values = doc.view(&f32s(&[9., 8., 7., 6., 5., 4.]));
            doc.json["accessors"][0]["sparse"] = json!({"count": 2,
                "indices": {"bufferView": indices, "componentType": index_type}, "values": {"bufferView": values}});
            if !dense {
                doc.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
            }
            let middle = [f32::from(u8::from(dense)), 0., 0.];
            assert_eq!(doc.scene().triangles, [[[9., 8., 7.], middle, [6., 5., 4.]]], "{index_type} {dense}");
        }
    }
}

#[test]
fn strides_and_offsets_are_followed() {
    // Position and normal interleaved, with a gap of 4 bytes, after 8 unrelated bytes.
    let mut bytes = vec![0xff; 8];
    for p in [[1f32, 2., 3.], [4., 5., 6.], [7., 8., 10.]] {
        bytes.extend(f32s(&p));
        bytes.extend([0xff; 4]);
        bytes.extend(f32s(&[0., -1., 0.]));
    }
    let mut doc = Doc::new();
    let view = doc.view(&bytes);
    doc.json["bufferViews"][view]["byteStride"] = json!(28);
    for offset in [8, 24] {
        doc.push(
            "accessors",
            json!({"bufferView": view, "byteOffset": offset, "componentType": F32, "count": 3, "type": "VEC3"}),
        );
    }
    doc.mesh(json!({"POSITION": 0, "NORMAL": 1}));
    doc.push("nodes", json!({"mesh": 0}));
    let scene = doc.scene();
    assert_eq!(scene.triangles, [[[1., 2., 3.], [4., 5., 6.], [7., 8., 10.]]]);
    assert_eq!(scene.normals.unwrap(), [[[0., -1., 0.]; 3]]);
}

#[test]
fn quantized_positions_of_every_type() {
    let i8_bytes = i8s(&[0, 0, 0, 0, 127, 0, 0, 0, -128, 64, 0, 0]);
    let u8_bytes = [0, 0, 0, 0, 255, 0, 0, 0, 0, 51, 0, 0];
    let i16_bytes = i16s(&[0, 0, 0, 0, 32767, 0, 0, 0, -32768, 3, 0, 0]);
    let u16_bytes = u16s(&[0, 0, 0, 0, 65535, 0, 0, 0, 0, 13107, 0, 0]);
    let cases = [
        (I8, true, &i8_bytes, [1., 0., 0.], [-1., 64. / 127., 0.]),
        (I8, false, &i8_bytes, [127., 0., 0.], [-128., 64., 0.]),
        (U8, true, &u8_bytes.to_vec(), [1., 0., 0.], [0., 0.2, 0.]),
        (U8, false, &u8_bytes.to_vec(), [255., 0., 0.], [0., 51., 0.]),
        (I16, true, &i16_bytes, [1., 0., 0.], [-1., 3. / 32767., 0.]),
        (I16, false, &i16_bytes, [32767., 0., 0.], [-32768., 3., 0.]),
        (U16, true, &u16_bytes, [1., 0., 0.], [0., 0.2, 0.]),
        (U16, false, &u16_bytes, [65535., 0., 0.], [0., 13107., 0.]),
    ];
    for (component, normalized, bytes, b, c) in cases {
        let mut doc = Doc::new();
        doc.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        let position = doc.accessor("VEC3", component, 3, bytes);
        doc.json["accessors"][position]["normalized"] = json!(normalized);
        doc.json["bufferViews"][0]["byteStride"] = json!(bytes.len() / 3);
        doc.mesh(json!({"POSITION": position}));
        doc.push("nodes", json!({"mesh": 0}));
        assert_eq!(doc.scene().triangles, [[[0.; 3], b, c]], "{component} {normalized}");
    }
}

/// The triangle with a texture; `image` is the image's JSON.
fn textured(image: Value) -> Doc {
    let mut doc = Doc::triangle();
    let uv = doc.floats("VEC2", &[0., 0., 1., 0., 0., 1.]);
    let other = doc.accessor("VEC2", U8, 3, &[0, 255, 0, 0, 51, 0, 0, 0, 0, 0, 0, 0]);
    doc.json["accessors"][other]["normalized"] = json!(true);
    let view = doc.json["accessors"][other]["bufferView"].as_u64().unwrap();
    doc.json["bufferViews"][view as usize]["byteStride"] = json!(4);
    doc.primitive()["attributes"]["TEXCOORD_0"] = json!(uv);
    doc.primitive()["attributes"]["TEXCOORD_1"] = json!(other);
    doc.primitive()["material"] = json!(0);
    doc.push("materials", json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}));
    doc.push("textures", json!({"source": 0}));
    doc.push("images", image);
    doc
}

fn check_texels(scene: &Scene, what: &str) {
    let [texture] = &scene.textures[..] else { panic!("{what}: {} textures", scene.textures.len()) };
    assert_eq!((texture.width, texture.height, &texture.texels[..]), (2, 2, &TEXELS[..]), "{what}");
    assert_eq!(scene.materials[0].texture, Some(0));
    assert_eq!(scene.texcoords.as_deref(), Some(&[[[0., 0.], [1., 0.], [0., 1.]]][..]), "{what}");
}

#[test]
fn images_embedded_beside_and_in_uris() {
    let picture = png(2, 2, TEXELS.as_flattened());
    let mut doc = textured(json!({}));
    let view = doc.view(&picture);
    doc.json["images"][0] = json!({"bufferView": view, "mimeType": "image/png"});
    check_texels(&doc.scene(), "bufferView");

    let base64 = format!("data:image/png;base64,{}", STANDARD.encode(&picture));
    let unpadded = format!("data:image/png;base64,{}", STANDARD_NO_PAD.encode(&picture));
    let percent: String = picture.iter().map(|b| format!("%{b:02x}")).collect();
    let percent = format!("data:image/png,{percent}");
    for uri in [base64, unpadded, percent] {
        check_texels(&textured(json!({"uri": uri})).scene(), &uri[..30]);
    }

    let names = [
        ("a.png", "a.png"),
        ("dir/a%20b.png", "dir/a b.png"),
        ("../up.png", "../up.png"),
        ("Bücher/日本.png", "Bücher/日本.png"),
        ("B%C3%BCcher.png", "Bücher.png"),
        ("100%.png", "100%.png"),
    ];
    for (uri, file) in names {
        let doc = textured(json!({"uri": uri}));
        check_texels(&doc.load_with(&Files::one(file, &picture), &LoadOptions::default()).unwrap(), uri);
    }
}

#[test]
fn jpegs_and_deep_or_gray_pngs() {
    let gray = image::DynamicImage::ImageLuma16(image::ImageBuffer::from_pixel(3, 2, image::Luma([0x8080])));
    for format in [image::ImageFormat::Png, image::ImageFormat::Jpeg] {
        let mut bytes = std::io::Cursor::new(Vec::new());
        // JPEG has no 16-bit format.
        let picture = if format == image::ImageFormat::Jpeg { gray.to_luma8().into() } else { gray.clone() };
        picture.write_to(&mut bytes, format).unwrap();
        let mut doc = textured(json!({}));
        let view = doc.view(bytes.get_ref());
        // A wrong mimeType is common and harmless.
        doc.json["images"][0] = json!({"bufferView": view, "mimeType": "image/webp"});
        let texture = doc.scene().textures.remove(0);
        assert_eq!((texture.width, texture.height), (3, 2));
        assert_eq!(texture.texels, [[128, 128, 128, 255]; 6], "{format:?}");
    }
}

#[test]
fn samplers_give_wrap_and_filter() {
    let picture = format!("data:image/png;base64,{}", STANDARD.encode(png(2, 2, TEXELS.as_flattened())));
    let cases = [
        (None, Wrap::Repeat, Wrap::Repeat, true),
        (Some(json!({})), Wrap::Repeat, Wrap::Repeat, true),
        (Some(json!({"wrapS": 33071, "wrapT": 33648, "magFilter": 9728})), Wrap::Clamp, Wrap::Mirror, false),
        (Some(json!({"wrapS": 33648, "wrapT": 10497, "magFilter": 9729})), Wrap::Mirror, Wrap::Repeat, true),
    ];
    for (sampler, wrap_u, wrap_v, linear) in cases {
        let mut doc = textured(json!({"uri": picture}));
        if let Some(sampler) = &sampler {
            doc.push("samplers", sampler.clone());
            doc.json["textures"][0]["sampler"] = json!(0);
        }
        let texture = &doc.scene().textures[0];
        assert_eq!((texture.wrap_u, texture.wrap_v, texture.linear), (wrap_u, wrap_v, linear), "{sampler:?}");
    }
}

#[test]
fn textures_are_shared_and_only_those_in_use_are_read() {
    let picture = format!("data:image/png;base64,{}", STANDARD.encode(png(2, 2, TEXELS.as_flattened())));
    let mut doc = textured(json!({"uri": picture}));
    // Another texture of the same image and sampling, and an unused one whose image is missing.
    doc.push("textures", json!({"source": 0}));
    doc.push("textures", json!({"source": 1}));
    doc.push("images", json!({"uri": "missing.png"}));
    for texture in [1, 2] {
        doc.push("materials", json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": texture}}}));
    }
    let mut primitive = doc.primitive().clone();
    primitive["material"] = json!(1);
    doc.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(primitive);
    let scene = doc.scene();
    assert_eq!((scene.textures.len(), scene.materials.len()), (1, 2));
    assert_eq!(scene.materials[1].texture, Some(0));
    // A texture whose image is only in an unknown extension has none.
    doc.json["textures"][1] = json!({"extensions": {"MSFT_texture_dds": {"source": 1}}});
    let scene = doc.scene();
    assert_eq!(scene.materials[1].texture, None);
    let note = "1 material is drawn without its texture: textures[1]: has no image";
    assert!(notes(&scene).contains(&note), "{:?}", scene.notes);
}

#[test]
fn texture_coordinates_by_set_and_transform() {
    let picture = format!("data:image/png;base64,{}", STANDARD.encode(png(2, 2, TEXELS.as_flattened())));
    let transform = |value: Value| json!({"index": 0, "extensions": {"KHR_texture_transform": value}});
    let cases = [
        (json!({"index": 0}), [[0., 0.], [1., 0.], [0., 1.]]),
        (json!({"index": 0, "texCoord": 1}), [[0., 1.], [0.2, 0.], [0., 0.]]),
        (transform(json!({"texCoord": 1})), [[0., 1.], [0.2, 0.], [0., 0.]]),
        (transform(json!({"offset": [0.5, 0.25], "scale": [2, 3]})), [[0.5, 0.25], [2.5, 0.25], [0.5, 3.25]]),
        // Counter-clockwise with v pointing down: u turns to -v.
        (transform(json!({"rotation": FRAC_PI_2})), [[0., 0.], [0., -1.], [1., 0.]]),
        (transform(json!({"rotation": FRAC_PI_2, "scale": [2, 3]})), [[0., 0.], [0., -2.], [3., 0.]]),
    ];
    for (info, expected) in cases {
        let mut doc = textured(json!({"uri": picture}));
        doc.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = info.clone();
        let uv = doc.scene().texcoords.unwrap()[0];
        println!("{info}");
        close(uv.as_flattened(), expected.as_flattened());
    }
    // A mesh without the texture coordinate set gets one texel, and a note.
    let mut doc = textured(json!({"uri": picture}));
    doc.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = json!(7);
    let scene = doc.scene();
    assert_eq!(scene.texcoords.as_deref(), Some(&[[[0.; 2]; 3]][..]));
    assert!(notes(&scene).iter().any(|n| n.contains("texture coordinates")));
}

#[test]
fn buffers_beside_and_in_uris() {
    let bytes = f32s(&[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
    let mut doc = Doc::triangle();
    doc.bin.clear();
    let uri = format!("data:;base64,{}", STANDARD.encode(&bytes));
    for uri in [uri.as_str(), "gr%C3%BC%C3%9Fe.bin"] {
        // A buffer may be longer than its byteLength.
        doc.json["buffers"] = json!([{"byteLength": 36, "uri": uri}]);
        let mut longer = bytes.clone();
        longer.extend([1, 2, 3]);
        let files = Files::one("grüße.bin", &longer);
        let scene = load("x", doc.json.to_string().as_bytes(), &files, &LoadOptions::default()).unwrap();
        assert_eq!(scene.triangles.len(), 1);
        // But bytes beyond that length are not part of the buffer.
        let shorter = doc.json.to_string().replace("\"byteLength\":36,\"uri\"", "\"byteLength\":35,\"uri\"");
        let error = load("x", shorter.as_bytes(), &files, &LoadOptions::default()).unwrap_err();
        assert!(one_line(&error).contains("35 bytes of buffers[0]"), "{error}");
        // The same JSON in a GLB without a BIN chunk.
        let whole = glb(&doc.json, &[]);
        let (body, _) = whole.split_at(whole.len() - 8);
        let mut body = body.to_vec();
        let length = body.len() as u32;
        body[8..12].copy_from_slice(&length.to_le_bytes());
        assert_eq!(load("x", &body, &files, &LoadOptions::default()).unwrap().triangles, scene.triangles);
    }
    let error = load("x", doc.json.to_string().as_bytes(), &NoFiles, &LoadOptions::default()).unwrap_err();
    assert!(one_line(&error).contains("buffers[0].uri: cannot read \"grüße.bin\""), "{error}");
}
