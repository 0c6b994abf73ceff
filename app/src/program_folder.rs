//! Reads the folders of users' programs.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use raystep_kernels::options::folder::Folder;
use raystep_kernels::programs::own::{self, Own};
use raystep_lab::text::visible;

use crate::error::{Error, reason};
use crate::scene_file::bytes_of;

/// Most folders inside of each other that are looked through for WGSL files.
const MOST_DEPTH: usize = 4;

/// The folder that a path names, itself or by its `program.toml`.
pub(crate) fn find(path: &Path) -> Option<PathBuf> {
    let is_manifest = path.file_name().is_some_and(|name| name == Folder::MANIFEST);
    let folder = match is_manifest {
        true => path.parent().map(|parent| if parent.as_os_str().is_empty() { Path::new(".") } else { parent })?,
        false => path,
    };
    folder.join(Folder::MANIFEST).is_file().then(|| folder.to_owned())
}

/// Reads what a program consists of: `program.toml`, all WGSL files, and the files that `program.toml` names. Also returns
/// their paths.
pub(crate) fn read(folder: &Path) -> Result<(Folder, Vec<PathBuf>), Error> {
    let failed = |why: &dyn std::fmt::Display| Error::at(folder, why);
    let full = fs::canonicalize(folder).map_err(|e| failed(&reason(&e)))?;
    let mut paths = vec![Folder::MANIFEST.to_owned()];
    wgsl_files(folder, "", 0, &mut paths)?;
    let manifest = bytes_of(&folder.join(Folder::MANIFEST), Folder::MOST_BYTES)?;
    let text = String::from_utf8_lossy(&manifest);
    // Any string of it may be a file's name.
    for quoted in text.split(['"', '\'']) {
        let is_new = Folder::is_inside(quoted) && !quoted.contains(['\n', '\r']) && !paths.iter().any(|p| p == quoted);
        if is_new && folder.join(quoted).is_file() {
            paths.push(quoted.to_owned());
        }
    }
    let mut files = BTreeMap::new();
    let mut left = Folder::MOST_BYTES;
    for path in &paths {
        let bytes = bytes_of(&folder.join(path), left)?;
        left = left.saturating_sub(bytes.len() as u64);
        files.insert(path.clone(), bytes);
    }
    let name = full.file_name().unwrap_or_default().to_string_lossy();
    let read = Folder::new(visible(&name).into_owned(), folder.to_string_lossy().into_owned(), files);
    let read = read.map_err(|why| failed(&why))?;
    Ok((read, paths.iter().map(|path| folder.join(path)).collect()))
}

/// Adds the paths of the WGSL files in a folder and in those in it.
fn wgsl_files(folder: &Path, inside: &str, depth: usize, paths: &mut Vec<String>) -> Result<(), Error> {
    let at = folder.join(inside);
    let failed = |why: &dyn std::fmt::Display| Error::at(&at, why);
    let mut entries = Vec::new();
    for entry in fs::read_dir(&at).map_err(|e| failed(&reason(&e)))? {
        let entry = entry.map_err(|e| failed(&reason(&e)))?;
        let Ok(name) = entry.file_name().into_string() else { continue };
        entries.push((name, entry.path()));
    }
    entries.sort();
    for (name, path) in entries {
        let inner = if inside.is_empty() { name.clone() } else { format!("{inside}/{name}") };
        if paths.len() > Folder::MOST_FILES {
            return Err(failed(&format!("more than {} files are too many for a program", Folder::MOST_FILES)));
        }
        if path.is_dir() {
            if depth < MOST_DEPTH && !name.starts_with('.') {
                wgsl_files(folder, &inner, depth + 1, paths)?;
            }
        } else if name.ends_with(".wgsl") {
            paths.push(inner);
        }
    }
    Ok(())
}

/// The program of these files.
pub(crate) fn program(folder: &Arc<Folder>) -> Result<Arc<Own>, Error> {
    own::read(folder).map_err(|mistake| Error::from(&*mistake))
}

/// The program in a folder.
pub(crate) fn own(folder: &Path) -> Result<Arc<Own>, Error> {
    program(&Arc::new(read(folder)?.0))
}
