//! Structures hold what a ray can meet, shaders bind what the tables say, and modules reach down only.

mod bvh;
mod floors;
mod grid;
mod shaders;
