//! Compressed geometry: Draco and meshoptimizer, by streams that their own encoders have written.

#![allow(clippy::unwrap_used, reason = "a test that cannot make its input has failed")]

mod draco;
mod meshopt;
