//! What keeps a ray from testing every triangle: a uniform grid, or a bounding volume hierarchy.

pub mod bvh;
pub mod grid;
