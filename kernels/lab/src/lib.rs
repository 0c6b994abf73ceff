//! What is measured and judged of kernels: truth in f64 and what f32 may get wrong of it, agreement of executors pass
//! by pass, kinds of rays, extreme cases, statistics, benchmarks and reports. Written once; the command line, the
//! inspector, the docs' measurements and the tests use the same functions.

pub mod bench;
pub mod compare;
pub mod divergence;
mod error;
pub mod hash;
pub mod html;
pub mod judge;
pub mod layer_stats;
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
