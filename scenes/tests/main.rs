//! Scenes: loading, errors, generation and conversion.

mod convert;
mod files;
mod generate;
mod glb;
mod load_bad;
mod load_common;
mod load_corrupt;
mod load_data;
mod load_features;
