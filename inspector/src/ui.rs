//! The window: menus, keys and panels over a run.

mod asked_path;
pub mod canvas;
pub mod command;
mod dialogs;
pub mod host;
mod keep;
mod layout;
mod lessons;
mod menu;
pub mod offscreen;
mod palette;
pub mod pane;
mod panels;
mod perform;
mod places;
mod shared;
mod take;
mod toast;

use std::collections::VecDeque;
use std::sync::Arc;

use egui_notify::Toasts;
use egui_tiles::Tree;

use crate::saved::Saved;
use crate::session::engine::{Devices, OPENING};
use crate::session::request::{Opened, Request};
use crate::session::{Model, Target};
use crate::settings::{DeviceKind, Settings, View};
use asked_path::{AskedPath, NOT_WRITTEN};
use canvas::Canvas;
use command::Command;
use dialogs::Dialog;
use host::{Host, HostEvent};
use layout::Layout;
use lessons::Lesson;
use pane::{Context, Pane, PaneKind};
use shared::Shared;
pub use shared::Shown;

/// The inspector. Whoever has a window calls [`ui`](Self::ui) once a frame.
pub struct Inspector {
    model: Model,
    other: Option<Model>,
    devices: Devices,
    canvas: Arc<Canvas>,
    host: Box<dyn Host>,
    shared: Shared,
    tree: Tree<Pane>,
    dialog: Option<Dialog>,
    /// Paths that are still to be asked for.
    asked: VecDeque<AskedPath>,
    todo: VecDeque<Command>,
    toasts: Toasts,
    is_playing: bool,
    /// The path of the scene that is open, as the user gave it, for links and the title.
    path: Option<String>,
    /// Runs known to the panels: a new one is followed from its selected pixel.
    generation: u64,
    /// What to do once the scene that is being opened is there.
    arrival: Option<Arrival>,
    lesson: Option<Lesson>,
    /// The selected ray is still to be followed.
    is_to_follow: bool,
    /// Something had the keys at the end of the last frame.
    had_focus: bool,
    saved: Saved,
}

/// Where to go in a scene that is still being opened.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Arrival {
    /// The ray to look at.
    pub pixel: Option<[u32; 2]>,
    /// After so many passes, or as many as there are.
    pub place: Option<usize>,
    /// What the first stream view is to show.
    pub shown: Option<Shown>,
}

impl Arrival {
    /// After the last pass: how a scene is seen first.
    #[must_use]
    pub fn picture() -> Self {
        Self { pixel: None, place: Some(usize::MAX), shown: None }
    }
}

impl Inspector {
    /// An inspector without a scene. `renderer` is egui's own, on the device of `devices`.
    #[must_use]
    pub fn new(
        devices: Devices,
        renderer: Arc<egui::mutex::RwLock<egui_wgpu::Renderer>>,
        mut host: Box<dyn Host>,
    ) -> Self {
        let canvas = Arc::new(Canvas::new(devices.gpu.clone(), renderer));
        let for_engine = devices.clone();
        let (model, task) = Model::new(|engine| engine.serve(for_engine));
        host.spawn(task);
        Self {
            model,
            other: None,
            devices,
            canvas,
            host,
            shared: Shared::default(),
            tree: Layout::Simple.tree(),
            dialog: None,
            asked: VecDeque::new(),
            todo: VecDeque::new(),
            toasts: Toasts::default().with_anchor(egui_notify::Anchor::BottomRight),
            is_playing: false,
            path: None,
            generation: 0,
            arrival: None,
            lesson: None,
            is_to_follow: false,
            had_focus: false,
            saved: Saved::default(),
        }
    }

    /// Opens a scene by its path; the one that is open stays until the new one has been read.
    pub fn open(&mut self, path: &str, settings: Settings, arrival: Arrival) {
        let load = match path {
            lessons::BUILT_IN => Box::new(|| Ok(raystep_scenes::generate::cornell_box())),
            path => self.host.loader(path),
        };
        self.arrival = Some(arrival);
        self.model.ask(Request::Open { path: path.to_owned(), load, settings: Box::new(settings) });
    }

    /// Does a command, as a menu would.
    pub fn perform(&mut self, command: Command) {
        self.todo.push_back(command);
    }

    /// Whether work goes on.
    #[must_use]
    pub fn is_busy(&self) -> bool {
        self.model.is_busy()
            || self.other.as_ref().is_some_and(Model::is_busy)
            || !self.todo.is_empty()
            || self.is_to_follow
            || self.lesson.as_ref().is_some_and(Lesson::is_waiting)
    }

    /// The run that is shown.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// What went wrong last, in one line.
    #[must_use]
    pub fn last_error(&self) -> Option<&str> {
        self.shared.log.iter().rev().find(|line| line.is_error).map(|line| line.text.as_str())
    }

    /// The ray that is looked at.
    #[must_use]
    pub fn pixel(&self) -> Option<[u32; 2]> {
        self.shared.pixel
    }

    /// The panels in view, not those behind other tabs.
    #[must_use]
    pub fn panes_in_view(&self) -> Vec<PaneKind> {
        let active = self.tree.active_tiles().into_iter();
        active.filter_map(|id| self.tree.tiles.get_pane(&id)).map(|pane| pane.kind).collect()
    }

    /// The window's title.
    #[must_use]
    pub fn title(&self) -> String {
        self.model.opened.as_ref().map_or_else(|| "raystep".into(), |opened| format!("{} – raystep", opened.scene.name))
    }

    /// For whoever lost the window: how to come back to this place; empty without a scene.
    #[must_use]
    pub fn how_to_go_on(&self) -> String {
        let Some(link) = self.link() else { return String::new() };
        format!("; to go on: raystep inspect --link \"{link}\"")
    }

    /// Shows everything, and does what was asked for.
    pub fn ui(&mut self, ui: &mut egui::Ui) {
        let ctx = ui.ctx().clone();
        self.listen(&ctx);
        if self.dialog.is_none() {
            self.todo.extend(command::pressed(&ctx, self.had_focus));
        }
        self.menu_bar(ui);
        self.status_bar(ui);
        egui::CentralPanel::default().frame(egui::Frame::NONE).show(ui, |ui| self.panes(ui));
        self.show_dialog(&ctx);
        self.had_focus = ctx.egui_wants_keyboard_input();
        self.toasts.show(&ctx);
        self.show_lesson(&ctx);
        self.follow_up();
        self.hand_over();
        self.tell_fired();
        while let Some(command) = self.todo.pop_front() {
            self.execute(&ctx, command);
        }
        if self.is_playing && !self.model.is_busy() {
            if self.model.next.is_some() {
                self.model.ask(Request::Step(Target::Next));
            } else {
                self.is_playing = false;
            }
        }
        if self.is_playing {
            ctx.request_repaint();
        }
    }

    /// Takes in what engines and host have said.
    fn listen(&mut self, ctx: &egui::Context) {
        let (place, is_at_end) = (self.model.place, self.model.next.is_none());
        self.model.update();
        if let Some(other) = &mut self.other {
            other.update();
        }
        let failures = self.model.failures.drain(..).chain(self.other.iter_mut().flat_map(|m| m.failures.drain(..)));
        for (what, message) in failures.collect::<Vec<_>>() {
            if what == OPENING {
                // Nobody arrives there: the next run is another one.
                self.arrival = None;
            }
            self.fail(format!("{what}: {message}"));
        }
        let cancelled = self.model.cancelled.drain(..).chain(self.other.iter_mut().flat_map(|m| m.cancelled.drain(..)));
        if cancelled.filter(|&what| what == take::EXPORTING).count() > 0 {
            self.note(NOT_WRITTEN);
        }
        for event in self.host.events() {
            match event {
                HostEvent::Chosen(path) => self.open_file(&path),
                HostEvent::Saved { holds, path } => self.note(format!("{holds} written to {path}")),
                HostEvent::Cancelled(what) => self.note(what),
                HostEvent::AskPath { file, path, why } => self.asked.push_back(AskedPath::new(file, path, why)),
                HostEvent::Failed(message) => self.fail(message),
            }
        }
        let dropped = ctx.input(|input| input.raw.dropped_files.first().map(|file| file.path().to_owned()));
        if let Some(path) = dropped {
            self.open_file(&path.to_string_lossy());
        }
        if self.generation != self.model.generation {
            self.generation = self.model.generation;
            // Other options of the same scene: where the last run was.
            let place = if is_at_end { usize::MAX } else { place };
            self.arrival.get_or_insert(Arrival { place: Some(place), ..Arrival::default() });
            self.arrived();
        } else if !self.model.is_busy() {
            // What could not be opened leaves nothing behind.
            self.arrival = None;
        }
    }

    /// A file from a dialog, a drop or the list of recent ones: with the settings in use, seen as it wants.
    fn open_file(&mut self, path: &str) {
        let settings = self.model.opened.as_ref().map(|o| o.settings.clone());
        let settings = settings.unwrap_or_else(|| Settings { device: DeviceKind::Auto, ..Settings::default() });
        let settings = Settings { view: Settings::default().view, ray: None, ..settings };
        self.open(path, settings, Arrival::picture());
    }

    /// A new run is there.
    fn arrived(&mut self) {
        self.path = self.model.opened.as_ref().and_then(|opened| opened.path.clone());
        self.remember_file();
        let Some(opened) = &self.model.opened else { return };
        let plan = &opened.plan;
        for note in &opened.scene.notes {
            self.shared.say(false, format!("note: {}", note.0));
        }
        let text =
            format!("{}: {} triangles, {} rays on {}", opened.scene.name, plan.triangles, plan.rays, opened.device);
        self.shared.say(false, text);
        let Arrival { pixel, place, shown } = self.arrival.take().unwrap_or_default();
        let inside = |[x, y]: &[u32; 2]| *x < plan.width && *y < plan.height;
        let pixel = pixel.or(self.shared.pixel).filter(inside).or(Some([plan.width / 2, plan.height / 2]));
        let missing = missing_camera(opened);
        let is_other = |m: &Model| m.opened.as_ref().is_some_and(|b| !Arc::ptr_eq(&b.scene, &opened.scene));
        if self.other.as_ref().is_some_and(is_other)
            && let Some(other) = self.other.take()
        {
            other.cancel();
        }
        self.shared.pixel = None;
        self.shared.select = pixel;
        self.shared.show = shown;
        if let Some(place) = place {
            self.model.ask(Request::Step(Target::Pass(place)));
        }
        if let Some(missing) = missing {
            self.fail(missing);
        }
    }

    fn panes(&mut self, ui: &mut egui::Ui) {
        let mut todo = Vec::new();
        let cx = Context {
            model: &mut self.model,
            other: self.other.as_mut(),
            canvas: &self.canvas,
            shared: &mut self.shared,
            todo: &mut todo,
        };
        self.tree.ui(&mut layout::Panes { cx }, ui);
        self.todo.extend(todo);
    }

    /// Says what was done, also to who looks later.
    fn note(&mut self, text: impl Into<String>) {
        let text = text.into();
        self.shared.say(false, text.clone());
        self.tell(text);
    }

    fn fail(&mut self, message: String) {
        self.is_playing = false;
        self.shared.say(true, message.clone());
        self.warn(message);
    }

    /// What panels asked for through what they share.
    fn follow_up(&mut self) {
        if let Some(path) = self.shared.open.take() {
            self.open_file(&path);
        }
        if let Some(link) = self.shared.visit.take() {
            self.go_to_link(&link);
        }
        for copy in self.model.pinned.drain(..) {
            layout::add(&mut self.tree, Pane::pinned(copy));
        }
        if let Some(place) = self.shared.go_to.take()
            && place != self.model.place
        {
            self.model.ask(Request::Step(Target::Pass(place)));
        }
        if let Some(pixel) = self.shared.select.take() {
            // A ray whose following was cancelled can be clicked again.
            let is_known = self.model.life.as_ref().is_some_and(|life| life.pixel == pixel);
            if self.shared.pixel != Some(pixel) || !is_known {
                self.shared.pixel = Some(pixel);
                self.is_to_follow = true;
            }
        }
        // One at a time: while a key is held, the last one counts.
        if let Some(pixel) = self.shared.pixel.filter(|_| self.is_to_follow && !self.model.is_busy()) {
            self.is_to_follow = false;
            self.model.ask(Request::Follow(pixel));
            if let Some(other) = &mut self.other {
                other.ask(Request::Follow(pixel));
            }
        }
    }
}

/// What to say where the scene has no such camera.
fn missing_camera(opened: &Opened) -> Option<String> {
    let (View::Scene(index), count) = (opened.settings.view, opened.scene.cameras.len()) else { return None };
    let text = format!("camera {index}: the scene has {count}, counted from 0; one that frames it is shown");
    (index > 0 && index >= count).then_some(text)
}
