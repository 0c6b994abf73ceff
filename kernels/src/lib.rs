//! Traces rays by small kernels over per-ray streams, on any wgpu adapter or on the CPU, and keeps every pass and every
//! value open to inspection.
//!
//! The tracer is the stream program of Mølhave's *Implementing a Ray Tracer on a GPU*: `generate` makes
//! eye rays, `setup` finds each ray's first cell in a uniform grid, `traverse_grid` moves it to the next cell,
//! `intersect` tests it against one triangle, and `shade` colours it. A ray's [`state`](tables::state) says which kernel
//! it waits for; kernels read and write [`stream`](tables::stream)s. Every kernel is a WGSL file with its CPU reference
//! kernel, its *twin*, in Rust beside it. One table lists all kernels, one all streams, and one all states.
//!
//! # A run, pass by pass
//!
//! ```
//! use raystep_kernels::programs::closest_hit;
//! use raystep_kernels::{Device, Options, RaySource, Renderer};
//! use raystep_scenes::{Camera, Scene};
//! # pollster::block_on(async {
//! let scene = Scene::from_triangles(vec![[[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]]]);
//! let camera = Camera::framing(&scene.bounds());
//! let options = Options::new(RaySource::Camera { camera, width: 32, height: 32 });
//!
//! // The twins; `Device::Gpu(Gpu::new(&AdapterChoice::Best).await?)` for a GPU.
//! let mut renderer = Renderer::new(&scene, &options, &Device::Cpu(None)).await?;
//! while let Some(pass) = renderer.step().await? {
//!     println!("{:>3} {:<14} {} rays", pass.index, pass.kernel.name(), pass.rays_in);
//! }
//! let hit = renderer.values(closest_hit::streams::HIT).await?;
//! assert_eq!(hit.get(2, 16 * 32 + 16), 0, "the centre pixel sees triangle 0");
//! let image = renderer.image().await?;
//! assert_eq!(image.pixels.len(), 32 * 32);
//! # Ok::<(), raystep_kernels::RenderError>(())
//! # }).unwrap();
//! ```
//!
//! # Features
//!
//! All are on by default, and every combination builds.
//!
//! | feature | adds | without it |
//! |---|---|---|
//! | `gpu` | [`Device::Gpu`], [`executor::gpu`] and wgpu | the twins trace rays; plans still compose and reflect the WGSL, which needs naga |
//! | `poll-thread` | a thread that polls the GPU, so that futures complete under any executor; turns on `gpu` | the host polls |
//! | `parallel` | twins and builds of grids and trees on all cores, by rayon | one thread |
//! | `serde` | `Serialize` for options, summaries and histories; [`export::csv`], [`export::json`], [`export::plan`], [`export::trace_events`] | exports are EXR, npy and text; serde remains a dependency of `raystep-scenes`, which reads glTF |

pub mod compose;
pub mod executor;
pub mod export;
pub mod fragment;
pub mod history;
pub mod interpret;
pub mod numbers;
pub mod options;
pub mod plan;
pub mod program;
pub mod programs;
pub mod renderer;
pub mod scene_data;
pub mod shader;
pub mod shared;
pub mod structures;
pub mod tables;

#[cfg(feature = "gpu")]
pub use executor::gpu::{AdapterChoice, AdapterSummary, ClockCheck, Gpu, GpuError, Held, HostPolls, Load, adapters};
pub use executor::{DrawTime, Drawing, Rounding};
pub use options::Choices;
pub use options::keep::{Item, Keep};
pub use options::samples::Samples;
pub use options::{
    Accelerator, BuiltBy, GridSize, Numerics, Options, Order, Ray, RaySource, Rule, ScheduleKind, Skip, Traversal,
};
pub use plan::{Limits, Loops, Plan, PlanError};
pub use program::{Kernel, Program};
pub use renderer::all_hits::{AllHits, AllHitsPlace};
pub use renderer::cast::{CastHit, Caster};
pub use renderer::image::Image;
pub use renderer::{Checkpoint, Device, Pass, PassTotals, Progress, RayHit, RenderError, Renderer, let_others_run};
pub use shared::samples::Sampler;
pub use tables::stream::{Region, Stream, StreamData};
