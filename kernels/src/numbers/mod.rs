//! Numbers, units and the few helpers that everything else is written with.

pub mod named;
