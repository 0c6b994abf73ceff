//! Scenes by name: those in a folder that comes with the program, and those in the program itself.

use std::fs;
use std::path::{Component, Path, PathBuf};
use std::sync::OnceLock;

use raystep_inspector::lesson::built_in::{self, CORNELL_BOX, PREFIX};
use raystep_scenes::generate::{self, GENERATORS};
use raystep_scenes::{ENDINGS, write_glb};

use crate::commands::extension;
use crate::error::Error;
use crate::output::folder_of;
use crate::usage::{nearest, or};

/// The folder that the host has named.
static FOLDER: OnceLock<PathBuf> = OnceLock::new();

/// Most names of a folder that are compared with a wrong one.
const MOST_COMPARED: usize = 10_000;

/// Most names in an error.
const MOST_NAMED: usize = 3;

/// Names the folder; the first call counts.
pub(crate) fn set_folder(folder: PathBuf) {
    let _ = FOLDER.set(folder);
}

/// The folder: the host's, otherwise one that is installed with the executable, otherwise that of the checkout of
/// raystep in which the current folder is.
fn folder() -> Option<PathBuf> {
    FOLDER.get().cloned().or_else(installed).or_else(checkout).filter(|folder| folder.is_dir())
}

fn installed() -> Option<PathBuf> {
    let executable = std::env::current_exe().ok()?;
    let beside = executable.parent()?;
    ["scenes", "../share/raystep/scenes"].map(|name| beside.join(name)).into_iter().find(|folder| folder.is_dir())
}

/// A checkout is known by its package of scenes.
fn checkout() -> Option<PathBuf> {
    let here = std::env::current_dir().ok()?;
    let has_package = |folder: &PathBuf| ["Cargo.toml", "cornell-box.gltf"].iter().all(|f| folder.join(f).is_file());
    here.ancestors().map(|above| above.join("scenes")).find(has_package)
}

/// The name of a built-in scene, if a path is one: that of a generator.
pub(super) fn built_in_name(path: &Path) -> Option<&str> {
    path.to_str()?.strip_prefix(PREFIX).filter(|_| !path.exists())
}

/// A built-in scene as a GLB file; `None` if a path is not one.
pub(super) fn built_in(path: &Path) -> Option<Result<Vec<u8>, String>> {
    let name = built_in_name(path)?;
    let scene = generate::find(name).and_then(|generator| generator.make(&[])).map_err(|e| e.to_string());
    Some(scene.and_then(|scene| write_glb(&scene).map_err(|e| e.to_string())))
}

/// The name, if a path is one: a word that is no file's, without a folder or the ending of a scene.
fn name_of(path: &Path) -> Option<&str> {
    let mut parts = path.components();
    let (Some(Component::Normal(name)), None) = (parts.next(), parts.next()) else { return None };
    let is_file = ENDINGS.contains(&extension(path).as_str()) || path.exists();
    name.to_str().filter(|name| !is_file && path.as_os_str().len() == name.len())
}

/// The file of a name; what is in the program comes last.
fn find(name: &str) -> Option<PathBuf> {
    let in_folder = |folder: PathBuf| {
        ENDINGS.map(|ending| folder.join(format!("{name}.{ending}"))).into_iter().find(|path| path.is_file())
    };
    folder().and_then(in_folder).or_else(|| (name == CORNELL_BOX).then(|| format!("{PREFIX}{name}").into()))
}

/// The files of scenes in a folder.
fn scenes_in(folder: &Path) -> impl Iterator<Item = PathBuf> {
    let paths = fs::read_dir(folder).into_iter().flatten().take(MOST_COMPARED);
    paths.filter_map(|entry| Some(entry.ok()?.path())).filter(|path| ENDINGS.contains(&extension(path).as_str()))
}

/// The names of all scenes, sorted.
pub(crate) fn names() -> Vec<String> {
    let stem = |path: PathBuf| Some(path.file_stem()?.to_string_lossy().into_owned());
    let mut names: Vec<String> = folder().iter().flat_map(|folder| scenes_in(folder)).filter_map(stem).collect();
    names.push(CORNELL_BOX.to_owned());
    names.sort();
    names.dedup();
    names
}

/// Whether a path is the name of a scene that there is.
pub(crate) fn is_known(path: &Path) -> bool {
    match built_in_name(path) {
        Some(name) => GENERATORS.iter().any(|generator| generator.name == name),
        None => name_of(path).is_some_and(|name| find(name).is_some()),
    }
}

/// The file that a path or name stands for. A file that exists is itself, whatever scenes there are.
pub(crate) fn file_of(path: &Path) -> Result<PathBuf, Error> {
    if let Some(name) = built_in_name(path) {
        return generate::find(name).map(|_| path.to_owned()).map_err(Error::failed);
    }
    match name_of(path) {
        Some(name) => find(name).ok_or_else(|| no_scene(name)),
        None if path.exists() => Ok(path.to_owned()),
        None => no_file(path).map_or_else(|| Ok(path.to_owned()), Err),
    }
}

/// The error for a name that no scene has.
fn no_scene(name: &str) -> Error {
    if built_in::lesson(name).is_some() {
        return Error::failed(format!(
            "{name}: no such scene, but a lesson; 'raystep inspect --lesson {name}' begins it"
        ));
    }
    let names = names();
    let near = nearest(name, &names).into_iter().map(str::to_owned).chain(near_files(Path::new("."), name));
    let near = or(&near.take(MOST_NAMED).collect::<Vec<_>>());
    let near = if near.is_empty() { near } else { format!("did you mean {near}? ") };
    Error::failed(format!("{name}: no such file, and no scene of that name; {near}scenes: {}", names.join(", ")))
}

/// The error for a missing file, if something is near that could be meant. Examples name the repository's files, which
/// others do not have.
fn no_file(path: &Path) -> Option<Error> {
    let (at, stem) = (path.display(), path.file_stem()?.to_str()?);
    if find(stem).is_some() {
        return Some(Error::failed(format!(
            "{at}: no such file; '{stem}' alone opens the scene that comes with raystep"
        )));
    }
    let near = near_files(folder_of(path), stem);
    (!near.is_empty()).then(|| {
        let near = or(&near[..near.len().min(MOST_NAMED)]);
        Error::failed(format!("{at}: no such file; did you mean {near}?"))
    })
}

/// The scenes in a folder with a name that is near.
fn near_files(folder: &Path, stem: &str) -> Vec<String> {
    let mut files: Vec<PathBuf> = scenes_in(folder).collect();
    files.sort();
    let stem_of = |path: &PathBuf| path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let stems: Vec<String> = files.iter().filter_map(stem_of).collect();
    let near = nearest(stem, &stems);
    let is_near = |path: &&PathBuf| stem_of(path).is_some_and(|stem| near.contains(&stem.as_str()));
    let shown = |path: &PathBuf| path.strip_prefix(".").unwrap_or(path).display().to_string();
    files.iter().filter(is_near).map(shown).collect()
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

    #[test]
    fn a_built_in_scene_is_a_file_in_the_program() {
        let bytes = built_in(Path::new("built-in:cornell-box")).expect("a built-in scene").expect("bytes");
        assert!(bytes.starts_with(b"glTF"));
        assert!(built_in(Path::new("cornell-box")).is_none() && is_known(Path::new("built-in:terrain")));
        let error = file_of(Path::new("built-in:palace")).expect_err("no such scene");
        assert!(error.message().contains("cornell-box, cornell-lamp, soup, terrain"), "{error}");
        assert!(!is_known(Path::new("built-in:palace")));
    }
}
