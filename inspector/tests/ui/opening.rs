//! What a new user sees first: a preview, a ray that is selected already, and what to do next.

use egui::{Key, Modifiers, Role};
use egui_kittest::kittest::NodeT as _;
use raystep_inspector::command::PaneKind;
use raystep_inspector::settings::{DeviceKind, Settings};
use raystep_inspector::ui::Arrival;
use raystep_inspector::ui::host::HostEvent;

use crate::ui::desk::CORNELL;
use crate::ui::stage::{Plan, Stage};

fn settings() -> Settings {
    Settings { size: [64, 64], device: DeviceKind::Cpu, ..Settings::default() }
}

fn open() -> Stage {
    Stage::with_scene(CORNELL, settings(), Arrival::picture())
}

#[test]
fn a_preview_is_shown_as_such_until_the_run_has_a_picture() {
    let mut stage = Stage::new(Plan::default());
    stage.desk.lock().expect("not poisoned").previews = true;
    stage.inspector().open(CORNELL, settings(), Arrival::picture());
    stage.frame();
    assert!(stage.inspector().shows_picture());
    assert!(stage.reads("preview of 64 × 64 pixels; the run: "), "{}", stage.read_out());
    assert!(stage.find(Role::Image, |name| name.contains(" after ")).is_none(), "{}", stage.read_out());
    stage.settle();
    assert!(!stage.reads("preview of"), "{}", stage.read_out());
    assert!(stage.find(Role::Image, |name| name.starts_with("color after")).is_some(), "{}", stage.read_out());
}

#[test]
fn a_preview_of_another_scene_or_one_that_comes_too_late_is_not_shown() {
    let mut stage = Stage::new(Plan::default());
    stage.desk.lock().expect("not poisoned").previews = true;
    stage.inspector().open(CORNELL, settings(), Arrival::picture());
    let sent = std::mem::take(&mut stage.desk.lock().expect("not poisoned").events);
    let Some(HostEvent::Previewed { path, preview }) = sent.into_iter().next() else { panic!("no preview") };
    let send = |stage: &mut Stage, path: &str| {
        let event = HostEvent::Previewed { path: path.into(), preview: preview.clone() };
        stage.desk.lock().expect("not poisoned").events.push(event);
        stage.frame();
    };
    send(&mut stage, "another");
    assert!(!stage.reads("preview of"), "{}", stage.read_out());
    stage.settle();
    send(&mut stage, &path);
    assert!(!stage.reads("preview of"), "{}", stage.read_out());
}

#[test]
fn at_first_there_are_the_picture_and_the_walk_and_history_of_a_ray_above_the_passes() {
    let mut stage = open();
    let mut panes = stage.inspector().panes_in_view();
    panes.sort_by_key(|kind| PaneKind::ALL.iter().position(|other| other == kind));
    assert_eq!(panes, [PaneKind::Stream, PaneKind::Ray, PaneKind::Walk2d, PaneKind::Timeline]);
    let area = |kind| stage.harness.state().rect_of(kind).expect("in view").area();
    assert!(area(PaneKind::Stream) > 2.0 * area(PaneKind::Timeline));
    let history = stage.harness.state().model().history.clone().expect("a history");
    assert!(
        history.rows.iter().any(|row| row.tested.is_some())
            && history.rows.last().is_some_and(|row| row.after.t.is_some())
    );
    assert!(stage.paints("scene units") && stage.reads(&format!("pixel {},{}", history.pixel[0], history.pixel[1])));
}

#[test]
fn a_line_says_what_to_do_next_and_goes_away_once_it_was_done() {
    let mut stage = open();
    let line =
        |stage: &Stage| ["Click any pixel", "Shift+F11 to its previous", "F10 runs"].map(|part| stage.reads(part));
    assert_eq!(line(&stage), [true, false, false]);
    let picture = stage.find(Role::Image, |name| name.starts_with("color after")).expect("the stream").rect();
    stage.click_at(picture.center() + egui::vec2(20.0, 30.0));
    stage.settle();
    assert_eq!(line(&stage), [false, true, false]);
    stage.key(Modifiers::SHIFT, Key::F11);
    stage.settle();
    assert_eq!(line(&stage), [false, false, true]);
    stage.key(Modifiers::SHIFT, Key::F10);
    stage.settle();
    assert_eq!(line(&stage), [false; 3]);
}

#[test]
fn from_the_start_the_stream_shows_what_differs_and_the_history_its_first_rows() {
    let mut stage = open();
    assert!(!stage.paints("a ray through the pixel's centre"), "the history is at its end");
    stage.key(Modifiers::NONE, Key::Home);
    stage.settle();
    assert!(stage.paints("a ray through the pixel's centre"), "{:?}", stage.painted());
    let is_on = |stage: &Stage, name: &str| {
        stage.get(Role::Button, name).accesskit_node().toggled() == Some(egui::accesskit::Toggled::True)
    };
    for place in 1..=4 {
        stage.key(Modifiers::NONE, Key::F10);
        stage.settle();
        assert_eq!(stage.place(), place);
        // All rays are in one state, and begin in one cell.
        let [on, shown] = if place < 4 { ["x", "ray_direction after"] } else { ["cell", "state after"] };
        assert!(is_on(&stage, on), "after {place} passes all rays are in one state");
        assert!(stage.find(Role::Image, |name| name.starts_with(shown)).is_some(), "{}", stage.read_out());
    }
    // A choice stays, and what it shows is said.
    stage.click(Role::Button, "tag");
    stage.settle();
    assert!(is_on(&stage, "tag") && !is_on(&stage, "cell"));
    assert!(stage.paints("all texels have one value: ISECT_NO_HIT"), "{:?}", stage.painted());
    // Also one of the directions.
    let mut stage = Stage::with_scene(CORNELL, settings(), Arrival { place: Some(1), ..Arrival::default() });
    stage.click(Role::Button, "y");
    stage.settle();
    stage.key(Modifiers::NONE, Key::End);
    stage.settle();
    assert!(is_on(&stage, "y"), "{}", stage.read_out());
    assert!(stage.find(Role::Image, |name| name.starts_with("ray_direction after")).is_some());
    // Where rays are in several states, these are shown.
    let mut stage = Stage::with_scene(CORNELL, settings(), Arrival { place: Some(35), ..Arrival::default() });
    assert!(is_on(&stage, "tag"), "{}", stage.read_out());
    stage.frame();
}

#[test]
fn a_link_beyond_the_last_pass_says_so() {
    let mut stage = Stage::new(Plan::default());
    let link = |pass: usize| format!("raystep:1?scene={CORNELL}&size=32x32&device=cpu&pass={pass}");
    let last_error = |stage: &Stage| stage.harness.state().last_error().map(str::to_owned);
    stage.inspector().go_to_link(&link(99_999));
    stage.settle();
    let passes = stage.place();
    let wanted = format!("pass 99999: the run has {passes} passes; it is shown after the last");
    assert_eq!(last_error(&stage), Some(wanted.clone()));
    // The last one itself is there.
    let mut stage = Stage::new(Plan::default());
    stage.inspector().go_to_link(&link(passes));
    stage.settle();
    assert_eq!((last_error(&stage), stage.place()), (None, passes));
}
