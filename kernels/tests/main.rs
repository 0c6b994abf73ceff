//! Structures hold everything that a ray can hit, shaders bind what the tables say, and modules use only lower ones.

mod bvh;
mod floors;
mod grid;
mod shaders;
