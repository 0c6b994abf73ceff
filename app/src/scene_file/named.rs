//! Scenes by name: those in a folder that the host of the program brings along.

use std::fs;
use std::path::{Component, Path, PathBuf};
use std::sync::OnceLock;

use raystep_scenes::ENDINGS;

use crate::commands::extension;
use crate::error::Error;
use crate::usage::did_you_mean;

/// The folder that the host has named.
static FOLDER: OnceLock<PathBuf> = OnceLock::new();

/// Names the folder; the first call counts.
pub(crate) fn set_folder(folder: PathBuf) {
    let _ = FOLDER.set(folder);
}

/// The folder: the host's, otherwise one that is installed with the executable.
fn folder() -> Option<PathBuf> {
    if let Some(folder) = FOLDER.get() {
        return Some(folder.clone());
    }
    let executable = std::env::current_exe().ok()?;
    let beside = executable.parent()?;
    ["scenes", "../share/raystep/scenes"].map(|name| beside.join(name)).into_iter().find(|folder| folder.is_dir())
}

/// The name, if a path is one: a word that is no file's, without a folder or the ending of a scene.
fn name_of(path: &Path) -> Option<&str> {
    let mut parts = path.components();
    let (Some(Component::Normal(name)), None) = (parts.next(), parts.next()) else { return None };
    let is_file = ENDINGS.contains(&extension(path).as_str()) || path.exists();
    name.to_str().filter(|name| !is_file && path.as_os_str().len() == name.len())
}

fn find_in(folder: &Path, name: &str) -> Option<PathBuf> {
    ENDINGS.map(|ending| folder.join(format!("{name}.{ending}"))).into_iter().find(|path| path.is_file())
}

/// The names of all scenes in a folder, sorted.
fn names_in(folder: &Path) -> Vec<String> {
    let paths = fs::read_dir(folder).into_iter().flatten().filter_map(|entry| Some(entry.ok()?.path()));
    let scenes = paths.filter(|path| ENDINGS.contains(&extension(path).as_str()));
    let mut names: Vec<String> =
        scenes.filter_map(|path| Some(path.file_stem()?.to_string_lossy().into_owned())).collect();
    names.sort();
    names
}

/// Whether a path is the name of a scene that there is.
pub(crate) fn is_known(path: &Path) -> bool {
    name_of(path).zip(folder()).is_some_and(|(name, folder)| find_in(&folder, name).is_some())
}

/// The file that a path or name stands for. A file that exists is itself, whatever scenes there are.
pub(crate) fn file_of(path: &Path) -> Result<PathBuf, Error> {
    let installed = || folder().filter(|folder| folder.is_dir());
    let Some((name, folder)) = name_of(path).zip(installed()) else {
        // Examples name the repository's files, which others do not have.
        let stem = path.file_stem().and_then(|stem| stem.to_str()).filter(|_| !path.exists());
        return match stem.filter(|stem| installed().is_some_and(|folder| find_in(&folder, stem).is_some())) {
            Some(stem) => {
                let at = path.display();
                Err(Error::failed(format!("{at}: No such file; the installed scene opens by its name, {stem}")))
            }
            None => Ok(path.to_owned()),
        };
    };
    find_in(&folder, name).ok_or_else(|| {
        let names = names_in(&folder);
        let near = did_you_mean(name, &names);
        Error::failed(format!("{name}: no such file, nor a scene of this name; {near}scenes: {}", names.join(", ")))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_a_word_that_is_no_file() {
        for name in ["cornell-box", "a.b", "schach brett ü"] {
            assert_eq!(name_of(Path::new(name)), Some(name));
        }
        for path in ["", ".", "..", "./teapot", "teapot/", "a/teapot", "/teapot", "teapot.glb", "teapot.GLTF", "src"] {
            assert_eq!(name_of(Path::new(path)), None, "{path}");
        }
    }
}
