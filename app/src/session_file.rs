//! `.raystep-session` files on a disk: scenes are named relative to the file.

use std::path::{Component, Path, PathBuf};

use raystep_inspector::session_file::{BUILT_IN, EXTENSION, MOST_BYTES, SessionFile};
use raystep_inspector::ui::host::FileToSave;

use crate::commands::extension;
use crate::error::Error;
use crate::output::folder_of;
use crate::scene_file::{bytes_of, is_known};

/// Whether a file is a session, by its name.
pub(crate) fn is_session(path: &Path) -> bool {
    extension(path) == EXTENSION
}

/// Reads a file.
pub(crate) fn bytes(path: &Path) -> Result<Vec<u8>, Error> {
    bytes_of(path, MOST_BYTES as u64)
}

/// Reads a session; a broken one is wrong usage.
pub(crate) fn read(path: &Path) -> Result<SessionFile, Error> {
    SessionFile::from_bytes(&bytes(path)?).map_err(|e| Error::usage(format!("{}: {e}", path.display())))
}

/// The path of a scene that a session names.
pub(crate) fn beside(session: &Path, scene: &str) -> PathBuf {
    let path = folder_of(session).join(scene);
    let is_named = !path.exists() && is_known(Path::new(scene));
    if is_named || scene.starts_with(BUILT_IN) { scene.into() } else { path }
}

/// A file as it is written to a path: in a session, scenes are relative to it, and its name ends as that of a session.
/// Other files stay as they are.
pub(crate) fn prepared(file: FileToSave, path: &Path) -> Result<(FileToSave, PathBuf), (FileToSave, String)> {
    if !is_session(Path::new(&file.name)) {
        return Ok((file, path.to_owned()));
    }
    let path = if is_session(path) { path.to_owned() } else { path.with_added_extension(EXTENSION) };
    let relative = || {
        let mut session = SessionFile::from_bytes(&file.bytes).map_err(|e| e.to_string())?;
        session.rename_scenes(|scene| relative(scene, folder_of(&path)));
        session.to_text().map_err(|e| e.to_string())
    };
    match relative() {
        Ok(text) => Ok((FileToSave { bytes: text.into_bytes(), ..file }, path)),
        Err(why) => Err((file, why)),
    }
}

/// A scene's path relative to a folder, with forward slashes; the absolute path if there is none, for example to another
/// drive. The name of a scene stays.
fn relative(scene: &str, folder: &Path) -> String {
    if is_known(Path::new(scene)) {
        return scene.to_owned();
    }
    let (Ok(scene_path), Ok(folder)) = (plain(Path::new(scene)), plain(folder)) else { return scene.to_owned() };
    let parts = |path: &Path| path.components().map(|part| part.as_os_str().to_owned()).collect::<Vec<_>>();
    let (to, from) = (parts(&scene_path), parts(&folder));
    let same = to.iter().zip(&from).take_while(|(a, b)| a == b).count();
    // Of two absolute paths, at least the root is the same, unless they are on different drives.
    if same == 0 {
        return scene_path.to_string_lossy().into_owned();
    }
    let up = std::iter::repeat_n("..".into(), from.len() - same);
    let names: Vec<_> = up.chain(to[same..].iter().map(|part| part.to_string_lossy())).collect();
    names.join("/")
}

/// An absolute path without `.` and `..`, links resolved where the file exists.
fn plain(path: &Path) -> std::io::Result<PathBuf> {
    if let Ok(path) = std::fs::canonicalize(path) {
        return Ok(path);
    }
    let mut plain = PathBuf::new();
    for part in std::path::absolute(path)?.components() {
        match part {
            Component::ParentDir => drop(plain.pop()),
            Component::CurDir => {}
            part => plain.push(part),
        }
    }
    Ok(plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn scenes_are_named_relative_to_the_session() {
        for (scene, folder, wanted) in [
            ("/none/scenes/a b.glb", "/none/scenes", "a b.glb"),
            ("/none/scenes/a.glb", "/none/work/x", "../../scenes/a.glb"),
            ("/none/x/../scenes/./a.glb", "/none", "scenes/a.glb"),
            ("/none/a.glb", "/other", "../none/a.glb"),
        ] {
            assert_eq!(relative(scene, Path::new(folder)), wanted);
        }
    }

    #[test]
    fn only_sessions_are_changed() {
        let csv = FileToSave { name: "a.csv".into(), bytes: vec![1], holds: String::new() };
        assert_eq!(prepared(csv.clone(), Path::new("b")), Ok((csv.clone(), "b".into())));
        let broken = FileToSave { name: format!("a.{EXTENSION}"), ..csv };
        assert!(prepared(broken, Path::new("b")).is_err());
        let session = br#"{"version": 1, "here": {"link": "raystep:1?scene=a.glb"}}"#.to_vec();
        let file = FileToSave { name: format!("a.{EXTENSION}"), bytes: session, holds: String::new() };
        let (file, path) = prepared(file, Path::new("sub/b")).expect("a session");
        assert_eq!(path, Path::new("sub/b").with_extension(EXTENSION));
        assert!(String::from_utf8_lossy(&file.bytes).contains("scene=../a.glb"), "{file:?}");
    }

    #[test]
    fn scenes_beside_a_session_are_found() {
        assert_eq!(beside(Path::new("sub/b.raystep-session"), "../a.glb"), Path::new("sub").join("../a.glb"));
        assert_eq!(beside(Path::new("sub/b.raystep-session"), "built-in:x"), Path::new("built-in:x"));
    }
}
