//! The actions whose responses are timed.

use egui::{Event, Key, Modifiers, PointerButton, Pos2, Rect, vec2};

use crate::command::{Command, Layout, PaneKind};
use crate::ui::Inspector;

/// The name of the row that others are compared with.
pub(super) const REPAINTS: &str = "two idle repaints";

/// So many actions begin with the program.
pub(super) const OPENING: usize = 2;

/// An action.
pub(super) struct Action {
    pub(super) name: &'static str,
    /// What its median may take at most.
    pub(super) limit_ms: f64,
    pub(super) times: usize,
    /// Frames that it takes at least.
    pub(super) frames: u32,
    /// Its events, the `i`-th time.
    pub(super) events: fn(&mut Inspector, usize) -> Vec<Event>,
    /// Whether the response is known.
    pub(super) is_shown: fn(&Inspector, &Before) -> bool,
}

/// The state before an action.
pub(super) struct Before {
    pixel: Option<[u32; 2]>,
    place: usize,
    generation: u64,
}

impl Before {
    pub(super) fn of(inspector: &Inspector) -> Self {
        let model = inspector.model();
        Self { pixel: inspector.pixel(), place: model.place, generation: model.generation }
    }
}

/// All actions, in order.
pub(super) const ACTIONS: &[Action] = &[
    Action {
        name: "start, until a picture of the scene is there",
        limit_ms: 500.0,
        times: 1,
        frames: 1,
        events: none,
        is_shown: |inspector, _| inspector.shows_picture(),
    },
    Action {
        name: "start, until the run's picture is there",
        limit_ms: 1500.0,
        times: 1,
        frames: 1,
        events: none,
        is_shown: is_there,
    },
    Action { name: REPAINTS, limit_ms: f64::INFINITY, times: 30, frames: 2, events: none, is_shown: |_, _| true },
    Action {
        name: "click, until the ray's history is there",
        limit_ms: 100.0,
        times: 50,
        frames: 1,
        events: click,
        is_shown: ray,
    },
    Action { name: "hover", limit_ms: 50.0, times: 50, frames: 1, events: hover, is_shown: |_, _| true },
    Action {
        name: "arrow key, until the neighbour's history is there",
        limit_ms: 100.0,
        times: 50,
        frames: 1,
        events: arrow,
        is_shown: ray,
    },
    Action {
        name: "Shift+F10",
        limit_ms: 250.0,
        times: 30,
        frames: 1,
        events: |_, _| key(Modifiers::SHIFT, Key::F10),
        is_shown: |i, was| i.model().place < was.place,
    },
    Action {
        name: "F10",
        limit_ms: 100.0,
        times: 30,
        frames: 1,
        events: |_, _| key(Modifiers::NONE, Key::F10),
        is_shown: |i, was| i.model().place > was.place,
    },
    Action {
        name: "Home, End",
        limit_ms: 1500.0,
        times: 10,
        frames: 1,
        events: |_, i| key(Modifiers::NONE, if i % 2 == 0 { Key::Home } else { Key::End }),
        is_shown: |i, was| i.model().place != was.place && !i.model().is_busy(),
    },
    Action {
        name: "Shift+F10 from the end, and back",
        limit_ms: 250.0,
        times: 10,
        frames: 1,
        events: |_, i| if i % 2 == 0 { key(Modifiers::SHIFT, Key::F10) } else { key(Modifiers::NONE, Key::F10) },
        is_shown: |i, was| i.model().place != was.place,
    },
    Action {
        name: "the Ray layout",
        limit_ms: 1000.0,
        times: 1,
        frames: 1,
        events: |inspector, _| {
            inspector.perform(Command::Arrange(Layout::Ray));
            Vec::new()
        },
        is_shown: |i, _| i.panes_in_view().contains(&PaneKind::Walk3d),
    },
    Action {
        name: "– two idle repaints of it",
        limit_ms: f64::INFINITY,
        times: 30,
        frames: 2,
        events: none,
        is_shown: |_, _| true,
    },
    Action {
        name: "– click, until the ray's history is there",
        limit_ms: 100.0,
        times: 30,
        frames: 1,
        events: click,
        is_shown: ray,
    },
    Action { name: "– hover", limit_ms: 50.0, times: 30, frames: 1, events: hover, is_shown: |_, _| true },
    Action { name: "– orbit, a frame", limit_ms: 100.0, times: 50, frames: 1, events: orbit, is_shown: |_, _| true },
    Action {
        name: "– another camera, until its picture is there",
        limit_ms: 1500.0,
        times: 5,
        frames: 1,
        events: camera,
        is_shown: |i, was| i.model().generation > was.generation,
    },
    Action {
        name: "– a kernel that was saved, until its picture is there",
        limit_ms: 1000.0,
        times: 10,
        frames: 1,
        events: kernel,
        is_shown: |i, was| i.model().generation > was.generation && !i.model().is_busy(),
    },
];

fn none(_: &mut Inspector, _: usize) -> Vec<Event> {
    Vec::new()
}

fn is_there(inspector: &Inspector, _: &Before) -> bool {
    inspector.model().is_complete && !inspector.model().is_busy()
}

/// Another ray is selected, and its history is there.
fn ray(inspector: &Inspector, was: &Before) -> bool {
    let pixel = inspector.pixel();
    pixel != was.pixel && inspector.model().history.as_ref().map(|history| history.pixel) == pixel
}

fn key(modifiers: Modifiers, key: Key) -> Vec<Event> {
    let event = |pressed| Event::Key { key, physical_key: None, pressed, repeat: false, modifiers };
    vec![Event::ModifiersChanged(modifiers), event(true), event(false), Event::ModifiersChanged(Modifiers::NONE)]
}

fn arrow(_: &mut Inspector, i: usize) -> Vec<Event> {
    key(Modifiers::NONE, if i % 20 < 10 { Key::ArrowLeft } else { Key::ArrowRight })
}

/// A point in the picture, another each time.
fn place(inspector: &Inspector, i: usize) -> Pos2 {
    let rect = inspector.rect_of(PaneKind::Stream).unwrap_or(Rect::NOTHING);
    // The additive recurrence with the plastic number (Roberts 2018) covers a square evenly.
    let [x, y] = [0.754_877_7, 0.569_840_3].map(|step: f32| (0.5 + step * (i + 1) as f32).fract() - 0.5);
    // The picture is square, below two lines of tools.
    let side = 0.6 * rect.width().min(rect.height());
    rect.center() + vec2(0.0, 16.0) + vec2(x, y) * side
}

fn click(inspector: &mut Inspector, i: usize) -> Vec<Event> {
    let at = place(inspector, i);
    vec![Event::PointerMoved(at), press(at, true), press(at, false)]
}

fn press(pos: Pos2, pressed: bool) -> Event {
    Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE }
}

fn hover(inspector: &mut Inspector, i: usize) -> Vec<Event> {
    vec![Event::PointerMoved(place(inspector, i + 1000))]
}

/// Drags the 3D view; pressed at first, released at the end.
fn orbit(inspector: &mut Inspector, i: usize) -> Vec<Event> {
    let rect = inspector.rect_of(PaneKind::Walk3d).unwrap_or(Rect::NOTHING);
    let at = rect.center() + vec2((i % 40) as f32, 0.3 * (i % 40) as f32);
    let mut events = vec![Event::PointerMoved(at)];
    match i {
        0 => events.push(press(at, true)),
        49 => events.push(press(at, false)),
        _ => {}
    }
    events
}

/// A kernel of the walk as a user's file, with another comment each time.
fn kernel(inspector: &mut Inspector, i: usize) -> Vec<Event> {
    let opened = inspector.model().opened.as_ref();
    let own = opened.and_then(|opened| opened.plan.variants.iter().rfind(|variant| variant.kernel.is_walk()));
    if let Some(own) = own {
        let source = format!("// Version {i}.\n{}", own.kernel.info().wgsl);
        inspector.take_kernel("latency.wgsl", source.into_bytes());
    }
    Vec::new()
}

/// Moves the traced camera a little.
fn camera(inspector: &mut Inspector, _: usize) -> Vec<Event> {
    if let Some(opened) = &inspector.model().opened {
        let mut camera = opened.settings.view.camera(&opened.scene);
        camera.eye += camera.right * 0.01;
        let view = crate::settings::View::of(&camera, &opened.scene);
        let settings = crate::settings::Settings { view, ..opened.settings.clone() };
        inspector.plan(settings);
    }
    Vec::new()
}
