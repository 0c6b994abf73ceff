//! Scenes to measure: with a view, and a hash that identifies their contents.

use std::path::PathBuf;

use raystep_lab::{Hash, Subject};

use crate::args::{CameraArgs, SceneArgs};
use crate::error::Error;
use crate::scene_file::{self, SceneFile, hashed};
use crate::terminal::Progress;

/// The files of a scene.
pub(crate) struct Input {
    /// As the user wrote it.
    pub(crate) path: PathBuf,
    /// Canonical names of all files that it was read from.
    pub(crate) files: Vec<PathBuf>,
}

/// Reads a scene, and prints its notes.
pub(crate) fn read(file: SceneArgs, camera: &CameraArgs, progress: &Progress) -> Result<(Input, Subject), Error> {
    let SceneFile { scene, inputs: files, .. } = scene_file::read(&file)?;
    let hash = hashed(Hash::default(), &files, file.read.max_memory)?;
    let (camera, note) = scene_file::camera(camera, &scene)?;
    for note in scene.notes.iter().map(|n| &n.0).chain(&note) {
        progress.say(format_args!("note: {}: {note}", scene.name));
    }
    let at = file.scene.display().to_string();
    Ok((Input { path: file.scene, files }, Subject { scene, camera, hash, file: at }))
}
