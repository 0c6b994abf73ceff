//! Writes the scene files of this repository, all of them and always the same:
//! `cargo run -p raystep-scenes --example make_scenes -- scenes`.

use base64::{Engine, prelude::BASE64_STANDARD};
use raystep_scenes::{Scene, generate, write_glb};
use serde_json::Value;
use std::error::Error;
use std::fs;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args_os().nth(1).ok_or("usage: make_scenes FOLDER")?;
    let folder = Path::new(&folder);
    fs::create_dir_all(folder)?;

    fs::write(folder.join("cornell-box.gltf"), readable(&generate::cornell_box())?)?;
    Ok(())
}

/// The scene as `.gltf`: the writer's JSON, one value a line, its bytes in a data URI.
fn readable(scene: &Scene) -> Result<String, Box<dyn Error>> {
    let glb = write_glb(scene)?;
    let length = |at: usize| glb[at..at + 4].try_into().map(|b| u32::from_le_bytes(b) as usize);
    let json = length(12)?;
    let mut document: Value = serde_json::from_slice(&glb[20..20 + json])?;
    if document.get("buffers").is_some() {
        let (at, bytes) = (20 + json + 8, document["buffers"][0]["byteLength"].as_u64().unwrap_or(0) as usize);
        let uri = format!("data:application/octet-stream;base64,{}", BASE64_STANDARD.encode(&glb[at..at + bytes]));
        document["buffers"][0]["uri"] = uri.into();
    }
    Ok(pretty(&document, 0) + "\n")
}

/// JSON with what fits on a line on one line. Strings with commas are only safe in what does not fit,
/// which here are data URIs alone.
fn pretty(value: &Value, indent: usize) -> String {
    let flat = value.to_string();
    let inner = " ".repeat(indent + 2);
    let lines: Vec<String> = match value {
        _ if indent > 0 && flat.len() + indent < 110 && !flat.contains("data:") => {
            return flat.replace(',', ", ").replace("\":", "\": ");
        }
        Value::Array(items) => items.iter().map(|v| inner.clone() + &pretty(v, indent + 2)).collect(),
        Value::Object(map) => {
            map.iter().map(|(k, v)| format!("{inner}{}: {}", Value::from(k.as_str()), pretty(v, indent + 2))).collect()
        }
        _ => return flat,
    };
    let (open, close) = if value.is_array() { ('[', ']') } else { ('{', '}') };
    format!("{open}\n{}\n{}{close}", lines.join(",\n"), " ".repeat(indent))
}
