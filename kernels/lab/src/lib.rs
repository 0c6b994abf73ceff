//! What is measured and judged of kernels: truth in f64 and what f32 may get wrong of it, agreement of executors pass
//! by pass, kinds of rays, extreme cases, statistics, benchmarks and reports. Written once; the command line, the
//! inspector, the docs' measurements and the tests use the same functions.
//!
//! | module | holds |
//! |---|---|
//! | [`mod@reference`] | f64 brute force with exact predicates, and the bound on what f32 may get wrong |
//! | [`judge`] | what became of a run's rays against that, all of them, a sample, or over the passes |
//! | [`rounding`], [`parity`], [`divergence`] | what rounding may change in one pass; device and CPU reference kernels, pass by pass |
//! | [`compare`], [`layer_stats`] | two runs' values of a stream; one stream's values |
//! | [`rays`], [`ways`], [`watertight`] | which rays to trace, how to trace them, and a closed mesh that none may leave |
//! | [`machine`], [`meter`], [`statistics`] | a device with its clocks, runs timed in turn, medians and intervals |
//! | [`work`], [`structure_stats`] | what rays cost and launched threads do; lists of a grid, nodes of a BVH |
//! | [`mod@bench`], [`report`], [`stability`] | the three measurements of the command line |
//! | [`subject`], [`reporter`] | what these are given: a scene with a view, and somebody to tell how far they are |
//! | [`plots`], [`html`], [`text`], [`hash`] | what their files are made of |

pub mod bench;
pub mod compare;
pub mod divergence;
mod error;
pub mod hash;
pub mod html;
pub mod judge;
pub mod layer_stats;
pub mod lockstep;
pub mod machine;
pub mod meter;
pub mod parity;
pub mod plots;
pub mod rays;
pub mod reference;
pub mod report;
pub mod reporter;
pub mod rounding;
pub mod stability;
pub mod statistics;
pub mod structure_stats;
pub mod subject;
pub mod text;
mod wait;
pub mod watertight;
pub mod ways;
pub mod work;

pub use error::Error;
pub use hash::Hash;
pub use machine::Machine;
pub use rays::RayKind;
pub use subject::{Size, Subject};
pub use wait::{block_on, block_on_shared};
