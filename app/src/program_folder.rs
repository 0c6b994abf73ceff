//! Reads the folders of users' programs.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use raystep_kernels::options::folder::Folder;
use raystep_kernels::programs::own::{self, Own};
use raystep_lab::text::visible;
use raystep_lab::zipped;
use raystep_scenes::ENDINGS;

use crate::error::{Error, reason};
use crate::scene_file::bytes_of;

/// Most folders inside of each other that are looked through for WGSL files.
const MOST_DEPTH: usize = 4;

/// A program's folder, and the scene that it is to read.
pub(crate) struct Found {
    pub(crate) folder: PathBuf,
    pub(crate) scene: Option<PathBuf>,
}

/// The program that a path names: a folder, its `program.toml`, or one of these with a scene as in `my-program@teapot`.
pub(crate) fn find(path: &Path) -> Option<Found> {
    if let Some(folder) = folder_of(path) {
        return Some(Found { folder, scene: None });
    }
    let (folder, scene) = path.to_str()?.rsplit_once('@')?;
    Some(Found { folder: folder_of(Path::new(folder))?, scene: Some(scene.into()) })
}

/// The folder that a path names, itself or by its `program.toml`; or a zip file of one.
fn folder_of(path: &Path) -> Option<PathBuf> {
    if is_zip(path) && path.is_file() {
        return Some(path.to_owned());
    }
    let is_manifest = path.file_name().is_some_and(|name| name == Folder::MANIFEST);
    let folder = match is_manifest {
        true => path.parent().map(|parent| if parent.as_os_str().is_empty() { Path::new(".") } else { parent })?,
        false => path,
    };
    folder.join(Folder::MANIFEST).is_file().then(|| folder.to_owned())
}

fn is_zip(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("zip"))
}

/// Reads what a program consists of: `program.toml`, all WGSL files, and the files that `program.toml` names. Also returns
/// their paths.
pub(crate) fn read(folder: &Path) -> Result<(Folder, Vec<PathBuf>), Error> {
    let failed = |why: &dyn std::fmt::Display| Error::at(folder, why);
    if is_zip(folder) {
        let bytes = bytes_of(folder, Folder::MOST_BYTES)?;
        let read = zipped::folder(&visible(&folder.to_string_lossy()), &bytes).map_err(|why| failed(&why))?;
        return Ok((read, vec![folder.to_owned()]));
    }
    let full = fs::canonicalize(folder).map_err(|e| failed(&reason(&e)))?;
    let mut paths = vec![Folder::MANIFEST.to_owned()];
    wgsl_files(folder, "", 0, &mut paths)?;
    let manifest = bytes_of(&folder.join(Folder::MANIFEST), Folder::MOST_BYTES)?;
    let text = String::from_utf8_lossy(&manifest);
    // Any string of it may be a file's name.
    for quoted in text.split(['"', '\'']) {
        // A scene is read for its triangles, not as a part of the program.
        let is_scene = ENDINGS.iter().any(|ending| quoted.ends_with(&format!(".{ending}")));
        let is_new = Folder::is_inside(quoted)
            && !is_scene
            && !quoted.contains(['\n', '\r'])
            && !paths.iter().any(|p| p == quoted);
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

/// The file of the scene that a program reads, if it reads one.
pub(crate) fn scene_of(found: &Found, own: &Own) -> Result<Option<PathBuf>, Error> {
    let place = found.folder.display();
    match (&own.scene, &found.scene) {
        (None, None) => Ok(None),
        (None, Some(scene)) => Err(Error::usage(format!(
            "{place} reads no scene; remove @{}, or add a table [scene] to program.toml",
            scene.display()
        ))),
        (Some(_), Some(scene)) => Ok(Some(scene.clone())),
        (Some(of), None) => match &of.file {
            Some(file) if Folder::is_inside(file) && found.folder.join(file).is_file() => {
                Ok(Some(found.folder.join(file)))
            }
            Some(name) if !name.contains(['/', '\\']) => Ok(Some(name.into())),
            Some(file) => Err(Error::failed(format!("{place}/program.toml: no file {file} is in the folder"))),
            None => Err(Error::usage(format!("{place} reads a scene: name one, as in {place}@cornell-box"))),
        },
    }
}

/// The program in a folder.
pub(crate) fn own(folder: &Path) -> Result<Arc<Own>, Error> {
    program(&Arc::new(read(folder)?.0))
}
