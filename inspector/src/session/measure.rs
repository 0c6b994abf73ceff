//! Measuring choices: which structure, schedule and rules a view of a scene should be traced with.

use std::pin::Pin;
use std::sync::Arc;

use raystep_kernels::Device;
use raystep_lab::meter::Meter;
use raystep_lab::report::{self, Answer, Extent};
use raystep_lab::reporter::Reporter;
use raystep_lab::subject::Subject;
use raystep_lab::{Error, Machine};

/// What to measure.
pub struct Measurement {
    /// The scene and the view.
    pub subject: Subject,
    /// Its size, and how thoroughly.
    pub extent: Extent,
    /// Shows what is known so far.
    pub ready: Arc<dyn Fn(Answer) + Send + Sync>,
    /// Where passes run: the session's device, but in f32.
    pub device: Device,
}

/// The future of an answer; the error is one line.
pub type Measuring<'a> = Pin<Box<dyn Future<Output = Result<Answer, String>> + Send + 'a>>;

/// Measures choices as a part of the engine's task.
pub type Measure = Arc<dyn for<'a> Fn(Measurement, &'a dyn Reporter) -> Measuring<'a> + Send + Sync>;

/// Measures on the session's device: for a host that has no other one. Where passes have times of their own, what the
/// window draws between them is not part of these.
#[must_use]
pub fn on_its_device() -> Measure {
    Arc::new(|measurement, reporter| {
        Box::pin(async move {
            let machine = machine(measurement.device.clone());
            let has_times = machine.timer().times_passes();
            let mut answer = measured(measurement, reporter).await.map_err(|error| error.to_string())?;
            if !has_times {
                answer.notes.push("Times include what the window drew meanwhile.".into());
            }
            Ok(answer)
        })
    })
}

/// Measures on the given device.
///
/// # Errors
/// If the device fails, nothing could be measured, or it was cancelled.
pub async fn measured(measurement: Measurement, reporter: &dyn Reporter) -> Result<Answer, Error> {
    let Measurement { subject, extent, ready, device } = measurement;
    let meter = Meter::new(machine(device));
    report::answer(subject, extent, &meter, reporter, &*ready).await
}

fn machine(device: Device) -> Machine {
    Machine { device, reason: "as in the inspector".into() }
}
