//! Images that cannot be read: the material is drawn in its colour.

use super::noted;
use crate::load_common::*;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use raystep_scenes::{FileError, LoadOptions, NoFiles, Resolver, Scene, external_files};
use serde_json::{Value, json};

/// The triangle with a red texture; `image` is the image's JSON.
fn textured(image: Value) -> Doc {
    let mut doc = Doc::triangle();
    let uv = doc.floats("VEC2", &[0., 0., 1., 0., 0., 1.]);
    doc.primitive()["attributes"]["TEXCOORD_0"] = json!(uv);
    doc.primitive()["material"] = json!(0);
    let pbr = json!({"baseColorFactor": [0.5, 0.25, 0, 1], "baseColorTexture": {"index": 0}});
    doc.push("materials", json!({"pbrMetallicRoughness": pbr}));
    doc.push("textures", json!({"source": 0}));
    doc.push("images", image);
    doc
}

fn plate() -> Vec<u8> {
    png(2, 2, TEXELS.as_flattened())
}

/// Expects the triangle in its colour, and a note with these words.
#[track_caller]
fn untextured(scene: &Scene, words: &[&str]) {
    assert_eq!((scene.triangles.len(), scene.textures.len()), (1, 0));
    assert_eq!((scene.materials[0].base_color, scene.materials[0].texture), ([0.5, 0.25, 0.], None));
    noted(scene, &[&["1 material is drawn without its texture: "], words].concat());
}

/// What lies outside of the folder, as the program's own resolver says.
struct Guarded;

impl Resolver for Guarded {
    fn read(&self, path: &str, _max_bytes: u64) -> Result<Vec<u8>, FileError> {
        match path {
            _ if path.contains("..") && !path.contains('\\') => Err(FileError::Outside { folder: "/here".into() }),
            "big.png" => Err(FileError::TooLarge { bytes: 1 << 40 }),
            "textures/plate.png" | "own\\name.png" | "own/name.png" => Ok(plate()),
            _ => Err("No such file or directory".into()),
        }
    }
}

#[test]
fn files_that_cannot_be_read() {
    for (uri, words) in [
        ("nothere.png", "images[0].uri: cannot read \"nothere.png\": No such file or directory"),
        ("../outside.png", "images[0].uri: \"../outside.png\" lies outside of /here, the scene's folder"),
        ("..\\outside.png", "images[0].uri: \"..\\outside.png\" lies outside of /here, the scene's folder"),
        ("big.png", "images[0].uri: this takes 1099511627776 more bytes"),
        ("/etc/passwd", "images[0].uri: is an absolute path"),
        ("C:\\a.png", "images[0].uri: is an absolute path"),
        ("http://a/b.png", "images[0].uri: is a http: URI"),
        ("%FF.png", "images[0].uri: is not UTF-8"),
        ("", "images[0].uri: is empty"),
        ("data:image/png;base64,!", "images[0].uri: is not valid base64"),
    ] {
        let scene = textured(json!({"uri": uri})).load_with(&Guarded, &small()).unwrap();
        untextured(&scene, &[words]);
    }
    for (image, words) in [
        (json!({}), "images[0]: has neither a uri nor a bufferView"),
        (json!(4), "images[0]: invalid type"),
        (json!({"uri": 4}), "images[0].uri: invalid type"),
        (json!({"bufferView": 44}), "images[0].bufferView: refers to bufferView 44"),
    ] {
        untextured(&textured(image).scene(), &[words]);
    }
}

#[test]
fn backslashes_are_slashes_where_no_file_has_that_name() {
    for uri in ["textures\\plate.png", "textures%5Cplate.png", "own\\name.png"] {
        let scene = textured(json!({"uri": uri})).load_with(&Guarded, &small()).unwrap();
        assert_eq!(scene.textures[0].texels, TEXELS, "{uri}");
    }
    // The literal name comes first.
    let files =
        Files([("a\\b.png", png(1, 1, &[1, 2, 3, 255])), ("a/b.png", plate())].map(|(n, b)| (n.to_owned(), b)).into());
    let scene = textured(json!({"uri": "a\\b.png"})).load_with(&files, &small()).unwrap();
    assert_eq!(scene.textures[0].texels, [[1, 2, 3, 255]]);
    // Buffers, too, and whoever fetches files ahead is told both names.
    let mut doc = textured(json!({"uri": "textures\\plate.png"}));
    doc.json["buffers"] = json!([{"byteLength": doc.bin.len(), "uri": "sub\\a.bin"}]);
    let files =
        Files([("sub/a.bin", doc.bin.clone()), ("textures/plate.png", plate())].map(|(n, b)| (n.to_owned(), b)).into());
    let text = doc.json.to_string();
    let scene = raystep_scenes::load("x", text.as_bytes(), &files, &LoadOptions::default()).unwrap();
    assert_eq!((scene.triangles.len(), scene.textures.len()), (1, 1));
    let names = external_files(text.as_bytes(), 1 << 20).unwrap();
    assert_eq!(names, ["sub/a.bin", "sub\\a.bin", "textures/plate.png", "textures\\plate.png"]);
}

#[test]
fn images_that_are_none_or_too_large() {
    let picture = plate();
    // A decompression bomb: the header declares 60,000 x 60,000 texels, with a matching checksum.
    let sized = |side: u32| {
        let mut bomb = picture.clone();
        bomb[16..20].copy_from_slice(&side.to_be_bytes());
        bomb[20..24].copy_from_slice(&side.to_be_bytes());
        let crc = !bomb[12..29].iter().fold(!0_u32, |crc, &byte| {
            (0..8).fold(crc ^ u32::from(byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 })
        });
        bomb[29..33].copy_from_slice(&crc.to_be_bytes());
        bomb
    };
    for (bytes, words) in [
        (b"GIF89a".to_vec(), "neither a PNG, a JPEG nor a WebP"),
        (Vec::new(), "neither a PNG, a JPEG nor a WebP"),
        (b"\xabKTX 20\xbb\r\n\x1a\n".to_vec(), "is a KTX2 texture (KHR_texture_basisu)"),
        (b"RIFF\x04\0\0\0WEBP".to_vec(), "cannot be decoded"),
        (picture[..picture.len() - 20].to_vec(), "cannot be decoded"),
        (sized(60_000), "60000 x 60000"),
        (sized(30_000), "30000 x 30000 texels, and 900000000 texels with all images before it; at most 536870912"),
        (sized(20_000), "this takes 4800000000 more bytes"),
        (sized(900), "cannot be decoded"),
    ] {
        let mut doc = textured(json!({}));
        let view = doc.view(&bytes);
        doc.json["images"][0] = json!({"bufferView": view});
        untextured(&doc.load_with(&NoFiles, &small()).unwrap(), &["images[0]", words]);
    }
}

/// 4 x 4 texels of one colour, by libwebp.
const WEBP: &str =
    "data:image/webp;base64,UklGRjoAAABXRUJQVlA4IC4AAACwAQCdASoEAAQAAUAmJaACdLoABDAAAP7x3I/4DdfFtMv/vYL/3YL/3YL/WwAA";

#[test]
fn webp_images_are_read_with_and_without_the_extension() {
    let check = |doc: &Doc| {
        let texture = &doc.scene().textures[0];
        assert_eq!((texture.width, texture.height), (4, 4));
        // libwebp's own decoder says the same of each texel, give or take one: its conversion from YUV is not exact.
        let expected = [0xc8, 0x1d, 0x1e, 255];
        for texel in &texture.texels {
            assert!(texel.iter().zip(expected).all(|(a, b)| a.abs_diff(b) <= 1), "{texel:?}");
        }
    };
    check(&textured(json!({"uri": WEBP})));
    let mut doc = textured(json!({"uri": WEBP}));
    doc.json["extensionsRequired"] = json!(["EXT_texture_webp"]);
    doc.json["textures"][0] = json!({"extensions": {"EXT_texture_webp": {"source": 0}}});
    check(&doc);
    // A truncated one falls back to the texture's own image, if it has one.
    let cut = STANDARD.encode(&STANDARD.decode(&WEBP[23..]).unwrap()[..40]);
    doc.json["images"][0] = json!({"uri": format!("data:image/webp;base64,{cut}")});
    untextured(&doc.scene(), &["images[0]: cannot be decoded"]);
    doc.push("images", json!({"uri": format!("data:;base64,{}", STANDARD.encode(plate()))}));
    doc.json["textures"][0]["source"] = json!(1);
    assert_eq!(doc.scene().textures[0].texels, TEXELS);
    // The same for KTX2, which is not read.
    doc.json["textures"][0] = json!({"source": 1, "extensions": {"KHR_texture_basisu": {"source": 0}}});
    assert_eq!(doc.scene().textures[0].texels, TEXELS);
}

#[test]
fn webp_images_without_loss_and_with_alpha() {
    let opaque = "UklGRiwAAABXRUJQVlA4TB8AAAAvAUAAAB8gEEjeHzqN+RcQFPwf3fxHZA/gBgwR/Q8BAA==";
    let alpha = "UklGRjoAAABXRUJQVlA4TC0AAAAvAUAAEB8gEEjaH3oNAUHB/9EJCIr8H00gQPhvMKRK6AdXCLIBylRhE9H/+AAA";
    for bytes in [opaque, alpha] {
        let scene = textured(json!({"uri": format!("data:image/webp;base64,{bytes}")})).scene();
        assert_eq!(
            scene.textures[0].texels.iter().map(|t| [t[0], t[1], t[2]]).collect::<Vec<_>>(),
            TEXELS.map(|t| [t[0], t[1], t[2]])
        );
    }
}

#[test]
fn textures_samplers_and_transforms_that_are_wrong() {
    let uri = format!("data:;base64,{}", STANDARD.encode(plate()));
    let mut doc = textured(json!({"uri": uri}));
    for (pointer, value, words) in [
        ("/textures/0", json!({"source": 9}), "textures[0].source: refers to image 9"),
        ("/textures/0", json!({}), "textures[0]: has no image"),
        ("/materials/0/pbrMetallicRoughness/baseColorTexture", json!({"index": 7}), "refers to texture 7"),
        ("/materials/0/pbrMetallicRoughness/baseColorTexture", json!({"index": 0, "texCoord": "x"}), "texCoord"),
        (
            "/materials/0/pbrMetallicRoughness/baseColorTexture",
            json!({"index": 0, "extensions": {"KHR_texture_transform": {"scale": [1]}}}),
            "KHR_texture_transform.scale: has 1 numbers; expected 2",
        ),
    ] {
        let mut doc = doc.clone();
        *doc.json.pointer_mut(pointer).unwrap() = value;
        untextured(&doc.scene(), &[words]);
    }
    doc.push("samplers", json!({"wrapS": 5}));
    doc.json["textures"][0]["sampler"] = json!(0);
    let scene = doc.scene();
    assert_eq!(scene.textures.len(), 1);
    noted(&scene, &["1 texture is repeated and filtered: samplers[0].wrapS: is 5"]);
}

#[test]
fn an_image_of_many_materials_is_read_once() {
    /// Counts how often it is asked.
    struct Counting(std::cell::Cell<u32>);
    impl Resolver for Counting {
        fn read(&self, _path: &str, _max_bytes: u64) -> Result<Vec<u8>, FileError> {
            self.0.set(self.0.get() + 1);
            Err("there is no such file".into())
        }
    }
    let mut doc = textured(json!({"uri": "missing.png"}));
    let (material, primitive) = (doc.json["materials"][0].clone(), doc.primitive().clone());
    for i in 1..100 {
        doc.push("materials", material.clone());
        let mut primitive = primitive.clone();
        primitive["material"] = json!(i);
        doc.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(primitive);
    }
    let files = Counting(0.into());
    let scene = doc.load_with(&files, &small()).unwrap();
    assert_eq!(files.0.get(), 1);
    noted(&scene, &["100 materials are drawn without their textures; the first: images[0].uri: cannot read"]);
}
