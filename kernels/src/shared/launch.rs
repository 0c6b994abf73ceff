//! Twin of `launch.wgsl`: what a kernel is launched over.

use bytemuck::{Pod, Zeroable};

/// Threads of a workgroup, each for one element.
pub const BLOCK: usize = 256;

/// The uniform `launch`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Launch {
    /// Of the set that the kernel is launched over.
    pub elements: u32,
    /// The step's number: which digit is sorted by.
    pub parameter: u32,
    /// Workgroups that the elements fill, the last one perhaps in part.
    pub blocks: u32,
    _pad: u32,
}

impl Launch {
    /// A launch over a set.
    #[must_use]
    pub fn new(elements: u32, parameter: u32) -> Self {
        Self { elements, parameter, blocks: elements.div_ceil(BLOCK as u32), _pad: 0 }
    }
}
