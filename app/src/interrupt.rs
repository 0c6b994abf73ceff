//! Signals: removes temporary files, then exits.

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Temporary files and folders that currently exist.
static TEMPORARY: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Child processes that currently run.
static CHILDREN: Mutex<Vec<Arc<Mutex<Child>>>> = Mutex::new(Vec::new());

/// Ends child processes, removes temporary files, and exits.
pub(crate) fn end(code: i32) -> ! {
    // Children first: they would write into what is removed. Neither lock is ever released.
    let children = CHILDREN.lock().unwrap_or_else(PoisonError::into_inner);
    for child in children.iter() {
        let mut child = child.lock().unwrap_or_else(PoisonError::into_inner);
        // It may have ended already.
        let _ = child.kill();
        let _ = child.wait();
    }
    // The lock is never released: nothing new is created during exit.
    let temporary = TEMPORARY.lock().unwrap_or_else(PoisonError::into_inner);
    for path in temporary.iter() {
        let _ = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
    }
    leave(code)
}

/// Exits without the exit handlers of libraries, which would conflict with threads that still run.
pub(crate) fn leave(code: i32) -> ! {
    #[cfg(unix)]
    signal_hook::low_level::exit(code);
    #[cfg(not(unix))]
    std::process::exit(code)
}

/// Handles SIGHUP, SIGINT and SIGTERM, except those that the parent process has set to be ignored, as `nohup` and
/// shells that start background jobs do. The exit code is 128 plus the signal's number, as in shells.
///
/// If the handler cannot be installed, a signal ends the program as usual, and may leave a temporary file.
#[cfg(unix)]
pub(crate) fn install() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    let ignored = ignored();
    let handled = [SIGHUP, SIGINT, SIGTERM].into_iter().filter(|&signal| !has(ignored, signal));
    let Ok(mut signals) = Signals::new(handled) else { return };
    std::thread::spawn(move || {
        if let Some(signal) = signals.forever().next() {
            end(128 + signal);
        }
    });
}

/// Handles Ctrl-C.
#[cfg(not(unix))]
pub(crate) fn install() {
    /// The exit code that shells expect after Ctrl-C.
    const INTERRUPTED: i32 = 130;
    let _ = ctrlc::set_handler(|| end(INTERRUPTED));
}

/// A bit for each ignored signal, the lowest for signal 1. Linux reports it in a file; elsewhere only unsafe code could
/// ask, and none is assumed to be ignored.
#[cfg(unix)]
fn ignored() -> u64 {
    let status = if cfg!(target_os = "linux") { fs::read_to_string("/proc/self/status").ok() } else { None };
    status.as_deref().and_then(sig_ign).unwrap_or(0)
}

/// The line `SigIgn` of a process's status.
#[cfg(unix)]
fn sig_ign(status: &str) -> Option<u64> {
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"))?;
    u64::from_str_radix(mask.trim(), 16).ok()
}

#[cfg(unix)]
fn has(mask: u64, signal: i32) -> bool {
    mask >> (signal - 1) & 1 == 1
}

/// Runs a command to its end. An interrupt ends it, too.
pub(crate) fn run(command: &mut Command) -> io::Result<ExitStatus> {
    /// Short against the start of a process.
    const PAUSE: Duration = Duration::from_millis(10);
    let all = || CHILDREN.lock().unwrap_or_else(PoisonError::into_inner);
    let child = {
        let mut children = all();
        let child = Arc::new(Mutex::new(command.spawn()?));
        children.push(child.clone());
        child
    };
    let status = loop {
        // Without a lock held while waiting: an interrupt needs it.
        match child.lock().unwrap_or_else(PoisonError::into_inner).try_wait() {
            Ok(None) => {}
            Ok(Some(status)) => break Ok(status),
            Err(error) => break Err(error),
        }
        std::thread::sleep(PAUSE);
    };
    all().retain(|other| !Arc::ptr_eq(other, &child));
    status
}

/// Creates a file in a temporary folder. No interrupt occurs in between: while removing the folder, it would miss the
/// new file and leave both.
pub(crate) fn create_inside<T>(create: impl FnOnce() -> T) -> T {
    let _temporary = TEMPORARY.lock().unwrap_or_else(PoisonError::into_inner);
    create()
}

/// A temporary file or folder that an interrupt removes, registered when it is created.
pub(crate) struct Temporary<T> {
    /// The file or folder.
    pub(crate) inner: T,
    path: PathBuf,
}

impl<T> Temporary<T> {
    /// Creates it.
    pub(crate) fn create(create: impl FnOnce() -> io::Result<T>, path: impl Fn(&T) -> &Path) -> io::Result<Self> {
        let mut temporary = TEMPORARY.lock().unwrap_or_else(PoisonError::into_inner);
        let inner = create()?;
        let path = path(&inner).to_owned();
        temporary.insert(path.clone());
        Ok(Self { inner, path })
    }

    /// Ends its temporary life: `finish` renames or drops it, without an interrupt in between.
    pub(crate) fn finish<R>(self, finish: impl FnOnce(T) -> R) -> R {
        let mut temporary = TEMPORARY.lock().unwrap_or_else(PoisonError::into_inner);
        let result = finish(self.inner);
        temporary.remove(&self.path);
        result
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn ignored_signals_are_read_from_a_status_as_linux_writes_it() {
        let status =
            "Name:\traystep\nSigBlk:\t0000000000000002\nSigIgn:\t0000000000001001\nSigCgt:\t0000000180000440\n";
        let mask = sig_ign(status).expect("a mask");
        // SIGHUP and SIGPIPE.
        assert_eq!([1, 2, 13, 15].map(|signal| has(mask, signal)), [true, false, true, false]);
        assert_eq!(sig_ign("Name:\traystep\n"), None);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn the_signal_that_rust_ignores_is_seen_to_be_ignored() {
        assert!(has(ignored(), signal_hook::consts::SIGPIPE));
    }
}
