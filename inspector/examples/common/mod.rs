//! A host for windows without a screen: threads, and a generated scene.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use raystep_inspector::session::engine::EngineTask;
use raystep_inspector::session::request::{Loader, at_once};
use raystep_inspector::settings::Settings;
use raystep_inspector::ui::host::{FileToSave, Host, HostEvent};
use raystep_kernels::Gpu;
use raystep_lab::block_on_shared;

/// Runs tasks in threads; every path is the Cornell box, or a terrain of so many triangles.
pub(crate) struct Threads {
    pub(crate) gpu: Arc<Gpu>,
    pub(crate) triangles: u64,
}

impl Host for Threads {
    fn spawn(&mut self, task: EngineTask) {
        let gpu = self.gpu.clone();
        std::thread::spawn(move || block_on_shared(&gpu, &AtomicBool::new(false), task));
    }

    fn scene_of(&self, path: &str) -> (String, Option<usize>) {
        (path.into(), None)
    }

    fn path_of(&self, scene: &str, _index: Option<usize>) -> String {
        scene.into()
    }

    fn loader(&mut self, _path: &str, _settings: &Settings) -> Loader {
        let triangles = self.triangles;
        at_once(move || match triangles {
            0 => Ok(raystep_scenes::generate::cornell_box()),
            count => raystep_scenes::generate::terrain(count, 1).map_err(|e| e.to_string()),
        })
    }

    fn choose_scene(&mut self) {}

    fn choose_kernel(&mut self) {}

    fn choose_session(&mut self) {}

    fn read(&mut self, _path: &str) {}

    fn beside(&self, _session: &str, scene: &str) -> String {
        scene.into()
    }

    fn save(&mut self, _file: FileToSave) {}

    fn save_as(&mut self, _file: FileToSave, _path: &str, _replaces: bool) {}

    fn events(&mut self) -> Vec<HostEvent> {
        Vec::new()
    }

    fn remember(&mut self, _saved: &str) {}
}
