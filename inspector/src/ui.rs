//! The window: menus, keys and panels for a run.

mod arrivals;
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
mod preview;
pub mod retained;
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
use raystep_lab::Hash;

use crate::runs::Runs;
use crate::saved::Saved;
use crate::session::engine::Devices;
use crate::session::request::Request;
use crate::session::{Model, Target};
use crate::settings::Settings;
use asked_path::AskedPath;
use canvas::Canvas;
use command::Command;
use dialogs::Dialog;
use host::Host;
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
    /// The path of the scene that was opened last, until its run has nothing more to do.
    opening: Option<String>,
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
            opening: None,
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
            false => self.host.loader(path, &settings),
        };
        self.arrival = Some(arrival);
        (self.opening, self.shared.preview) = (Some(path.to_owned()), None);
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

    /// Whether a stream view shows a picture of the scene: a preview, or that of the run.
    #[must_use]
    pub fn shows_picture(&self) -> bool {
        self.shared.preview.is_some() || self.model.opened.is_some() && self.model.next.is_none()
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
