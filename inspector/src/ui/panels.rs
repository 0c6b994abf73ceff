//! One file per panel.

mod chart;
pub(super) mod choices;
pub(super) mod compare;
pub(super) mod cost;
pub(super) mod dataflow;
pub(super) mod divergence;
pub(super) mod error;
pub(super) mod kernel;
mod legend;
pub(super) mod log;
pub(super) mod options;
pub(super) mod passes;
pub(super) mod plan;
pub(super) mod ray;
mod scroll;
pub(super) mod stream;
pub(super) mod structure;
pub(super) mod timeline;
pub(super) mod timings;
pub(super) mod walk2d;
pub(super) mod walk3d;
mod walked;
pub(super) mod watches;
mod zoom;
