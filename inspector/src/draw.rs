//! GPU rendering, independent of the user interface.

pub mod picture;
pub mod scene3d;
pub mod stream;

#[cfg(test)]
mod uniforms;
