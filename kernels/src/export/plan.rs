//! A plan as a value that serialises to JSON.

use serde::Serialize;

use super::json::{SCHEMA_VERSION, StreamSummary, stream};
use crate::fragment::{DrawnKernel, depth_of};
use crate::options::Accelerator;
use crate::options::keep::Item;
use crate::options::mapping::Fragment;
use crate::plan::display::element;
use crate::plan::{DrawnPlan, Plan, Planned, Structure};
use crate::program::Kernel;
use crate::program::schedule::{Count, Step};
use crate::scene_data::SceneData;
use crate::shader::Variant;
use crate::tables::stream::Stream;

/// A plan, for `raystep plan --json`.
#[derive(Clone, Debug, Serialize)]
pub struct PlanSummary {
    /// [`SCHEMA_VERSION`].
    pub schema_version: u32,
    /// Texels per row.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
    /// Number of rays.
    pub rays: u64,
    /// Number of triangles.
    pub triangles: u64,
    /// The acceleration structure.
    #[serde(flatten)]
    pub structure: Structure,
    /// Scene units per unit of the streams.
    pub scene_units_per_stream_unit: f64,
    /// Added to points in scene units, for the coordinates of the scene's file.
    pub scene_offset: [f64; 3],
    /// The schedule's steps.
    pub schedule: Vec<StepSummary>,
    /// Kernels and what they bind.
    pub kernels: Vec<PlannedKernel>,
    /// The draws of each kernel, if they are fragment programs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub draws: Option<DrawsSummary>,
    /// Streams to allocate.
    pub streams: Vec<StreamSummary>,
    /// Streams that are layers of one texture, as a kernel writes more than the device binds.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub shared_textures: Vec<Vec<&'static str>>,
    /// Buffers to allocate.
    pub buffers: Vec<PlannedBuffer>,
    /// Bytes of all streams and buffers.
    pub bytes: u64,
    /// What is left out.
    pub left_out: Vec<LeftOutSummary>,
}

/// A step of a schedule.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum StepSummary {
    /// Run a kernel once.
    Run(&'static str),
    /// Run a kernel once, with a parameter that counts with the loops it is in.
    RunBy {
        /// The kernel.
        kernel: &'static str,
        /// `launch.parameter` in the first turn of each loop.
        first: u32,
        /// What each turn of a loop adds, innermost loop first.
        by: &'static [u32],
    },
    /// Run a kernel until no ray is in its states.
    RunUntilIdle(&'static str),
    /// Repeat the steps while rays are in the states of one of the kernels.
    LoopWhileActive {
        /// The kernels.
        kernels: Vec<&'static str>,
        /// The steps.
        steps: Vec<StepSummary>,
    },
    /// Run the steps so many times.
    Repeat {
        /// How often, in the first turn of each loop that it is in.
        times: u32,
        /// How much oftener for each turn of these loops, innermost first.
        #[serde(skip_serializing_if = "<[u32]>::is_empty")]
        more: &'static [u32],
        /// The steps.
        steps: Vec<StepSummary>,
    },
    /// Run the steps, and repeat them while a set has elements.
    RepeatWhileAny {
        /// The set.
        elements: &'static str,
        /// The steps.
        steps: Vec<StepSummary>,
    },
}

/// A kernel of a plan.
#[derive(Clone, Debug, Serialize)]
pub struct PlannedKernel {
    /// Its name.
    pub name: &'static str,
    /// One sentence about it.
    pub summary: &'static str,
    /// States of the rays that it works on.
    pub rays_in: Vec<&'static str>,
    /// What it binds.
    pub bindings: Vec<BindingSummary>,
}

/// Kernels as draws.
#[derive(Clone, Debug, Serialize)]
pub struct DrawsSummary {
    /// `--targets`
    pub targets: &'static str,
    /// `--update`
    pub update: &'static str,
    /// `--cull`
    pub cull: &'static str,
    /// `--until`
    pub until: &'static str,
    /// The kernels.
    pub kernels: Vec<DrawnKernelSummary>,
}

/// The draws of a kernel.
#[derive(Clone, Debug, Serialize)]
pub struct DrawnKernelSummary {
    /// Its name.
    pub name: &'static str,
    /// The streams that it reads and writes.
    pub updates: Vec<&'static str>,
    /// Bytes that are copied before each pass.
    pub bytes_copied: u64,
    /// The depth that names it, with a depth test.
    pub depth: Option<f32>,
    /// Its draws, in order.
    pub draws: Vec<DrawSummary>,
}

/// A draw.
#[derive(Clone, Debug, Serialize)]
pub struct DrawSummary {
    /// The streams that it writes.
    pub targets: Vec<&'static str>,
    /// The streams that it reads.
    pub reads: Vec<&'static str>,
}

impl DrawsSummary {
    fn of(plan: &Plan, drawn: &DrawnPlan) -> Self {
        let names = |streams: &[Stream]| streams.iter().map(|stream| stream.name()).collect::<Vec<_>>();
        let kernel = |kernel: &DrawnKernel| DrawnKernelSummary {
            name: kernel.kernel.name(),
            updates: names(&kernel.updates),
            bytes_copied: drawn.copied_bytes(kernel.kernel, plan.size()),
            depth: drawn.depths.as_ref().map(|_| depth_of(kernel.kernel)),
            draws: kernel
                .draws
                .iter()
                .map(|draw| DrawSummary {
                    targets: names(&draw.targets),
                    reads: names(&draw.reads().collect::<Vec<_>>()),
                })
                .collect(),
        };
        let Fragment { targets, update, cull, until } = drawn.how;
        Self {
            targets: targets.name(),
            update: update.name(),
            cull: cull.name(),
            until: until.name(),
            kernels: drawn.kernels.iter().map(kernel).collect(),
        }
    }
}

/// A binding of a kernel.
#[derive(Clone, Debug, Serialize)]
pub struct BindingSummary {
    /// Name of the stream or buffer.
    pub name: String,
    /// `stream`, `uniform` or `buffer`.
    pub kind: &'static str,
    /// Whether the kernel reads it.
    pub reads: bool,
    /// Whether the kernel writes it.
    pub writes: bool,
}

/// A buffer of a plan.
#[derive(Clone, Debug, Serialize)]
pub struct PlannedBuffer {
    /// Its name.
    pub name: &'static str,
    /// What one element is.
    pub element: &'static str,
    /// Its size.
    pub bytes: u64,
}

/// Something that a plan leaves out.
#[derive(Clone, Debug, Serialize)]
pub struct LeftOutSummary {
    /// A kernel, stream, buffer or piece of code.
    pub what: String,
    /// Who made it unnecessary: `scene`, `options` or `view`.
    pub because: &'static str,
    /// The reason.
    pub reason: &'static str,
    /// The item that it belongs to, if the scene decides.
    pub item: Option<&'static str>,
}

/// The plan as printed to JSON, for a run with `--accelerator asked`.
#[must_use]
pub fn plan(asked: Accelerator, plan: &Plan, data: &SceneData) -> PlanSummary {
    let size = |of: Stream| plan.sets.iter().find(|set| set.what == of.info().elements).and_then(|set| set.size);
    let kernel = |variant: &Variant| {
        let info = variant.kernel.info();
        let bindings = variant.bindings.iter().map(|b| BindingSummary {
            name: b.name.clone(),
            kind: plan.kind_of(b),
            reads: b.reads,
            writes: b.writes,
        });
        PlannedKernel {
            name: variant.kernel.name(),
            summary: info.summary,
            rays_in: variant.kernel.takes().iter().map(|&tag| plan.program.states.name(tag)).collect(),
            bindings: bindings.collect(),
        }
    };
    let buffer = |b: &Planned<&'static str>| PlannedBuffer {
        name: b.what,
        element: element(plan.program, b.what),
        bytes: b.bytes,
    };
    let left_out = plan.left_out.iter().map(|item| LeftOutSummary {
        what: item.what.clone(),
        because: item.because.name(),
        reason: item.reason,
        item: item.item.map(Item::name),
    });
    PlanSummary {
        schema_version: SCHEMA_VERSION,
        width_px: plan.width,
        height_px: plan.height,
        rays: plan.rays,
        triangles: plan.triangles,
        structure: Structure::of(asked, plan, data),
        scene_units_per_stream_unit: data.units.scene_units_per_stream_unit(),
        scene_offset: data.units.offset.to_array(),
        schedule: steps(&plan.schedule.steps),
        kernels: plan.variants.iter().map(kernel).collect(),
        draws: plan.drawn.as_ref().map(|drawn| DrawsSummary::of(plan, drawn)),
        streams: plan
            .streams
            .iter()
            .map(|s| StreamSummary { bytes: s.bytes, ..stream(s.what, size(s.what)) })
            .collect(),
        shared_textures: (plan.sharing.groups.iter())
            .map(|group| group.iter().map(|stream| stream.name()).collect())
            .collect(),
        buffers: plan.buffers.iter().map(buffer).collect(),
        bytes: plan.bytes(),
        left_out: left_out.collect(),
    }
}

fn steps(all: &[Step]) -> Vec<StepSummary> {
    let names = |kernels: &[Kernel]| kernels.iter().map(|k| k.name()).collect();
    all.iter()
        .map(|step| match step {
            Step::Run(kernel) => StepSummary::Run(kernel.name()),
            Step::RunBy(kernel, Count { first, by }) => StepSummary::RunBy { kernel: kernel.name(), first: *first, by },
            Step::RunUntilIdle(kernel) => StepSummary::RunUntilIdle(kernel.name()),
            Step::Repeat(_, Count { first, by }, body) => {
                StepSummary::Repeat { times: *first, more: by, steps: steps(body) }
            }
            Step::LoopWhileActive(kernels, body) => {
                StepSummary::LoopWhileActive { kernels: names(kernels), steps: steps(body) }
            }
            Step::RepeatWhileAny(counted, body) => {
                StepSummary::RepeatWhileAny { elements: counted.name, steps: steps(body) }
            }
        })
        .collect()
}
