//! What a program is made of, one table a kind of thing, and how its values lie in memory.

pub mod sizes;
pub mod texels;
