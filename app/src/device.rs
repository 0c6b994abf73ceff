//! Selects the device, and waits for it.

use std::fmt;
use std::sync::Arc;

use raystep_kernels::{AdapterChoice, ClockCheck, Device, Gpu, GpuError};
use raystep_lab::machine::now_ns;
use raystep_lab::{Machine, block_on};
use serde::Serialize;

use crate::args::{DeviceArgs, DeviceKind};
use crate::error::Error;
use crate::{drawing, threads};

/// The device for the given options.
pub(crate) fn choose(args: &DeviceArgs) -> Result<Machine, Error> {
    let on_gpu = |gpu: Arc<Gpu>, reason: &str| Machine { device: Device::Gpu(gpu), reason: reason.into() };
    let on_cpu = |reason: String| Machine { device: Device::Cpu(Some(now_ns)), reason };
    if let Some(name) = &args.adapter {
        if args.device == DeviceKind::Cpu {
            return Err(Error::usage("--adapter names a GPU adapter, but --device cpu uses none: omit one of them"));
        }
        return Ok(on_gpu(open(&AdapterChoice::Named(name.clone()))?, "--adapter"));
    }
    match args.device {
        DeviceKind::Cpu => Ok(on_cpu("--device cpu".into())),
        DeviceKind::Gpu => Ok(on_gpu(open(&AdapterChoice::Best)?, "--device gpu")),
        DeviceKind::Auto | DeviceKind::GpuFirst => Ok(match block_on(None, Gpu::new(&AdapterChoice::Best)) {
            Ok(gpu) => {
                let name = gpu.info.name.clone();
                let device = match args.device {
                    DeviceKind::GpuFirst => Device::Gpu(gpu),
                    _ => Device::auto(gpu, Some(now_ns)),
                };
                match device {
                    Device::Gpu(gpu) => {
                        check_clock(&gpu)?;
                        on_gpu(gpu, "the best adapter")
                    }
                    device => {
                        Machine { device, reason: format!("the only adapter is software ({name}); the CPU is faster") }
                    }
                }
            }
            Err(GpuError::NoAdapter(_)) => on_cpu("no GPU adapter found; using the CPU".into()),
            Err(error) => on_cpu(format!("{error}; using the CPU")),
        }),
    }
}

/// Comparison of an adapter's clock with the host's, for files.
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

/// Opens an adapter, and checks its clock, and what it draws.
pub(crate) fn open(choice: &AdapterChoice) -> Result<Arc<Gpu>, Error> {
    let gpu = block_on(None, Gpu::new(choice))?;
    check_clock(&gpu)?;
    block_on(Some(&gpu), drawing::check(&gpu))?;
    Ok(gpu)
}

/// The same without blocking.
pub(crate) async fn opening(choice: &AdapterChoice) -> Result<Arc<Gpu>, Error> {
    let gpu = Gpu::new(choice).await?;
    threads::keep(&gpu);
    gpu.check_clock(now_ns).await?;
    drawing::check(&gpu).await?;
    Ok(gpu)
}

/// Compares its clock with the host's.
fn check_clock(gpu: &Arc<Gpu>) -> Result<(), Error> {
    threads::keep(gpu);
    Ok(block_on(Some(gpu), gpu.check_clock(now_ns))?)
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
        assert!(error.starts_with("the GPU device was lost"), "{error}");
    }
}
