//! The device that measurements run on, with its clocks.

use std::ops::ControlFlow;
use std::sync::OnceLock;
use std::time::Duration;

use raystep_kernels::export::csv::{RunContext, Timer};
use raystep_kernels::export::json::CounterSums;
use raystep_kernels::plan::Plan;
use raystep_kernels::shader::forget_variants;
use raystep_kernels::{Choices, Device, Gpu, GpuError, Limits, Options, Renderer, ScheduleKind};
use raystep_scenes::Scene;
use web_time::{Instant, SystemTime, UNIX_EPOCH};

use crate::block_on;
use crate::work::Cast;

/// A device, and why it was chosen. Only [`wait`](Self::wait) blocks this thread.
#[derive(Clone)]
pub struct Machine {
    /// A GPU, or the CPU.
    pub device: Device,
    /// Why it was chosen, in a phrase.
    pub reason: String,
}

impl Machine {
    /// The GPU, if it is one.
    #[must_use]
    pub fn gpu(&self) -> Option<&Gpu> {
        match &self.device {
            Device::Gpu(gpu) => Some(gpu),
            Device::Cpu(_) | Device::CpuF64(_) => None,
        }
    }

    /// `gpu` or `cpu`.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        if self.gpu().is_some() { "gpu" } else { "cpu" }
    }

    /// The adapter's name, or `cpu`.
    #[must_use]
    pub fn name(&self) -> String {
        self.gpu().map_or_else(|| "cpu".into(), |gpu| gpu.info.name.clone())
    }

    /// Its limits.
    #[must_use]
    pub fn limits(&self) -> Limits {
        self.gpu().map_or(Limits::CPU, Limits::from)
    }

    /// The clock for its passes, or for its runs if passes cannot be timed.
    #[must_use]
    pub fn timer(&self) -> Timer {
        match self.gpu().map(Gpu::clock_step_ns) {
            Some(Some(resolution_ns)) => Timer::GpuTimestamp { resolution_ns },
            Some(None) => Timer::Host { resolution_ns: clock_step_ns() },
            None => Timer::CpuClock { resolution_ns: clock_step_ns() },
        }
    }

    /// An explanation if passes cannot be timed.
    #[must_use]
    pub fn note_on_times(&self) -> Option<String> {
        let why = self.gpu()?.why_no_times()?;
        Some(format!("{why}: passes have no times, and a run is timed by the host, including waits for the adapter"))
    }

    /// Forgets composed and compiled kernels, so that the next plan and start are timed as the first. The driver may
    /// keep its compiled kernels, even on disk.
    pub fn forget_kernels(&self) {
        forget_variants();
        if let Some(gpu) = self.gpu() {
            gpu.forget_compiled();
        }
    }

    /// Waits for one of this device's futures; blocks this thread.
    pub fn wait<T>(&self, future: impl Future<Output = T>) -> T {
        block_on(self.gpu(), future)
    }

    /// An error if the device does not work any more.
    pub(crate) fn health(&self) -> Result<(), GpuError> {
        self.gpu().map_or(Ok(()), |gpu| gpu.health())
    }

    /// Waits until the device has finished everything submitted, uploads included.
    pub async fn settle(&self) {
        if let Some(gpu) = self.gpu() {
            // A lost device is reported by its next use.
            let _ = gpu.finish().await;
        }
    }

    /// Sums of the counters of a run with these options, which are counted for it; `None` if such a run cannot count,
    /// fails, or takes longer than it may.
    pub async fn counts(&self, scene: &Scene, options: &Options, longest: Duration) -> Option<CounterSums> {
        let options = Options { counters: true, timings: false, keep_passes: false, ..options.clone() };
        let (plan, data) = Plan::new(scene, &options, &self.limits()).ok()?;
        plan.counters()?;
        let mut renderer = Renderer::from_plan(plan, data, &options, &self.device).await.ok()?;
        let start = Instant::now();
        let watch = |_: &_| if start.elapsed() > longest { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        let counted = renderer.run_counting(false, watch).await.ok()?;
        counted.map(|counted| counted.sums)
    }

    /// The rays that a run with these options casts, counted in one whose passes tell; `None` if it fails, or takes longer
    /// than it may.
    pub async fn cast(&self, scene: &Scene, options: &Options, longest: Duration) -> Option<Cast> {
        let options = Options { schedule: ScheduleKind::Compact, timings: false, keep_passes: true, ..options.clone() };
        let mut renderer = Renderer::new(scene, &options, &self.device).await.ok()?;
        let start = Instant::now();
        let watch = |_: &_| if start.elapsed() > longest { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        renderer.run(watch).await.ok()?;
        Some(Cast::of(renderer.plan(), renderer.passes()))
    }

    /// The columns that all rows of a run in `passes.csv` share.
    #[must_use]
    pub fn run_context(&self, run_id: String, scene: &Scene, options: &Options, plan: &Plan) -> RunContext {
        RunContext {
            run_id,
            configuration: "0".into(),
            scene: scene.name.clone(),
            choices: Choices { accelerator: plan.accelerator, ..options.choices() },
            adapter: self.name(),
            width_px: Some(plan.width),
            height_px: Some(plan.height),
            repeat: 0,
            is_warmup: false,
            timer: options.timings.then(|| self.timer()),
            host_run_ns: None,
        }
    }
}

/// Nanoseconds since the first call, by the host's clock: times CPU runs and checks the GPU's clock.
#[must_use]
pub fn now_ns() -> u64 {
    static START: OnceLock<Instant> = OnceLock::new();
    START.get_or_init(Instant::now).elapsed().as_nanos() as u64
}

/// Identifies this process among all others: nanoseconds since 1970, in hex, when it was first asked for.
#[must_use]
pub fn session_id() -> &'static str {
    static ID: OnceLock<String> = OnceLock::new();
    ID.get_or_init(|| format!("{:x}", SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_nanos()))
}

/// The smallest observed step of the clock.
#[must_use]
pub fn clock_step_ns() -> Option<f64> {
    static STEP: OnceLock<Option<f64>> = OnceLock::new();
    *STEP.get_or_init(|| {
        let times: Vec<u64> = (0..1000).map(|_| now_ns()).collect();
        times.windows(2).map(|w| w[1] - w[0]).filter(|&step| step > 0).min().map(|step| step as f64)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_clock_moves() {
        assert!(clock_step_ns().is_some_and(|step| step >= 1.0));
    }
}
