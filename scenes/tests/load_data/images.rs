//! Images of every format, compared with the `image` crate's own decoding, and their memory limits.

use super::textured;
use crate::load_common::*;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use raystep_scenes::{LoadOptions, NoFiles};
use serde_json::json;

/// The CRC-32 of some bytes.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0_u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 })
    })
}

fn adler32(bytes: &[u8]) -> u32 {
    let (a, b) = bytes.iter().fold((1, 0), |(a, b), &byte| {
        let a = (a + u32::from(byte)) % 65521;
        (a, (b + a) % 65521)
    });
    b << 16 | a
}

fn chunk(out: &mut Vec<u8>, kind: &[u8; 4], data: &[u8]) {
    out.extend((data.len() as u32).to_be_bytes());
    let body = [&kind[..], data].concat();
    out.extend(&body);
    out.extend(crc32(&body).to_be_bytes());
}

/// First column and row of an interlaced image's pass, and the steps between them.
const PASSES: [[usize; 4]; 7] =
    [[0, 0, 8, 8], [4, 0, 8, 8], [0, 4, 4, 8], [2, 0, 4, 4], [0, 2, 2, 4], [1, 0, 2, 2], [0, 1, 1, 2]];

/// An uncompressed PNG of noise.
fn noise(width: usize, height: usize, color: u8, depth: u8, is_interlaced: bool, transparent: &[u8]) -> Vec<u8> {
    let channels = [1, 0, 3, 1, 2, 0, 4][usize::from(color)];
    let mut state = 1_u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    };
    let mut rows = Vec::new();
    let whole = [[0, 0, 1, 1]];
    for &[x, y, step_x, step_y] in if is_interlaced { &PASSES[..] } else { &whole } {
        let columns = width.saturating_sub(x).div_ceil(step_x);
        for _ in (y..height).step_by(step_y).filter(|_| columns > 0) {
            rows.push(0);
            rows.extend((0..(columns * channels * usize::from(depth)).div_ceil(8)).map(|_| random()));
        }
    }
    let mut out = b"\x89PNG\r\n\x1a\n".to_vec();
    let [w, h] = [width, height].map(|side| (side as u32).to_be_bytes());
    chunk(&mut out, b"IHDR", &[&w[..], &h, &[depth, color, 0, 0, u8::from(is_interlaced)]].concat());
    if color == 3 {
        chunk(&mut out, b"PLTE", &(0..3 << depth).map(|_| random()).collect::<Vec<_>>());
    }
    if !transparent.is_empty() {
        chunk(&mut out, b"tRNS", transparent);
    }
    let mut data = vec![0x78, 1, 1];
    data.extend((rows.len() as u16).to_le_bytes());
    data.extend((!(rows.len() as u16)).to_le_bytes());
    data.extend(&rows);
    data.extend(adler32(&rows).to_be_bytes());
    chunk(&mut out, b"IDAT", &data);
    chunk(&mut out, b"IEND", &[]);
    out
}

/// Checks that the texels are those that `image` decodes.
#[track_caller]
fn check(bytes: &[u8], what: &str) {
    let expected = image::load_from_memory(bytes).unwrap_or_else(|e| panic!("{what}: {e}")).into_rgba8();
    let mut doc = textured(json!({}));
    let view = doc.view(bytes);
    doc.json["images"][0] = json!({"bufferView": view});
    let texture = doc.scene().textures.remove(0);
    assert_eq!((texture.width, texture.height), expected.dimensions(), "{what}");
    assert!(texture.texels.as_flattened() == expected.as_raw(), "{what}: other texels");
}

#[test]
fn pngs_of_every_form_have_the_texels_that_image_decodes() {
    let forms: [(u8, &[u8]); 5] =
        [(0, &[1, 2, 4, 8, 16]), (2, &[8, 16]), (3, &[1, 2, 4, 8]), (4, &[8, 16]), (6, &[8, 16])];
    for (color, depths) in forms {
        for &depth in depths {
            for is_interlaced in [false, true] {
                // One grey or one colour is transparent, or the palette's first two entries.
                let transparent: [&[u8]; 2] = match color {
                    0 => [&[], &[0, 1]],
                    2 => [&[], &[0, 1, 0, 2, 0, 3]],
                    3 => [&[], &[0, 7]],
                    _ => [&[], &[]],
                };
                for transparent in transparent {
                    for [width, height] in [[13, 9], [1, 1], [3, 20]] {
                        let bytes = noise(width, height, color, depth, is_interlaced, transparent);
                        check(
                            &bytes,
                            &format!("{width} x {height}, {color}, {depth}, {is_interlaced}, {transparent:?}"),
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn every_sixteen_bit_value_becomes_the_nearest_of_eight() {
    let deep = image::ImageBuffer::from_fn(256, 256, |x, y| image::Luma([(256 * y + x) as u16]));
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::DynamicImage::ImageLuma16(deep).write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    check(bytes.get_ref(), "all of 16 bits");
}

/// 24 x 16 texels in several scans, which the decoder holds together: 538 bytes written by ImageMagick.
const PROGRESSIVE: &str = "/9j/4AAQSkZJRgABAQAAAQABAAD/2wBDABQODxIPDRQSEBIXFRQYHjIhHhwcHj0sLiQySUBMS0dARkVQWnNiUFVtVkVGZIhlbXd7gYKBTmCNl4x9lnN+gXz/2wBDARUXFx4aHjshITt8U0ZTfHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHx8fHz/wgARCAAQABgDASIAAhEBAxEB/8QAFgABAQEAAAAAAAAAAAAAAAAAAAME/8QAFQEBAQAAAAAAAAAAAAAAAAAAAAT/2gAMAwEAAhADEAAAAcSSiqqQ/8QAFRABAQAAAAAAAAAAAAAAAAAAABH/2gAIAQEAAQUCqqqq/8QAFREBAQAAAAAAAAAAAAAAAAAAABT/2gAIAQMBAT8BoUP/xAAVEQEBAAAAAAAAAAAAAAAAAAAAFP/aAAgBAgEBPwGZM//EABQQAQAAAAAAAAAAAAAAAAAAACD/2gAIAQEABj8CX//EABQQAQAAAAAAAAAAAAAAAAAAACD/2gAIAQEAAT8hQH//2gAMAwEAAgADAAAAEPPP/8QAFREBAQAAAAAAAAAAAAAAAAAAAHH/2gAIAQMBAT8QpT//xAAVEQEBAAAAAAAAAAAAAAAAAAAAcf/aAAgBAgEBPxCEP//EABQQAQAAAAAAAAAAAAAAAAAAACD/2gAIAQEAAT8QQH//2Q==";

#[test]
fn jpegs_have_the_texels_that_image_decodes() {
    let noise = image::RgbImage::from_fn(45, 31, |x, y| image::Rgb([(x * 5) as u8, (y * 8) as u8, (x * y) as u8]));
    let noise = image::DynamicImage::ImageRgb8(noise);
    for (picture, what) in [(noise.clone(), "colours"), (noise.to_luma8().into(), "grey")] {
        let mut bytes = std::io::Cursor::new(Vec::new());
        picture.write_to(&mut bytes, image::ImageFormat::Jpeg).unwrap();
        check(bytes.get_ref(), what);
    }
    check(&STANDARD.decode(PROGRESSIVE).unwrap(), "progressive");
}

#[test]
fn what_pictures_take_is_known_before_they_are_decoded() {
    let needed = |bytes: &[u8], max_bytes: u64| {
        let mut doc = textured(json!({}));
        let view = doc.view(bytes);
        doc.json["images"][0] = json!({"bufferView": view});
        let scene = doc.load_with(&NoFiles, &LoadOptions { max_bytes, ..LoadOptions::default() }).unwrap();
        let note = scene.notes.iter().find(|n| n.0.contains("without its texture")).map(|n| n.0.clone());
        let note = note.unwrap_or_default();
        let needed = note.split_once("images[0]: this takes ").and_then(|(_, rest)| rest.split(' ').next());
        needed.map_or(0, |needed| needed.parse().unwrap())
    };
    // 300 x 200 texels of 12 bytes; nothing is decoded, since there is no image data after the header.
    let header = &noise(300, 200, 0, 8, false, &[])[..33];
    assert_eq!(needed(header, 500_000), 720_000);
    // If the limit is slightly too small, the coefficients do not fit: 32 x 32 texels, four channels of 16 bits.
    let progressive = STANDARD.decode(PROGRESSIVE).unwrap();
    let least = (1_u64..).map(|k| 1000 * k).find(|&max_bytes| {
        let mut doc = textured(json!({"uri": format!("data:,{}", "x")}));
        let view = doc.view(&progressive);
        doc.json["images"][0] = json!({"bufferView": view});
        let scene = doc.load_with(&NoFiles, &LoadOptions { max_bytes, ..LoadOptions::default() });
        scene.is_ok_and(|scene| scene.textures.len() == 1)
    });
    assert_eq!(needed(&progressive, least.unwrap() - 1000), 32 * 32 * 4 * 2);
}

#[test]
fn texels_are_counted_over_all_pictures() {
    let picture = png(2, 2, TEXELS.as_flattened());
    let mut doc = textured(json!({}));
    let view = doc.view(&picture);
    doc.json["images"] = json!([{"bufferView": view}, {"bufferView": view}]);
    doc.push("textures", json!({"source": 1}));
    doc.push("materials", json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 1}}}));
    let mut primitive = doc.primitive().clone();
    primitive["material"] = json!(1);
    doc.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(primitive);
    let load = |max_texels| doc.load_with(&NoFiles, &LoadOptions { max_texels, ..LoadOptions::default() });
    assert_eq!(load(8).unwrap().textures.len(), 2);
    // The second is left out.
    let scene = load(7).unwrap();
    assert_eq!(scene.textures.len(), 1);
    let note = "1 material is drawn without its texture: images[1]: is 2 x 2 texels, and 8 texels with all images \
                before it; at most 7 can be traced";
    assert!(notes(&scene).contains(&note), "{:?}", scene.notes);
}
