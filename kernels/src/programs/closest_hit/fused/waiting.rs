//! Twin of `waiting.wgsl`: a ray between two dispatches of a kernel that takes whole walks.

/// Where a ray waits; all zeros if it does not.
#[derive(Default)]
pub(super) struct Wait {
    /// Whether it waited before this dispatch.
    pub(super) before: bool,
    /// Whether it waits after it.
    pub(super) after: bool,
    /// As in the stream `state`: the cell and the item in its list, or the node and its level, or the triangle.
    pub(super) cell: u32,
    pub(super) item: u32,
}

impl Wait {
    pub(super) fn at(&mut self, cell: u32, item: u32) {
        (self.after, self.cell, self.item) = (true, cell, item);
    }
}
