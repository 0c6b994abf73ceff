//! A scene that is read in a thread of its own, and traced there as a preview while its run is prepared elsewhere. For
//! the first scene that begins before there is a device or a window.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use raystep_inspector::session::preview::Preview;
use raystep_inspector::session::request::Loaded;
use raystep_inspector::settings::Settings;
use raystep_lab::block_on;

use super::SceneChoice;
use crate::args::{ReadArgs, SceneArgs};
use crate::scene_file;

/// A preview that takes longer is given up: by then the run itself is on its way.
const PATIENCE: Duration = Duration::from_secs(3);

/// A scene on its way.
pub(crate) struct Opening {
    choice: SceneChoice,
    settings: Settings,
    /// The scene, or why it cannot be read.
    pub(super) scene: Receiver<Result<Loaded, String>>,
    /// Its preview, if there will be one.
    pub(super) preview: Receiver<Preview>,
}

impl Opening {
    /// Begins to read a scene for a run with these settings.
    pub(crate) fn begin(choice: SceneChoice, read: ReadArgs, settings: Settings) -> Self {
        let ((tell_scene, scene), (tell_preview, preview)) = (channel(), channel());
        let opening = Self { choice: choice.clone(), settings: settings.clone(), scene, preview };
        std::thread::spawn(move || {
            let file = SceneArgs { scene: choice.path, scene_index: choice.index, read };
            let read = scene_file::read_any(&file).map_err(|e| e.message().to_owned());
            let read = read.map(|read| Loaded { scene: Arc::new(read.scene), folder: read.folder });
            // A program has no rays to preview.
            let scene = read.as_ref().ok().filter(|read| read.folder.is_none()).map(|read| read.scene.clone());
            let is_wanted = tell_scene.send(read).is_ok();
            let Some(scene) = scene.filter(|_| is_wanted) else { return };
            let begin = Instant::now();
            let traced = block_on(None, Preview::trace(&scene, &settings, || begin.elapsed() < PATIENCE));
            // What does not fit is reported by the run, and nobody waits for the preview of a closed window.
            if let Ok(Some(preview)) = traced {
                let _ = tell_preview.send(preview);
            }
        });
        opening
    }

    /// Whether this is the scene, and the run.
    pub(super) fn is_of(&self, choice: &SceneChoice, settings: &Settings) -> bool {
        (&self.choice, &self.settings) == (choice, settings)
    }
}
