//! Threads, files and dialogs of a desktop.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

use eframe::egui;
use raystep_inspector::session::engine::EngineTask;
use raystep_inspector::session::request::Loader;
use raystep_inspector::ui::host::{FileToSave, Host, HostEvent};
use raystep_kernels::Gpu;

use super::{files, thread};
use crate::args::{ReadArgs, SceneArgs};
use crate::output::{Target, write};
use crate::scene_file;

/// A scene by its path, and which of a file that holds several.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct SceneChoice {
    /// The file.
    pub(crate) path: PathBuf,
    /// `--scene-index`
    pub(crate) index: Option<usize>,
}

impl fmt::Display for SceneChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.path.display())?;
        self.index.map_or(Ok(()), |index| write!(f, "#{index}"))
    }
}

impl SceneChoice {
    /// The other way round. A file whose name ends like an index is that file.
    fn parse(text: &str) -> Self {
        let whole = Self { path: text.into(), index: None };
        match text.rsplit_once('#') {
            Some((path, index)) if !Path::new(text).exists() => match index.parse() {
                Ok(index) => Self { path: path.into(), index: Some(index) },
                Err(_) => whole,
            },
            _ => whole,
        }
    }
}

/// A desktop.
pub(super) struct Desktop {
    ctx: egui::Context,
    gpu: Arc<Gpu>,
    read: ReadArgs,
    events: Receiver<HostEvent>,
    tell: Sender<HostEvent>,
    /// What was remembered last.
    remembered: String,
}

impl Desktop {
    pub(super) fn new(ctx: egui::Context, gpu: Arc<Gpu>, read: ReadArgs) -> Self {
        let (tell, events) = channel();
        Self { ctx, gpu, read, events, tell, remembered: String::new() }
    }

    /// Does something that takes its time, and tells what came of it.
    fn aside(&self, work: impl FnOnce() -> Option<HostEvent> + Send + 'static) {
        let (tell, ctx) = (self.tell.clone(), self.ctx.clone());
        std::thread::spawn(move || {
            if let Some(event) = work() {
                // The window may be closed by now.
                let _ = tell.send(event);
                ctx.request_repaint();
            }
        });
    }
}

impl Host for Desktop {
    fn spawn(&mut self, task: EngineTask) {
        let gpu = self.gpu.clone();
        std::thread::spawn(move || thread::run(&gpu, task));
    }

    fn scene_of(&self, path: &str) -> (String, Option<usize>) {
        let SceneChoice { path, index } = SceneChoice::parse(path);
        (path.to_string_lossy().into_owned(), index)
    }

    fn path_of(&self, scene: &str, index: Option<usize>) -> String {
        SceneChoice { path: scene.into(), index }.to_string()
    }

    fn loader(&mut self, path: &str) -> Loader {
        let SceneChoice { path, index } = SceneChoice::parse(path);
        let file = SceneArgs { scene: path, scene_index: index, read: self.read };
        Box::new(move || {
            let read = scene_file::read(&file).map_err(|e| e.message().to_owned())?;
            Ok(read.scene)
        })
    }

    fn choose_scene(&mut self) {
        // Dialogs want the main thread on macOS, and are asynchronous everywhere.
        let dialog = rfd::AsyncFileDialog::new().add_filter("glTF 2.0", &["gltf", "glb"]).pick_file();
        self.aside(move || {
            let file = files::wait(dialog)?;
            Some(HostEvent::Chosen(file.path().to_string_lossy().into_owned()))
        });
    }

    fn save(&mut self, file: FileToSave) {
        let extension = Path::new(&file.name).extension().unwrap_or_default().to_string_lossy().into_owned();
        let dialog =
            rfd::AsyncFileDialog::new().set_file_name(&file.name).add_filter(&extension, &[&extension]).save_file();
        self.aside(move || {
            let chosen = files::wait(dialog)?;
            let written = Target::new(chosen.path()).and_then(|target| write(vec![(target, file.bytes)]));
            Some(match written {
                Ok(()) => HostEvent::Saved(chosen.path().display().to_string()),
                Err(error) => HostEvent::Failed(error.message().to_owned()),
            })
        });
    }

    fn events(&mut self) -> Vec<HostEvent> {
        self.events.try_iter().collect()
    }

    fn remember(&mut self, saved: &str) {
        if self.remembered != saved {
            files::remember(saved);
            saved.clone_into(&mut self.remembered);
        }
    }
}
