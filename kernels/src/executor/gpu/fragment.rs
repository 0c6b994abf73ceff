//! Runs kernels as fragment programs: each pass is one or more draws of a quad over all rays.

mod batch;
mod bound;
mod parts;
mod pipelines;
mod results;
mod snapshot;
mod streams;

use std::sync::Arc;

use super::snapshot::Copies;
use super::timers::Timers;
use super::uploaded::{Uploaded, upload_scene, upload_size, upload_view};
use super::{Gpu, GpuError, MOST_PASSES};
use crate::executor::sizes::Sizes;
use crate::options::Options;
use crate::options::mapping::{Fragment, Until};
use crate::plan::Plan;
use crate::scene_data::SceneData;
use crate::tables::elements::{Elements, Size};
use crate::tables::stream::{Region, Stream, StreamData};
use pipelines::Pipelines;
use results::Results;
pub(crate) use snapshot::Snapshot;
use streams::StreamTextures;

/// Runs a plan's kernels as fragment programs.
pub struct FragmentExecutor {
    gpu: Arc<Gpu>,
    plan: Arc<Plan>,
    how: Fragment,
    /// Whether occlusion queries end the loops.
    is_queried: bool,
    /// Whether rays are counted after every pass, rather than at the end of a batch.
    counts_each: bool,
    streams: StreamTextures,
    buffers: Vec<(&'static str, Uploaded)>,
    pipelines: Pipelines,
    results: Results,
    timers: Option<Timers>,
    given: Vec<StreamData>,
    device_ns: Option<u64>,
    host_ns: Option<u64>,
    copies: Copies,
}

impl FragmentExecutor {
    /// Allocates the plan's streams and buffers, uploads the buffers and compiles the draws. Validation and out-of-memory
    /// errors are returned and cause no panic. An executor `beside` it has the same data.
    ///
    /// # Errors
    /// If the plan has no draws, or the device refuses or is lost.
    pub(crate) async fn new(
        gpu: Arc<Gpu>,
        plan: &Arc<Plan>,
        data: &SceneData,
        options: &Options,
        beside: Option<&Self>,
    ) -> Result<Self, GpuError> {
        gpu.health()?;
        let drawn = plan.drawn.as_ref().ok_or(GpuError::Missing("fragment"))?;
        let scopes = gpu.push_scopes();
        let buffers = upload_scene(&gpu, plan, data, |name: &str| beside.and_then(|other| other.uploaded(name)));
        let streams = StreamTextures::new(&gpu.device, plan, drawn);
        let is_counted = drawn.how.until == Until::Count;
        let results = Results::new(&gpu.device, plan, drawn.counter.is_some(), options.count_fragments && is_counted)?;
        let is_queried = drawn.how.until == Until::Query && gpu.answers_queries();
        let pipelines = Pipelines::new(&gpu.device, plan, drawn);
        let timers = Timers::of_draws(&gpu, plan, options.timings);
        let mut executor = Self {
            plan: plan.clone(),
            how: drawn.how,
            is_queried,
            counts_each: options.keep_passes || !is_queried,
            streams,
            buffers,
            pipelines,
            results,
            timers,
            given: Vec::new(),
            device_ns: None,
            host_ns: None,
            copies: Copies::default(),
            gpu,
        };
        executor.clear();
        upload_size(&executor.gpu.queue, &executor.plan, &executor.buffers);
        executor.gpu.pop_scopes(scopes).await?;
        Ok(executor)
    }

    /// Most passes per submission. The host counts rays at the end of one.
    pub(crate) fn most_passes(&self) -> usize {
        if self.counts_each && self.results.sent.is_none() { 1 } else { MOST_PASSES }
    }

    /// Whether the device can still run passes.
    pub(crate) fn health(&self) -> Result<(), GpuError> {
        self.gpu.health()
    }

    /// The device.
    #[must_use]
    pub fn gpu(&self) -> &Arc<Gpu> {
        &self.gpu
    }

    fn uploaded(&self, name: &str) -> Option<&Uploaded> {
        self.buffers.iter().find(|(n, _)| *n == name).map(|(_, b)| b)
    }

    /// Uploads what depends on the camera.
    pub(crate) fn set_view(&self, data: &SceneData) {
        upload_view(&self.gpu, &self.plan, &self.buffers, data);
    }

    /// Sets the initial contents of some streams from now on: input rays.
    pub(crate) fn give(&mut self, streams: &[StreamData]) {
        self.given = streams.to_vec();
    }

    /// Resets every stream to its initial contents.
    pub(crate) fn clear(&mut self) {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        self.streams.clear(&mut encoder);
        self.gpu.submit([encoder.finish()]);
        self.copies.forget_all();
        self.device_ns = self.timers.as_ref().map(|_| 0);
        self.host_ns = self.gpu.host_clock().map(|_| 0);
        for data in std::mem::take(&mut self.given) {
            // A plan for input rays has these streams.
            let _: bool = self.write(&data);
            self.given.push(data);
        }
    }

    /// Replaces a stream. Returns false if the plan left it out or the size differs.
    pub(crate) fn write(&mut self, data: &StreamData) -> bool {
        self.copies.forget(data.stream);
        self.streams.write(&self.gpu, data)
    }

    /// The texture of a stream: `rgba32uint`, a texel per ray, a component per layer.
    #[must_use]
    pub fn texture(&self, stream: Stream) -> Option<&wgpu::Texture> {
        self.streams.get(stream).map(|textures| textures.current())
    }

    /// The size of a set.
    #[must_use]
    pub fn size(&self, elements: &Elements) -> Option<Size> {
        self.plan.sets.iter().find(|set| set.what.name == elements.name).and_then(|set| set.size)
    }

    /// The size of each set.
    pub(crate) fn sizes(&self) -> Sizes {
        Sizes::new(&self.plan)
    }

    /// Names and sizes in bytes of everything that is allocated on the device.
    #[must_use]
    pub fn allocated(&self) -> Vec<(&'static str, u64)> {
        let buffers = self.buffers.iter().map(|(name, uploaded)| (*name, uploaded.bytes()));
        let depth = self.pipelines.depth_bytes().map(|bytes| ("depth", bytes));
        self.streams.allocated().chain(buffers).chain(self.results.allocated()).chain(depth).collect()
    }

    /// Device time of all passes so far, see [`GpuExecutor::device_ns`](super::GpuExecutor::device_ns).
    #[must_use]
    pub fn device_ns(&self) -> Option<u64> {
        self.device_ns
    }

    /// Host time of all passes so far, see [`GpuExecutor::host_ns`](super::GpuExecutor::host_ns).
    #[must_use]
    pub fn host_ns(&self) -> Option<u64> {
        self.host_ns
    }

    /// The values of a stream; `None` if the plan left it out.
    ///
    /// # Errors
    /// If the device is lost or refuses.
    pub async fn read(&self, stream: Stream) -> Result<Option<StreamData>, GpuError> {
        let region = Region { x: 0, y: 0, width: self.plan.width, height: self.plan.height };
        self.read_region(stream, region).await
    }
}
