//! Rules that two kernels must agree on: one WGSL function each, with one twin beside it.

pub mod constants;
pub mod grid_walk;
pub mod texture;
pub mod triangle;
pub mod vector;

/// WESL modules that kernels import from, by name: `package::NAME`.
#[must_use]
pub(crate) fn modules() -> [(&'static str, String); 8] {
    [
        ("constants", constants::wgsl_module()),
        ("state", crate::state::wgsl_module()),
        ("vector", include_str!("vector.wgsl").into()),
        ("ray", include_str!("ray.wgsl").into()),
        ("corners", include_str!("corners.wgsl").into()),
        ("grid_walk", include_str!("grid_walk.wgsl").into()),
        ("triangle", include_str!("triangle.wgsl").into()),
        ("texture", include_str!("texture.wgsl").into()),
    ]
}
