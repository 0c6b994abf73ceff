//! Files that a scene refers to: those in its folder and below, unless the user permits others.

use std::cell::RefCell;
use std::fs;
use std::path::{Component, Path, PathBuf};

use raystep_scenes::{FileError, Resolver};

use super::read_file;
use crate::error::reason;
use crate::output::folder_of;

/// Reads the files that a scene refers to.
pub(super) struct Beside {
    /// With links resolved, for comparison.
    folder: PathBuf,
    allow_outside: bool,
    /// Files read so far, by the names under which they were found.
    read: RefCell<Vec<PathBuf>>,
}

impl Beside {
    /// The files beside the scene at `path`. If the scene's own name is a link, they are relative to the link.
    pub(super) fn new(path: &Path, allow_outside: bool) -> Result<Self, String> {
        let folder = fs::canonicalize(folder_of(path)).map_err(|e| reason(&e))?;
        Ok(Self { folder, allow_outside, read: RefCell::default() })
    }

    /// The scene's file and those that were read, by their names in its folder.
    pub(super) fn into_read(self, scene: &Path) -> Vec<PathBuf> {
        let scene = scene.file_name().map_or_else(|| scene.to_owned(), |name| self.folder.join(name));
        [vec![scene], self.read.into_inner()].concat()
    }

    /// The path of a file that is named relative to the folder, if it is permitted.
    pub(super) fn find(&self, path: &str) -> Result<PathBuf, FileError> {
        let relative = Path::new(path);
        // On Windows, a drive without a root also leaves the folder.
        if relative.components().any(|part| matches!(part, Component::Prefix(_) | Component::RootDir)) {
            return Err("an absolute path; expected one relative to the file that names it".into());
        }
        self.place(relative)
    }

    /// The path of a file after resolving links, if it is permitted.
    fn place(&self, relative: &Path) -> Result<PathBuf, FileError> {
        let path = self.folder.join(relative);
        let found = fs::canonicalize(&path);
        if self.allow_outside {
            return found.map_err(|e| reason(&e).into());
        }
        // For a missing file, its nearest existing folder decides, so that nothing is revealed about files outside.
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
        let bytes = read_file(&self.find(path)?, max_bytes)?;
        self.read.borrow_mut().push(self.folder.join(path));
        Ok(bytes)
    }
}
