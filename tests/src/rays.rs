//! Rays for tests; see [`raystep_lab::rays`].

pub use raystep_lab::rays::{Random, at_edges, mixed as random, segments};
