//! Measures choices for the inspector, on a device of its own: waiting for the window's would hold up its drawing.

use std::sync::Arc;

use raystep_inspector::session::measure::{Measure, Measurement};
use raystep_inspector::settings::DeviceKind;
use raystep_kernels::{AdapterChoice, Device, Gpu};
use raystep_lab::machine::now_ns;
use raystep_lab::meter::Meter;
use raystep_lab::{Machine, report};

use crate::device;

/// A measurement on the window's adapter, or on the CPU.
pub(super) fn measure(adapter: String) -> Measure {
    let kept: Arc<std::sync::Mutex<Option<Arc<Gpu>>>> = Arc::default();
    Arc::new(move |measurement, reporter| {
        let Measurement { subject, size, grid, is_quick, device } = measurement;
        let device = match device {
            DeviceKind::Gpu => {
                // Opened once: a device lives as long as the program.
                let mut kept =
                    kept.lock().map_err(|_| "an earlier measurement failed: open the scene in a new window")?;
                let gpu = match &*kept {
                    Some(gpu) if gpu.health().is_ok() => gpu.clone(),
                    _ => {
                        let choice = AdapterChoice::Named(adapter.clone());
                        device::open(&choice).map_err(|e| e.message().to_owned())?
                    }
                };
                *kept = Some(gpu.clone());
                Device::Gpu(gpu)
            }
            DeviceKind::Auto | DeviceKind::Cpu | DeviceKind::CpuF64 => Device::Cpu(Some(now_ns)),
        };
        let meter = Meter::new(Machine { device, reason: "as in the inspector".into() });
        report::answer(subject, size, grid, is_quick, &meter, reporter).map_err(|e| e.to_string())
    })
}
