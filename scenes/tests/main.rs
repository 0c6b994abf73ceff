//! Scenes: loading, errors, and generation.

mod files;
mod formats;
mod generate;
mod glb;
mod load_bad;
mod load_common;
mod load_compressed;
mod load_corrupt;
mod load_data;
mod load_features;
mod load_lost;
mod mesh_common;
mod obj;
mod ply;
mod polygons;
mod stl;
