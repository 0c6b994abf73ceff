//! `index.json`, which describes the other files.

use raystep_kernels::export::csv;
use raystep_kernels::export::json::{self, AdapterInfo, RunOptions, StreamSummary};
use raystep_kernels::plan::Structure;
use raystep_kernels::{Kernel, Pass, Stream};
use serde::Serialize;

use super::buffers::BufferFile;
use super::left_out::{LeftOut, NOT_NEEDED};
use crate::session::Running;

/// The file that describes the others.
pub(super) const INDEX: &str = "index.json";

/// `index.json`
#[derive(Serialize)]
pub(super) struct Index {
    schema_version: u32,
    raystep_version: &'static str,
    scene: String,
    device: &'static str,
    adapter: Option<AdapterInfo>,
    options: RunOptions,
    rays: u64,
    /// Multiply lengths and t of the streams by this for scene units.
    scene_units_per_stream_unit: f64,
    /// Then add this to points, for the coordinates of the scene's file.
    scene_offset: [f64; 3],
    #[serde(flatten)]
    structure: Structure,
    streams: Vec<StreamSummary>,
    /// Scene data.
    buffers: Vec<BufferFile>,
    /// Every pass up to the last one written.
    pub(super) passes: Vec<IndexPass>,
}

#[derive(Default, Serialize)]
pub(super) struct IndexPass {
    /// Its number, which does not depend on what is dumped.
    pub(super) index: usize,
    pub(super) kernel: &'static str,
    /// Why it did not run, otherwise `null`. Its results are then unknown.
    pub(super) left_out: Option<&'static str>,
    /// As in `passes.csv`, like the next four.
    sample: Option<u32>,
    iteration: Option<u32>,
    loops: Vec<u32>,
    rays_in: Option<u32>,
    rays_out: Option<u32>,
    rays_by_state: Option<std::collections::BTreeMap<&'static str, u32>>,
    pub(super) files: Vec<String>,
}

impl IndexPass {
    fn left_out(index: usize, kernel: Kernel) -> Self {
        Self { index, kernel: kernel.name(), left_out: Some(NOT_NEEDED), ..Self::default() }
    }
}

/// Passes up to `last` are listed.
pub(super) fn index(
    running: &Running,
    streams: &[Stream],
    buffers: Vec<BufferFile>,
    left_out: LeftOut,
    last: Option<usize>,
) -> Index {
    let (renderer, plan) = (&running.renderer, running.renderer.plan());
    let pass = |pass: &Pass| IndexPass {
        index: left_out.before() + pass.index,
        kernel: pass.kernel.name(),
        left_out: None,
        sample: Some(pass.sample),
        iteration: Some(pass.iteration),
        loops: pass.loops.clone(),
        rays_in: Some(pass.rays_in),
        rays_out: csv::rays_out(pass),
        rays_by_state: Some(json::states(plan.program, &pass.counts)),
        files: Vec::new(),
    };
    let before = left_out.first.map(|kernel| IndexPass::left_out(0, kernel));
    let mut passes: Vec<_> = before.into_iter().chain(renderer.passes().iter().map(pass)).collect();
    if let (Some(kernel), Some(last)) = (left_out.last, last)
        && passes.len() <= last
    {
        passes.push(IndexPass::left_out(passes.len(), kernel));
    }
    Index {
        schema_version: json::SCHEMA_VERSION,
        raystep_version: env!("CARGO_PKG_VERSION"),
        scene: running.scene.name.clone(),
        device: running.chosen.kind(),
        adapter: running.chosen.gpu().map(AdapterInfo::from),
        options: running.run_options(),
        rays: plan.rays,
        scene_units_per_stream_unit: renderer.data().units.scene_units_per_stream_unit(),
        scene_offset: renderer.data().units.offset.to_array(),
        structure: running.structure(),
        streams: streams.iter().map(|&s| json::stream(s, renderer.size(s.info().elements))).collect(),
        buffers,
        passes,
    }
}
