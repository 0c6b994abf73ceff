//! The uniform of `scene.wgsl`.

use bytemuck::{Pod, Zeroable};

/// The uniform `scene`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct SceneInfo {
    /// Number of triangles.
    pub triangles: u32,
    /// Most steps of a ray in one pass.
    pub steps: u32,
    /// Rays.
    pub rays: u32,
    /// Where a dispatch begins, in rows of workgroups.
    pub first_row: u32,
}
