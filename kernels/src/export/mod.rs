//! A run's results as files: used by the window and the command line alike, so they live below both.
//!
//! Everything here writes to an [`std::io::Write`] or returns values; paths, clocks and threads are up to the caller.
//!
//! | module | format | holds |
//! |---|---|---|
//! | [`npy`] | NumPy `.npy` | one stream, bit for bit, (layer, row, column) |
//! | [`exr`] | OpenEXR | the image with each ray's hit; or one stream, one channel per layer |
//! | [`csv`] | `passes.csv` | one row per pass |
//! | [`json`] | JSON | the run's summary |
//! | [`light_tree`] | table, JSON | where a pixel's light comes from, ray by ray |
//! | [`plan`] | JSON | what a run needs and what it leaves out |
//! | [`program`] | TOML, WGSL | a run's program as a folder of one's own |
//! | [`structure`] | text, JSON | the grid or BVH of a run |
//! | [`trace`] | table, CSV, JSON | the history of one ray, pass by pass |
//! | [`trace_events`] | JSON | a run as Chrome trace events, for Perfetto |
//!
//! CSV and JSON need the feature `serde`.

#[cfg(feature = "serde")]
pub mod csv;
pub mod exr;
#[cfg(feature = "serde")]
pub mod json;
pub mod light_tree;
pub mod npy;
#[cfg(feature = "serde")]
pub mod plan;
pub mod program;
#[cfg(feature = "serde")]
mod recorded;
pub mod trace;
#[cfg(feature = "serde")]
pub mod trace_events;

pub use crate::plan::structure;
#[cfg(feature = "serde")]
pub use recorded::Recorded;
