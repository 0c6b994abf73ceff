//! A run's summary, as values that serialise to JSON. Unknown values are `null`, never 0.

use std::collections::BTreeMap;

use serde::Serialize;

#[cfg(feature = "gpu")]
use crate::executor::gpu::{AdapterSummary, Gpu};
use crate::options::Choices;
use crate::options::rows;
pub use crate::plan::GridSummary;
#[cfg(feature = "gpu")]
use crate::plan::Loops;
use crate::plan::Structure;
use crate::program::Program;
use crate::renderer::RayHit;
pub use crate::renderer::{CounterSums, KernelSummary};
use crate::tables::elements::Size;
use crate::tables::state::StateCounts;
use crate::tables::stream::{Stream, Texel};

/// Version of these JSON objects.
pub const SCHEMA_VERSION: u32 = 3;

/// Summary of a run, for `--summary-json`.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// [`SCHEMA_VERSION`].
    pub schema_version: u32,
    /// raystep's version.
    pub raystep_version: &'static str,
    /// As in the run's `passes.csv`.
    pub run_id: String,
    /// The scene's name.
    pub scene: String,
    /// Notes from reading the scene.
    pub notes: Vec<String>,
    /// `gpu` or `cpu`.
    pub device: &'static str,
    /// Why this device.
    pub device_reason: String,
    /// The adapter; `null` on the CPU.
    pub adapter: Option<AdapterInfo>,
    /// The run's options.
    pub options: RunOptions,
    /// Number of triangles.
    pub triangles: u64,
    /// The acceleration structure.
    #[serde(flatten)]
    pub structure: Structure,
    /// Multiply lengths and t in streams by this for scene units.
    pub scene_units_per_stream_unit: f64,
    /// Then add this to points, for the coordinates of the scene's file.
    pub scene_offset: [f64; 3],
    /// As in `passes.csv`; `null` if passes were not timed.
    pub clock: Option<&'static str>,
    /// As in `passes.csv`; `null` if unknown.
    pub host_run_ns: Option<u64>,
    /// Number of passes.
    pub passes: usize,
    /// Passes of each kernel, and the rays they worked on.
    pub kernels: BTreeMap<&'static str, KernelSummary>,
    /// Number of rays, of all samples of all pixels.
    pub rays: u64,
    /// Number of these rays that hit a triangle.
    pub hits: u64,
    /// Number of these rays that were still active when the limit of passes was reached; 0 with robust numerics.
    pub unfinished: u64,
    /// What all of these rays have counted, the sums of `passes.csv`; `null` if counters were not requested.
    pub counters: Option<CounterSums>,
    /// Comparison of the last sample's rays with f64 brute force; `null` if not requested.
    pub check: Option<CheckSummary>,
    /// Wall-clock seconds per stage.
    pub seconds: BTreeMap<&'static str, f64>,
    /// Bytes of each stream.
    pub stream_bytes: BTreeMap<&'static str, u64>,
    /// Bytes of each buffer.
    pub buffer_bytes: BTreeMap<&'static str, u64>,
}

/// Names of an adapter.
#[derive(Clone, Debug, Serialize)]
pub struct AdapterInfo {
    /// Its name.
    pub name: String,
    /// Vulkan, Metal, …
    pub backend: String,
    /// Discrete, integrated, software, …
    pub kind: String,
    /// The driver's name and version.
    pub driver: String,
    /// Iterations after which it ends a loop, as found by a test; `null` if it ended none, or was not tested.
    pub loops_end_after: Option<u32>,
}

#[cfg(feature = "gpu")]
impl From<&Gpu> for AdapterInfo {
    fn from(gpu: &Gpu) -> Self {
        Self::new(&gpu.info, gpu.computes.then_some(gpu.loops))
    }
}

#[cfg(feature = "gpu")]
impl From<&AdapterSummary> for AdapterInfo {
    fn from(summary: &AdapterSummary) -> Self {
        Self::new(&summary.info, summary.loops)
    }
}

#[cfg(feature = "gpu")]
impl AdapterInfo {
    fn new(info: &wgpu::AdapterInfo, loops: Option<Loops>) -> Self {
        let kind = match info.device_type {
            wgpu::DeviceType::DiscreteGpu => "discrete GPU",
            wgpu::DeviceType::IntegratedGpu => "integrated GPU",
            wgpu::DeviceType::VirtualGpu => "virtual GPU",
            wgpu::DeviceType::Cpu => "software",
            wgpu::DeviceType::Other => "unknown kind",
        };
        Self {
            name: info.name.clone(),
            backend: info.backend.to_string(),
            kind: kind.into(),
            driver: format!("{} {}", info.driver, info.driver_info).trim().into(),
            loops_end_after: loops.and_then(Loops::end),
        }
    }
}

/// Options of the run.
#[derive(Clone, Debug, Serialize)]
pub struct RunOptions {
    /// Path of the scene file as the user wrote it.
    pub scene_path: String,
    /// What was chosen: the accelerator is possibly `auto`, and `null` is what has no meaning with the others.
    #[serde(flatten, serialize_with = "rows::serialize")]
    pub choices: Choices,
    /// Texels per row.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
    /// `--counters`
    pub counters: bool,
}

/// Number of rays that hit something.
#[must_use]
pub fn hit_count(hits: &[Option<RayHit>]) -> u64 {
    hits.iter().flatten().count() as u64
}

/// Result of a comparison with f64 brute force, in rays.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CheckSummary {
    /// Rays compared.
    pub rays: u64,
    /// Rays with the exact result.
    pub same: u64,
    /// Rays with another result that f32 cannot exclude.
    pub ties: u64,
    /// Rays that hit nothing where something is.
    pub missed: u64,
    /// Rays that hit something where nothing is.
    pub false_hits: u64,
    /// Rays that hit another triangle, or at a wrong t.
    pub wrong: u64,
    /// Largest error of t among correct hits, in units in the last place.
    pub largest_t_ulp: f64,
}

/// Number of rays in each state, by the state's name.
#[must_use]
pub fn states(program: &Program, counts: &StateCounts) -> BTreeMap<&'static str, u32> {
    program.states.iter().zip(counts).map(|(state, &n)| (state.name, n)).collect()
}

/// Describes a stream, for readers of a dump.
#[derive(Clone, Debug, Serialize)]
pub struct StreamSummary {
    /// Its name.
    pub name: &'static str,
    /// `float32` or `uint32`, NumPy's names.
    pub dtype: &'static str,
    /// One entry per layer.
    pub layers: Vec<LayerSummary>,
    /// Unit of its values.
    pub unit: &'static str,
    /// The set of its elements, such as `rays` or `photons`.
    pub elements: &'static str,
    /// How many elements that has: texels after them, in the last row, are of none. `null` until a pass has found it.
    pub count: Option<u32>,
    /// Size for the whole image.
    pub bytes: u64,
}

/// A layer of a stream.
#[derive(Clone, Debug, Serialize)]
pub struct LayerSummary {
    /// Its name.
    pub name: &'static str,
    /// Whether its bits are a float, whatever the texel's type.
    pub is_float: bool,
    /// The bits before any kernel writes it.
    pub unwritten_bits: u32,
}

/// Summary of a stream whose elements are so many, if that is known.
#[must_use]
pub fn stream(stream: Stream, size: Option<Size>) -> StreamSummary {
    let info = stream.info();
    let layer = |(i, name): (usize, &&'static str)| LayerSummary {
        name,
        is_float: stream.is_float_layer(i),
        unwritten_bits: info.unwritten[i],
    };
    StreamSummary {
        name: info.name,
        dtype: match info.texel {
            Texel::F32 => "float32",
            Texel::U32 => "uint32",
        },
        layers: info.layers.iter().enumerate().map(layer).collect(),
        unit: info.unit,
        elements: info.elements.name,
        count: size.map(|size| size.count),
        bytes: stream.bytes(size.map_or(0, |size| size.texels())).unwrap_or(u64::MAX),
    }
}
