//! Limits of an executor.

use crate::shared::constants::{LIST_GROUPS, LIST_SIDE, WORKGROUP};

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
    /// Largest image side in pixels.
    pub image_side: u32,
    /// Most bytes of one storage buffer.
    pub storage_bytes: u64,
    /// Most rays.
    pub rays: u64,
    /// Most loop iterations of one thread in one dispatch, all of its loops together; the rest continues in the next
    /// dispatch.
    pub turns: u32,
}

/// Loop iterations of a thread in one dispatch if the adapter sets no limit: a million triangle tests, about 200 ms, so
/// that no system resets the GPU.
pub(super) const TURNS_WITHOUT_LIMIT: u32 = 1 << 22;

/// A thread uses the adapter's limit divided by this. The adapter may count the iterations of up to 16 threads that run
/// in one vector together, and the loops that contain the counted ones take some too.
const SHARE_OF_LIMIT: u32 = 32;

impl Limits {
    /// The limits of the twins: memory is the only one, but images are kept to 2²⁶ pixels, about 6 GB of streams.
    pub const CPU: Self = Self { image_side: 32_768, storage_bytes: 1 << 32, rays: 1 << 26, turns: u32::MAX };
}

impl Limits {
    /// The limits of an adapter with these limits and this handling of loops.
    #[must_use]
    pub fn of_adapter(limits: &wgpu::Limits, loops: Loops) -> Self {
        let groups = limits.max_compute_workgroups_per_dimension;
        let side = limits.max_texture_dimension_2d.min(groups.saturating_mul(WORKGROUP));
        Self {
            image_side: side,
            turns: match loops {
                Loops::Unlimited => TURNS_WITHOUT_LIMIT,
                Loops::EndAfter(turns) => (turns / SHARE_OF_LIMIT).max(1),
            },
            storage_bytes: limits.max_storage_buffer_binding_size.min(limits.max_buffer_size),
            // Rows of workgroups in an indirect dispatch, times the rays of a row.
            rays: u64::from(groups.min(65_535)) * u64::from(LIST_GROUPS * LIST_SIDE * LIST_SIDE),
        }
    }
}
