//! The parts of a program, one kind of table each, and how its values are laid out in memory.

pub mod elements;
pub mod kernel;
pub mod sizes;
pub mod state;
pub mod stream;
pub mod texels;
