//! Loads a file into a [`Scene`].
//!
//! `format` finds out which format a file has. `obj`, `ply` and `stl` read vertices and polygons into a `mesh`, which
//! makes the scene of them; `polygon` cuts polygons into triangles.
//!
//! The modules of glTF are in the order in which a file is read, and `gltf_scene` calls them:
//!
//! * `container` splits a GLB; `json` parses the JSON into objects in which wrong values stay local.
//! * `buffers` reads bytes on demand: the BIN chunk, data URIs, external files, and what `meshopt` decompresses.
//! * `graph` mends the hierarchy of nodes (cycles, two parents) and computes their world transforms, `instances` those
//!   of instances.
//! * `survey` finds the primitives to show and counts their triangles; `draco` decompresses some.
//! * `materials` and `images` convert the materials in use.
//! * `primitive` decodes a primitive, `pose` applies morph targets and skins, and `geometry` places it for each of its
//!   nodes. If the scene turns out to lie far from the origin, all are placed again, with an `offset`.
//! * `lights_cameras` reads the rest.
//!
//! A file's contents are never trusted: every index goes through [`json::List`], every accessor through the bounded
//! reader in `accessor`, and every allocation is first charged to a [`Budget`](budget::Budget). What the picture does
//! not need is left out if it is wrong, and so is one shape among others; `lost` and `notes` count that.

mod accessor;
mod budget;
mod buffers;
mod check;
mod container;
mod draco;
mod format;
mod geometry;
mod gltf_scene;
mod graph;
mod images;
mod instances;
mod json;
mod json_path;
mod lights_cameras;
mod lost;
mod materials;
mod mesh;
mod meshopt;
mod notes;
mod obj;
mod offset;
mod place;
mod ply;
mod points;
mod polygon;
mod pose;
mod primitive;
mod stl;
mod survey;
mod text;

use crate::Scene;
use budget::Budget;
use check::at;
pub use format::ENDINGS;
use format::Format;
use std::cell::RefCell;
use std::collections::BTreeSet;

/// Reads the external files of a glTF file.
pub trait Resolver {
    /// The bytes of `path`: the percent-decoded relative path of the file's URI, with `/` as separator. It may contain
    /// `..`, and the file system may have links: the resolver must ensure that only permitted folders are read. A file
    /// of more than `max_bytes` must be rejected without reading it. If a path with `\` cannot be read, the same with `/`
    /// is asked for.
    ///
    /// # Errors
    /// If the file is not permitted, cannot be read, or is larger than `max_bytes`.
    fn read(&self, path: &str, max_bytes: u64) -> Result<Vec<u8>, FileError>;
}

/// Why a [`Resolver`] did not read a file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FileError {
    /// It is outside the folder from which files may be read.
    #[error("it lies outside of {folder}, the scene's folder")]
    Outside {
        /// That folder.
        folder: String,
    },
    /// It is larger than the limit.
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

/// A [`Resolver`] that rejects every file, for self-contained scenes.
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
    /// Index of the scene, counting from 0; `None` for the file's default scene, or else its first.
    pub scene: Option<usize>,
    /// Maximum number of bytes for a scene: the input, external files and everything decoded, including temporary bytes
    /// and the copy of texels for kernels. Charged bytes are never given back, except those for an image decoder, so
    /// this limits the time as well.
    pub max_bytes: u64,
    /// Maximum number of texels in all textures together.
    pub max_texels: u64,
}

impl Default for LoadOptions {
    /// The file's default scene, 8 GiB, and as many texels as fit into one buffer of 4 GiB at the eight bytes per texel
    /// that kernels read: no more can be bound on Vulkan, on Direct3D 12 or on the CPU.
    fn default() -> Self {
        Self { scene: None, max_bytes: 8 << 30, max_texels: 1 << 29 }
    }
}

/// Why a file could not be read. One line: where, what, and what was expected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LoadError {
    /// The file's structure is wrong: e.g. the lengths of a GLB's chunks, or PLY's header; or there is nothing to draw.
    #[error("{0}")]
    Container(String),
    /// The file is of a kind that is known, but not read.
    #[error("the file is {0}; raystep reads glTF 2.0, GLB, OBJ, PLY and STL")]
    OtherFormat(&'static str),
    /// The file is of no known kind. Only the name of an OBJ file shows what it is.
    #[error("not a scene: raystep reads glTF, GLB, PLY and STL by what they contain, and OBJ if its name ends in .obj")]
    UnknownFormat,
    /// A line of text does not have the form that its first word requires.
    #[error("line {line}: {problem}")]
    Line {
        /// Counting from 1.
        line: usize,
        /// What is wrong there, and what was expected.
        problem: String,
    },
    /// The JSON is malformed, or a property has the wrong type.
    #[error("the glTF JSON is invalid: {0}")]
    Json(String),
    /// The file requires an extension that raystep does not support.
    #[error("the file requires the extension {0}, which is not supported (supported: {1})")]
    RequiredExtension(String, String),
    /// [`LoadOptions::scene`] does not exist.
    #[error("scene {asked} does not exist; the file has {count} (counted from 0)")]
    NoSuchScene {
        /// The requested index.
        asked: usize,
        /// The number of scenes.
        count: usize,
    },
    /// Something in the JSON, or in data that it refers to, or an element of another format, is wrong.
    #[error("{path}: {problem}")]
    Invalid {
        /// The place, e.g. `meshes[0].primitives[1].attributes.POSITION` or `face 3`.
        path: String,
        /// What is wrong there, and what was expected.
        problem: String,
    },
    /// A buffer has not the bytes that the file says.
    #[error("{path}: {problem}")]
    Buffer {
        /// The buffer, e.g. `buffers[0]`.
        path: String,
        /// What is wrong with it, and what was expected.
        problem: String,
    },
    /// An external file could not be read.
    #[error("{path}: cannot read \"{file}\": {problem}")]
    External {
        /// The place that names the file, e.g. `buffers[0].uri`.
        path: String,
        /// The file's relative path.
        file: String,
        /// The resolver's message.
        problem: String,
    },
    /// An external file is outside the permitted folder.
    #[error("{path}: \"{uri}\" lies outside of {folder}, the scene's folder")]
    Outside {
        /// The place that names the file, e.g. `buffers[0].uri`.
        path: String,
        /// The file's URI as it is written there.
        uri: String,
        /// The folder from which files may be read.
        folder: String,
    },
    /// More texels than [`LoadOptions::max_texels`].
    #[error(
        "{path}: is {width} x {height} texels, and {all} texels with all images before it; at most {limit} can be traced"
    )]
    TooManyTexels {
        /// The image.
        path: String,
        /// Its width.
        width: u32,
        /// Its height.
        height: u32,
        /// Texels of all images so far.
        all: u64,
        /// [`LoadOptions::max_texels`].
        limit: u64,
    },
    /// There is not enough memory.
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

/// The external files that a file names, each once, as [`load`] asks its [`Resolver`] for them: for a host that cannot
/// read a file at once. Only glTF names such files. Names that [`load`] rejects are left out, as are those of files that
/// it rejects because of their format.
///
/// # Errors
/// If a glTF file is invalid, or has more than `max_bytes`.
pub fn external_files(bytes: &[u8], max_bytes: u64) -> Result<Vec<String>, LoadError> {
    /// Takes down what it is asked for.
    struct Names(RefCell<BTreeSet<String>>);

    impl Resolver for Names {
        fn read(&self, path: &str, _max_bytes: u64) -> Result<Vec<u8>, FileError> {
            self.0.borrow_mut().insert(path.to_owned());
            Err("only its name is wanted".into())
        }
    }

    let budget = Budget::new(max_bytes);
    budget.take(bytes.len() as u64, "the file")?;
    if Format::certain(bytes) != Some(Format::Gltf) {
        return Ok(Vec::new());
    }
    let (root, _) = container::parse(bytes, &budget)?;
    let names = Names(RefCell::default());
    let buffers = root.buffers.elements().iter().filter_map(|buffer| buffer.ok()?.uri.ok());
    let images = root.images.elements().iter().filter_map(|image| image.ok()?.uri.ok());
    for uri in buffers.chain(images).filter(|uri| !buffers::is_data(&uri.0)) {
        // What is wrong with a name is told where the file is read.
        let _: Result<Vec<u8>, LoadError> = buffers::read_uri(&uri.0, "", &names, &budget);
    }
    Ok(names.0.into_inner().into_iter().collect())
}

/// Reads a file into a [`Scene`]: glTF 2.0 (JSON or GLB), Wavefront OBJ, Stanford PLY or STL.
///
/// The format is that of the contents where they are certain, otherwise that of the ending of `name`, in letters of any
/// case. Without this ending, `name` becomes [`Scene::name`]. [`Scene::notes`] lists what was ignored or assumed.
///
/// # Errors
/// If the file is invalid, requires an unsupported extension, is too large, or is of another format. Parts of a file that
/// cannot be drawn are left out with a note, unless nothing else is left, or a file that they need is missing.
pub fn load(name: &str, bytes: &[u8], resolver: &dyn Resolver, options: &LoadOptions) -> Result<Scene, LoadError> {
    let budget = Budget::new(options.max_bytes);
    budget.take(bytes.len() as u64, "the file")?;
    let format = Format::of(name, bytes)?;
    if let Some(asked) = options.scene.filter(|&scene| scene > 0 && format != Format::Gltf) {
        return Err(LoadError::NoSuchScene { asked, count: 1 });
    }
    let scene = match format {
        Format::Gltf => {
            let read = gltf_scene::read(bytes, resolver, options, &budget);
            read.map_err(|error| if format::is_gltf_1(bytes) { LoadError::OtherFormat("glTF 1.0") } else { error })?
        }
        Format::Obj => obj::read(bytes, &budget)?,
        Format::Ply => ply::read(bytes, &budget)?,
        Format::Stl => stl::read(bytes, &budget)?,
    };
    Ok(Scene { name: format::stem(name).to_owned(), ..scene })
}
