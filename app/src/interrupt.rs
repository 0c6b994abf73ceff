//! Ctrl-C: what has been written under a temporary name is removed, then the program ends.

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Temporary files and folders that exist now.
static TEMPORARY: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// What a shell expects of a program that SIGINT ended.
const INTERRUPTED: i32 = 130;

/// Handles SIGINT, SIGTERM and SIGHUP from now on.
pub(crate) fn install() {
    // Where it cannot be installed, Ctrl-C ends the program as ever and may leave a temporary file.
    let _ = ctrlc::set_handler(|| {
        // The lock is never given back: nothing new is created while the program ends.
        let temporary = TEMPORARY.lock().unwrap_or_else(PoisonError::into_inner);
        for path in temporary.iter() {
            let _ = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
        }
        std::process::exit(INTERRUPTED);
    });
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
