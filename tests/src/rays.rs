//! Rays to test with; see [`raystep_lab::rays`].

pub use raystep_lab::rays::{SplitMix64 as Random, at_edges, mixed as random, segments};
