//! How a program's rays are read from its streams.

use super::RayState;
use super::light_tree::Grow;
use super::paths::Paths;
use crate::scene_data::SceneData;
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
}
