//! Measures and checks kernels: correct hits in f64 and the limits of f32, agreement of executors pass by pass, kinds
//! of rays, extreme cases, statistics, benchmarks and reports. The command line, the inspector, the pages on performance
//! and the tests share these functions.
//!
//! | module | contents |
//! |---|---|
//! | [`mod@reference`] | exact hits in f64, without testing every triangle, and the error bound of f32 |
//! | [`judge`] | a run's hits compared with that: all rays, a sample, or after each pass |
//! | [`rounding`] | what rounding may change in one pass |
//! | [`parity`], [`divergence`], [`lockstep`] | device against CPU reference kernels, pass by pass |
//! | [`compare`], [`layer_stats`], [`flip`] | a stream of two runs compared; statistics of one stream; how different two pictures look |
//! | [`rays`], [`outside`] | rays, and which of them the paper's numerics lose |
//! | [`configuration`], [`watertight`] | options that are compared, and a closed mesh that no ray may leave |
//! | [`machine`], [`meter`], [`statistics`] | a device with its clocks, interleaved timing, medians and intervals |
//! | [`compared`], [`built`] | how much a comparison covered, by kernel; a grid that a device has built |
//! | [`mod@check_kernel`], [`branch`] | a user's kernel beside the one that it replaces; how a condition came out, in words |
//! | [`mod@check_program`] | a user's program on a device beside the interpreter |
//! | [`mod@element_history`] | what each pass of a user's program has done to one element, and why |
//! | [`zipped`] | a user's program in a zip file |
//! | [`passed`], [`stops`], [`line_cost`] | a pass in the interpreter; which elements come to a line; what each line takes |
//! | [`course`] | exercises: kernels with a hole, and the check of what a student has written |
//! | [`self_test`] | whether raystep works on a GPU: all of this in a minute |
//! | [`strategies`] | one pixel's light by each strategy of a path tracer |
//! | [`bounces`], [`non_finite`] | paths of light over the whole image, bounce by bounce; the first value that is not finite, and its cause |
//! | [`work`], [`structure_stats`] | the cost of rays and use of launched threads; lists of a grid, nodes of a BVH |
//! | [`intensity`] | operations and bytes of each kernel, and their ratio |
//! | [`mod@bench`], [`report`], [`stability`] | the measuring commands of the command line |
//! | [`paper`] | the tables of Mølhave's paper beside ours |
//! | [`stiff`] | what scenes cost that get harder in one way |
//! | [`subject`], [`reporter`] | their inputs: a scene with a view, and a receiver of progress |
//! | [`tidy`] | their CSV files: one name for one thing, and a schema |
//! | [`plots`], [`png`], [`html`], [`human`], [`text`], [`hash`] | the parts of their pages |

#[macro_use]
pub mod tidy;

pub mod bench;
pub mod bounces;
pub mod branch;
pub mod built;
pub mod check_kernel;
pub mod check_program;
pub mod compare;
pub mod compared;
pub mod configuration;
pub mod course;
pub mod divergence;
pub mod element_history;
mod error;
pub mod flip;
pub mod hash;
pub mod html;
pub mod human;
pub mod intensity;
pub mod judge;
pub mod layer_stats;
pub mod line_cost;
pub mod lockstep;
pub mod machine;
pub mod meter;
pub mod non_finite;
pub mod outside;
pub mod paper;
pub mod parity;
pub mod passed;
pub mod plots;
pub mod png;
mod portions;
pub mod rays;
pub mod reference;
pub mod report;
pub mod reporter;
pub mod rough;
pub mod rounding;
pub mod self_test;
pub mod stability;
pub mod statistics;
pub mod stiff;
pub mod stops;
pub mod strategies;
pub mod structure_stats;
mod structures;
pub mod subject;
pub mod text;
mod wait;
pub mod watertight;
pub mod work;
pub mod zipped;

pub use error::Error;
pub use hash::Hash;
pub use machine::Machine;
pub use rays::RayKind;
pub use subject::{Size, Subject};
pub use wait::{block_on, block_on_shared};
