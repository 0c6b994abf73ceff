//! What an engine runs on.

use std::sync::Arc;

use raystep_kernels::{Device, Gpu};

use super::measure::Measure;
use crate::settings::DeviceKind;

/// The devices of an engine.
#[derive(Clone)]
pub struct Devices {
    /// The adapter that the window renders with.
    pub gpu: Arc<Gpu>,
    /// A clock in nanoseconds, to time the CPU reference's passes.
    pub clock: Option<fn() -> u64>,
    /// Measures choices.
    pub measure: Measure,
    /// Called after every answer, to wake the user interface.
    pub wake: Arc<dyn Fn() + Send + Sync>,
}

impl Devices {
    /// The device of this kind.
    #[must_use]
    pub fn of(&self, kind: DeviceKind) -> Device {
        match kind {
            DeviceKind::Auto => Device::auto(self.gpu.clone(), self.clock),
            DeviceKind::Gpu => Device::Gpu(self.gpu.clone()),
            DeviceKind::Cpu => Device::Cpu(self.clock),
            DeviceKind::CpuF64 => Device::CpuF64(self.clock),
        }
    }
}
