//! Runs that are kept side by side: their results, how they differ, and how long each of them takes.
//!
//! A kept run is plain data: its recipe, from which it can be run again, and its results. Jobs of an engine compare
//! results and measure runs.

pub mod differ;
mod hash;
pub mod kept;
pub mod measure;
pub mod outcome;
pub mod recipe;
pub mod spread;

pub use self::kept::{Kept, Runs};
pub use self::recipe::{Recipe, RunId};
pub use hash::scene_hash;
pub use outcome::{Outcome, Picture};
