//! Twin of `launch.wgsl`: the parameters of a launch.

use bytemuck::{Pod, Zeroable};

use crate::tables::elements::Size;

/// Threads per workgroup, one per element.
pub const BLOCK: usize = 256;

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
    /// The parameters of a launch over a set of this size.
    #[must_use]
    pub fn new(size: Size, parameter: u32) -> Self {
        let (elements, width) = (size.count, size.width);
        Self { elements, parameter, blocks: elements.div_ceil(BLOCK as u32), first_block: 0, width }
    }

    /// Workgroups with one element per thread that a set of this size takes, whether their elements follow each other or
    /// are in two rows.
    #[must_use]
    pub fn workgroups(size: Size) -> u32 {
        let in_rows = size.height.div_ceil(2) * (size.width / (BLOCK as u32 / 2));
        size.count.div_ceil(BLOCK as u32).max(in_rows)
    }
}
