//! Twin of `launch.wgsl`: the parameters of a launch.

use bytemuck::{Pod, Zeroable};

/// Threads per workgroup, one per element.
pub const BLOCK: usize = 256;

/// Most elements of a set: blocks of blocks of a prefix sum are one, and no index of a thread is beyond 2³².
pub const MOST_ELEMENTS: u64 = 1 << 26;

/// The uniform `launch`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Launch {
    /// Number of elements in the set that the kernel is launched over.
    pub elements: u32,
    /// Parameter of the step: the digit that it sorts by.
    pub parameter: u32,
    /// Workgroups that the elements fill, the last one perhaps only partly.
    pub blocks: u32,
    /// The first of them that this dispatch runs.
    pub first_block: u32,
    /// Texels per row of the set's streams.
    pub width: u32,
}

impl Launch {
    /// The parameters of a launch over so many elements, in textures of this width.
    #[must_use]
    pub fn new(elements: u32, width: u32, parameter: u32) -> Self {
        Self { elements, parameter, blocks: elements.div_ceil(BLOCK as u32), first_block: 0, width }
    }
}
