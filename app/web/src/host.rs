//! What the inspector needs from a page: files, downloads, and a place for settings.

use std::rc::Rc;

use js_sys::Uint8Array;
use raystep_inspector::session::engine::EngineTask;
use raystep_inspector::session::request::Loader;
use raystep_inspector::session_file::{BUILT_IN, EXTENSION};
use raystep_inspector::settings::Settings;
use raystep_inspector::ui::host::{FileToSave, Host, HostEvent};

use crate::files::{Files, accepted};
use crate::{shell, tasks};

/// A page as host.
pub(crate) struct Web {
    ctx: egui::Context,
    files: Rc<Files>,
    /// The settings that were stored last.
    remembered: String,
}

impl Web {
    pub(crate) fn new(ctx: egui::Context, files: Rc<Files>) -> Self {
        Self { ctx, files, remembered: String::new() }
    }
}

impl Host for Web {
    fn spawn(&mut self, task: EngineTask) {
        tasks::spawn(task);
    }

    fn scene_of(&self, path: &str) -> (String, Option<usize>) {
        match path.rsplit_once('#') {
            Some((scene, index)) if index.parse::<usize>().is_ok() => (scene.to_owned(), index.parse().ok()),
            _ => (path.to_owned(), None),
        }
    }

    fn path_of(&self, scene: &str, index: Option<usize>) -> String {
        index.map_or_else(|| scene.to_owned(), |index| format!("{scene}#{index}"))
    }

    fn loader(&mut self, path: &str, _settings: &Settings) -> Loader {
        let (path, scene) = self.scene_of(path);
        self.files.loader(&path, scene)
    }

    fn choose_scene(&mut self) {
        // A scene's textures and buffers may be files of their own.
        shell::choose(&accepted());
    }

    fn choose_session(&mut self) {
        shell::choose(&format!(".{EXTENSION}"));
    }

    fn choose_kernel(&mut self) {
        shell::choose(".wgsl");
    }

    fn read(&mut self, path: &str) {
        let ctx = self.ctx.clone();
        self.files.read_session(path, move || ctx.request_repaint());
    }

    fn beside(&self, session: &str, scene: &str) -> String {
        match session.rsplit_once('/') {
            Some((folder, _)) if !scene.starts_with(BUILT_IN) => format!("{folder}/{scene}"),
            _ => scene.to_owned(),
        }
    }

    fn save(&mut self, file: FileToSave) {
        let FileToSave { name, bytes, holds } = file;
        shell::download(&name, Uint8Array::from(bytes.as_slice()));
        self.files.events.borrow_mut().push(HostEvent::Saved { holds, path: name });
        self.ctx.request_repaint();
    }

    fn save_as(&mut self, file: FileToSave, path: &str, _replaces: bool) {
        self.save(FileToSave { name: crate::files::file_name(path).to_owned(), ..file });
    }

    fn events(&mut self) -> Vec<HostEvent> {
        self.files.events.take()
    }

    fn can_quit(&self) -> bool {
        false
    }

    fn remember(&mut self, saved: &str) {
        if self.remembered != saved {
            shell::keep(saved);
            saved.clone_into(&mut self.remembered);
        }
    }
}
