//! A run's summary, as values that serialise to JSON. Unknown is `null`, never 0.

use crate::programs::closest_hit::streams;
use std::collections::BTreeMap;

use serde::Serialize;

#[cfg(feature = "gpu")]
use crate::executor::gpu::{AdapterSummary, Gpu};
pub use crate::plan::GridSummary;
#[cfg(feature = "gpu")]
use crate::plan::Loops;
use crate::plan::{Plan, Structure};
use crate::program::Program;
pub use crate::renderer::KernelSummary;
use crate::renderer::RayHit;
use crate::tables::kernel::Role;
use crate::tables::state::StateCounts;
use crate::tables::stream::{Stream, Texel};

/// Version of the JSON objects here.
pub const SCHEMA_VERSION: u32 = 1;

/// What a run did, for `--summary-json`.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// [`SCHEMA_VERSION`].
    pub schema_version: u32,
    /// raystep's version.
    pub raystep_version: &'static str,
    /// The same as in the run's `passes.csv`.
    pub run_id: String,
    /// The scene's name.
    pub scene: String,
    /// What reading the scene had to say.
    pub notes: Vec<String>,
    /// `gpu` or `cpu`.
    pub device: &'static str,
    /// Why that one.
    pub device_reason: String,
    /// The adapter; `null` on the CPU.
    pub adapter: Option<AdapterInfo>,
    /// The run's options.
    pub options: RunOptions,
    /// Triangles.
    pub triangles: u64,
    /// What keeps rays from testing every triangle.
    #[serde(flatten)]
    pub structure: Structure,
    /// Multiply lengths and t of the streams by this for scene units.
    pub scene_units_per_stream_unit: f64,
    /// As in `passes.csv`; `null` where passes were not timed.
    pub timer_source: Option<&'static str>,
    /// As in `passes.csv`.
    pub host_run_ns: Option<u64>,
    /// Passes in all.
    pub passes: usize,
    /// Passes, and rays worked on, of each kernel.
    pub kernels: BTreeMap<&'static str, KernelSummary>,
    /// Rays.
    pub rays: u64,
    /// Rays that hit a triangle.
    pub hits: u64,
    /// Rays still walking at the bound on passes; 0 with robust numerics.
    pub unfinished: u64,
    /// Sums of the `counters` stream; `null` where they were not asked for.
    pub counters: Option<CounterSums>,
    /// Against f64 brute force; `null` where that was not asked for.
    pub check: Option<CheckSummary>,
    /// Wall-clock seconds a stage.
    pub seconds: BTreeMap<&'static str, f64>,
    /// Bytes of each stream.
    pub stream_bytes: BTreeMap<&'static str, u64>,
    /// Bytes of each buffer.
    pub buffer_bytes: BTreeMap<&'static str, u64>,
}

/// An adapter's names.
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
    /// Turns after which it ends a loop, as a probe found; `null` where it ended none.
    pub loops_end_after: Option<u32>,
}

#[cfg(feature = "gpu")]
impl From<&Gpu> for AdapterInfo {
    fn from(gpu: &Gpu) -> Self {
        Self::new(&gpu.info, Some(gpu.loops))
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

/// The options that decide a run.
#[derive(Clone, Debug, Serialize)]
pub struct RunOptions {
    /// The scene's file as the user wrote it.
    pub scene_path: String,
    /// `--accelerator`, be it `auto`
    pub accelerator: &'static str,
    /// `--schedule`
    pub schedule: &'static str,
    /// `--numerics`
    pub numerics: &'static str,
    /// Texels a row.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
    /// `--grid`: `auto`, or the cells asked for along x, y and z.
    pub grid: String,
    /// `--skip`
    pub skip: &'static str,
    /// Most steps of a ray in one pass; `null` where a pass takes it to its end.
    pub steps_per_pass: Option<u32>,
    /// `--counters`
    pub counters: bool,
    /// `--keep-all`
    pub keep_all: bool,
    /// `--spp`: samples a pixel. Rays, hits, counters and `check` are those of one sample, of several the last.
    pub spp: u32,
    /// `--sampler`; `null` where a pixel has one sample.
    pub sampler: Option<&'static str>,
    /// `--seed`; `null` where a pixel has one sample.
    pub seed: Option<u32>,
}

/// How many rays hit something.
#[must_use]
pub fn hit_count(hits: &[Option<RayHit>]) -> u64 {
    hits.iter().flatten().count() as u64
}

/// Sums over all rays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct CounterSums {
    /// Cells visited; of a tree, nodes.
    pub cells_visited: u64,
    /// Triangles tested.
    pub triangles_tested: u64,
    /// Those tested in an earlier cell or leaf already; `null` where that is not looked for: with several
    /// steps a pass, and in a tree.
    pub repeated_tests: Option<u64>,
}

impl CounterSums {
    /// Of the values of the `counters` stream after a run of this plan; `None` for another stream.
    #[must_use]
    pub fn of(data: &crate::tables::stream::StreamData, plan: &Plan) -> Option<Self> {
        let sum = |layer| data.layer(layer).iter().map(|&n| u64::from(n)).sum();
        (data.stream == streams::COUNTERS).then(|| Self {
            cells_visited: sum(0),
            triangles_tested: sum(1),
            repeated_tests: plan
                .variants
                .iter()
                .find(|v| v.kernel.role() == Role::Test)
                .filter(|_| !plan.features.bvh)
                .map(|_| sum(2)),
        })
    }
}

/// What a comparison with f64 brute force found, in rays.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CheckSummary {
    /// Compared.
    pub rays: u64,
    /// With the exact result.
    pub same: u64,
    /// With another that f32 cannot exclude.
    pub ties: u64,
    /// Hit nothing where something is.
    pub missed: u64,
    /// Hit something where nothing is.
    pub false_hits: u64,
    /// Hit another triangle, or at a wrong t.
    pub wrong: u64,
    /// Largest error of t among right hits, in units in the last place.
    pub largest_t_ulp: f64,
}

/// Rays in each state, by the state's name.
#[must_use]
pub fn states(program: &Program, counts: &StateCounts) -> BTreeMap<&'static str, u32> {
    program.states.iter().zip(counts).map(|(state, &n)| (state.name, n)).collect()
}

/// A stream's row of the table, for readers of a dump.
#[derive(Clone, Debug, Serialize)]
pub struct StreamSummary {
    /// Its name.
    pub name: &'static str,
    /// `float32` or `uint32`, as NumPy says it.
    pub dtype: &'static str,
    /// One a layer.
    pub layers: Vec<LayerSummary>,
    /// Unit of its values.
    pub unit: &'static str,
    /// Bytes for the whole image.
    pub bytes: u64,
}

/// A layer of a stream.
#[derive(Clone, Debug, Serialize)]
pub struct LayerSummary {
    /// Its name.
    pub name: &'static str,
    /// Whether its bits are a float's, whatever the texel.
    pub is_float: bool,
    /// The bits before a kernel has written any.
    pub unwritten_bits: u32,
}

/// A stream for `texels` texels.
#[must_use]
pub fn stream(stream: Stream, texels: u64) -> StreamSummary {
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
        bytes: stream.bytes(texels).unwrap_or(u64::MAX),
    }
}
