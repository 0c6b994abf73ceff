//! Rows of a program's table of buffers: scene data, and uniforms.

use super::SceneData;
use crate::options::keep::Item;
use crate::options::reasons::{Reason, Run};

/// A row of the table.
#[derive(Clone, Copy, Debug)]
pub struct BufferInfo {
    /// Its name in WGSL, files and reports.
    pub name: &'static str,
    /// Whether it is a uniform, else read-only storage.
    pub is_uniform: bool,
    /// Description of an element, with its unit.
    pub element: &'static str,
    /// Its bytes; empty if a run does without it.
    pub bytes: fn(&SceneData) -> &[u8],
    /// Why a run does without it.
    pub why_absent: fn(&Run<'_>) -> Reason,
    /// The item that it belongs to, if only some scenes need it.
    pub item: Option<Item>,
    /// Which of its elements belong together, as the last axes of an array: 3 coordinates of 3 corners of a triangle.
    pub rows: &'static [u32],
    /// Whether it depends on the camera or the number of rays, so that a new view of the scene writes it again.
    pub is_of_view: bool,
}

/// The row of a uniform.
pub const fn uniform(
    name: &'static str,
    element: &'static str,
    bytes: fn(&SceneData) -> &[u8],
    why_absent: fn(&Run<'_>) -> Reason,
) -> BufferInfo {
    BufferInfo { name, is_uniform: true, element, bytes, why_absent, item: None, rows: &[], is_of_view: false }
}

/// The row of a storage buffer.
pub const fn storage(
    name: &'static str,
    element: &'static str,
    bytes: fn(&SceneData) -> &[u8],
    why_absent: fn(&Run<'_>) -> Reason,
) -> BufferInfo {
    BufferInfo { name, is_uniform: false, element, bytes, why_absent, item: None, rows: &[], is_of_view: false }
}

impl BufferInfo {
    /// The row of a buffer that depends on the camera or the number of rays.
    pub const fn of_view(mut self) -> Self {
        self.is_of_view = true;
        self
    }

    /// The row of a buffer of which elements belong together.
    pub const fn in_rows(mut self, rows: &'static [u32]) -> Self {
        self.rows = rows;
        self
    }

    /// The row of a buffer that belongs to an item.
    pub const fn of(mut self, item: Item) -> Self {
        self.item = Some(item);
        self
    }

    /// Its bytes in a run; an empty storage buffer gets 80 zero bytes, the size of the largest entry, since empty
    /// buffers cannot be bound.
    #[must_use]
    pub fn contents(self, data: &SceneData) -> &[u8] {
        const EMPTY: &[u8] = &[0; 80];
        let bytes = (self.bytes)(data);
        if bytes.is_empty() { EMPTY } else { bytes }
    }
}
