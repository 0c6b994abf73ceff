//! glTF 2.0 in, a [`Scene`] out.
//!
//! A file is read in the order of the modules below:
//!
//! * `container` splits a GLB and parses the JSON, with `repair` for what the parser is too strict about.
//! * `buffers` brings the bytes together as they are used: the BIN chunk, data URIs and external files.
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
mod json_path;
mod lights_cameras;
mod materials;
mod place;
mod pose;
mod repair;

use crate::{Note, Scene};
use budget::Budget;
use check::{Notes, at};
use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;

/// Reads the files that a glTF file names beside itself.
pub trait Resolver {
    /// The bytes of `path`: the percent-decoded relative path of the file's URI, `/` between its
    /// parts. `..` may occur in it, and so may links on the way: it is for the resolver to keep to the
    /// folder that it may read. A file of more than `max_bytes` is to be refused without reading it.
    ///
    /// # Errors
    /// If the file may not be read, cannot be, or is larger than `max_bytes`.
    fn read(&self, path: &str, max_bytes: u64) -> Result<Vec<u8>, FileError>;
}

/// Why a [`Resolver`] did not read a file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FileError {
    /// It lies outside of the folder that files are read from.
    #[error("it lies outside of {folder}, the scene's folder")]
    Outside {
        /// That folder.
        folder: String,
    },
    /// It is larger than what may be read.
    #[error("its {bytes} bytes are more than can be read here")]
    TooLarge {
        /// Its size.
        bytes: u64,
    },
    /// What is wrong with the file, without its path.
    #[error("{0}")]
    Unreadable(String),
}

impl From<String> for FileError {
    fn from(problem: String) -> Self {
        Self::Unreadable(problem)
    }
}

impl From<&str> for FileError {
    fn from(problem: &str) -> Self {
        Self::Unreadable(problem.into())
    }
}

/// A [`Resolver`] that refuses every file, for scenes that hold everything themselves.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoFiles;

impl Resolver for NoFiles {
    fn read(&self, _path: &str, _max_bytes: u64) -> Result<Vec<u8>, FileError> {
        Err("no files can be read beside this scene".into())
    }
}

/// How [`load`] reads a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoadOptions {
    /// Which scene of the file, counted from 0; `None` is the file's default scene, else its first.
    pub scene: Option<usize>,
    /// The most bytes that a scene may take: the input, the files beside it and all that is decoded, temporary
    /// bytes included, and for texels also the copy that kernels will read. All but what the decoder of an image
    /// needs is counted for good, so this bounds the time as well.
    pub max_bytes: u64,
    /// The most texels of all textures together.
    pub max_texels: u64,
}

impl Default for LoadOptions {
    /// The file's own scene, 8 GiB, and as many texels as one buffer of 4 GiB holds in eight bytes each: that is
    /// how kernels read them, and no more can be bound on Vulkan, on Direct3D 12 or on the CPU.
    fn default() -> Self {
        Self { scene: None, max_bytes: 8 << 30, max_texels: 1 << 29 }
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
    #[error("the glTF JSON is invalid: {0}")]
    Json(String),
    /// The file needs an extension that raystep does not know.
    #[error("the file requires the extension {0}, which is not supported (supported: {1})")]
    RequiredExtension(String, String),
    /// [`LoadOptions::scene`] names a scene that is not there.
    #[error("scene {asked} does not exist; the file has {count} (counted from 0)")]
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
    /// A file beside this one lies where it must not be read.
    #[error("{path}: \"{uri}\" lies outside of {folder}, the scene's folder")]
    Outside {
        /// The place that names the file, e.g. `buffers[0].uri`.
        path: String,
        /// The file's URI as it is written there.
        uri: String,
        /// The folder that files are read from.
        folder: String,
    },
    /// More texels than [`LoadOptions::max_texels`].
    #[error(
        "{path}: is {width} x {height} texels, and {all} texels with all images before it; at most {limit} can be traced"
    )]
    TooManyTexels {
        /// The image.
        path: String,
        /// Its texels a row.
        width: u32,
        /// Its rows.
        height: u32,
        /// With all before it.
        all: u64,
        /// [`LoadOptions::max_texels`].
        limit: u64,
    },
    /// This machine's memory does not hold it.
    #[error("{path}: not enough memory for the {bytes} bytes that this takes")]
    OutOfMemory {
        /// The place.
        path: String,
        /// Bytes it would take.
        bytes: u64,
    },
    /// Reading this would take more than [`LoadOptions::max_bytes`].
    #[error("{path}: this takes {needed} more bytes, but only {left} of the limit of {limit} are left")]
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
    let budget = Budget::new(options.max_bytes);
    budget.take(bytes.len() as u64, "the file")?;
    let (root, bin) = container::parse(bytes, &budget)?;
    let notes = RefCell::new(Notes::default());
    check::extensions(&root, &mut notes.borrow_mut())?;

    let buffers = buffers::Buffers::new(&root, bin, resolver, &budget)?;
    let accessors = accessor::Accessors::new(&root, &buffers, &budget, &notes);

    let graph = graph::Graph::new(&root)?;
    let nodes = graph.nodes_of(&root, options.scene)?;
    graph::check_transforms(&root, &nodes, &mut notes.borrow_mut());
    let groups = geometry::groups(&root, &nodes)?;
    let primitives = geometry::survey(&root, &accessors, &groups, &notes)?;

    // Sorted: the default material, then the file's order, and each once.
    let used: BTreeSet<Option<usize>> = primitives.iter().map(geometry::Primitive::material).collect();
    let images = images::Images {
        buffers: &buffers,
        resolver,
        budget: &budget,
        max_texels: options.max_texels,
        texels: Cell::new(0),
    };
    let materials = materials::read(&root, &used, &images, &mut notes.borrow_mut())?;

    let poser = pose::Poser::new(&root, &accessors, &graph, &budget);
    let triangles = geometry::triangles(&primitives, &accessors, &poser, &graph, &materials, &budget, &notes)?;
    let mut notes = notes.take();
    let cameras = lights_cameras::cameras(&root, &graph, &nodes, &budget)?;
    let lights = lights_cameras::lights(&root, &graph, &nodes, &mut notes)?;

    if triangles.positions.is_empty() {
        notes.add("the scene has no triangles");
    }
    if cameras.is_empty() {
        notes.add("no camera in the file: using one that frames the scene");
    }
    if lights.is_empty() {
        notes.add("no lights in the file: using a headlight at the eye");
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
