//! Structures hold everything that a ray can hit, and shaders bind what the tables say.

mod bvh;
mod grid;
mod mutated;
mod shaders;
