//! A plan as a value that serialises to JSON.

use serde::Serialize;

use super::json::{SCHEMA_VERSION, StreamSummary, stream};
use crate::options::Accelerator;
use crate::options::keep::Item;
use crate::plan::display::element;
use crate::plan::{Plan, Planned, Structure};
use crate::program::schedule::Step;
use crate::program::{Kernel, Program};
use crate::scene_data::SceneData;
use crate::shader::{Resource, Variant};

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
    /// The schedule's steps.
    pub schedule: Vec<StepSummary>,
    /// Kernels and what they bind.
    pub kernels: Vec<PlannedKernel>,
    /// Streams to allocate.
    pub streams: Vec<StreamSummary>,
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
    /// Run a kernel until no ray is in its states.
    RunUntilIdle(&'static str),
    /// Repeat the steps while rays are in the states of one of the kernels.
    LoopWhileActive {
        /// The kernels.
        kernels: Vec<&'static str>,
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
    let texels = u64::from(plan.width) * u64::from(plan.height);
    let kernel = |variant: &Variant| {
        let info = variant.kernel.info();
        let bindings = variant.bindings.iter().map(|b| BindingSummary {
            name: b.name.clone(),
            kind: match b.resource {
                Resource::ReadStream(_) | Resource::WriteStream { .. } => "stream",
                Resource::Uniform | Resource::Launch => "uniform",
                Resource::Storage | Resource::Live { .. } => "buffer",
            },
            reads: b.reads,
            writes: b.writes,
        });
        PlannedKernel {
            name: variant.kernel.name(),
            summary: info.summary,
            rays_in: info.takes.iter().map(|&tag| plan.program.states.name(tag)).collect(),
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
        schedule: steps(&plan.schedule.steps, plan.program),
        kernels: plan.variants.iter().map(kernel).collect(),
        streams: plan.streams.iter().map(|s| stream(s.what, texels)).collect(),
        buffers: plan.buffers.iter().map(buffer).collect(),
        bytes: plan.bytes(),
        left_out: left_out.collect(),
    }
}

fn steps(all: &[Step], program: &Program) -> Vec<StepSummary> {
    let names = |kernels: &[Kernel]| kernels.iter().map(|k| k.name()).collect();
    all.iter()
        .map(|step| match step {
            Step::Run(kernel) => StepSummary::Run(kernel.name()),
            Step::RunUntilIdle(kernel) => StepSummary::RunUntilIdle(kernel.name()),
            Step::LoopWhileActive(kernels, body) => {
                StepSummary::LoopWhileActive { kernels: names(kernels), steps: steps(body, program) }
            }
            Step::RepeatWhileAny(counted, body) => {
                StepSummary::RepeatWhileAny { elements: program.counted[*counted].name, steps: steps(body, program) }
            }
        })
        .collect()
}
