//! glTF 2.0 in, a [`Scene`] out.
//!
//! A file is read in the order of the modules below:
//!
//! * `container` splits a GLB and parses the JSON.
//! * `buffers` brings the bytes together: the BIN chunk, data URIs and external files.
//! * `graph` checks the nodes (cycles, two parents) and works out their world matrices.
//! * `materials` and `images` turn the materials in use into ours.
//! * `geometry` counts the triangles, then decodes each primitive once and places it where its
//!   nodes say; `pose` applies morph targets and skins.
//! * `lights_cameras` reads the rest.
//!
//! Nothing in a file is believed. No `gltf::Document` is ever built, since its iterators index
//! without checks: every index goes through `check`, every accessor through the bounded reader in
//! `accessor`, and every allocation through a [`Budget`](budget::Budget) before it is made.

mod accessor;
mod budget;
mod buffers;
mod check;
mod container;
mod geometry;
mod graph;
mod images;
mod lights_cameras;
mod materials;
mod place;
mod pose;

use crate::{Note, Scene};
use budget::Budget;
use check::{Notes, at};
use std::collections::BTreeSet;

/// Reads the files that a glTF file names beside itself.
pub trait Resolver {
    /// The bytes of `path`: the percent-decoded relative path of the file's URI, `/` between its
    /// parts. `..` may occur in it, and it is for the resolver to allow that or not. A file of more
    /// than `max_bytes` is to be refused without reading it. The message of an error should say
    /// what is wrong with the file; `path` is added to it.
    ///
    /// # Errors
    /// Where the file cannot be read, or is larger than `max_bytes`.
    fn read(&self, path: &str, max_bytes: u64) -> Result<Vec<u8>, String>;
}

/// A [`Resolver`] that refuses every file, for scenes that hold everything themselves.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoFiles;

impl Resolver for NoFiles {
    fn read(&self, _path: &str, _max_bytes: u64) -> Result<Vec<u8>, String> {
        Err("no files can be read beside this scene".into())
    }
}

/// How [`load`] reads a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoadOptions {
    /// Which scene of the file, counted from 0; `None` is the file's default scene, else its first.
    pub scene: Option<usize>,
    /// The most bytes that may be decoded, temporary ones included, on top of the input itself.
    /// All that is decoded is counted and nothing is given back, so this bounds the time as well.
    pub max_bytes: u64,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self { scene: None, max_bytes: 16 << 30 }
    }
}

/// Why a file could not be read. One line: where, what, and what would be right.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LoadError {
    /// The bytes are neither a GLB nor glTF JSON, or a GLB's chunks do not add up.
    #[error("{0}")]
    Container(String),
    /// The JSON is malformed, or a property has the wrong type.
    #[error("the glTF JSON is wrong: {0}")]
    Json(String),
    /// The file needs an extension that raystep does not know.
    #[error("the file requires the extension {0}, which is not supported (supported: {1})")]
    RequiredExtension(String, String),
    /// [`LoadOptions::scene`] names a scene that is not there.
    #[error("scene {asked} was asked for, but the file has {count} (counted from 0)")]
    NoSuchScene {
        /// What was asked for.
        asked: usize,
        /// How many there are.
        count: usize,
    },
    /// Something at one place of the JSON, or in what that place refers to, is wrong.
    #[error("{path}: {problem}")]
    Invalid {
        /// The place, e.g. `meshes[0].primitives[1].attributes.POSITION`.
        path: String,
        /// What is wrong there, and what would be right.
        problem: String,
    },
    /// A file beside this one could not be read.
    #[error("{path}: cannot read \"{file}\": {problem}")]
    External {
        /// The place that names the file, e.g. `buffers[0].uri`.
        path: String,
        /// The file's relative path.
        file: String,
        /// The resolver's words.
        problem: String,
    },
    /// Decoding would take more than [`LoadOptions::max_bytes`].
    #[error("{path}: decoding this takes {needed} more bytes, but only {left} of the limit of {limit} are left")]
    TooLarge {
        /// The place.
        path: String,
        /// Bytes it would take.
        needed: u64,
        /// Bytes left.
        left: u64,
        /// [`LoadOptions::max_bytes`].
        limit: u64,
    },
}

/// Reads a glTF 2.0 file, JSON or GLB, into a [`Scene`].
///
/// `name` becomes [`Scene::name`], without a `.gltf` or `.glb` at its end. What was left out or
/// assumed is said in [`Scene::notes`].
///
/// # Errors
/// A [`LoadError`] where the file is broken, needs what is not supported, or is too large.
pub fn load(name: &str, bytes: &[u8], resolver: &dyn Resolver, options: &LoadOptions) -> Result<Scene, LoadError> {
    let (root, bin) = container::parse(bytes)?;
    let mut notes = Notes::default();
    check::extensions(&root, &mut notes)?;

    let budget = Budget::new(options.max_bytes);
    let buffers = buffers::gather(&root, bin, resolver, &budget)?;
    let accessors = accessor::Accessors::new(&root, &buffers, &budget);

    let graph = graph::Graph::new(&root)?;
    let nodes = graph.nodes_of(&root, options.scene)?;
    let groups = geometry::groups(&root, &nodes)?;
    let primitives = geometry::survey(&root, &accessors, &groups, &mut notes)?;

    // Sorted: the default material, then the file's order, and each once.
    let used: BTreeSet<Option<usize>> = primitives.iter().map(geometry::Primitive::material).collect();
    let materials = materials::read(&root, &used, &buffers, resolver, &budget, &mut notes)?;

    let poser = pose::Poser::new(&root, &accessors, &graph, &budget);
    let triangles = geometry::triangles(&primitives, &accessors, &poser, &graph, &materials, &budget, &mut notes)?;
    let cameras = lights_cameras::cameras(&root, &graph, &nodes, &budget)?;
    let lights = lights_cameras::lights(&root, &graph, &nodes, &mut notes)?;

    if triangles.positions.is_empty() {
        notes.add("the scene has no triangles");
    }
    if cameras.is_empty() {
        notes.add("no camera in the file: one that frames the scene is used");
    }
    if lights.is_empty() {
        notes.add("no lights in the file: a headlight at the eye is used");
    }
    if !root.animations.is_empty() {
        notes.add("animations are ignored");
    }
    let name = name.strip_suffix(".gltf").or_else(|| name.strip_suffix(".glb")).unwrap_or(name);
    Ok(Scene {
        name: name.to_owned(),
        triangles: triangles.positions,
        normals: triangles.normals,
        texcoords: triangles.texcoords,
        colors: triangles.colors,
        triangle_materials: triangles.materials,
        materials: materials.materials,
        textures: materials.textures,
        lights,
        cameras,
        notes: notes.into_vec().into_iter().map(Note).collect(),
    })
}
