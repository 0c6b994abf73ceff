//! Runs that are kept side by side: what they came to, how they differ, and how long each of them takes.
//!
//! A kept run is plain data: its recipe, from which it can be run again, and what it came to. Results are compared and
//! runs are measured by jobs of an engine.

pub mod differ;
mod hash;
pub mod kept;
pub mod measure;
pub mod outcome;
pub mod spread;

pub use hash::scene_hash;
pub use kept::{Kept, Recipe, RunId, Runs};
pub use outcome::{Outcome, Picture};
