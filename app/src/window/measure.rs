//! Measures choices for the inspector, on a GPU device of its own: on the window's, frames would be drawn between the
//! runs, on the same queue.

use std::sync::{Arc, Mutex, PoisonError};

use raystep_inspector::session::measure::{Measure, Measurement, measured};
use raystep_kernels::{AdapterChoice, Device, Gpu};

use crate::device;
use crate::error::Error;

/// A measurement on the window's adapter, or on the CPU.
pub(super) fn measure(adapter: String) -> Measure {
    let own = Arc::new(Own { choice: AdapterChoice::Named(adapter), kept: Mutex::default() });
    Arc::new(move |measurement, reporter| {
        let own = own.clone();
        Box::pin(async move {
            let line = |error: Error| error.message().to_owned();
            let device = match measurement.device {
                Device::Gpu(_) => Device::Gpu(own.device().await.map_err(line)?),
                Device::Cpu(_) | Device::CpuF64(_) => measurement.device,
            };
            measured(Measurement { device, ..measurement }, reporter).await.map_err(|error| error.to_string())
        })
    })
}

/// The device of measurements.
struct Own {
    choice: AdapterChoice,
    /// Opened once: a device lives as long as the program.
    kept: Mutex<Option<Arc<Gpu>>>,
}

impl Own {
    /// Opens it, unless it is open. Its own thread polls it.
    async fn device(&self) -> Result<Arc<Gpu>, Error> {
        let kept = || self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let open = kept().clone().filter(|gpu| gpu.health().is_ok());
        if let Some(gpu) = open {
            return Ok(gpu);
        }
        let gpu = device::opening(&self.choice).await?;
        *kept() = Some(gpu.clone());
        Ok(gpu)
    }
}
