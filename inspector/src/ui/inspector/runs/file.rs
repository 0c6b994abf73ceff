//! Sessions as files.

use std::sync::Arc;

use raystep_lab::text::counted;
use raystep_scenes::Scene;

use super::perform::RESTORING;
use crate::exports::EXPORTING;
use crate::link::{Link, LinkRay, Shown};
use crate::runs::{Recipe, scene_hash};
use crate::session::request::{Job, Request, answered, job};
use crate::session::{Edit, go_on};
use crate::session_file::{BUILT_IN, EXTENSION, SavedRun, SessionFile, layout};
use crate::ui::host::FileToSave;
use crate::ui::state::kept_runs::{Expected, KeptRuns, Opening};
use crate::ui::{Arrival, Inspector};

/// The job that computes the hash of the open scene.
const IDENTIFYING: &str = "identifying the scene";

/// A scene, and its hash.
struct Identified(Arc<Scene>, String);

fn identify() -> Job {
    job!(context, {
        let hash = scene_hash(context.scene).to_string();
        answered(Identified(context.scene.clone(), hash))
    })
}

/// Restores the edits of a run that has just begun, or none of them.
fn restore(edits: Vec<Edit>) -> Job {
    job!(context, {
        let renderer = context.session.renderer();
        for Edit { stream, x, y, .. } in &edits {
            let size = renderer.size(stream.info().elements);
            let is_inside = size.is_none_or(|size| *x < size.width && *y < size.height);
            if !renderer.plan().has_stream(*stream) || !is_inside {
                return Err(format!("the run has no stream {} with a texel {x},{y}", stream.name()));
            }
        }
        context.session.set_edits(edits, &mut go_on).await.map_err(|e| e.to_string())?;
        answered(())
    })
}

impl Inspector {
    /// Restores edits and passes on the CPU reference in a run that was requested last.
    fn restore_edits(&mut self, edits: Vec<Edit>, twins: Option<usize>) {
        if !edits.is_empty() {
            self.model.ask(Request::Job(RESTORING, restore(edits)));
        }
        if twins.is_some() {
            self.model.ask(Request::TwinsUntil(twins));
        }
    }

    /// Saves the session, once the scene's hash is known.
    pub(in crate::ui) fn save_session(&mut self) {
        let Some(opened) = &self.model.opened else { return };
        if self.state.runs.hash(&opened.scene).is_some() {
            self.write_session();
        } else {
            self.state.runs.is_saving = true;
            self.model.ask(Request::Job(EXPORTING, identify()));
        }
    }

    /// The scene's hash has arrived.
    pub(super) fn identified(&mut self) {
        for what in [EXPORTING, IDENTIFYING] {
            while let Some(answer) = self.model.take_answer::<Identified>(what) {
                let Identified(scene, hash) = *answer;
                self.state.runs.scene = Some((Arc::downgrade(&scene), hash));
            }
        }
        let Some(opened) = &self.model.opened else { return };
        let Some(hash) = self.state.runs.hash(&opened.scene).map(str::to_owned) else {
            // For links; kept runs may be of this scene, too, although it was read anew.
            let (generation, runs) = (self.model.generation, &mut self.state.runs);
            if runs.identifying != generation && !self.model.is_busy() {
                runs.identifying = generation;
                self.model.ask(Request::Job(IDENTIFYING, identify()));
            }
            return;
        };
        if let Some(Expected { hash, of }) = self.state.runs.expected.take().filter(|expected| expected.hash != hash) {
            let name = opened.scene.name.clone();
            let kept = self.state.runs.runs.list().iter().filter(|kept| kept.hash == hash).count();
            let results = if kept > 0 { " and its kept runs are of the other scene" } else { "" };
            self.fail(format!("{name} is not the scene that the {of} was made with: results may differ{results}"));
        }
        if std::mem::take(&mut self.state.runs.is_saving) {
            self.write_session();
        }
    }

    /// The session as a file.
    fn session_file(&self) -> Option<SessionFile> {
        let (opened, runs) = (self.model.opened.as_ref()?, &self.state.runs);
        let hash = runs.hash(&opened.scene)?;
        let (edits, twins) = (self.model.edits.clone(), self.model.twins);
        let recipe = Recipe { settings: opened.settings.clone(), edits, twins };
        let mut file = SessionFile::new(SavedRun::new(&recipe, &self.link()?, hash));
        file.bookmarks.clone_from(&self.state.bookmarks.list);
        file.watches.clone_from(&self.state.watches.list);
        file.notes.clone_from(&runs.notes);
        file.layout = serde_json::to_string(&self.desk.tree).ok().filter(|text| layout::is_sound(text));
        for kept in runs.runs.list() {
            let (scene, scene_index) = self.host.scene_of(&kept.path);
            let place = Link { scene: (!scene.is_empty()).then_some(scene), scene_index, ..Link::default() };
            let run = SavedRun::new(&kept.recipe, &place, &kept.hash);
            file.runs.push(run.named(&kept.name, &kept.note));
        }
        let index = |id: Option<u64>| runs.runs.list().iter().position(|kept| Some(kept.id) == id);
        (file.reference, file.compared) = (index(runs.reference), index(runs.compared));
        Some(file)
    }

    fn write_session(&mut self) {
        let (Some(file), Some(opened)) = (self.session_file(), &self.model.opened) else { return };
        if file.here.link.scene.as_ref().is_none_or(String::is_empty) {
            self.fail("the session cannot be saved: its scene has no file".into());
            return;
        }
        // Scene names can contain any characters.
        let plain = |c: char| if c.is_alphanumeric() || "-_".contains(c) { c } else { '-' };
        let name: String = opened.scene.name.chars().map(plain).take(100).collect();
        let name = format!("{}.{EXTENSION}", if name.is_empty() { "raystep" } else { &name });
        match file.to_text() {
            Ok(text) => {
                let holds = format!("a session with {}", counted(file.runs.len(), "kept run"));
                self.host.save(FileToSave { name, bytes: text.into_bytes(), holds });
            }
            Err(error) => self.fail(error.to_string()),
        }
    }

    /// Opens a session's file that the host has read; what is open stays if it cannot be read.
    pub(in crate::ui) fn open_session_bytes(&mut self, path: &str, bytes: &[u8]) {
        match SessionFile::from_bytes(bytes) {
            Ok(file) => self.open_session(path, file),
            Err(error) => self.fail(format!("{path}: {error}")),
        }
    }

    /// Opens a session. What is open stays until its scene has been read.
    pub fn open_session(&mut self, path: &str, file: SessionFile) {
        let link = &file.here.link;
        let pixel = match link.ray {
            Some(LinkRay::Pixel(pixel)) => Some(pixel),
            _ => None,
        };
        let place = link.pass.or(Some(usize::MAX));
        let arrival = Arrival { pixel, place, shown: Shown::of(link), scene_hash: None };
        let Some(scene) = self.scene_beside(path, link) else { return };
        let settings = file.here.recipe().settings;
        let opening = Opening { scene: scene.clone(), path: path.to_owned(), file };
        self.open(&scene, settings, arrival);
        self.state.runs.opening = Some(Box::new(opening));
    }

    /// A scene that a session's file names, as the host names it.
    fn scene_beside(&self, session: &str, link: &Link) -> Option<String> {
        let scene = link.scene.as_deref()?;
        if scene.starts_with(BUILT_IN) {
            return Some(scene.to_owned());
        }
        Some(self.host.path_of(&self.host.beside(session, scene), link.scene_index))
    }

    /// The scene of a session, or the plan of a kept run, is ready: the rest follows.
    pub(in crate::ui) fn apply_session(&mut self) {
        let settings = self.model.opened.as_ref().map(|opened| &opened.settings);
        if let Some(recipe) = self.state.runs.restoring.take_if(|recipe| Some(&recipe.settings) == settings) {
            self.restore_edits(recipe.edits, recipe.twins);
        }
        let is_it = |opening: &mut Box<Opening>| Some(&opening.scene) == self.scene.path.as_ref();
        let Some(opening) = self.state.runs.opening.take_if(is_it) else { return };
        let Opening { path, file, scene: own } = *opening;
        if let Some(tree) = file.layout.as_deref().and_then(|text| layout::read(text).ok()) {
            self.desk.tree = tree;
        }
        if !file.watches.is_empty() {
            self.state.watches.list.clone_from(&file.watches);
        }
        let replaced = self.state.runs.runs.list().len();
        let mut runs = KeptRuns { notes: file.notes.clone(), ..KeptRuns::default() };
        runs.runs.set_budget(self.state.runs.runs.budget());
        runs.measurements = self.state.runs.measurements;
        let expected = Some(file.here.scene_hash.clone()).filter(|hash| !hash.is_empty());
        runs.expected = expected.map(|hash| Expected { hash, of: "session" });
        let mut ids = Vec::new();
        for run in &file.runs {
            let recipe = run.recipe();
            let settings = recipe.settings.clone().on(&self.devices.gpu);
            let scene = self.scene_beside(&path, &run.link).unwrap_or_default();
            let id = runs.runs.add(&run.name, Recipe { settings, ..recipe }, scene, run.scene_hash.clone());
            if let Some(kept) = id.and_then(|id| runs.runs.get_mut(id)) {
                kept.note.clone_from(&run.note);
                // Without a hash, the file's name has to do.
                if let Some(opened) = self.model.opened.as_ref().filter(|_| kept.hash.is_empty() && kept.path == own) {
                    kept.scene = Arc::downgrade(&opened.scene);
                }
            }
            ids.push(id);
        }
        let id = |index: Option<usize>| index.and_then(|index| ids.get(index).copied().flatten());
        (runs.reference, runs.compared) = (id(file.reference), id(file.compared));
        self.state.runs = runs;
        self.state.bookmarks.list = file.bookmarks;
        let recipe = file.here.recipe();
        self.restore_edits(recipe.edits, recipe.twins);
        self.state.runs.identifying = self.model.generation;
        self.model.ask(Request::Job(IDENTIFYING, identify()));
        let mut text = format!("session {path} opened, with {}", counted(file.runs.len(), "kept run"));
        if replaced > 0 {
            text += &format!(" in place of {replaced}");
        }
        self.note(text);
        self.remember_session(&path);
    }
}
