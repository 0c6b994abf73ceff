//! Writes the scene files of this repository, the same bytes every time:
//! `cargo run -p raystep-scenes --example make_scenes -- scenes [teapot.js]`.
//!
//! `teapot.js` is the file of that name in the npm package `teapot` 1.0.0; without it, `teapot.glb` is left unchanged.

mod gltf;
mod plain;
mod shapes;
mod surfaces;
mod teapot;

use base64::{Engine, prelude::BASE64_STANDARD};
use raystep_scenes::{Scene, generate, write_glb};
use serde_json::Value;
use std::error::Error;
use std::fs;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1);
    let folder = arguments.next().ok_or("usage: make_scenes FOLDER [teapot.js]")?;
    let folder = Path::new(&folder);
    fs::create_dir_all(folder)?;
    let write = |name: &str, bytes: &[u8]| {
        println!("{:>9} bytes  {name}", bytes.len());
        fs::write(folder.join(name), bytes)
    };

    write("cornell-box.gltf", readable(&generate::cornell_box())?.as_bytes())?;
    write("primitives.gltf", plain::primitives().as_bytes())?;
    write("instances.gltf", plain::instances().as_bytes())?;
    write("bare.gltf", plain::bare().as_bytes())?;
    write("single-triangle.gltf", plain::single_triangle().as_bytes())?;
    write("flat.gltf", plain::flat().as_bytes())?;
    write("empty.gltf", plain::empty().as_bytes())?;
    let (text, data, chessboard) = surfaces::textures()?;
    write("textures.gltf", text.as_bytes())?;
    write(surfaces::DATA, &data)?;
    write(surfaces::CHESSBOARD, &chessboard)?;
    write("lights.gltf", surfaces::lights().as_bytes())?;
    write("quantized.glb", &surfaces::quantized())?;
    write("skin-and-morph.gltf", surfaces::skin_and_morph().as_bytes())?;
    write("sphere-flake.glb", &write_glb(&generate::sphere_flake(2, 2)?)?)?;
    write("whitted.glb", &write_glb(&generate::whitted(3)?)?)?;
    write("terrain.glb", &write_glb(&generate::terrain(20_000, 1)?)?)?;
    if let Some(source) = arguments.next() {
        write("teapot.glb", &write_glb(&teapot::teapot(&fs::read_to_string(source)?)?)?)?;
    }
    Ok(())
}

/// The scene as `.gltf`: JSON on several lines, bytes in a data URI.
fn readable(scene: &Scene) -> Result<String, Box<dyn Error>> {
    let glb = write_glb(scene)?;
    let json = u32::from_le_bytes(glb[12..16].try_into()?) as usize;
    let mut document: Value = serde_json::from_slice(&glb[20..20 + json])?;
    let bytes = document["buffers"][0]["byteLength"].as_u64().unwrap_or(0) as usize;
    let at = 20 + json + 8;
    let uri = format!("data:application/octet-stream;base64,{}", BASE64_STANDARD.encode(&glb[at..at + bytes]));
    document["buffers"][0]["uri"] = uri.into();
    Ok(gltf::pretty(&document) + "\n")
}
