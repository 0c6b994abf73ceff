//! What a program is made of, one table a kind of thing, and how its values lie in memory.

pub mod elements;
pub mod kernel;
pub mod sizes;
pub mod state;
pub mod stream;
pub mod texels;
