//! Rules that two kernels must agree on: one WGSL function each, with one twin beside it.

pub mod bvh_walk;
pub mod camera;
pub mod constants;
pub mod grid_walk;
pub mod samples;
pub mod scene;
pub mod shading;
pub mod texture;
pub mod triangle;
pub mod vector;
pub mod wide_node;
pub mod wide_walk;

/// WESL modules that kernels import from, by name: `package::NAME`.
#[must_use]
pub(crate) fn modules(stack: u32, turns: u32) -> [(&'static str, String); 17] {
    [
        ("constants", constants::wgsl_module(stack, turns)),
        ("state", crate::state::wgsl_module()),
        ("vector", include_str!("vector.wgsl").into()),
        ("ray", include_str!("ray.wgsl").into()),
        ("camera", include_str!("camera.wgsl").into()),
        ("samples", include_str!("samples.wgsl").into()),
        ("scene", include_str!("scene.wgsl").into()),
        ("live", include_str!("live.wgsl").into()),
        ("grid_lists", include_str!("grid_lists.wgsl").into()),
        ("bvh_walk", include_str!("bvh_walk.wgsl").into()),
        ("wide_walk", include_str!("wide_walk.wgsl").into()),
        ("tracing", include_str!("tracing.wgsl").into()),
        ("packed_triangles", include_str!("packed_triangles.wgsl").into()),
        ("corners", include_str!("corners.wgsl").into()),
        ("grid_walk", include_str!("grid_walk.wgsl").into()),
        ("triangle", include_str!("triangle.wgsl").into()),
        ("texture", include_str!("texture.wgsl").into()),
    ]
}
