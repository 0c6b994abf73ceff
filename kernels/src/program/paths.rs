//! What a pass did to a path of light: what statistics by bounce are made of.

use super::schedule::Schedule;
use super::{Kernel, Program, RayState};
use crate::numbers::named::named;
use crate::scene_data::SceneData;
use crate::tables::state::Tag;
use crate::tables::stream::Stream;

/// How light was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Technique {
    /// The path hit a surface that emits.
    EmitterHit,
    /// A shadow ray reached an emitter that was picked.
    LightSample,
    /// The path left the scene.
    Background,
}

named!(Technique, EmitterHit "emitter hit", LightSample "light sample", Background "background");

/// Why a path ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Ending {
    /// Nothing was hit.
    Escape,
    /// It has as many bounces as it may have.
    Depth,
    /// The surface reflects nothing.
    Absorption,
    /// The direction leads below the triangle, whose interpolated normal is another one.
    Surface,
    /// Russian roulette.
    Roulette,
}

named!(Ending, Escape "escaped", Depth "depth", Absorption "absorbed", Surface "below surface", Roulette "roulette");

impl Ending {
    /// One sentence about it.
    #[must_use]
    pub fn summary(self) -> &'static str {
        match self {
            Self::Escape => "paths that left the scene",
            Self::Depth => "paths that had as many bounces as they may have",
            Self::Absorption => "paths that a black surface absorbed",
            Self::Surface => {
                "paths whose sampled direction leads below the triangle, whose interpolated normal is another one"
            }
            Self::Roulette => "paths that Russian roulette ended",
        }
    }
}

/// The densities of a sample of light.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Density {
    /// The pdf of its direction by the technique that found it, per steradian; `None` if no other direction was possible.
    pub pdf: Option<f64>,
    /// Its weight among all techniques that could have found it.
    pub weight: f64,
}

/// Light that was added to a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Added {
    /// How it was found.
    pub technique: Technique,
    /// Linear light, of one sample.
    pub light: [f64; 3],
    /// Its densities; those of a light sample were told when its shadow ray was cast.
    pub density: Option<Density>,
}

/// What became of a shadow ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shadow {
    /// It is cast, with these densities of its emitter's sample.
    Cast(Option<Density>),
    /// Nothing was in its way.
    Reached,
    /// Something was.
    Occluded,
}

/// What a pass did to a path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathStep {
    /// Bounces before: surfaces that have sent the path on.
    pub depth: u32,
    /// The ray of this bounce has ended: the share of its light that reaches the pixel.
    pub arrived: Option<[f32; 3]>,
    /// What it added to the pixel.
    pub added: Option<Added>,
    /// What became of the shadow ray of this bounce.
    pub shadow: Option<Shadow>,
    /// Why the path ended.
    pub ended: Option<Ending>,
    /// The path has gone on: to one bounce more.
    pub goes_on: bool,
}

/// How a program's paths are followed.
#[derive(Clone, Copy, Debug)]
pub struct Paths {
    /// The streams that this reads, as far as a run has them.
    pub streams: &'static [Stream],
    /// The states in which a path waits for a pass that concerns it.
    pub takes: &'static [Tag],
    /// What such a pass did, from the ray before and after it.
    pub step: fn(&SceneData, &RayState, &RayState) -> PathStep,
}

impl Paths {
    /// Whether a kernel's passes concern paths.
    #[must_use]
    pub fn concern(&self, kernel: Kernel) -> bool {
        kernel.takes().iter().any(|tag| self.takes.contains(tag))
    }

    /// How the paths of a run can be followed. `None` if it has none, or if one kernel traces a path to its end.
    #[must_use]
    pub fn of(program: &Program, schedule: &Schedule) -> Option<Self> {
        let paths = program.rays?.paths?;
        schedule.kernels().into_iter().any(|kernel| paths.concern(kernel)).then_some(paths)
    }
}
