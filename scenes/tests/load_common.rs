//! Tiny glTF documents, built in the tests.
#![allow(clippy::unwrap_used, reason = "a test that cannot make its input has failed")]

use raystep_scenes::{FileError, LoadError, LoadOptions, NoFiles, Resolver, Scene, load};
use serde_json::{Value, json};
use std::collections::HashMap;

pub(crate) const I8: u32 = 5120;
pub(crate) const U8: u32 = 5121;
pub(crate) const I16: u32 = 5122;
pub(crate) const U16: u32 = 5123;
pub(crate) const U32: u32 = 5125;
pub(crate) const F32: u32 = 5126;

/// A document under construction: JSON and the bytes of its only buffer.
#[derive(Clone)]
pub(crate) struct Doc {
    pub(crate) json: Value,
    pub(crate) bin: Vec<u8>,
}

impl Doc {
    /// A document with only the version and one buffer.
    pub(crate) fn new() -> Self {
        let json = json!({"asset": {"version": "2.0"}, "buffers": [], "bufferViews": [], "accessors": [],
            "meshes": [], "nodes": []});
        Self { json, bin: Vec::new() }
    }

    /// The unit right triangle in the XY plane as mesh 0, facing +Z, on node 0.
    pub(crate) fn triangle() -> Self {
        let mut doc = Self::new();
        let position = doc.floats("VEC3", &[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
        doc.mesh(json!({"POSITION": position}));
        doc.push("nodes", json!({"mesh": 0}));
        doc
    }

    /// Appends to one of the lists; returns the index.
    pub(crate) fn push(&mut self, list: &str, value: Value) -> usize {
        if self.json.get(list).is_none() {
            self.json[list] = json!([]);
        }
        let list = self.json[list].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let offset = self.bin.len();
        self.bin.extend(bytes);
        self.push("bufferViews", json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}))
    }

    pub(crate) fn accessor(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        self.push("accessors", json!({"bufferView": view, "componentType": component, "count": count, "type": kind}))
    }

    pub(crate) fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let size = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        self.accessor(kind, F32, values.len() / size, &f32s(values))
    }

    /// A mesh of one primitive.
    pub(crate) fn mesh(&mut self, attributes: Value) -> usize {
        self.push("meshes", json!({"primitives": [{"attributes": attributes}]}))
    }

    /// The first primitive of the first mesh.
    pub(crate) fn primitive(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]
    }

    pub(crate) fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"] = json!([{"byteLength": self.bin.len()}]);
        glb(&json, &self.bin)
    }

    pub(crate) fn load_with(&self, resolver: &dyn Resolver, options: &LoadOptions) -> Result<Scene, LoadError> {
        load("test.glb", &self.glb(), resolver, options)
    }

    pub(crate) fn load(&self) -> Result<Scene, LoadError> {
        self.load_with(&NoFiles, &LoadOptions::default())
    }

    #[track_caller]
    pub(crate) fn scene(&self) -> Scene {
        self.load().unwrap_or_else(|error| panic!("{error}"))
    }

    /// The message of the error that loading must return.
    #[track_caller]
    pub(crate) fn error(&self) -> String {
        match self.load() {
            Ok(scene) => panic!("loaded: {} triangles, {:?}", scene.triangles.len(), scene.notes),
            Err(error) => one_line(&error),
        }
    }
}

#[track_caller]
pub(crate) fn one_line(error: &LoadError) -> String {
    let text = error.to_string();
    assert!(!text.contains('\n') && text.len() > 10, "{text:?}");
    text
}

/// A GLB of this JSON and BIN chunk.
pub(crate) fn glb(json: &Value, bin: &[u8]) -> Vec<u8> {
    let mut json = json.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bin = bin.to_vec();
    bin.resize(bin.len().next_multiple_of(4), 0);
    let mut out = b"glTF\x02\0\0\0".to_vec();
    out.extend((28 + json.len() as u32 + bin.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &bin)] {
        out.extend((chunk.len() as u32).to_le_bytes());
        out.extend(kind);
        out.extend(chunk);
    }
    out
}

pub(crate) fn f32s(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

pub(crate) fn u16s(values: &[u16]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

pub(crate) fn u32s(values: &[u32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

pub(crate) fn i16s(values: &[i16]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

pub(crate) fn i8s(values: &[i8]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// Files in memory.
#[derive(Default)]
pub(crate) struct Files(pub HashMap<String, Vec<u8>>);

impl Files {
    pub(crate) fn one(name: &str, bytes: &[u8]) -> Self {
        Self(HashMap::from([(name.to_owned(), bytes.to_vec())]))
    }
}

impl Resolver for Files {
    fn read(&self, path: &str, max_bytes: u64) -> Result<Vec<u8>, FileError> {
        match self.0.get(path) {
            Some(bytes) if bytes.len() as u64 > max_bytes => Err(FileError::TooLarge { bytes: bytes.len() as u64 }),
            Some(bytes) => Ok(bytes.clone()),
            None => Err("there is no such file".into()),
        }
    }
}

/// The notes as plain strings.
pub(crate) fn notes(scene: &Scene) -> Vec<&str> {
    scene.notes.iter().map(|note| note.0.as_str()).collect()
}

/// Whether all numbers are within 1e-6 of each other: about ten f32 steps at 1.
#[track_caller]
pub(crate) fn close(a: &[f32], b: &[f32]) {
    assert!(a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-6), "{a:?} and {b:?}");
}

/// A 2 x 2 image: red, green / blue, white.
pub(crate) const TEXELS: [[u8; 4]; 4] = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255, 255, 255, 255]];

pub(crate) fn png(width: u32, height: u32, rgba: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new(&mut out);
    image::ImageEncoder::write_image(encoder, rgba, width, height, image::ExtendedColorType::Rgba8).unwrap();
    out
}

/// Options with a small memory limit.
pub(crate) fn small() -> LoadOptions {
    LoadOptions { max_bytes: 16 << 20, ..Default::default() }
}
