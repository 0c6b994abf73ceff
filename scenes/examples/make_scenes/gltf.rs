//! A small glTF writer for features that `write_glb` never uses: strips, fans, sparse, normalised and interleaved
//! accessors, external files. Each scene provides its nodes and meshes as JSON.

use base64::{Engine, prelude::BASE64_STANDARD};
use serde_json::{Value, json};

pub(crate) const BYTE: u32 = 5120;
pub(crate) const UNSIGNED_BYTE: u32 = 5121;
pub(crate) const SHORT: u32 = 5122;
pub(crate) const UNSIGNED_SHORT: u32 = 5123;
pub(crate) const FLOAT: u32 = 5126;

pub(crate) const TRIANGLE_STRIP: u32 = 5;
pub(crate) const TRIANGLE_FAN: u32 = 6;

/// A file's buffer, with the views and accessors of its contents.
#[derive(Default)]
pub(crate) struct Buffer {
    pub(crate) bytes: Vec<u8>,
    pub(crate) views: Vec<Value>,
    pub(crate) accessors: Vec<Value>,
}

impl Buffer {
    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() }));
        self.bytes.extend(bytes);
        self.views.len() - 1
    }

    /// A view with vertices `stride` bytes apart.
    pub(crate) fn strided(&mut self, bytes: &[u8], stride: usize) -> usize {
        let view = self.view(bytes);
        self.views[view]["byteStride"] = stride.into();
        view
    }

    pub(crate) fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Tightly packed floats, with the bounds that POSITION requires.
    pub(crate) fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
        let view = self.view(&bytes);
        let bound = |pick: fn(f32, f32) -> f32| {
            (0..N).map(|i| values.iter().map(|v| v[i]).reduce(pick).unwrap_or(0.0)).collect::<Vec<_>>()
        };
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][(N - 1).min(3)];
        let (count, min, max) = (values.len(), bound(f32::min), bound(f32::max));
        self.accessor(json!({
            "bufferView": view, "componentType": FLOAT, "count": count, "type": kind, "min": min, "max": max
        }))
    }

    pub(crate) fn indices(&mut self, indices: &[u16]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|v| v.to_le_bytes()).collect();
        let view = self.view(&bytes);
        self.accessor(
            json!({ "bufferView": view, "componentType": UNSIGNED_SHORT, "count": indices.len(), "type": "SCALAR" }),
        )
    }

    pub(crate) fn byte_indices(&mut self, indices: &[u8]) -> usize {
        let view = self.view(indices);
        self.accessor(
            json!({ "bufferView": view, "componentType": UNSIGNED_BYTE, "count": indices.len(), "type": "SCALAR" }),
        )
    }

    /// The document with this buffer at `uri`; `None` for the GLB's own chunk.
    pub(crate) fn document(&self, mut scene: Value, uri: Option<String>) -> Value {
        scene["asset"] = json!({ "version": "2.0", "generator": "raystep make_scenes" });
        for (name, list) in [("bufferViews", &self.views), ("accessors", &self.accessors)] {
            if !list.is_empty() {
                scene[name] = json!(list);
            }
        }
        if !self.bytes.is_empty() {
            scene["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
            if let Some(uri) = uri {
                scene["buffers"][0]["uri"] = uri.into();
            }
        }
        scene
    }

    /// `.gltf` text with the buffer in a data URI.
    pub(crate) fn text(&self, scene: Value) -> String {
        pretty(&self.document(scene, Some(data_uri("application/octet-stream", &self.bytes)))) + "\n"
    }

    /// A GLB.
    pub(crate) fn glb(&self, scene: Value) -> Vec<u8> {
        let mut json = self.document(scene, None).to_string().into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut bytes = self.bytes.clone();
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        let mut out = b"glTF\x02\0\0\0".to_vec();
        out.extend((28 + json.len() as u32 + bytes.len() as u32).to_le_bytes());
        for (kind, chunk) in [(b"JSON", json), (b"BIN\0", bytes)] {
            out.extend((chunk.len() as u32).to_le_bytes());
            out.extend(kind);
            out.extend(chunk);
        }
        out
    }
}

pub(crate) fn data_uri(mime: &str, bytes: &[u8]) -> String {
    format!("data:{mime};base64,{}", BASE64_STANDARD.encode(bytes))
}

/// JSON in which everything that fits on one line is on one line.
pub(crate) fn pretty(value: &Value) -> String {
    broken(value, 0)
}

fn broken(value: &Value, indent: usize) -> String {
    let flat = flat(value);
    if flat.len() + indent < 110 && indent > 0 {
        return flat;
    }
    let inner = " ".repeat(indent + 2);
    let lines: Vec<String> = match value {
        Value::Array(items) => items.iter().map(|v| inner.clone() + &broken(v, indent + 2)).collect(),
        Value::Object(map) => {
            let entry = |(k, v): (&String, _)| format!("{inner}{}: {}", json!(k), broken(v, indent + 2));
            map.iter().map(entry).collect()
        }
        _ => return flat,
    };
    let (open, close) = if value.is_array() { ('[', ']') } else { ('{', '}') };
    format!("{open}\n{}\n{}{close}", lines.join(",\n"), " ".repeat(indent))
}

fn flat(value: &Value) -> String {
    match value {
        Value::Array(items) => format!("[{}]", items.iter().map(flat).collect::<Vec<_>>().join(", ")),
        Value::Object(map) => {
            let entries = map.iter().map(|(k, v)| format!("{}: {}", json!(k), flat(v)));
            format!("{{{}}}", entries.collect::<Vec<_>>().join(", "))
        }
        _ => value.to_string(),
    }
}

/// A rough material of one colour.
pub(crate) fn matte(name: &str, color: [f64; 3]) -> Value {
    let [r, g, b] = color;
    json!({ "name": name, "pbrMetallicRoughness": {
        "baseColorFactor": [r, g, b, 1], "metallicFactor": 0, "roughnessFactor": 1
    } })
}

/// A node at `position` with the rotation that turns −Z to `target`.
pub(crate) fn looking(position: [f64; 3], target: [f64; 3]) -> Value {
    let projection = raystep_scenes::Projection::Orthographic { half_height: 1.0 };
    let turn = raystep_scenes::Camera::look_at(position.into(), target.into(), glam::DVec3::Y, projection)
        .map_or(glam::DQuat::IDENTITY, |c| glam::DQuat::from_mat3(&glam::DMat3::from_cols(c.right, c.up, -c.forward)));
    json!({ "translation": position, "rotation": turn.to_array() })
}

pub(crate) fn perspective(name: &str, fov_deg: f64) -> Value {
    json!({ "name": name, "type": "perspective", "perspective": { "yfov": fov_deg.to_radians(), "znear": 0.01 } })
}

/// `node` with `entries` added.
pub(crate) fn with(mut node: Value, entries: Value) -> Value {
    if let (Some(node), Value::Object(entries)) = (node.as_object_mut(), entries) {
        node.extend(entries);
    }
    node
}
