//! Configurations in which a scene can be traced; see [`raystep_lab::configuration`].

use raystep_kernels::Options;
pub use raystep_lab::configuration::{COVERING, Configuration, EVERY, FAST, STEPPED};
use raystep_scenes::Scene;

use crate::options;

/// Options for an image with the paper's schedule.
#[must_use]
pub fn stepped(scene: &Scene, width: u32, height: u32) -> Options {
    STEPPED.of(&options(scene, width, height))
}
