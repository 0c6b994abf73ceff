//! What an executor can hold.

use crate::shared::constants::{LIST_GROUPS, LIST_SIDE, WORKGROUP};

/// What an adapter makes of a loop that takes many turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loops {
    /// It took as many turns as it was told to, more than four times what any adapter is known to end a loop after.
    Unlimited,
    /// It ended after so many turns, without an error. Mesa's software Vulkan does after 65,535, of all loops of a
    /// thread together.
    EndAfter(u32),
}

impl Loops {
    /// Turns after which a loop ends; `None` where it does when it is told to.
    #[must_use]
    pub fn end(self) -> Option<u32> {
        match self {
            Self::Unlimited => None,
            Self::EndAfter(turns) => Some(turns),
        }
    }
}

/// What an executor can hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Largest image side in pixels.
    pub image_side: u32,
    /// Most bytes of one storage buffer.
    pub storage_bytes: u64,
    /// Most rays.
    pub rays: u64,
    /// Most loop turns of one thread in one dispatch, all of its loops together; what takes more goes on in the next.
    pub turns: u32,
}

/// Loop turns of a thread in one dispatch where the adapter sets no limit: a million tests of triangles, some 200 ms, so
/// that no system takes the GPU away from it.
pub(super) const TURNS_WITHOUT_LIMIT: u32 = 1 << 22;

/// Of the turns after which an adapter ends loops, the part that a thread takes. It may count the turns of up to 16
/// threads that run in one vector together, and the loops around the budget take some, too.
const SHARE_OF_LIMIT: u32 = 32;

impl Limits {
    /// The CPU twins': memory is the only limit, images are kept to 2²⁶ pixels, some 6 GB of streams.
    pub const CPU: Self = Self { image_side: 32_768, storage_bytes: 1 << 32, rays: 1 << 26, turns: u32::MAX };
}

impl Limits {
    /// What an adapter with these limits and loops can hold.
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
            // Rows of workgroups of one indirect dispatch, and rays of a row.
            rays: u64::from(groups.min(65_535)) * u64::from(LIST_GROUPS * LIST_SIDE * LIST_SIDE),
        }
    }
}
