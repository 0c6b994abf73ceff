//! Limits of an executor.

use crate::options::scene_data::SceneDataKind;

/// How an adapter handles a loop with many iterations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loops {
    /// It ran all requested iterations, more than four times the number after which any adapter is known to end a loop.
    Unlimited,
    /// It ended the loop after this many iterations, without an error. Mesa's software Vulkan does so after 65,535,
    /// counted over all loops of a thread.
    EndAfter(u32),
}

impl Loops {
    /// Iterations after which a loop is ended; `None` if there is no limit.
    #[must_use]
    pub fn end(self) -> Option<u32> {
        match self {
            Self::Unlimited => None,
            Self::EndAfter(turns) => Some(turns),
        }
    }
}

/// Limits of an executor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Largest image side in pixels, and largest side of the texture of a list.
    pub image_side: u32,
    /// Most bytes of one storage buffer.
    pub storage_bytes: u64,
    /// Most storage buffers that a shader binds; 0 without compute shaders.
    pub storage_buffers: u32,
    /// Most textures that a shader binds to write them.
    pub storage_textures: u32,
    /// Most textures that a shader binds only to read them.
    pub sampled_textures: u32,
    /// Most rays.
    pub rays: u64,
    /// Most bytes per texel of all the streams that a fragment program writes; 0 if nothing is drawn.
    pub color_bytes: u32,
    /// Most loop iterations of one thread in one dispatch, all of its loops together; the rest continues in the next
    /// dispatch.
    pub turns: u32,
    /// Whether it is a GPU in hardware, for which [`Accelerator::Auto`](crate::Accelerator::Auto) also considers a grid.
    pub is_gpu: bool,
}

/// Loop iterations of a thread in one dispatch if the adapter sets no limit: a million triangle tests, about 200 ms, so
/// that no system resets the GPU.
pub(crate) const TURNS_WITHOUT_LIMIT: u32 = 1 << 22;

/// The same where the adapter allows any number: far more than a walk through any scene of the repository takes, and well
/// below a second on a large GPU if all threads take them at once.
const MOST_TURNS_OF_USERS: u32 = 1 << 20;

impl Limits {
    /// The limits of the twins: memory is the only one, but images are kept to 2²⁶ pixels, about 6 GB of streams.
    pub const CPU: Self = Self {
        image_side: 32_768,
        storage_bytes: 1 << 32,
        storage_buffers: u32::MAX,
        storage_textures: u32::MAX,
        sampled_textures: u32::MAX,
        rays: 1 << 26,
        color_bytes: 0,
        turns: u32::MAX,
        is_gpu: false,
    };

    /// Most turns of all loops of one thread of a user's kernel in a dispatch. Our own kernels stay below half of it where
    /// the adapter sets a limit.
    #[must_use]
    pub fn turns_of_users(&self) -> u32 {
        self.turns.saturating_mul(2).min(MOST_TURNS_OF_USERS)
    }

    /// Whether it has compute shaders, or is the CPU.
    #[must_use]
    pub fn computes(&self) -> bool {
        self.storage_buffers > 0
    }

    /// Most 32-bit words of one list of scene data.
    #[must_use]
    pub fn list_words(&self, scene_data: SceneDataKind) -> u64 {
        match scene_data {
            SceneDataKind::Buffers => self.storage_bytes / 4,
            SceneDataKind::Textures => u64::from(self.image_side).pow(2),
        }
    }
}
