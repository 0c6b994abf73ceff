//! Scenes to measure: with a view, and a hash that tells whether they have changed.

use std::path::PathBuf;

use raystep_lab::Hash;
use raystep_scenes::{Camera, Scene};

use crate::args::{CameraArgs, SceneArgs};
use crate::error::Error;
use crate::scene_file::{self, SceneFile, read_file};
use crate::terminal::Progress;

/// A scene and its view.
pub(crate) struct Input {
    /// As the user wrote it.
    pub(crate) path: PathBuf,
    /// The scene.
    pub(crate) scene: Scene,
    /// What is seen.
    pub(crate) camera: Camera,
    /// Of all files that it was read from.
    pub(crate) hash: Hash,
    /// Their canonical names.
    pub(crate) files: Vec<PathBuf>,
}

impl Input {
    /// Reads a scene, says its notes.
    pub(crate) fn read(file: SceneArgs, camera: &CameraArgs, progress: &Progress) -> Result<Self, Error> {
        let SceneFile { scene, inputs: files } = scene_file::read(&file)?;
        let mut hash = Hash::default();
        for path in &files {
            let bytes = read_file(path, file.read.max_memory);
            hash.add(&bytes.map_err(|e| Error::failed(format!("{}: {e}", path.display())))?);
        }
        let (camera, note) = scene_file::camera(camera, &scene)?;
        for note in scene.notes.iter().map(|n| &n.0).chain(&note) {
            progress.say(format_args!("note: {}: {note}", scene.name));
        }
        Ok(Self { path: file.scene, scene, camera, hash, files })
    }
}
