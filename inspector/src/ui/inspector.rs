//! The inspector: what is open, what it shows, and what performs commands on it.

mod arrivals;
mod asked_path;
mod dialogs;
mod export_dialog;
mod first_steps;
mod keep;
mod lessons;
mod menu;
mod own_kernels;
mod palette;
mod perform;
mod places;
mod runs;
mod selected;
mod take;
mod text_size;
mod toolbar;

use std::collections::VecDeque;
use std::sync::Arc;

use raystep_lab::Hash;

use super::canvas::Canvas;
use super::desk::{Desk, layout};
use super::host::Host;
use super::pane::Context;
use super::panes::Pane;
use super::state::State;
use super::{keys, style};
use crate::command::{Command, PaneKind};
use crate::link::Shown;
use crate::runs::Runs;
use crate::saved::Saved;
use crate::session::devices::Devices;
use crate::session::request::Request;
use crate::session::{Model, Target};
use crate::settings::Settings;
use dialogs::Dialogs;
pub use lessons::CheckedStep;
use lessons::Lesson;

/// The inspector. The owner of the window calls [`ui`](Self::ui) once per frame.
pub struct Inspector {
    model: Model,
    other: Option<Model>,
    devices: Devices,
    canvas: Arc<Canvas>,
    host: Box<dyn Host>,
    /// What panels share.
    state: State,
    /// How panels are arranged.
    desk: Desk,
    dialogs: Dialogs,
    todo: VecDeque<Command>,
    scene: OpenScene,
    lesson: Option<Lesson>,
    saved: Saved,
    is_playing: bool,
    /// Whether the context has our style.
    is_styled: bool,
    /// Whether it is a part of another page, and shows no menus.
    is_embedded: bool,
}

/// The scene that is open, and the one that is being opened.
#[derive(Default)]
struct OpenScene {
    /// The path of the open scene as the user entered it, for links and the title.
    path: Option<String>,
    /// Whether its file was written since it was opened.
    has_changed: bool,
    /// Whether the run that is being made is the first with a version of a user's kernel.
    awaits_kernel: bool,
    /// Runs known to the panels: in a new one, the selected pixel's ray is followed from the start.
    generation: u64,
    /// What to do once the scene being opened is ready.
    arrival: Option<Arrival>,
    /// The number of passes that a link, a session or an option asked for, until the run is there.
    asked_place: Option<usize>,
    /// The path of the scene that was opened last, until its run has nothing more to do.
    opening: Option<String>,
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
    /// The hash of the scene's contents, as far as it is known; another scene is said to be one.
    pub scene_hash: Option<Hash>,
}

impl Arrival {
    /// After the last pass: the initial view of a scene.
    #[must_use]
    pub fn picture() -> Self {
        Self { place: Some(usize::MAX), ..Self::default() }
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
        let mut state = State::default();
        state.log.clock = devices.clock.map(|now| (now, now()));
        Self {
            model,
            other: None,
            devices,
            canvas,
            host,
            state,
            desk: Desk::default(),
            dialogs: Dialogs::default(),
            todo: VecDeque::new(),
            scene: OpenScene::default(),
            lesson: None,
            saved: Saved::default(),
            is_playing: false,
            is_styled: false,
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
            false => self.host.loader(path, &settings),
        };
        (self.scene.arrival, self.scene.opening) = (Some(arrival), Some(path.to_owned()));
        self.state.display.preview = None;
        self.model.ask(Request::Open { path: path.to_owned(), load, settings: Box::new(settings) });
    }

    /// Prepares a run of the open scene with other settings, and goes to the place of the present run, which stays until
    /// then.
    pub fn plan(&mut self, settings: Settings) {
        self.model.ask(Request::Plan(Box::new(settings)));
    }

    /// The pictures of streams that were drawn again since this was last asked, for an owner of the window that does
    /// not draw all of it in each frame.
    #[must_use]
    pub fn take_redrawn(&self) -> std::collections::BTreeSet<egui::TextureId> {
        self.canvas.take_redrawn()
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
            || self.state.asks.scrub.is_waiting(self.model.place)
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
        &self.state.runs.runs
    }

    /// The last error, in one line.
    #[must_use]
    pub fn last_error(&self) -> Option<&str> {
        self.state.log.lines.iter().rev().find(|line| line.is_error).map(|line| line.text.as_str())
    }

    /// The selected ray.
    #[must_use]
    pub fn pixel(&self) -> Option<[u32; 2]> {
        self.state.selection.pixel
    }

    /// The name of the layout that is shown.
    #[must_use]
    pub fn layout(&self) -> &str {
        self.desk.arranged.now.name()
    }

    /// The visible panels, excluding those behind other tabs.
    #[must_use]
    pub fn panes_in_view(&self) -> Vec<PaneKind> {
        self.desk.in_view()
    }

    /// Whether a stream view shows a picture of the scene: a preview, or that of the run.
    #[must_use]
    pub fn shows_picture(&self) -> bool {
        self.state.display.preview.is_some() || self.model.opened.is_some() && self.model.next.is_none()
    }

    /// Whether the last frame showed the present place in every stream view.
    #[must_use]
    pub fn is_up_to_date(&self) -> bool {
        !self.state.display.is_behind
    }

    /// The place of the first visible panel of a kind, in points.
    #[must_use]
    pub fn rect_of(&self, kind: PaneKind) -> Option<egui::Rect> {
        self.desk.rect_of(kind)
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
            // Its fonts are there in the next pass.
            ctx.request_discard("the style was set");
            return;
        }
        self.state.display.is_behind = false;
        let before = self.selection();
        self.listen(&ctx);
        self.model.glance(self.state.selection.hovered.filter(|&pixel| self.state.selection.pixel != Some(pixel)));
        self.desk.begin(&ctx);
        if self.dialogs.open.is_none() {
            let held = self.desk.keys_held(&ctx, self.state.display.keeps_keys);
            self.todo.extend(keys::pressed(&ctx, held, self.desk.had_focus(), self.lesson.is_some()));
        }
        if !self.is_embedded {
            self.menu_bar(ui);
            self.offer_reload(ui);
            self.first_steps(ui);
        }
        self.status_bar(ui);
        self.state.display.hides_next = self.lesson.as_ref().is_some_and(Lesson::hides_next);
        self.show_lesson(ui);
        egui::CentralPanel::default().frame(egui::Frame::NONE).show(ui, |ui| self.panes(ui));
        self.show_dialog(&ctx);
        self.desk.note_focus(&ctx);
        self.state.log.toasts.show(&ctx);
        if !ctx.input(|input| input.pointer.any_down()) {
            self.state.asks.scrub.release();
        }
        if self.state.display.thumbs.draw_sketches(&self.canvas, &mut self.model) {
            ctx.request_repaint();
        }
        self.desk.end(&ctx);
        self.follow_up();
        self.serve_runs();
        self.hand_over();
        self.tell_fired();
        while let Some(command) = self.todo.pop_front() {
            self.execute(&ctx, command);
        }
        self.set_up_lesson();
        self.play_lesson(&ctx);
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

    fn panes(&mut self, ui: &mut egui::Ui) {
        (self.state.display.keeps_keys, self.state.log.place) = (false, self.model.place);
        let before = self.state.asks.select;
        let cx = Context::new(&mut self.model, self.other.as_mut(), &self.canvas, &mut self.state);
        self.desk.show(ui, cx);
        self.todo.extend(self.state.asks.commands.drain(..));
        let asked = self.state.asks.select;
        self.saved.first_steps.has_clicked |= asked.is_some() && asked != before;
    }

    /// Asks the panels to perform a command about a view.
    fn ask_panels(&mut self, command: Command) {
        let mut cx = Context::new(&mut self.model, self.other.as_mut(), &self.canvas, &mut self.state);
        self.desk.ask(command, &mut cx);
        self.todo.extend(self.state.asks.commands.drain(..));
    }

    /// Reports success, also to screen readers and the log.
    pub fn note(&mut self, text: impl Into<String>) {
        self.state.log.note(text);
    }

    fn fail(&mut self, message: String) {
        self.is_playing = false;
        self.state.log.fail(message);
    }

    /// Performs the requests that panels left in the shared state.
    fn follow_up(&mut self) {
        if let Some(path) = self.state.asks.open.take() {
            self.open_file(&path);
        }
        if let Some(link) = self.state.asks.visit.take() {
            self.go_to_link(&link);
        }
        for copy in self.model.pinned.drain(..) {
            layout::add(&mut self.desk.tree, Pane::pinned(copy));
        }
        if let Some(kind) = self.state.asks.panel.take() {
            layout::show(&mut self.desk.tree, kind);
        }
        if let Some(place) = self.state.asks.go_to.take()
            && place != self.model.place
        {
            self.model.ask(Request::Step(Target::Pass(place)));
        }
        let target = self.state.asks.scrub.next(self.model.place, self.model.served());
        if let Some(place) = target {
            self.model.ask(Request::Step(Target::Pass(place)));
            self.state.asks.scrub.sent(place, self.model.sent());
        }
        self.follow_selected();
    }
}
