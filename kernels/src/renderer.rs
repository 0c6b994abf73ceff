//! A run that a program drives: one pass at a time or to the end, with every stream in the open.

mod given;
mod results;

use std::ops::ControlFlow;
use std::sync::Arc;

use raystep_scenes::Scene;

use crate::executor::PassResult;
use crate::executor::cpu::{CpuExecutor, OutOfMemory};
use crate::executor::gpu::{Gpu, GpuError, GpuExecutor, MOST_PASSES};
use crate::kernel::Kernel;
use crate::options::{Options, RaySource};
use crate::plan::{Limits, Plan, PlanError};
use crate::scene_data::SceneData;
use crate::schedule::Cursor;
use crate::state::{self, StateCounts};
use crate::stream::{STATE_TAG, Stream, StreamData};
pub(crate) use given::GIVEN;
use given::GivenRays;
pub use results::RayHit;

/// Rays times passes of one submission at most, or two passes.
const RAYS_A_BATCH: u64 = 1 << 26;

/// Where passes run.
#[derive(Clone)]
pub enum Device {
    /// A wgpu device.
    Gpu(Arc<Gpu>),
    /// The twins in f32. The clock, in nanoseconds from any start, times passes if there is one.
    Cpu(Option<fn() -> u64>),
    /// The twins in f64, from the same f32 scene and camera.
    CpuF64(Option<fn() -> u64>),
}

enum Executor {
    Gpu(Box<GpuExecutor>),
    Cpu(CpuExecutor<f32>),
    CpuF64(CpuExecutor<f64>),
}

/// A run that failed.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// It does not fit.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The GPU failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The system has not enough memory for the twins' streams.
    #[error(transparent)]
    Memory(#[from] OutOfMemory),
    /// The caller's progress function asked to stop.
    #[error("cancelled after {passes} passes")]
    Cancelled {
        /// Passes that were complete.
        passes: usize,
    },
    /// The stream is not part of the plan.
    #[error("stream {0:?} is left out of this run's plan")]
    NoStream(&'static str),
    /// A pass that was submitted ahead changed something. This is a defect of raystep.
    #[error("pass {0}, submitted ahead of its turn, was not idle")]
    Overshoot(usize),
}

/// One pass that has run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pass {
    /// Its place in the run, from 0.
    pub index: usize,
    /// Turn of the walk's loop that it belongs to, from 1; 0 before the loop.
    pub iteration: u32,
    /// Its kernel.
    pub kernel: Kernel,
    /// Rays that it worked on.
    pub rays_in: u32,
    /// Rays in each state after it.
    pub counts: StateCounts,
    /// Threads that it launched, with or without a ray to work on.
    ///
    /// On a GPU whole workgroups: of a kernel that works from a list of live rays as many full rows of
    /// workgroups as hold them, of any other as many workgroups as cover the image. On the CPU calls of the
    /// twin: for all rays of every chunk of 512 that has a ray in one of the kernel's states. What a GPU
    /// launches to count rays, or in passes submitted ahead that turn out not to be needed, is not part of it.
    pub threads_launched: u64,
    /// When it began, on the device's own clock.
    pub begin_ns: Option<u64>,
    /// How long it took on the device.
    pub duration_ns: Option<u64>,
}

/// How far a run is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Passes so far.
    pub passes: usize,
    /// Rays whose hit is decided.
    pub rays_decided: u64,
    /// All rays.
    pub rays: u64,
}

/// A scene, its options and a device, between two passes.
pub struct Renderer {
    plan: Plan,
    data: SceneData,
    executor: Executor,
    given: Option<GivenRays>,
    cursor: Cursor,
    counts: StateCounts,
    passes: Vec<Pass>,
    pass_bound: u64,
    unfinished: u64,
    /// Passes were submitted whose results are not in `passes`: a caller dropped the future that waited.
    is_ahead: bool,
}

impl Renderer {
    /// Plans the run, prepares the scene, allocates. No pass has run yet.
    ///
    /// # Errors
    /// Where the scene or options do not fit the device, or the device fails.
    pub async fn new(scene: &Scene, options: &Options, device: &Device) -> Result<Self, RenderError> {
        let limits = match device {
            Device::Gpu(gpu) => Limits::from(&gpu.device.limits()),
            Device::Cpu(_) | Device::CpuF64(_) => Limits::CPU,
        };
        let (plan, data) = Plan::new(scene, options, &limits)?;
        Self::from_plan(plan, data, options, device).await
    }

    /// The same from a plan that was made before.
    ///
    /// # Errors
    /// Where the device fails.
    pub async fn from_plan(
        plan: Plan,
        data: SceneData,
        options: &Options,
        device: &Device,
    ) -> Result<Self, RenderError> {
        let timer = |clock: &Option<fn() -> u64>| clock.filter(|_| options.timings);
        let executor = match device {
            Device::Gpu(gpu) => {
                Executor::Gpu(Box::new(GpuExecutor::new(gpu.clone(), &plan, &data, options.timings).await?))
            }
            Device::Cpu(clock) => Executor::Cpu(CpuExecutor::new(&plan, timer(clock))?),
            Device::CpuF64(clock) => Executor::CpuF64(CpuExecutor::new(&plan, timer(clock))?),
        };
        let given = match &options.rays {
            RaySource::Given(rays) => Some(GivenRays::new(rays, &plan, &data)),
            RaySource::Camera { .. } => None,
        };
        let mut executor = executor;
        if let (Executor::Gpu(e), Some(given)) = (&mut executor, &given) {
            e.give(&given.streams);
        }
        let pass_bound = plan.pass_bound(&data);
        let mut renderer = Self {
            plan,
            data,
            executor,
            given,
            cursor: Cursor::start(),
            counts: StateCounts::default(),
            passes: Vec::new(),
            pass_bound,
            unfinished: 0,
            is_ahead: false,
        };
        renderer.restart();
        Ok(renderer)
    }

    /// Back to before the first pass. Kernels are deterministic, so the same passes follow.
    pub fn restart(&mut self) {
        match &mut self.executor {
            Executor::Gpu(e) => e.clear(),
            Executor::Cpu(e) => e.clear(),
            Executor::CpuF64(e) => e.clear(),
        }
        self.cursor = Cursor::start();
        self.passes.clear();
        self.unfinished = 0;
        self.is_ahead = false;
        self.counts = StateCounts::default();
        let texels = self.plan.width * self.plan.height;
        match &self.given {
            Some(given) => {
                for data in &given.streams {
                    // A plan for given rays has these streams; a GPU keeps them, and copies them in `clear`.
                    let _: bool = match &mut self.executor {
                        Executor::Gpu(_) => true,
                        Executor::Cpu(e) => e.write(data),
                        Executor::CpuF64(e) => e.write(data),
                    };
                }
                let rays = given.exponents.len() as u32;
                self.counts[state::TRAV_SETUP as usize] = rays;
                self.counts[state::UNWRITTEN as usize] = texels - rays;
            }
            // The fused kernel's rays wait for nobody to make them.
            None if self.plan.features.eye_rays => self.counts[state::TRAV_SETUP as usize] = texels,
            None => self.counts[state::UNWRITTEN as usize] = texels,
        }
    }

    /// Runs one pass. `None` when the run is complete.
    ///
    /// # Errors
    /// Where the device fails.
    pub async fn step(&mut self) -> Result<Option<Pass>, RenderError> {
        let before = self.passes.len();
        self.advance(1).await?;
        Ok(self.passes.get(before).copied())
    }

    /// The kernel that [`step`](Self::step) would run.
    #[must_use]
    pub fn next_kernel(&self) -> Option<Kernel> {
        self.cursor.clone().next(&self.plan.schedule, &self.counts)
    }

    /// Runs to the end. `progress` is called between batches of passes and may stop the run.
    ///
    /// # Errors
    /// Where the device fails, or `progress` said so.
    pub async fn run(&mut self, mut progress: impl FnMut(&Progress) -> ControlFlow<()>) -> Result<(), RenderError> {
        // Enough passes to hide the read-back, few enough rays to report often.
        let most = match self.executor {
            Executor::Gpu(_) => MOST_PASSES,
            Executor::Cpu(_) | Executor::CpuF64(_) => 1,
        };
        let mut batch = 8.min(most);
        loop {
            let recorded = self.advance(batch).await?;
            if recorded == 0 {
                break;
            }
            // Where fewer were needed than submitted, a kernel is idle soon; the rest was for nothing.
            let wanted = if 2 * recorded < batch { 2 * recorded } else { 2 * batch };
            // Passes that launch every ray cost as much at the end as at the beginning.
            let launched = if self.plan.features.live_lists { self.undecided() } else { self.plan.rays };
            batch = wanted.min((RAYS_A_BATCH / launched.max(1)) as usize).max(2).min(most);
            if progress(&self.progress()).is_break() && self.next_kernel().is_some() {
                return Err(RenderError::Cancelled { passes: self.passes.len() });
            }
        }
        Ok(())
    }

    /// Submits up to `most` passes and records those that the schedule asked for.
    async fn advance(&mut self, most: usize) -> Result<usize, RenderError> {
        if self.is_ahead {
            // The streams are past what was recorded. Passes are deterministic: run the recorded ones again.
            let place = self.passes.len();
            self.restart();
            while self.passes.len() < place && self.submit(1).await? > 0 {}
        }
        self.submit(most).await
    }

    async fn submit(&mut self, most: usize) -> Result<usize, RenderError> {
        if self.passes.len() as u64 >= self.pass_bound && self.unfinished == 0 {
            // Only the paper's numerics can get here: a ray that wraps over a face of the grid.
            self.unfinished = self.undecided();
            self.cursor.leave_loop();
        }
        let guess = self.cursor.guess(&self.plan.schedule, &self.counts, most);
        if guess.is_empty() {
            return Ok(0);
        }
        self.is_ahead = true;
        let results: Vec<PassResult> = match &mut self.executor {
            Executor::Gpu(e) => e.run(&guess, &self.counts).await?,
            Executor::Cpu(e) => vec![e.run(guess[0], &self.data)],
            Executor::CpuF64(e) => vec![e.run(guess[0], &self.data)],
        };
        let mut recorded = 0;
        for result in &results {
            let mut ahead = self.cursor.clone();
            if ahead.next(&self.plan.schedule, &self.counts) != Some(result.kernel) {
                // What follows was submitted ahead for rays that are no longer there.
                if results[recorded..].iter().any(|r| r.counts != self.counts) {
                    return Err(RenderError::Overshoot(self.passes.len()));
                }
                break;
            }
            let rays_in = result.kernel.live(&self.counts);
            self.cursor = ahead;
            self.counts = result.counts;
            self.passes.push(Pass {
                index: self.passes.len(),
                iteration: self.cursor.iteration,
                kernel: result.kernel,
                rays_in,
                counts: result.counts,
                threads_launched: result.threads_launched,
                begin_ns: result.begin_ns,
                duration_ns: result.duration_ns,
            });
            recorded += 1;
        }
        self.is_ahead = false;
        Ok(recorded)
    }

    fn undecided(&self) -> u64 {
        [state::TRAV_SETUP, state::TRAV, state::ISECT_NO_HIT, state::ISECT_HIT]
            .iter()
            .map(|&tag| u64::from(self.counts[tag as usize]))
            .sum()
    }

    /// How far the run is.
    #[must_use]
    pub fn progress(&self) -> Progress {
        let decided = [state::SHADE, state::BACKGROUND, state::DONE];
        let rays_decided = decided.iter().map(|&tag| u64::from(self.counts[tag as usize])).sum();
        Progress { passes: self.passes.len(), rays_decided, rays: self.plan.rays }
    }

    /// The plan.
    #[must_use]
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The scene as the kernels read it.
    #[must_use]
    pub fn data(&self) -> &SceneData {
        &self.data
    }

    /// Every pass so far.
    #[must_use]
    pub fn passes(&self) -> &[Pass] {
        &self.passes
    }

    /// Rays in each state now.
    #[must_use]
    pub fn live(&self) -> StateCounts {
        self.counts
    }

    /// Rays that were still walking when the bound on passes was reached. 0 with robust numerics.
    #[must_use]
    pub fn unfinished(&self) -> u64 {
        self.unfinished
    }

    /// Time of all passes so far on the device's own clock, in nanoseconds: on a GPU from the first begin to
    /// the last end of each submission, summed; of the twins, the sum of their passes, where they are timed.
    #[must_use]
    pub fn device_ns(&self) -> Option<u64> {
        match &self.executor {
            Executor::Gpu(e) => e.device_ns(),
            _ => self.passes.iter().map(|p| p.duration_ns).sum(),
        }
    }

    /// The GPU executor, where passes run on one.
    #[must_use]
    pub fn gpu(&self) -> Option<&GpuExecutor> {
        match &self.executor {
            Executor::Gpu(e) => Some(e),
            _ => None,
        }
    }

    /// The f64 twins, where passes run on them.
    #[must_use]
    pub fn cpu_f64(&self) -> Option<&CpuExecutor<f64>> {
        match &self.executor {
            Executor::CpuF64(e) => Some(e),
            _ => None,
        }
    }

    /// Replaces a stream's values; the next pass works on them. False where the plan left it out or the
    /// size differs.
    pub fn write(&mut self, data: &StreamData) -> bool {
        let is_written = match &mut self.executor {
            Executor::Gpu(e) => e.write(data),
            Executor::Cpu(e) => e.write(data),
            Executor::CpuF64(e) => e.write(data),
        };
        if is_written && data.stream == Stream::State {
            // Which kernel is next follows from the counts.
            self.counts = StateCounts::default();
            data.layer(STATE_TAG).iter().for_each(|&tag| self.counts[(tag as usize).min(state::COUNT - 1)] += 1);
        }
        is_written
    }
}
