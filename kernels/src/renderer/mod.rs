//! A run, driven by its caller: pass by pass or to the end, with access to every stream.

pub mod all_hits;
pub mod cast;
mod checkpoint;
mod counting;
mod device;
mod edit;
mod error;
mod given;
pub mod image;
mod lists;
mod one_ray;
mod passes;
mod records;
mod results;
mod view;

use std::sync::Arc;

use raystep_scenes::Scene;

use crate::executor::DrawTime;
use crate::executor::cpu::CpuExecutor;
#[cfg(feature = "gpu")]
use crate::executor::gpu::GpuExecutor;
use crate::options::mapping::Until;
use crate::options::{Options, Ray, RaySource};
use crate::plan::Plan;
use crate::program::schedule::{Call, Cursor};
use crate::scene_data::SceneData;
use crate::tables::elements::{Elements, Size};
use crate::tables::state::{Population, StateCounts};
pub use checkpoint::Checkpoint;
pub use counting::{Counted, CounterSums, Counting};
use device::Executor;
pub use device::{Device, let_others_run};
pub use error::RenderError;
use given::GivenRays;
pub use lists::{Lists, build_on_host};
use records::Records;
pub use records::{KernelSummary, Pass, PassTotals};
pub use results::RayHit;

/// Progress of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Number of passes so far.
    pub passes: usize,
    /// Number of rays whose hit is decided.
    pub rays_decided: u64,
    /// Number of rays.
    pub rays: u64,
    /// Number of complete samples per pixel; `rays_decided` counts rays of the next one.
    pub samples: u32,
    /// Number of samples per pixel at the end of the run.
    pub samples_wanted: u32,
    /// Name of the elements that the next pass works on, if they are no rays: photons, for example.
    pub others: Option<&'static str>,
}

/// A scene, its options and a device, between two passes.
pub struct Renderer {
    plan: Arc<Plan>,
    data: Arc<SceneData>,
    executor: Executor,
    given: Option<GivenRays>,
    cursor: Cursor,
    population: Population,
    /// The same as far as occlusion queries tell, if those decide what runs next.
    believed: Option<Population>,
    records: Records,
    pass_bound: u64,
    unfinished: u64,
    /// The pixel of the only ray, in a run that leaves out all others.
    alone: Option<[u32; 2]>,
    /// The kernels of all passes, if they are known from a run before.
    foreseen: Vec<Call>,
    /// Whether passes were submitted whose results are not recorded: a caller dropped the future that waited for them.
    is_ahead: bool,
}

impl Renderer {
    /// Plans the run, prepares the scene and allocates memory. No pass has run yet.
    ///
    /// # Errors
    /// If the scene or options do not fit the device, or the device fails.
    pub async fn new(scene: &Scene, options: &Options, device: &Device) -> Result<Self, RenderError> {
        // Boxed: a build is a run, too.
        let (plan, data) = Box::pin(Plan::on(scene, options, device)).await?;
        Self::from_plan(plan, data, options, device).await
    }

    /// As [`new`](Self::new), with an existing plan. Runs of one scene can share the data that they only read.
    ///
    /// # Errors
    /// If the device fails.
    pub async fn from_plan(
        plan: impl Into<Arc<Plan>>,
        data: impl Into<Arc<SceneData>>,
        options: &Options,
        device: &Device,
    ) -> Result<Self, RenderError> {
        Self::start(plan.into(), data.into(), options, device, None).await
    }

    /// Another run with the same plan on the same device, at its start. What kernels only read is uploaded once for
    /// both.
    ///
    /// # Errors
    /// If the device fails.
    pub async fn another(&self, options: &Options, device: &Device) -> Result<Self, RenderError> {
        Self::start(self.plan.clone(), self.data.clone(), options, device, Some(&self.executor)).await
    }

    async fn start(
        plan: Arc<Plan>,
        data: Arc<SceneData>,
        options: &Options,
        device: &Device,
        beside: Option<&Executor>,
    ) -> Result<Self, RenderError> {
        let given = match (&options.rays, plan.program.results) {
            (RaySource::Given(rays), Some(results)) => Some(GivenRays::new(rays, &[], &results, &plan, &data)),
            _ => GivenRays::inputs(&data),
        };
        let streams = given.as_ref().map_or(&[][..], |given| &given.streams);
        let executor = Executor::new(device, &plan, &data, options, streams, beside).await?;
        Ok(Self::with(plan, data, options, given, executor))
    }

    /// As [`from_plan`](Self::from_plan) for a plan of input rays that come later, see [`give`](Self::give). Another
    /// run with the same data on the same device may share what is uploaded.
    pub(crate) async fn for_later(
        plan: Arc<Plan>,
        data: Arc<SceneData>,
        options: &Options,
        device: &Device,
        beside: Option<&Self>,
    ) -> Result<Self, RenderError> {
        let beside = beside.map(|other| &other.executor);
        let executor = Executor::new(device, &plan, &data, options, &[], beside).await?;
        Ok(Self::with(plan, data, options, None, executor))
    }

    /// Replaces the input rays, of which the plan must have room for as many, and the triangles of the hits after which each
    /// looks for the next, if all hits are wanted; returns to before the first pass.
    pub(crate) fn give(&mut self, rays: &[Ray], last: &[u32]) {
        self.given =
            self.plan.program.results.map(|results| GivenRays::new(rays, last, &results, &self.plan, &self.data));
        self.executor.give(self.given.as_ref().map_or(&[], |given| &given.streams));
        self.restart();
    }

    fn with(
        plan: Arc<Plan>,
        data: Arc<SceneData>,
        options: &Options,
        given: Option<GivenRays>,
        executor: Executor,
    ) -> Self {
        let pass_bound = plan.pass_bound;
        let mut renderer = Self {
            plan,
            data,
            executor,
            given,
            cursor: Cursor::start(),
            population: Population::default(),
            believed: None,
            records: Records::new(options.keep_passes),
            pass_bound,
            unfinished: 0,
            alone: None,
            foreseen: Vec::new(),
            is_ahead: false,
        };
        renderer.restart();
        renderer
    }

    /// Returns to before the first pass, with all rays. Kernels are deterministic, so the same passes follow.
    pub fn restart(&mut self) {
        self.alone = None;
        self.begin();
    }

    /// Returns to before the first pass, with one ray if it is traced alone.
    fn begin(&mut self) {
        self.executor.clear(self.given.as_ref().map_or(&[], |given| &given.streams));
        self.cursor = Cursor::start();
        self.records.clear();
        self.unfinished = 0;
        self.is_ahead = false;
        let in_set = self.executor.sizes().counts();
        let (program, in_state) = (self.plan.program, StateCounts::none(self.plan.program.states));
        self.population = Population { in_state, sets: program.elements, in_set };
        let given = self.given.as_ref().map(|given| given.exponents.len() as u32);
        let (courses, is_eye) = (self.plan.program.courses, self.plan.features.eye_rays);
        for (index, course) in courses.iter().enumerate() {
            let texels = self.size(course.stream.info().elements).map_or(0, |size| size.texels() as u32);
            // If the fused kernel generates its rays, no other kernel does so before it.
            let born = match given.filter(|_| index == 0) {
                Some(given) => given,
                None if is_eye => texels,
                None => 0,
            };
            self.population.in_state.add(course.born, born);
            self.population.in_state.add(course.unborn, texels - born);
        }
        if let Some(ray) = self.alone {
            self.leave_out_others(ray);
        }
        self.believe_counts();
    }

    /// Lets the schedule know all rays in each state.
    fn believe_counts(&mut self) {
        let is_queried = self.plan.drawn.as_ref().is_some_and(|drawn| drawn.how.until == Until::Query);
        self.believed = is_queried.then(|| self.population.clone());
    }

    /// Makes runs from now on submit exactly these passes, which an earlier run of the same plan needed. Without them,
    /// passes are submitted ahead, some of them for rays that have left: see
    /// [`Cursor::guess`](crate::program::schedule::Cursor::guess).
    pub fn foresee<'a>(&mut self, passes: impl IntoIterator<Item = &'a Pass>) {
        self.foreseen = passes.into_iter().map(Pass::call).collect();
    }

    /// The plan.
    #[must_use]
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Whether the device can still run passes.
    ///
    /// # Errors
    /// If it was lost.
    pub fn health(&self) -> Result<(), RenderError> {
        self.executor.health()
    }

    /// The size of a set of the program, and its layout in the streams' textures; `None` while the run has not counted
    /// it.
    #[must_use]
    pub fn size(&self, elements: &Elements) -> Option<Size> {
        self.executor.size(elements)
    }

    /// The plan, for another run of the same scene and options.
    #[must_use]
    pub fn shared_plan(&self) -> Arc<Plan> {
        self.plan.clone()
    }

    /// The scene as the kernels read it.
    #[must_use]
    pub fn data(&self) -> &SceneData {
        &self.data
    }

    /// The scene as the kernels read it, for another run.
    #[must_use]
    pub fn shared_data(&self) -> Arc<SceneData> {
        self.data.clone()
    }

    /// All passes so far, if [`Options::keep_passes`] is set; else none.
    #[must_use]
    pub fn passes(&self) -> &[Pass] {
        self.records.kept()
    }

    /// The parts of each of [`passes`](Self::passes), if they are drawn; else none.
    #[must_use]
    pub fn draws(&self) -> &[Vec<DrawTime>] {
        self.records.draws()
    }

    /// Number of passes so far.
    #[must_use]
    pub fn pass_count(&self) -> usize {
        self.records.len()
    }

    /// Sums over all passes so far.
    #[must_use]
    pub fn totals(&self) -> &PassTotals {
        self.records.totals()
    }

    /// The pass that ran last.
    #[must_use]
    pub fn last_pass(&self) -> Option<Pass> {
        self.records.last()
    }

    /// Number of rays in each state.
    #[must_use]
    pub fn live(&self) -> &StateCounts {
        &self.population.in_state
    }

    /// Number of rays that were still walking when the limit of passes was reached, over all samples. 0 with robust
    /// numerics.
    #[must_use]
    pub fn unfinished(&self) -> u64 {
        self.unfinished
    }

    /// Time of all passes so far on the device's own clock, in nanoseconds: on a GPU from the first begin to the last
    /// end of each submission, summed; for the twins, the sum of their passes, if timed.
    #[must_use]
    pub fn device_ns(&self) -> Option<u64> {
        match &self.executor {
            #[cfg(feature = "gpu")]
            Executor::Gpu(e) => e.device_ns(),
            #[cfg(feature = "gpu")]
            Executor::Fragment(e) => e.device_ns(),
            _ => self.records.totals().duration_ns,
        }
    }

    /// Time of all passes so far on the host's clock, in nanoseconds, including the wait for a GPU: known even if the
    /// device's own clock is not valid. `None` if there is no such clock; see
    /// [`Gpu::check_clock`](crate::Gpu::check_clock).
    #[must_use]
    pub fn host_ns(&self) -> Option<u64> {
        match &self.executor {
            #[cfg(feature = "gpu")]
            Executor::Gpu(e) => e.host_ns(),
            #[cfg(feature = "gpu")]
            Executor::Fragment(e) => e.host_ns(),
            _ => self.device_ns(),
        }
    }

    /// The GPU executor, if passes run on one.
    #[cfg(feature = "gpu")]
    #[must_use]
    pub fn gpu(&self) -> Option<&GpuExecutor> {
        match &self.executor {
            Executor::Gpu(e) => Some(e),
            _ => None,
        }
    }

    /// The f64 twins, if passes run on them.
    #[must_use]
    pub fn cpu_f64(&self) -> Option<&CpuExecutor<f64>> {
        match &self.executor {
            Executor::CpuF64(e) => Some(e),
            _ => None,
        }
    }
}
