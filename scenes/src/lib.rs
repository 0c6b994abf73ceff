//! Loads and generates a [`Scene`]: triangles, materials, lights and cameras, ready to be traced.
//!
//! * [`load`] reads glTF 2.0 (`.gltf` JSON and `.glb`), Wavefront OBJ, Stanford PLY and STL from bytes, with a
//!   [`Resolver`] for external files. It never accesses the file system and never panics on bad input.
//! * [`generate`] generates scenes from a few numbers.
//! * [`write_glb`] turns any [`Scene`] into a GLB that `load` reads back.

pub mod generate;
mod glb;
mod load;
pub mod scene;

pub use glb::{WriteError, write_glb};
pub use load::{ENDINGS, FileError, LoadError, LoadOptions, NoFiles, Resolver, external_files, load};
pub use scene::{Bounds, Camera, Light, Material, Note, Optics, Projection, Scene, Texture, Wrap, offset_for};
