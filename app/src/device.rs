//! Where passes run, and waiting for them.

use std::fmt;
use std::pin::pin;
use std::sync::{Arc, OnceLock};
use std::task::{Context, Poll, Waker};
use std::time::{Duration, Instant};

use raystep_kernels::export::csv::Timer;
use raystep_kernels::{AdapterChoice, ClockCheck, Device, Gpu, GpuError, Limits, RenderError};
use serde::Serialize;

use crate::args::{DeviceArgs, DeviceKind};
use crate::error::Error;

/// A device, and why that one.
pub(crate) struct Chosen {
    /// A GPU, or the twins.
    pub(crate) device: Device,
    /// One phrase.
    pub(crate) reason: String,
}

impl Chosen {
    /// The GPU, where there is one.
    pub(crate) fn gpu(&self) -> Option<&Gpu> {
        match &self.device {
            Device::Gpu(gpu) => Some(gpu),
            Device::Cpu(_) | Device::CpuF64(_) => None,
        }
    }

    /// `gpu` or `cpu`.
    pub(crate) fn kind(&self) -> &'static str {
        if self.gpu().is_some() { "gpu" } else { "cpu" }
    }

    /// The adapter's name, or `cpu`.
    pub(crate) fn name(&self) -> String {
        self.gpu().map_or_else(|| "cpu".into(), |gpu| gpu.info.name.clone())
    }

    /// What it can hold.
    pub(crate) fn limits(&self) -> Limits {
        self.gpu().map_or(Limits::CPU, Limits::from)
    }

    /// What times its passes, or, where they have no times, its runs.
    pub(crate) fn timer(&self) -> Timer {
        match self.gpu().map(Gpu::clock_period_ns) {
            Some(Some(resolution_ns)) => Timer::GpuTimestamp { resolution_ns },
            Some(None) => Timer::Host { resolution_ns: clock_step_ns() },
            None => Timer::CpuClock { resolution_ns: clock_step_ns() },
        }
    }

    /// What to know where passes have no times.
    pub(crate) fn note_on_times(&self) -> Option<String> {
        let why = self.gpu()?.why_no_times()?;
        Some(format!("{why}: passes have no times, a run has the host's, waiting for the adapter included"))
    }

    /// Waits until the device has done everything that it was given, uploads included.
    pub(crate) fn settle(&self) {
        if let Some(gpu) = self.gpu() {
            gpu.submit([]);
            // A lost device is said by whatever uses it next.
            let _ = gpu.device.poll(wgpu::PollType::Wait { submission_index: None, timeout: None });
        }
    }

    /// Waits for a future of the library.
    pub(crate) fn wait<T>(&self, future: impl Future<Output = Result<T, RenderError>>) -> Result<T, Error> {
        Ok(block_on(self.gpu(), future)?)
    }
}

/// The device that the options ask for.
pub(crate) fn choose(args: &DeviceArgs) -> Result<Chosen, Error> {
    let on_gpu = |gpu: Arc<Gpu>, reason: &str| Chosen { device: Device::Gpu(gpu), reason: reason.into() };
    let on_cpu = |reason: String| Chosen { device: Device::Cpu(Some(now_ns)), reason };
    if let Some(name) = &args.adapter {
        if args.device == DeviceKind::Cpu {
            return Err(Error::usage(
                "--adapter names a GPU adapter, and --device cpu uses none: leave one of them out",
            ));
        }
        return Ok(on_gpu(open(&AdapterChoice::Named(name.clone()))?, "--adapter"));
    }
    match args.device {
        DeviceKind::Cpu => Ok(on_cpu("--device cpu".into())),
        DeviceKind::Gpu => Ok(on_gpu(open(&AdapterChoice::Best)?, "--device gpu")),
        DeviceKind::Auto => Ok(match block_on(None, Gpu::new(&AdapterChoice::Best)) {
            Ok(gpu) => {
                let name = gpu.info.name.clone();
                match Device::auto(gpu, Some(now_ns)) {
                    Device::Gpu(gpu) => {
                        check_clock(&gpu)?;
                        on_gpu(gpu, "the best adapter")
                    }
                    device => Chosen {
                        device,
                        reason: format!("the only adapter is software ({name}), the CPU twins are faster"),
                    },
                }
            }
            Err(GpuError::NoAdapter(_)) => on_cpu("no GPU adapter found: the CPU twins".into()),
            Err(error) => on_cpu(format!("{error}: the CPU twins")),
        }),
    }
}

/// What an adapter's clock said beside ours, for files.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct AboutClock {
    device_ns: Option<u64>,
    host_ns: u64,
    /// Whether both are times.
    pub(crate) agrees: bool,
}

impl From<ClockCheck> for AboutClock {
    fn from(check: ClockCheck) -> Self {
        Self { device_ns: check.device_ns, host_ns: check.host_ns, agrees: check.agrees() }
    }
}

impl fmt::Display for AboutClock {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        ClockCheck { device_ns: self.device_ns, host_ns: self.host_ns }.fmt(f)
    }
}

/// Opens an adapter, and finds out whether its clock is one.
pub(crate) fn open(choice: &AdapterChoice) -> Result<Arc<Gpu>, Error> {
    let gpu = block_on(None, Gpu::new(choice))?;
    check_clock(&gpu)?;
    Ok(gpu)
}

/// Compares its clock with ours.
fn check_clock(gpu: &Arc<Gpu>) -> Result<(), Error> {
    Ok(block_on(Some(gpu), gpu.check_clock(now_ns))?)
}

/// Waits for a future. Those of the library become ready only while the device is polled.
pub(crate) fn block_on<T>(gpu: Option<&Gpu>, future: impl Future<Output = T>) -> T {
    let mut future = pin!(future);
    let mut context = Context::from_waker(Waker::noop());
    loop {
        if let Poll::Ready(value) = future.as_mut().poll(&mut context) {
            return value;
        }
        let wait = wgpu::PollType::Wait { submission_index: None, timeout: Some(Duration::from_secs(1)) };
        // An error here is a lost device or a long pass; the future itself says which.
        if gpu.is_none_or(|gpu| gpu.device.poll(wait).is_err()) {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

/// Nanoseconds since the first call.
pub(crate) fn now_ns() -> u64 {
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
    use raystep_kernels::{Options, RaySource, Renderer};
    use raystep_scenes::generate;

    use super::*;

    #[test]
    fn a_device_lost_halfway_is_an_error_and_not_a_hang() {
        let scene = generate::cornell_box();
        let rays = RaySource::Camera { camera: scene.cameras[0].clone(), width: 16, height: 16 };
        let chosen =
            choose(&DeviceArgs { device: DeviceKind::Gpu, adapter: None }).expect("an adapter, if only software");
        let gpu = chosen.gpu().expect("a GPU");
        let options = Options::new(rays);
        let mut renderer = chosen.wait(Renderer::new(&scene, &options, &chosen.device)).expect("a small scene");
        chosen.wait(renderer.step()).expect("a pass");
        gpu.device.destroy();
        let error = loop {
            match chosen.wait(renderer.step()) {
                Ok(Some(_)) => {}
                Ok(None) => panic!("a lost device finished its run"),
                Err(error) => break error.to_string(),
            }
        };
        assert!(error.starts_with("error: the GPU device was lost"), "{error}");
    }

    #[test]
    fn the_clock_moves() {
        assert!(clock_step_ns().is_some_and(|step| step >= 1.0));
    }
}
