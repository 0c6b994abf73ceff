//! The device under test and its description.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Duration;

use raystep_kernels::export::json::AdapterInfo;
use raystep_kernels::plan::Limits;
use raystep_kernels::{AdapterChoice, Device, Gpu, RenderError, Renderer};
use raystep_lab::block_on;
use raystep_lab::machine::now_ns;
use raystep_lab::meter::{Ended, Meter};
use serde::{Deserialize, Serialize};

use crate::args::{AdapterKind, MeasureArgs};

/// `machine.json`
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct About {
    pub(crate) raystep_version: String,
    /// The adapter's name, or the processor's, for display.
    pub(crate) name: String,
    pub(crate) adapter: String,
    pub(crate) backend: String,
    pub(crate) kind: String,
    pub(crate) driver: String,
    pub(crate) timer: String,
    pub(crate) timestamp_period_ns: Option<f64>,
    pub(crate) processor: String,
    pub(crate) cores: usize,
    pub(crate) arguments: String,
    pub(crate) quick: bool,
    /// Section name and how many seconds it took.
    pub(crate) seconds: Vec<(String, f64)>,
}

/// The device.
pub(crate) struct Machine {
    kind: AdapterKind,
    pub(crate) quick: bool,
    meter: Meter,
}

impl Machine {
    pub(crate) fn open(args: &MeasureArgs) -> Result<Self, String> {
        let open = |choice| block_on(None, Gpu::new(&choice)).map_err(|e| e.to_string());
        let device = match args.adapter {
            AdapterKind::Cpu => Device::Cpu(Some(now_ns)),
            AdapterKind::Software => Device::Gpu(open(AdapterChoice::Named("llvmpipe".into()))?),
            AdapterKind::Gpu => {
                let gpu = open(AdapterChoice::Best)?;
                if gpu.info.device_type == wgpu::DeviceType::Cpu {
                    return Err(format!("--adapter gpu: the only adapter is {}, which is software", gpu.info.name));
                }
                Device::Gpu(gpu)
            }
        };
        if let Device::Gpu(gpu) = &device {
            block_on(Some(gpu), gpu.check_clock(now_ns)).map_err(|e| e.to_string())?;
            if let Some(why) = gpu.why_no_times() {
                return Err(format!("{}: {why}", gpu.info.name));
            }
        }
        let machine = raystep_lab::Machine { device, reason: "--adapter".into() };
        Ok(Self { kind: args.adapter, quick: args.quick, meter: Meter::new(machine) })
    }

    /// Keeps the device busy until its clocks are up; what runs next should keep them there.
    pub(crate) fn raise_clocks(&self) {
        if self.is_fast() {
            self.meter.raise_clocks(Duration::from_millis(250));
        }
    }

    /// See [`Meter::keep_clocks`].
    pub(crate) fn keep_clocks(&self) {
        self.wait(self.meter.keep_clocks());
    }

    pub(crate) fn device(&self) -> &Device {
        &self.meter.machine.device
    }

    pub(crate) fn gpu(&self) -> Option<&Arc<Gpu>> {
        match self.device() {
            Device::Gpu(gpu) => Some(gpu),
            _ => None,
        }
    }

    pub(crate) fn limits(&self) -> Limits {
        self.meter.machine.limits()
    }

    /// Whether the device is fast enough for large images.
    pub(crate) fn is_fast(&self) -> bool {
        self.kind == AdapterKind::Gpu
    }

    /// Maximum number of runs per configuration.
    pub(crate) fn repeats(&self) -> usize {
        match (self.quick, self.is_fast()) {
            (true, _) => 3,
            (false, true) => 31,
            (false, false) => 9,
        }
    }

    /// Waits for one of this device's futures.
    pub(crate) fn wait<T>(&self, future: impl Future<Output = T>) -> T {
        self.meter.machine.wait(future)
    }

    /// See [`raystep_lab::Machine::forget_kernels`].
    pub(crate) fn forget_kernels(&self) {
        self.meter.machine.forget_kernels();
    }

    /// Waits until the device is idle, uploads included, so that earlier work is not timed.
    pub(crate) fn settle(&self) {
        self.wait(self.meter.machine.settle());
    }

    /// Runs from the start. Gives up after `most`.
    pub(crate) fn run(&self, renderer: &mut Renderer, most: Duration) -> Result<Ended, RenderError> {
        self.wait(self.meter.run(renderer, |_, spent| match spent > most {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }))
    }

    pub(crate) fn about(&self, args: &MeasureArgs) -> About {
        let processor = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let processor = processor.lines().find_map(|l| l.strip_prefix("model name")?.split_once(": "));
        let processor = processor.map_or(std::env::consts::ARCH, |(_, name)| name).trim().to_owned();
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let info = self.gpu().map(|gpu| AdapterInfo::from(&**gpu));
        let text = |f: fn(&AdapterInfo) -> &String| info.as_ref().map(f).cloned();
        About {
            raystep_version: env!("CARGO_PKG_VERSION").into(),
            name: text(|i| &i.name).unwrap_or_else(|| format!("CPU: {processor}")),
            adapter: text(|i| &i.name).unwrap_or_else(|| "none".into()),
            backend: text(|i| &i.backend).unwrap_or_else(|| "twins".into()),
            kind: text(|i| &i.kind).unwrap_or_else(|| "processor".into()),
            driver: text(|i| &i.driver).unwrap_or_default(),
            timer: if info.is_some() { "gpu_timestamp" } else { "cpu_clock" }.into(),
            timestamp_period_ns: self.gpu().and_then(|gpu| gpu.clock_period_ns()),
            processor,
            cores,
            arguments: args.text.clone(),
            quick: args.quick,
            seconds: Vec::new(),
        }
    }
}
