//! Ctrl-C, and being told to end: what has been written under a temporary name is removed, then the program ends.

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Temporary files and folders that exist now.
static TEMPORARY: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Takes away what is half-written, and ends.
fn end(code: i32) -> ! {
    // The lock is never given back: nothing new is created while the program ends.
    let temporary = TEMPORARY.lock().unwrap_or_else(PoisonError::into_inner);
    for path in temporary.iter() {
        let _ = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
    }
    #[cfg(unix)]
    // At once: what libraries do at an ordinary exit would meet their own threads, which still work.
    signal_hook::low_level::exit(code);
    #[cfg(not(unix))]
    std::process::exit(code)
}

/// Handles SIGHUP, SIGINT and SIGTERM from now on, but for those that whoever started the program has it ignore, as
/// `nohup` does and a shell that starts it in the background. The exit code is the one that shells give such an end:
/// 128 and the signal's number.
///
/// Where it cannot be installed, a signal ends the program as ever, and may leave a temporary file.
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

/// Handles Ctrl-C from now on.
#[cfg(not(unix))]
pub(crate) fn install() {
    /// What shells expect of a program that Ctrl-C ended.
    const INTERRUPTED: i32 = 130;
    let _ = ctrlc::set_handler(|| end(INTERRUPTED));
}

/// A bit for each signal that is ignored now, the lowest for signal 1. Linux says it in a file; elsewhere only unsafe
/// code could ask, and none is taken to be ignored.
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

/// Creates a file in a temporary folder: no interrupt comes in between, as one that is removing the folder
/// would not see the new file and leave both.
pub(crate) fn create_inside<T>(create: impl FnOnce() -> T) -> T {
    let _temporary = TEMPORARY.lock().unwrap_or_else(PoisonError::into_inner);
    create()
}

/// A temporary file or folder that an interrupt removes. It is known from the moment it exists.
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

    /// Ends its temporary life: `finish` renames it or lets it drop, and no interrupt comes in between.
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
