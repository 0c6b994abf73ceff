//! Structures hold what a ray can meet, and shaders bind what the tables say.

mod bvh;
mod grid;
mod shaders;
