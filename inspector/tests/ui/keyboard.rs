//! The window by keyboard alone, its text sizes, maximised panels, and what a first start says.

use std::collections::HashSet;

use egui::accessibility::is_input;
use egui::{Key, Modifiers, Rect, Role, Shape};
use egui_kittest::Node;
use egui_kittest::kittest::NodeT as _;
use raystep_inspector::command::{Command, Layout, PaneKind};
use raystep_inspector::settings::Settings;
use raystep_inspector::ui::Arrival;

use crate::ui::desk::CORNELL;
use crate::ui::readable::contrast;
use crate::ui::stage::{Plan, Stage};

const HINT: &str = "Dismiss";

fn stage() -> Stage {
    let mut stage = Stage::new(Plan { size: [1280.0, 720.0], ..Plan::default() });
    let settings = Settings { size: [32, 32], ..Settings::default() };
    stage.open(CORNELL, settings, Arrival { pixel: Some([20, 22]), place: Some(20), ..Arrival::default() });
    stage
}

/// Role, name and place of what has keyboard focus.
fn focused(stage: &Stage) -> Option<(Role, String, Rect)> {
    let nodes = stage.nodes();
    let node = nodes.iter().find(|node| node.accesskit_node().is_focused())?;
    let consumer = node.accesskit_node();
    Some((consumer.role(), consumer.label().unwrap_or_default(), rect_of(node)?))
}

/// Its place, if it has one.
fn rect_of(node: &Node<'_>) -> Option<Rect> {
    node.accesskit_node().bounding_box().map(|_| node.rect())
}

fn panel_with_focus(stage: &Stage) -> Option<String> {
    focused(stage).filter(|(role, ..)| *role == Role::Pane).map(|(_, name, _)| name)
}

/// Whether a line of at least two points' width and 3:1 contrast to the panels is drawn around a rectangle (WCAG 2.2,
/// 2.4.13).
fn is_outlined(stage: &Stage, rect: Rect) -> bool {
    fn any(shape: &Shape, is_so: &dyn Fn(&egui::epaint::RectShape) -> bool) -> bool {
        match shape {
            Shape::Vec(shapes) => shapes.iter().any(|shape| any(shape, is_so)),
            Shape::Rect(rect) => is_so(rect),
            _ => false,
        }
    }
    let is_so = |shape: &egui::epaint::RectShape| {
        let is_around = shape.rect.expand(1.5).contains_rect(rect) && rect.expand(4.0).contains_rect(shape.rect);
        let parts = |color: egui::Color32| [color.r(), color.g(), color.b()].map(f64::from);
        let ratio = contrast(parts(shape.stroke.color), parts(stage.harness.ctx.global_style().visuals.panel_fill));
        is_around && shape.stroke.width >= 2.0 && ratio >= 3.0
    };
    let shapes = &stage.harness.output().shapes;
    shapes.iter().any(|clipped| clipped.clip_rect.intersects(rect) && any(&clipped.shape, &is_so))
}

#[test]
fn every_widget_of_the_simple_layout_is_reached_by_tab_and_outlined() {
    let mut stage = stage();
    let window = stage.harness.ctx.content_rect();
    let mut wanted: HashSet<(Role, String)> = HashSet::new();
    for node in stage.nodes() {
        let Some(rect) = rect_of(&node) else { continue };
        let node = node.accesskit_node();
        let name = node.label().unwrap_or_default();
        if is_input(node.role()) && !node.is_disabled() && !name.is_empty() && window.contains_rect(rect) {
            wanted.insert((node.role(), name));
        }
    }
    assert!(wanted.len() > 15, "{wanted:?}");
    let mut first = None;
    // Rows of tables are stops as well.
    for _ in 0..1500 {
        stage.key(Modifiers::NONE, Key::Tab);
        let Some((role, name, rect)) = focused(&stage) else { continue };
        if role == Role::Pane || is_input(role) {
            assert!(is_outlined(&stage, rect), "{role:?} {name:?} at {rect:?} has no outline");
        }
        wanted.remove(&(role, name.clone()));
        if is_input(role) && !name.is_empty() {
            let now = (role, name, rect);
            if first.as_ref() == Some(&now) {
                break;
            }
            first.get_or_insert(now);
        }
    }
    assert!(wanted.is_empty(), "not reached by Tab: {wanted:?}");
}

/// Presses Tab until something with this role has focus.
#[track_caller]
fn tab_to(stage: &mut Stage, wanted: Role) {
    for _ in 0..8 {
        stage.key(Modifiers::NONE, Key::Tab);
        if focused(stage).is_some_and(|(role, ..)| role == wanted) {
            return;
        }
    }
    panic!("no {wanted:?} is reached:\n{}", stage.read_out());
}

#[test]
fn f6_goes_round_the_panels_and_keys_for_commands_still_work() {
    let mut stage = stage();
    stage.perform(Command::Show(PaneKind::Passes));
    for name in ["Stream panel", "Passes panel", "Unfolded walk panel", "Ray panel", "Stream panel"] {
        stage.key(Modifiers::NONE, Key::F6);
        stage.settle();
        assert_eq!(panel_with_focus(&stage).as_deref(), Some(name));
        let (_, _, rect) = focused(&stage).expect("a panel");
        assert!(is_outlined(&stage, rect.shrink(1.0)), "{name} has no outline");
    }
    stage.key(Modifiers::SHIFT, Key::F6);
    stage.settle();
    assert_eq!(panel_with_focus(&stage).as_deref(), Some("Ray panel"));
    stage.key(Modifiers::NONE, Key::ArrowLeft);
    stage.key(Modifiers::NONE, Key::F10);
    stage.settle();
    assert_eq!((stage.inspector().pixel(), stage.place()), (Some([19, 22]), 21));
    assert_eq!(panel_with_focus(&stage).as_deref(), Some("Ray panel"), "arrows moved the focus");

    // From the panel into it, and to the list's rows: a row is chosen by Enter.
    stage.key(Modifiers::NONE, Key::F6);
    stage.key(Modifiers::NONE, Key::F6);
    stage.settle();
    tab_to(&mut stage, Role::Table);
    for _ in 0..3 {
        stage.key(Modifiers::NONE, Key::ArrowUp);
    }
    stage.settle();
    assert_ne!(stage.place(), 21, "no pass was chosen by keyboard");
    assert_eq!(stage.inspector().pixel(), Some([19, 22]), "arrows selected a ray");

    // A button with focus keeps Space, but not the keys that no button uses.
    stage.key(Modifiers::NONE, Key::F6);
    stage.key(Modifiers::SHIFT, Key::F6);
    stage.settle();
    tab_to(&mut stage, Role::CheckBox);
    stage.key(Modifiers::NONE, Key::Home);
    stage.settle();
    assert_eq!(stage.place(), 0);
    stage.key(Modifiers::NONE, Key::Space);
    stage.settle();
    let (role, name, _) = focused(&stage).expect("the same button");
    assert_eq!((role, stage.place()), (Role::CheckBox, 0), "it plays");
    let is_on = stage.get(role, &name).accesskit_node().toggled();
    assert_eq!(is_on, Some(egui::accesskit::Toggled::True));
}

#[test]
fn every_panel_of_a_layout_is_reached() {
    let mut stage = stage();
    stage.arrange(Layout::Step);
    let mut seen: HashSet<PaneKind> = stage.harness.state().panes_in_view().into_iter().collect();
    let groups = seen.len();
    for _ in 0..groups {
        stage.key(Modifiers::NONE, Key::F6);
        stage.settle();
        assert!(panel_with_focus(&stage).is_some());
        for _ in 0..6 {
            stage.key(Modifiers::COMMAND, Key::PageDown);
            stage.settle();
            assert!(panel_with_focus(&stage).is_some());
            seen.extend(stage.harness.state().panes_in_view());
        }
    }
    let all = [
        PaneKind::Passes,
        PaneKind::Options,
        PaneKind::Watches,
        PaneKind::Stream,
        PaneKind::Dataflow,
        PaneKind::Kernel,
        PaneKind::Ray,
        PaneKind::Plan,
        PaneKind::Timeline,
        PaneKind::Timings,
        PaneKind::Log,
    ];
    let missing: Vec<_> = all.into_iter().filter(|kind| !seen.contains(kind)).collect();
    assert!(missing.is_empty(), "{missing:?}");
}

#[test]
fn what_gets_focus_in_a_list_is_scrolled_to() {
    let mut stage = Stage::new(Plan { size: [700.0, 300.0], ..Plan::default() });
    let settings = Settings { size: [32, 32], ..Settings::default() };
    stage.open(CORNELL, settings, Arrival { place: Some(20), ..Arrival::default() });
    stage.close_panels();
    stage.perform(Command::Show(PaneKind::Options));
    let name = "Defaults";
    let window = stage.harness.ctx.content_rect();
    assert!(!window.contains_rect(stage.get(Role::Button, name).rect()), "it is in view from the start");
    stage.key(Modifiers::NONE, Key::F6);
    for _ in 0..60 {
        stage.key(Modifiers::NONE, Key::Tab);
        if focused(&stage).is_some_and(|(_, found, _)| found == name) {
            break;
        }
    }
    stage.settle();
    let (_, found, rect) = focused(&stage).expect("something has focus");
    assert_eq!(found, name);
    assert!(window.contains_rect(rect), "{rect:?} is not in view");
    assert!(is_outlined(&stage, rect));
}

#[test]
fn text_sizes_are_kept() {
    let mut stage = stage();
    for _ in 0..2 {
        stage.key(Modifiers::COMMAND, Key::Plus);
    }
    stage.settle();
    assert_eq!(stage.harness.ctx.zoom_factor(), 1.25);
    stage.perform(Command::ToolbarWords);
    stage.inspector().keep();
    let saved = stage.desk.lock().expect("not poisoned").remembered.clone();

    let mut other = Stage::new(Plan { scale: 2.0, ..Plan::default() });
    other.inspector().restore(saved.as_bytes());
    other.settle();
    assert_eq!(other.harness.ctx.pixels_per_point(), 2.5, "on top of the window's own scale");
    assert!(!other.paints("Previous event"), "the toolbar's words are kept");
    for _ in 0..30 {
        other.key(Modifiers::COMMAND, Key::Minus);
    }
    assert_eq!(other.harness.ctx.zoom_factor(), 0.5);
    other.key(Modifiers::COMMAND, Key::Num0);
    other.settle();
    assert_eq!(other.harness.ctx.zoom_factor(), 1.0);
}

#[test]
fn words_are_dropped_before_they_are_cut_off() {
    let mut stage = stage();
    assert!(stage.paints("Previous event") && stage.paints("Next pass"));
    stage.harness.set_size(egui::vec2(420.0, 400.0));
    stage.settle();
    assert!(!stage.paints("Previous event"));
    let rect = stage.get(Role::Button, Command::NextEvent.name()).rect();
    assert!(stage.harness.ctx.content_rect().contains_rect(rect));
}

#[test]
fn a_panel_is_maximised_and_restored_in_every_way() {
    let mut stage = stage();
    let all = stage.inspector().panes_in_view();
    let is_maximised = |stage: &Stage, kind| stage.harness.state().panes_in_view() == [kind];
    // The menus have a "Ray", too.
    let tabs: Vec<_> = stage.nodes().into_iter().filter(|node| rect_of(node).is_some_and(|r| r.top() > 60.0)).collect();
    let tab = tabs.into_iter().find(|node| node.accesskit_node().label().as_deref() == Some("Ray")).expect("a tab");
    let at = tab.rect().left_center() + egui::vec2(12.0, 0.0);
    for pressed in [true, false, true, false] {
        // In one frame: the harness lets a quarter of a second pass between two.
        let (button, modifiers) = (egui::PointerButton::Primary, Modifiers::NONE);
        let events = &mut stage.harness.input_mut().events;
        events.push(egui::Event::PointerMoved(at));
        events.push(egui::Event::PointerButton { pos: at, button, pressed, modifiers });
    }
    stage.frame();
    stage.event(egui::Event::PointerGone);
    stage.settle();
    let shown = stage.inspector().panes_in_view();
    assert!(is_maximised(&stage, PaneKind::Ray), "{shown:?}, tab at {at:?}");
    assert!(stage.paints("Restore layout") && stage.paints("or F12, Escape"));
    // What is saved is the layout underneath.
    stage.inspector().keep();
    let saved = stage.desk.lock().expect("not poisoned").remembered.clone();
    let mut other = Stage::new(Plan::default());
    other.inspector().restore(saved.as_bytes());
    assert_eq!(other.inspector().panes_in_view(), all);

    // Another panel takes its place: by its command, by F6, and where one is opened.
    stage.perform(Command::Show(PaneKind::Passes));
    assert!(is_maximised(&stage, PaneKind::Passes));
    stage.key(Modifiers::NONE, Key::F6);
    stage.settle();
    assert!(is_maximised(&stage, PaneKind::Stream));
    stage.perform(Command::Show(PaneKind::Log));
    assert!(is_maximised(&stage, PaneKind::Log));
    stage.key(Modifiers::NONE, Key::Escape);
    stage.settle();
    assert!(stage.inspector().panes_in_view().contains(&PaneKind::Log));
    stage.arrange(Layout::Overview);

    // Under the cursor.
    let picture = stage.find(Role::Image, |name| name.starts_with("state after")).expect("the stream").rect();
    stage.event(egui::Event::PointerMoved(picture.center()));
    stage.event(egui::Event::PointerMoved(picture.center() + egui::vec2(1.0, 0.0)));
    stage.key(Modifiers::NONE, Key::F12);
    stage.settle();
    assert!(is_maximised(&stage, PaneKind::Stream));
    let picture = stage.find(Role::Image, |name| name.starts_with("state after")).expect("the stream").rect();
    assert!(picture.width() > 1200.0, "{picture:?}");
    stage.event(egui::Event::PointerGone);
    stage.key(Modifiers::NONE, Key::F12);
    stage.settle();
    assert_eq!(stage.inspector().panes_in_view(), all);

    // With keyboard focus, and back by the button.
    stage.key(Modifiers::NONE, Key::F6);
    stage.key(Modifiers::NONE, Key::F12);
    stage.settle();
    assert!(is_maximised(&stage, PaneKind::Stream));
    stage.click(Role::Button, "Restore layout");
    stage.settle();
    assert_eq!(stage.inspector().panes_in_view(), all);
}

#[test]
fn a_first_start_says_what_click_and_f10_do_until_both_were_done() {
    let mut stage = stage();
    assert!(stage.reads(HINT));
    stage.key(Modifiers::NONE, Key::F10);
    stage.settle();
    assert!(stage.reads(HINT), "the ray was not clicked yet");
    let picture = stage.find(Role::Image, |name| name.starts_with("state after")).expect("the stream").rect();
    stage.click_at(picture.center());
    stage.settle();
    assert!(!stage.reads(HINT));
    stage.inspector().keep();
    let saved = stage.desk.lock().expect("not poisoned").remembered.clone();
    let mut other = self::stage();
    other.inspector().restore(saved.as_bytes());
    other.settle();
    assert!(!other.reads(HINT), "it is not kept");

    let mut dismissed = self::stage();
    dismissed.click(Role::Button, "Dismiss");
    dismissed.settle();
    assert!(!dismissed.reads(HINT));
}

/// The three uses at 1280 × 720: everything needed is in view at once.
#[test]
fn the_three_uses_need_no_scrolling() {
    let mut stage = stage();
    let window = stage.harness.ctx.content_rect();
    #[track_caller]
    fn in_view(stage: &Stage, window: Rect, role: Role, is_so: impl Fn(&str) -> bool) -> Rect {
        let nodes = stage.nodes();
        let node = nodes.iter().find(|node| {
            let node = node.accesskit_node();
            // The text of a label is its value.
            let text = if role == Role::Label { node.value() } else { node.label() };
            node.role() == role && text.is_some_and(|text| is_so(&text))
        });
        let rect = node.unwrap_or_else(|| panic!("no such {role:?}\n{}", stage.read_out())).rect();
        assert!(window.contains_rect(rect), "{role:?} at {rect:?}");
        rect
    }
    let button = |stage: &Stage, name: &'static str| in_view(stage, window, Role::Button, move |label| label == name);
    // Step passes.
    for command in [Command::Start, Command::PreviousPass, Command::NextPass, Command::End] {
        button(&stage, command.name());
    }
    let picture = in_view(&stage, window, Role::Image, |name| name.starts_with("state after 20 passes"));
    assert!(picture.width().min(picture.height()) > 300.0, "{picture:?}");
    // A pixel's walk: the reason of the current row, and the walk itself.
    let history = stage.inspector().model().history.clone().expect("a history");
    let row = history.rows.iter().rev().find(|row| row.is_within(20)).expect("a row");
    in_view(&stage, window, Role::Label, |text| text.starts_with(&format!("pass {}, {}: ", row.number(), row.kernel)));
    let walk = in_view(&stage, window, Role::Image, |name| name.contains("visited"));
    assert!(walk.height() > 140.0, "{walk:?}");
    button(&stage, Command::NextEvent.name());
    // Timings.
    button(&stage, Command::Export.name());
    stage.perform(Command::Export);
    button(&stage, Command::ExportPasses.name());
    button(&stage, Command::ExportTrace.name());
    stage.key(Modifiers::NONE, Key::Escape);
    stage.settle();
    stage.perform(Command::Show(PaneKind::Timings));
    button(&stage, "CSV…");
    in_view(&stage, window, Role::Label, |text| text.contains(" passes"));
}
