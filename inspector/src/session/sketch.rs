//! Small copies of the rays' states, for thumbnails of passes that were never shown.

use std::sync::Arc;

use raystep_kernels::Stream;
use raystep_kernels::executor::gpu::StreamTexture;

/// Most texels along a side of a sketch from the CPU: those of a thumbnail.
pub(crate) const SIDE: u32 = 128;

/// The tags of all states after some pass: the first layer of a texture.
#[derive(Clone)]
pub struct Sketch {
    /// The stream of states.
    pub stream: Stream,
    /// Number of passes before it.
    pub place: usize,
    /// The tags; from the CPU, only as many as a thumbnail shows.
    pub texture: StreamTexture,
    /// While it exists, the sketch waits.
    pub(super) _waiting: Arc<()>,
}
