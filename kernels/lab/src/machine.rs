//! What measurements run on: a device with its clocks.

use std::sync::OnceLock;
use std::time::Instant;

use raystep_kernels::export::csv::{RunContext, Timer};
use raystep_kernels::plan::Plan;
use raystep_kernels::shader::forget_variants;
use raystep_kernels::{Device, Gpu, Limits, Options};
use raystep_scenes::Scene;

use crate::block_on;

/// A device, and why that one. The methods that wait block this thread.
#[derive(Clone)]
pub struct Machine {
    /// A GPU, or the twins.
    pub device: Device,
    /// Why that one, in a phrase.
    pub reason: String,
}

impl Machine {
    /// The GPU, where there is one.
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

    /// What it can hold.
    #[must_use]
    pub fn limits(&self) -> Limits {
        self.gpu().map_or(Limits::CPU, Limits::from)
    }

    /// What times its passes, or, where they have no times, its runs.
    #[must_use]
    pub fn timer(&self) -> Timer {
        match self.gpu().map(Gpu::clock_period_ns) {
            Some(Some(resolution_ns)) => Timer::GpuTimestamp { resolution_ns },
            Some(None) => Timer::Host { resolution_ns: clock_step_ns() },
            None => Timer::CpuClock { resolution_ns: clock_step_ns() },
        }
    }

    /// What to know where passes have no times.
    #[must_use]
    pub fn note_on_times(&self) -> Option<String> {
        let why = self.gpu()?.why_no_times()?;
        Some(format!("{why}: passes have no times, and a run is timed by the host, including waits for the adapter"))
    }

    /// Forgets the kernels that were composed and compiled before, so that what is timed next is a first plan and a first
    /// start. A driver may have kept what it compiled, on disk too.
    pub fn forget_kernels(&self) {
        forget_variants();
        if let Some(gpu) = self.gpu() {
            gpu.forget_compiled();
        }
    }

    /// Waits for a future of this device.
    pub fn wait<T>(&self, future: impl Future<Output = T>) -> T {
        block_on(self.gpu(), future)
    }

    /// Waits until the device has done everything that it was given, uploads included.
    pub fn settle(&self) {
        if let Some(gpu) = self.gpu() {
            gpu.submit([]);
            // A lost device is said by whatever uses it next.
            let _ = gpu.device.poll(wgpu::PollType::Wait { submission_index: None, timeout: None });
        }
    }

    /// What all rows of a run in `passes.csv` have in common, but what it took.
    #[must_use]
    pub fn run_context(&self, run_id: String, scene: &Scene, options: &Options, plan: &Plan) -> RunContext {
        RunContext {
            run_id,
            scene: scene.name.clone(),
            accelerator: options.accelerator.name(),
            schedule: options.schedule.name(),
            numerics: options.numerics.name(),
            device: self.name(),
            width_px: plan.width,
            height_px: plan.height,
            repeat: 0,
            is_warmup: false,
            timer: options.timings.then(|| self.timer()),
            host_run_ns: None,
        }
    }
}

/// Nanoseconds since the first call: a host's clock, for the twins and for comparing a GPU's with.
#[must_use]
pub fn now_ns() -> u64 {
    static START: OnceLock<Instant> = OnceLock::new();
    START.get_or_init(Instant::now).elapsed().as_nanos() as u64
}

/// The smallest step that the clock was seen to make.
fn clock_step_ns() -> Option<f64> {
    let times: Vec<u64> = (0..1000).map(|_| now_ns()).collect();
    times.windows(2).map(|w| w[1] - w[0]).filter(|&step| step > 0).min().map(|step| step as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_clock_moves() {
        assert!(clock_step_ns().is_some_and(|step| step >= 1.0));
    }
}
