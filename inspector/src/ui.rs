//! The window: menus, keys and panels for a run.

mod asked_path;
mod bookmarks;
pub mod canvas;
pub mod command;
mod dialogs;
mod export_dialog;
mod first_steps;
mod focus;
pub mod host;
mod keep;
mod keys;
pub mod latency;
mod layout;
mod lessons;
pub mod mask;
mod maximise;
mod menu;
pub mod offscreen;
mod palette;
pub mod pane;
mod panels;
mod perform;
mod picture;
mod places;
mod runs;
mod scrub;
mod selected;
mod shared;
mod style;
mod take;
mod text_size;
mod thumbs;
mod toast;
mod toolbar;
pub mod units;

use std::collections::VecDeque;
use std::sync::Arc;

use egui_notify::Toasts;
use egui_tiles::Tree;
use raystep_lab::text::counted;

use crate::runs::Runs;
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
pub use lessons::CheckedStep;
use lessons::Lesson;
use pane::{Pane, PaneKind};
use shared::Shared;
pub use shared::{Bookmark, Shown};
pub use style::background;

/// The inspector. The owner of the window calls [`ui`](Self::ui) once per frame.
pub struct Inspector {
    model: Model,
    other: Option<Model>,
    devices: Devices,
    canvas: Arc<Canvas>,
    host: Box<dyn Host>,
    shared: Shared,
    tree: Tree<Pane>,
    dialog: Option<Dialog>,
    /// Paths that the user still has to enter.
    asked: VecDeque<AskedPath>,
    todo: VecDeque<Command>,
    toasts: Toasts,
    is_playing: bool,
    /// Whether the context has our style.
    is_styled: bool,
    /// The path of the open scene as the user entered it, for links and the title.
    path: Option<String>,
    /// Runs known to the panels: in a new one, the selected pixel's ray is followed from the start.
    generation: u64,
    /// What to do once the scene being opened is ready.
    arrival: Option<Arrival>,
    lesson: Option<Lesson>,
    /// Whether something that Escape leaves had keyboard focus at the end of the last frame.
    had_focus: bool,
    focus: focus::Focus,
    maximised: Option<maximise::Maximised>,
    saved: Saved,
    /// Whether it is a part of another page, and shows no menus.
    is_embedded: bool,
}

/// The place to go to in a scene that is being opened.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Arrival {
    /// The ray to look at.
    pub pixel: Option<[u32; 2]>,
    /// The number of passes to run, or as many as there are.
    pub place: Option<usize>,
    /// The view of the first stream panel.
    pub shown: Option<Shown>,
}

impl Arrival {
    /// After the last pass: the initial view of a scene.
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
        let (clock, began_ns) = (devices.clock, devices.clock.map_or(0, |now| now()));
        Self {
            model,
            other: None,
            devices,
            canvas,
            host,
            shared: Shared { clock, began_ns, ..Shared::default() },
            tree: Layout::Simple.tree(),
            dialog: None,
            asked: VecDeque::new(),
            todo: VecDeque::new(),
            toasts: Toasts::default().with_anchor(egui_notify::Anchor::BottomRight),
            is_playing: false,
            is_styled: false,
            path: None,
            generation: 0,
            arrival: None,
            lesson: None,
            had_focus: false,
            focus: focus::Focus::default(),
            maximised: None,
            saved: Saved::default(),
            is_embedded: false,
        }
    }

    /// Shows no menus and no hints, as a part of something else. Keys and commands stay.
    pub fn embed(&mut self) {
        self.is_embedded = true;
    }

    /// Opens a scene by its path; the open one stays until the new one has been read.
    pub fn open(&mut self, path: &str, settings: Settings, arrival: Arrival) {
        let load = match path.starts_with(crate::lesson::built_in::PREFIX) {
            true => crate::lesson::built_in::loader(path),
            false => self.host.loader(path),
        };
        self.arrival = Some(arrival);
        self.model.ask(Request::Open { path: path.to_owned(), load, settings: Box::new(settings) });
    }

    /// Prepares a run of the open scene with other settings, and goes to the place of the present run, which stays until
    /// then.
    pub fn plan(&mut self, settings: Settings) {
        self.model.ask(Request::Plan(Box::new(settings)));
    }

    /// Performs a command, as its menu item would.
    pub fn perform(&mut self, command: Command) {
        self.todo.push_back(command);
    }

    /// Whether work is in progress.
    #[must_use]
    pub fn is_busy(&self) -> bool {
        self.model.is_busy()
            || self.other.as_ref().is_some_and(Model::is_busy)
            || !self.todo.is_empty()
            || self.shared.scrub.is_waiting(self.model.place)
            || self.is_to_follow()
            || self.is_confirming()
            || self.lesson.as_ref().is_some_and(Lesson::is_waiting)
    }

    /// The current run.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The kept runs.
    #[must_use]
    pub fn kept_runs(&self) -> &Runs {
        &self.shared.runs.runs
    }

    /// The last error, in one line.
    #[must_use]
    pub fn last_error(&self) -> Option<&str> {
        self.shared.log.iter().rev().find(|line| line.is_error).map(|line| line.text.as_str())
    }

    /// The selected ray.
    #[must_use]
    pub fn pixel(&self) -> Option<[u32; 2]> {
        self.shared.pixel
    }

    /// The visible panels, excluding those behind other tabs.
    #[must_use]
    pub fn panes_in_view(&self) -> Vec<PaneKind> {
        let panes = self.maximised().map_or_else(|| self.active_panes(), |pane| vec![pane]);
        panes.into_iter().filter_map(|id| self.tree.tiles.get_pane(&id)).map(|pane| pane.kind).collect()
    }

    /// Whether the last frame showed the present place in every stream view.
    #[must_use]
    pub fn is_up_to_date(&self) -> bool {
        !self.shared.is_behind
    }

    /// The place of the first visible panel of a kind, in points.
    #[must_use]
    pub fn rect_of(&self, kind: PaneKind) -> Option<egui::Rect> {
        let mut active = self.tree.active_tiles().into_iter();
        let is_kind = |id: &egui_tiles::TileId| self.tree.tiles.get_pane(id).is_some_and(|pane| pane.kind == kind);
        active.find(is_kind).and_then(|id| self.tree.tiles.rect(id))
    }

    /// The window's title.
    #[must_use]
    pub fn title(&self) -> String {
        self.model.opened.as_ref().map_or_else(|| "raystep".into(), |opened| format!("{} – raystep", opened.scene.name))
    }

    /// For the host that lost the window: how to return to this place; empty without a scene.
    #[must_use]
    pub fn how_to_go_on(&self) -> String {
        let Some(link) = self.link() else { return String::new() };
        format!("; to resume: raystep inspect --link \"{link}\"")
    }

    /// Shows everything, and performs requests.
    pub fn ui(&mut self, ui: &mut egui::Ui) {
        let ctx = ui.ctx().clone();
        if !std::mem::replace(&mut self.is_styled, true) {
            style::set(&ctx);
            text_size::set_up(&ctx, self.saved.text_size);
            ctx.request_discard("the style was set");
        }
        self.shared.is_behind = false;
        let before = self.selection();
        self.listen(&ctx);
        self.model.glance(self.shared.hovered.filter(|&pixel| self.shared.pixel != Some(pixel)));
        focus::reveal(&ctx, &mut self.focus);
        if self.dialog.is_none() {
            self.todo.extend(keys::pressed(&ctx, self.keys_held(&ctx), self.had_focus));
        }
        if !self.is_embedded {
            self.menu_bar(ui);
            self.first_steps(ui);
        }
        self.status_bar(ui);
        self.show_lesson(ui);
        egui::CentralPanel::default().frame(egui::Frame::NONE).show(ui, |ui| self.panes(ui));
        self.show_dialog(&ctx);
        self.had_focus = self.has_focus(&ctx);
        self.toasts.show(&ctx);
        if !ctx.input(|input| input.pointer.any_down()) {
            self.shared.scrub.release();
        }
        if self.shared.thumbs.draw_sketches(&self.canvas, &mut self.model) {
            ctx.request_repaint();
        }
        focus::outline(&ctx, &mut self.focus);
        self.follow_up();
        self.serve_runs();
        self.hand_over();
        self.tell_fired();
        while let Some(command) = self.todo.pop_front() {
            self.execute(&ctx, command);
        }
        self.set_up_lesson();
        // What commands have selected.
        self.follow_up();
        self.model.drop_unwanted_glimpse(ctx.input(|input| input.pointer.any_down()));
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
        // What was selected or pointed at is shown in this frame, not only in the next.
        if self.selection() != before {
            ctx.request_discard("another ray was selected");
        }
    }

    /// Processes the messages of engines and host.
    fn listen(&mut self, ctx: &egui::Context) {
        let (place, is_at_end) = (self.model.place, self.model.next.is_none());
        self.model.update();
        if let Some(other) = &mut self.other {
            other.update();
        }
        let failures = self.model.failures.drain(..).chain(self.other.iter_mut().flat_map(|m| m.failures.drain(..)));
        for (what, message) in failures.collect::<Vec<_>>() {
            if what == OPENING {
                // The place of the old run no longer applies.
                (self.arrival, self.shared.runs.opening) = (None, None);
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
                HostEvent::Read { path, bytes } => self.open_session_bytes(&path, &bytes),
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
            // Other options for the same scene: go to the place of the last run.
            let place = if is_at_end { usize::MAX } else { place };
            self.arrival.get_or_insert(Arrival { place: Some(place), ..Arrival::default() });
            self.arrived();
        } else if !self.model.is_busy() {
            // A scene that could not be opened leaves no state behind.
            self.arrival = None;
        }
    }

    /// A file from a dialog, a drop or the list of recent ones: with the current settings, and the scene's own view.
    fn open_file(&mut self, path: &str) {
        if runs::is_session(path) {
            self.host.read(path);
            return;
        }
        let settings = self.model.opened.as_ref().map(|o| o.settings.clone());
        let settings = settings.unwrap_or_else(|| Settings { device: DeviceKind::Auto, ..Settings::default() });
        let settings = Settings { view: Settings::default().view, ray: None, ..settings };
        self.open(path, settings, Arrival::picture());
    }

    /// A new run is ready.
    fn arrived(&mut self) {
        self.path = self.model.opened.as_ref().and_then(|opened| opened.path.clone());
        self.remember_file();
        self.keep_bookmarks();
        let Some(opened) = &self.model.opened else { return };
        let plan = &opened.plan;
        for note in &opened.scene.notes {
            self.shared.say(false, format!("note: {}", note.0));
        }
        let (triangles, rays) = (counted(plan.triangles, "triangle"), counted(plan.rays, "ray"));
        let text = format!("{}: {triangles}, {rays} on {}", opened.scene.name, opened.device);
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
        self.shared.scrub.stop();
        self.shared.pixel = None;
        self.shared.select = pixel;
        self.shared.show = shown;
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

    fn panes(&mut self, ui: &mut egui::Ui) {
        (self.shared.keeps_keys, self.shared.place) = (false, self.model.place);
        let before = self.shared.select;
        self.focus.begin();
        if !self.show_maximised(ui) {
            self.with_panes(|panes, tree| tree.ui(panes, ui));
        }
        self.note_click(before);
    }

    /// Reports success, also to screen readers and the log.
    pub fn note(&mut self, text: impl Into<String>) {
        let text = text.into();
        self.shared.say(false, text.clone());
        self.tell(text);
    }

    fn fail(&mut self, message: String) {
        self.is_playing = false;
        self.shared.say(true, message.clone());
        self.warn(message);
    }

    /// Performs the requests that panels left in the shared state.
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
        let target = self.shared.scrub.next(self.model.place, self.model.served());
        if let Some(place) = target {
            self.model.ask(Request::Step(Target::Pass(place)));
            self.shared.scrub.sent(place, self.model.sent());
        }
        self.follow_selected();
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
