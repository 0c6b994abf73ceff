//! The last error that libraries logged: where a window cannot be opened, eframe says why nowhere else.

use std::sync::{Mutex, PoisonError};

use log::{Level, LevelFilter, Log, Metadata, Record};

struct LastError(Mutex<Option<String>>);

static LAST: LastError = LastError(Mutex::new(None));

impl Log for LastError {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.level() == Level::Error
    }

    fn log(&self, record: &Record<'_>) {
        if self.enabled(record.metadata()) {
            *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(record.args().to_string());
        }
    }

    fn flush(&self) {}
}

/// From now on.
pub(super) fn listen() {
    if log::set_logger(&LAST).is_ok() {
        log::set_max_level(LevelFilter::Error);
    }
}

/// The last one since, in one line.
pub(super) fn take() -> Option<String> {
    let last = LAST.0.lock().unwrap_or_else(PoisonError::into_inner).take()?;
    let line = last.split_whitespace().collect::<Vec<_>>().join(" ");
    Some(line.trim_start_matches("Exiting because of error: ").to_owned())
}
