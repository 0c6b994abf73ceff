//! Where kernels read a scene's lists from.

use crate::numbers::named::named;

/// Where kernels read a scene's lists from: cells, nodes, triangles, materials and the like.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SceneDataKind {
    /// From storage buffers.
    #[default]
    Buffers,
    /// From square textures, as the paper's kernels do (its §4.1, Figure 5): a kernel then binds no storage buffer for them.
    Textures,
}

named!(SceneDataKind, "buffers, textures", Buffers "buffers", Textures "textures");

/// Why the CPU reads no textures.
pub const NO_GPU: &str =
    "--scene-data textures is for kernels that run on a GPU: use --device gpu, which may be a software driver";
