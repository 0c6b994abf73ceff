//! What an executor can hold.

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
pub(crate) const TURNS_WITHOUT_LIMIT: u32 = 1 << 22;

impl Limits {
    /// The CPU twins': memory is the only limit, images are kept to 2²⁶ pixels, some 6 GB of streams.
    pub const CPU: Self = Self { image_side: 32_768, storage_bytes: 1 << 32, rays: 1 << 26, turns: u32::MAX };
}
