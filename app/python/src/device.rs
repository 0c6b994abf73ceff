//! Devices: each is opened once in a process.

use std::ffi::OsString;
use std::sync::{Mutex, PoisonError};

use pyo3::prelude::*;
use raystep_lab::Machine;

use crate::error::of_device;

/// The devices that are open, by kind and adapter.
static OPEN: Mutex<Vec<(Vec<OsString>, Machine)>> = Mutex::new(Vec::new());

/// The device of `--device` and `--adapter`. One that was lost is opened again.
pub(crate) fn choose(device: &str, adapter: Option<&str>) -> PyResult<Machine> {
    let mut words = vec![OsString::from(format!("--device={device}"))];
    words.extend(adapter.map(|name| OsString::from(format!("--adapter={name}"))));
    let mut open = OPEN.lock().unwrap_or_else(PoisonError::into_inner);
    open.retain(|(_, machine)| machine.gpu().is_none_or(|gpu| gpu.health().is_ok()));
    if let Some((_, machine)) = open.iter().find(|(of, _)| *of == words) {
        return Ok(machine.clone());
    }
    let machine = raystep_app::api::open(&words).map_err(of_device)?;
    open.push((words, machine.clone()));
    Ok(machine)
}
