//! The last errors logged by libraries: eframe and rfd only log why a window or a file dialog cannot be opened.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use log::{Level, LevelFilter, Log, Metadata, Record};

/// By crate.
struct LastErrors(Mutex<BTreeMap<String, String>>);

static LAST: LastErrors = LastErrors(Mutex::new(BTreeMap::new()));

impl Log for LastErrors {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.level() == Level::Error
    }

    fn log(&self, record: &Record<'_>) {
        if self.enabled(record.metadata()) {
            let library = record.target().split(':').next().unwrap_or_default().to_owned();
            self.0.lock().unwrap_or_else(PoisonError::into_inner).insert(library, record.args().to_string());
        }
    }

    fn flush(&self) {}
}

/// Installs the logger.
pub(super) fn listen() {
    if log::set_logger(&LAST).is_ok() {
        log::set_max_level(LevelFilter::Error);
    }
}

/// The last error of a library since then, in one line.
pub(super) fn take_of(library: &str) -> Option<String> {
    let last = LAST.0.lock().unwrap_or_else(PoisonError::into_inner).remove(library)?;
    Some(last.split_whitespace().collect::<Vec<_>>().join(" "))
}
