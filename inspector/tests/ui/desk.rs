//! A host for tests: threads, scenes by name, a dialog that answers at once, files kept in memory.

use std::sync::{Arc, Mutex};

use raystep_inspector::session::engine::EngineTask;
use raystep_inspector::session::preview::Preview;
use raystep_inspector::session::request::{Loaded, Loader, at_once};
use raystep_inspector::settings::Settings;
use raystep_inspector::ui::host::{FileToSave, Host, HostEvent};
use raystep_kernels::Gpu;
use raystep_kernels::options::folder::Folder;
use raystep_scenes::{Light, LoadOptions, NoFiles, Scene, generate, load};

use crate::ui::adapter::block_on;

/// The scene of most tests.
/// A program in place of a scene.
pub(crate) const PROGRAM: &str = "work/life";

/// The Game of Life, on a small field.
pub(crate) fn life() -> Folder {
    let files = [
        ("program.toml", include_str!("../../../app/programs/life/program.toml").replace("[256, 256]", "[48, 32]")),
        ("seed.wgsl", include_str!("../../../app/programs/life/seed.wgsl").to_owned()),
        ("generation.wgsl", include_str!("../../../app/programs/life/generation.wgsl").to_owned()),
    ];
    let files = files.map(|(name, text)| (name.to_owned(), text.into_bytes()));
    Folder::new("life".into(), PROGRAM.into(), files.into()).expect("a folder")
}

pub(crate) const CORNELL: &str = "cornell-box";
/// The same room with lights of every kind, of which the last is behind its back wall.
pub(crate) const ROOM: &str = "room";
/// The same room without lights, whose first material glows.
pub(crate) const GLOW: &str = "glow";
/// A ball of glass and one that is a mirror, over a floor.
pub(crate) const WHITTED: &str = "whitted";
/// The same room, where all surfaces emit more than half of what a float holds.
pub(crate) const GLARE: &str = "glare";
/// A glTF file with a single triangle.
pub(crate) const TRIANGLE: &str = "triangle.gltf";
/// A glTF file without a mesh.
pub(crate) const EMPTY: &str = "empty.gltf";
/// A file that is not glTF.
pub(crate) const BROKEN: &str = "broken.glb";

/// The reason shown when a path is asked for because there are no dialogs.
pub(crate) const NO_DIALOG: &str = "there is no dialog for files";

/// Requests to the host, and its answers.
#[derive(Default)]
pub(crate) struct Desk {
    /// Saved files.
    pub(crate) saved: Vec<FileToSave>,
    /// The answer of the dialog for scenes; `None` if the user cancels it.
    pub(crate) choice: Option<String>,
    /// How dialogs behave.
    pub(crate) dialogs: Dialogs,
    /// The answer of the dialog for sessions; `None` if the user cancels it.
    pub(crate) session: Option<String>,
    /// Sessions that can be read, by name.
    pub(crate) sessions: Vec<(String, Vec<u8>)>,
    /// Names of existing files, if there are no dialogs.
    pub(crate) there: Vec<String>,
    /// The saved state.
    pub(crate) remembered: String,
    /// Whether a preview of the Cornell box comes before the scene itself.
    pub(crate) previews: bool,
    pub(crate) events: Vec<HostEvent>,
}

/// How the host's dialogs behave.
#[derive(Clone, Copy, Default, PartialEq)]
pub(crate) enum Dialogs {
    /// They answer.
    #[default]
    Answer,
    /// The user cancels them.
    Cancel,
    /// There are none.
    Missing,
}

/// The host, as the inspector sees it.
pub(crate) struct TestHost {
    pub(crate) gpu: Arc<Gpu>,
    pub(crate) desk: Arc<Mutex<Desk>>,
}

impl TestHost {
    fn desk(&self) -> std::sync::MutexGuard<'_, Desk> {
        self.desk.lock().expect("no test panicked in here")
    }
}

impl Host for TestHost {
    fn spawn(&mut self, task: EngineTask) {
        let gpu = self.gpu.clone();
        std::thread::spawn(move || block_on(&gpu, task));
    }

    fn scene_of(&self, path: &str) -> (String, Option<usize>) {
        (path.into(), None)
    }

    fn path_of(&self, scene: &str, _index: Option<usize>) -> String {
        scene.into()
    }

    fn loader(&mut self, path: &str, settings: &Settings) -> Loader {
        if self.desk().previews {
            let scene = generate::cornell_box();
            let trace = Preview::trace(&scene, settings, || true);
            let preview = pollster::block_on(trace).expect("a small scene").expect("a preview");
            self.desk().events.push(HostEvent::Previewed { path: path.into(), preview });
        }
        let path = path.to_owned();
        if path == PROGRAM {
            return Box::new(|_| Box::pin(async { Ok(Loaded::from(life())) }));
        }
        at_once(move || {
            let json = match path.as_str() {
                CORNELL => return Ok(generate::cornell_box()),
                ROOM => return Ok(room()),
                WHITTED => return generate::whitted(2).map_err(|error| error.to_string()),
                GLOW => return Ok(glowing(1, [2.0, 1.5, 1.0])),
                GLARE => return Ok(glowing(usize::MAX, [3e38; 3])),
                TRIANGLE => triangle(),
                EMPTY => {
                    r#"{"asset": {"version": "2.0"}, "scenes": [{"name": "empty", "nodes": []}], "scene": 0}"#.into()
                }
                BROKEN => "glTF, but not really".into(),
                other => return Err(format!("{other}: no such file")),
            };
            load(&path, json.as_bytes(), &NoFiles, &LoadOptions::default()).map_err(|e| e.to_string())
        })
    }

    fn choose_scene(&mut self) {
        let mut desk = self.desk();
        let choice = desk.choice.clone();
        let event = match (desk.dialogs, choice) {
            (Dialogs::Missing, _) => HostEvent::AskPath { file: None, path: "/here/".into(), why: NO_DIALOG.into() },
            (Dialogs::Answer, Some(choice)) => HostEvent::Chosen(choice),
            _ => HostEvent::Cancelled("cancelled: no scene opened"),
        };
        desk.events.push(event);
    }

    fn choose_kernel(&mut self) {
        self.choose_scene();
    }

    fn choose_session(&mut self) {
        let mut desk = self.desk();
        let event = match desk.session.clone() {
            Some(choice) => HostEvent::Chosen(choice),
            None => HostEvent::Cancelled("cancelled: no session opened"),
        };
        desk.events.push(event);
    }

    fn read(&mut self, path: &str) {
        let mut desk = self.desk();
        let found = desk.sessions.iter().find(|(name, _)| name == path).map(|(_, bytes)| bytes.clone());
        let event = match found {
            Some(bytes) => HostEvent::Read { path: path.into(), bytes },
            None => HostEvent::Failed(format!("{path}: no such file")),
        };
        desk.events.push(event);
    }

    fn beside(&self, _session: &str, scene: &str) -> String {
        scene.into()
    }

    fn save(&mut self, file: FileToSave) {
        let mut desk = self.desk();
        let event = match desk.dialogs {
            Dialogs::Answer => {
                let (holds, path) = (file.holds.clone(), file.name.clone());
                desk.saved.push(file);
                HostEvent::Saved { holds, path }
            }
            Dialogs::Cancel => HostEvent::Cancelled("cancelled: nothing written"),
            Dialogs::Missing => {
                HostEvent::AskPath { path: format!("/here/{}", file.name), file: Some(file), why: NO_DIALOG.into() }
            }
        };
        desk.events.push(event);
    }

    fn save_as(&mut self, file: FileToSave, path: &str, replaces: bool) {
        let mut desk = self.desk();
        let path = path.to_owned();
        let event = if desk.there.contains(&path) && !replaces {
            HostEvent::AskPath { file: Some(file), path, why: "it is there already".into() }
        } else {
            let holds = file.holds.clone();
            desk.there.push(path.clone());
            desk.saved.push(file);
            HostEvent::Saved { holds, path }
        };
        desk.events.push(event);
    }

    fn events(&mut self) -> Vec<HostEvent> {
        std::mem::take(&mut self.desk().events)
    }

    fn remember(&mut self, saved: &str) {
        self.desk().remembered = saved.into();
    }
}

/// A triangle of side 1 in the plane z = 0: three vertices, no indices, in a data URI.
fn triangle() -> String {
    const VERTICES: &str = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}], "nodes": [{{"mesh": 0}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}}}]}}],
        "buffers": [{{"byteLength": 36, "uri": "data:application/octet-stream;base64,{VERTICES}"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 36}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
            "min": [0, 0, 0], "max": [1, 1, 0]}}]}}"#
    )
}

/// The Cornell box without lights, of which the first materials emit light.
fn glowing(materials: usize, emissive: [f32; 3]) -> Scene {
    let mut scene = generate::cornell_box();
    scene.lights.clear();
    scene.materials.iter_mut().take(materials).for_each(|material| material.emissive = emissive);
    scene
}

fn room() -> Scene {
    let mut scene = generate::cornell_box();
    let bounds = scene.bounds();
    let at = |part: [f32; 3]| [0, 1, 2].map(|a| bounds.min[a] + (bounds.max[a] - bounds.min[a]) * part[a]);
    scene.lights = vec![
        Light::Point { position: at([0.3, 0.9, 0.5]), color: [0.35, 0.5, 0.9], intensity: 1.0 },
        Light::Directional { direction: [0.18, -0.37, -0.91], color: [0.6, 0.55, 0.3], intensity: 1.0 },
        Light::Spot {
            position: at([0.8, 0.8, 0.4]),
            direction: [0.0, -1.0, 0.0],
            color: [0.9, 0.2, 0.2],
            intensity: 1.0,
            inner_cone: 0.4,
            outer_cone: 0.9,
        },
        Light::Point { position: at([0.5, 0.5, -0.4]), color: [1.0; 3], intensity: 1.0 },
    ];
    scene
}
