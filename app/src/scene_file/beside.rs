//! The files beside a scene: those in its folder and below it, unless the user lets it read others.

use std::cell::RefCell;
use std::fs;
use std::path::{Component, Path, PathBuf};

use raystep_scenes::{FileError, Resolver};

use super::read_file;
use crate::output::{folder_of, reason};

/// Reads the files that a scene names.
pub(super) struct Beside {
    /// Without links on the way, so that it can be compared.
    folder: PathBuf,
    allow_outside: bool,
    /// What was read so far.
    read: RefCell<Vec<PathBuf>>,
}

impl Beside {
    /// The files beside the scene at `path`. Where the scene's own name is a link, they are looked for beside the
    /// link.
    pub(super) fn new(path: &Path, allow_outside: bool) -> Result<Self, String> {
        let folder = fs::canonicalize(folder_of(path)).map_err(|e| reason(&e))?;
        Ok(Self { folder, allow_outside, read: RefCell::default() })
    }

    /// The files that were read.
    pub(super) fn into_read(self) -> Vec<PathBuf> {
        self.read.into_inner()
    }

    /// Where a file is once all links are followed, if that is where it may be.
    fn place(&self, relative: &Path) -> Result<PathBuf, FileError> {
        let path = self.folder.join(relative);
        let found = fs::canonicalize(&path);
        if self.allow_outside {
            return found.map_err(|e| reason(&e).into());
        }
        // Of what is missing, its nearest folder decides: what lies outside is not said to exist or not.
        let known = match &found {
            Ok(path) => Some(path.clone()),
            Err(_) => path.ancestors().skip(1).find_map(|path| fs::canonicalize(path).ok()),
        };
        if !known.is_some_and(|path| path.starts_with(&self.folder)) {
            return Err(FileError::Outside { folder: self.folder.display().to_string() });
        }
        found.map_err(|e| reason(&e).into())
    }
}

impl Resolver for Beside {
    fn read(&self, path: &str, max_bytes: u64) -> Result<Vec<u8>, FileError> {
        let relative = Path::new(path);
        // A drive alone makes a path that is not relative to the folder either.
        if relative.components().any(|part| matches!(part, Component::Prefix(_) | Component::RootDir)) {
            return Err("an absolute path; one relative to the scene is wanted".into());
        }
        let path = self.place(relative)?;
        let bytes = read_file(&path, max_bytes)?;
        self.read.borrow_mut().push(path);
        Ok(bytes)
    }
}
