//! Files in, scenes out: what is loaded, what is refused and how, what is generated and converted.

mod convert;
mod files;
mod generate;
mod glb;
mod load_bad;
mod load_common;
mod load_corrupt;
mod load_data;
mod load_features;
