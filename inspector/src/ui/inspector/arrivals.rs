//! What arrives at the inspector: answers of engines, events of the host, files, and runs that are ready.

use crate::command::Layout;
use crate::exports::EXPORTING;
use crate::session_file;
use crate::ui::desk::arranged::Now;
use crate::ui::preview::PreviewTexture;
use std::sync::Arc;

use raystep_lab::text::counted;

use super::asked_path::{AskedPath, NOT_WRITTEN};
use crate::session::engine::{OPENING, PREPARING};
use crate::session::request::{Opened, Request};
use crate::session::{Model, Target};
use crate::settings::{DeviceKind, Settings, View};
use crate::ui::host::HostEvent;
use crate::ui::{Arrival, Inspector};

impl Inspector {
    /// Processes the messages of engines and host.
    pub(super) fn listen(&mut self, ctx: &egui::Context) {
        let (place, is_at_end) = (self.model.place, self.model.next.is_none());
        self.model.update();
        if let Some(other) = &mut self.other {
            other.update();
        }
        let failures = self.model.failures.drain(..).chain(self.other.iter_mut().flat_map(|m| m.failures.drain(..)));
        for (what, message) in failures.collect::<Vec<_>>() {
            if what == OPENING {
                // The place of the old run no longer applies.
                (self.scene.arrival, self.state.runs.opening) = (None, None);
            }
            if what == PREPARING && std::mem::take(&mut self.scene.awaits_kernel) {
                self.refuse_kernel(message);
            } else {
                self.fail(format!("{what}: {message}"));
            }
        }
        let cancelled = self.model.cancelled.drain(..).chain(self.other.iter_mut().flat_map(|m| m.cancelled.drain(..)));
        let cancelled: Vec<_> = cancelled.collect();
        self.scene.awaits_kernel &= !cancelled.contains(&PREPARING);
        if cancelled.contains(&EXPORTING) {
            self.note(NOT_WRITTEN);
        }
        for event in self.host.events() {
            match event {
                HostEvent::Chosen(path) => self.open_file(&path),
                // It is of use as long as its scene is being opened.
                HostEvent::Previewed { path, preview } if self.scene.opening.as_ref() == Some(&path) => {
                    self.state.display.preview = Some(PreviewTexture::new(ctx, &preview));
                }
                HostEvent::Previewed { .. } => {}
                HostEvent::Changed { path } => self.scene.has_changed |= self.scene.path.as_ref() == Some(&path),
                HostEvent::Read { path, bytes } if self.is_kernel(&path) => self.take_kernel(&path, bytes),
                HostEvent::Read { path, bytes } => self.open_session_bytes(&path, &bytes),
                HostEvent::Saved { holds, path } => self.note(format!("{holds} written to {path}")),
                HostEvent::Cancelled(what) => self.note(what),
                HostEvent::AskPath { file, path, why } => self.dialogs.asked.push_back(AskedPath::new(file, path, why)),
                HostEvent::Failed(message) => self.fail(message),
            }
        }
        let dropped = ctx.input(|input| input.raw.dropped_files.first().map(|file| file.path().to_owned()));
        if let Some(path) = dropped {
            self.open_file(&path.to_string_lossy());
        }
        if self.scene.generation != self.model.generation {
            self.scene.generation = self.model.generation;
            // Other options for the same scene: go to the place of the last run.
            let place = if is_at_end { usize::MAX } else { place };
            let asked = self.scene.arrival.as_ref().and_then(|arrival| arrival.place);
            self.scene.asked_place = asked.filter(|&place| place < usize::MAX);
            self.scene.arrival.get_or_insert(Arrival { place: Some(place), ..Arrival::default() });
            self.arrived();
        } else if !self.model.is_busy() {
            // A scene that could not be opened leaves no state behind.
            self.scene.arrival = None;
        }
        // Once the run is at its first place, or has failed, streams are shown.
        if !self.model.is_busy() {
            (self.scene.opening, self.state.display.preview) = (None, None);
            self.tell_missing_place();
        }
    }

    /// Says so if the run has fewer passes than it was to go to.
    fn tell_missing_place(&mut self) {
        let Some(asked) = self.scene.asked_place.take() else { return };
        let passes = self.model.passes.len();
        if self.model.opened.is_some() && self.model.next.is_none() && asked > passes {
            let of_run = counted(passes, "pass");
            self.fail(format!("pass {asked}: the run has {of_run}; it is shown after the last"));
        }
    }

    /// A file from a dialog, a drop or the list of recent ones: with the current settings, and the scene's own view.
    pub(super) fn open_file(&mut self, path: &str) {
        if session_file::is_session(path) || self.is_kernel(path) {
            self.host.read(path);
            return;
        }
        let settings = self.model.opened.as_ref().map(|o| o.settings.clone());
        let settings = settings.unwrap_or_else(|| Settings { device: DeviceKind::Auto, ..Settings::default() });
        let settings = Settings { view: Settings::default().view, ray: None, ..settings };
        self.open(path, settings, Arrival::picture());
    }

    /// The scene's file again, at the same place.
    pub(super) fn reload(&mut self) {
        let (Some(path), Some(opened)) = (self.scene.path.clone(), &self.model.opened) else { return };
        let arrival = Arrival {
            place: Some(if self.model.next.is_none() { usize::MAX } else { self.model.place }),
            shown: self.state.display.shown,
            ..Arrival::default()
        };
        self.open(&path, opened.settings.clone(), arrival);
    }

    /// A new run is ready.
    fn arrived(&mut self) {
        self.scene.path = self.model.opened.as_ref().and_then(|opened| opened.path.clone());
        self.scene.has_changed = false;
        (self.scene.awaits_kernel, self.state.display.kernel_error) = (false, None);
        self.watch_kernels();
        self.remember_file();
        let scene = self.scene.path.as_deref().map(|path| {
            let (scene, index) = self.host.scene_of(path);
            index.map_or_else(|| scene.clone(), |index| format!("{scene}#{index}"))
        });
        if !self.model.has_rays() && self.desk.arranged.now == Now::Task(Layout::Overview) {
            // Its panels are about rays.
            self.desk.arrange(Now::Task(Layout::Step));
        }
        let Some(opened) = &self.model.opened else { return };
        let plan = &opened.plan;
        self.state.bookmarks.keep(scene, [plan.width, plan.height]);
        for note in &opened.scene.notes {
            self.state.log.say(false, format!("note: {}", note.0));
        }
        let (triangles, rays) = (counted(plan.triangles, "triangle"), counted(plan.rays, "ray"));
        let text = format!("{}: {triangles}, {rays} on {}", opened.scene.name, opened.device);
        self.state.log.say(false, text);
        let Arrival { pixel, place, shown, scene_hash } = self.scene.arrival.take().unwrap_or_default();
        let inside = |[x, y]: &[u32; 2]| *x < plan.width && *y < plan.height;
        let pixel = pixel.or(self.state.selection.pixel).filter(inside).or_else(|| self.model.telling_pixel());
        let pixel = pixel.or(Some([plan.width / 2, plan.height / 2]));
        let missing = missing_camera(opened);
        let is_other = |m: &Model| m.opened.as_ref().is_some_and(|b| !Arc::ptr_eq(&b.scene, &opened.scene));
        if self.other.as_ref().is_some_and(is_other)
            && let Some(other) = self.other.take()
        {
            other.cancel();
        }
        self.state.asks.scrub.stop();
        self.state.selection.pixel = None;
        self.state.asks.select = pixel;
        self.state.asks.show = shown;
        self.state.runs.expect(scene_hash);
        self.apply_session();
        // The engine may have gone there already.
        let is_there = |place: usize| {
            self.model.place == place || self.model.place < place && self.model.next.is_none() && self.model.place > 0
        };
        if let Some(place) = place.filter(|&place| !is_there(place)) {
            self.model.ask(Request::Step(Target::Pass(place)));
        }
        if let Some(missing) = missing {
            self.fail(missing);
        }
    }
}

/// The message if the scene has no such camera.
fn missing_camera(opened: &Opened) -> Option<String> {
    let (View::Scene(index), count) = (opened.settings.view, opened.scene.cameras.len()) else { return None };
    let text = format!(
        "camera {index} does not exist (the scene has {count}, counted from 0); using one that frames \
                        the scene"
    );
    (index > 0 && index >= count).then_some(text)
}
