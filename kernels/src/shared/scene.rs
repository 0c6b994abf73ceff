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
    /// Number of rays.
    pub rays: u32,
    /// First row of workgroups of a dispatch; the executor writes it.
    pub first_row: u32,
    /// Width and height of the streams; the executor writes those of its own.
    pub size: [u32; 2],
    /// WebGL wants the size of a uniform to be a multiple of 16 bytes.
    pub padding: [u32; 2],
}
