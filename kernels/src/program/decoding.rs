//! How a program's rays are read from its streams.

use super::light_tree::Grow;
use super::paths::Paths;
use super::{Program, RayState};
use crate::scene_data::SceneData;
use crate::tables::elements::Elements;
use crate::tables::stream::Stream;

/// A ray's texel in a stream, one word per layer; `None` for a stream that the run leaves out.
pub type Texel<'t> = &'t dyn Fn(Stream) -> Option<&'t [u32]>;

/// How a program's rays are decoded.
#[derive(Clone, Copy, Debug)]
pub struct Decoding {
    /// The streams that it reads, as far as a run has them.
    pub streams: &'static [Stream],
    /// Decodes a ray's texels.
    pub decode: fn(Texel<'_>) -> RayState,
    /// The triangle that a pass of a kernel that tests one tested, from the ray before and after it.
    pub tested: fn(&SceneData, &RayState, &RayState) -> Option<u32>,
    /// How a pass adds to a pixel's light tree; `None` if no ray leaves a hit.
    pub tree: Option<Grow>,
    /// What its passes do to paths of light; `None` if it follows none.
    pub paths: Option<Paths>,
    /// How the elements of other sets are decoded that walk through the scene as rays do.
    pub others: &'static [Decoding],
}

impl Decoding {
    /// The set whose elements it decodes.
    #[must_use]
    pub fn elements(&self) -> Option<&'static Elements> {
        self.streams.first().map(|stream| stream.info().elements)
    }
}

impl Program {
    /// How a set's elements are decoded; `None` if they do not walk through the scene.
    #[must_use]
    pub fn decoding_of(&self, set: &Elements) -> Option<Decoding> {
        let rays = self.rays?;
        let all = std::iter::once(&rays).chain(rays.others);
        all.copied().find(|of| of.elements().is_some_and(|elements| elements.name == set.name))
    }
}
