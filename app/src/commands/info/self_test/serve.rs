//! The process that has the device: it does the steps that it is asked for, one by one.
//!
//! | request | answer, a line of JSON |
//! |---|---|
//! | none: at the start | `{"opened":{…}}`, the adapter; or `{"refused":"…"}`, and the program ends |
//! | a step's number | `{"done":{…}}`; the program ends if the device does not work any more |
//! | end of input | none: the program ends |

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io::{self, BufRead as _, Write as _};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::Instant;

use raystep_kernels::export::json::AdapterInfo;
use raystep_kernels::{AdapterChoice, Gpu};
use raystep_lab::block_on;
use raystep_lab::self_test::{Bench, Faults, Outcome, steps};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::error::{Error, FAILED};
use crate::process::this_program;
use crate::{interrupt, threads};

/// An answer, as a line of JSON.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Answer {
    Opened(Value),
    Refused(String),
    Done(Box<Outcome>),
}

impl Answer {
    fn say(&self) -> Result<(), Error> {
        let line = serde_json::to_string(self).map_err(Error::failed)?;
        let mut out = io::stdout().lock();
        writeln!(out, "{line}").and_then(|()| out.flush()).map_err(Error::failed)
    }
}

/// The command line of such a process.
pub(super) fn words(adapter: Option<&str>, run_id: &str) -> Result<Vec<OsString>, Error> {
    let mut words = this_program()?;
    words.extend(["info", "--self-test", "--serve", run_id].map(OsString::from));
    words.extend(adapter.into_iter().flat_map(|name| ["--adapter".into(), name.into()]));
    Ok(words)
}

pub(super) fn serve(adapter: Option<&str>, run_id: &str) -> Result<(), Error> {
    let requests = requests();
    let choice = adapter.map_or(AdapterChoice::Best, |name| AdapterChoice::Named(name.to_owned()));
    let gpu = match block_on(None, Gpu::new(&choice)) {
        Ok(gpu) => gpu,
        Err(error) => return Answer::Refused(error.to_string()).say(),
    };
    threads::keep(&gpu);
    Answer::Opened(about(&gpu)).say()?;
    let (steps, mut bench) = (steps(), Bench::new(gpu, run_id.to_owned(), Faults::default()));
    for request in requests {
        let Some(step) = request.trim().parse().ok().and_then(|index: usize| steps.get(index)) else {
            return Err(Error::failed(format!("--serve: {request:?} is no step")));
        };
        let begin = Instant::now();
        let run = catch_unwind(AssertUnwindSafe(|| step.run(&mut bench)));
        let outcome = run.unwrap_or_else(|panic| {
            let message = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
            let why = format!("the program panicked: {}", message.unwrap_or("without a message"));
            Outcome::failed(step, &why, begin.elapsed().as_secs_f64())
        });
        let is_lost = outcome.is_device_lost;
        Answer::Done(Box::new(outcome)).say()?;
        if is_lost {
            break;
        }
    }
    Ok(())
}

/// Lines of standard input. The process ends with it, also in a step: nobody waits for the answer.
fn requests() -> Receiver<String> {
    let (lines, requests) = channel();
    std::thread::spawn(move || {
        for line in io::stdin().lock().lines().map_while(Result::ok) {
            if lines.send(line).is_err() {
                return;
            }
        }
        interrupt::end(FAILED.into());
    });
    requests
}

/// What there is to know about an adapter.
fn about(gpu: &Arc<Gpu>) -> Value {
    let info = &gpu.info;
    let (limits, features) = match &gpu.source {
        Some(source) => (source.adapter.limits(), source.adapter.features()),
        None => (gpu.device.limits(), gpu.device.features()),
    };
    let features: Vec<&str> = features.iter_names().map(|(name, _)| name).collect();
    json!({
        "adapter": AdapterInfo::from(&**gpu),
        "vendor_id": format!("{:#06x}", info.vendor),
        "device_id": format!("{:#06x}", info.device),
        "limits": fields(&format!("{limits:?}")),
        "features": features,
    })
}

/// The numbers in a value's debug text, `Limits { a: 1, b: 2 }`.
fn fields(debug: &str) -> BTreeMap<String, u64> {
    let inner = debug.split_once('{').and_then(|(_, rest)| rest.rsplit_once('}')).map_or("", |(inner, _)| inner);
    let field = |text: &str| {
        text.split_once(':').and_then(|(name, value)| Some((name.trim().into(), value.trim().parse().ok()?)))
    };
    inner.split(',').filter_map(field).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_read_from_their_debug_text() {
        let limits = fields(&format!("{:?}", wgpu::Limits::default()));
        assert_eq!(limits.get("max_texture_dimension_2d"), Some(&8192));
        assert!(limits.len() > 20, "{limits:?}");
    }
}
