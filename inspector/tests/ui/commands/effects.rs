//! What has to be there before commands, and what is there after several of them.

use egui::{Key, Modifiers, Role};
use egui_kittest::kittest::NodeT as _;
use raystep_inspector::command::{Command, PaneKind};
use raystep_inspector::lesson::Lesson;
use raystep_kernels::programs::closest_hit::kernels::INTERSECT;
use raystep_kernels::programs::closest_hit::streams;
use raystep_kernels::programs::closest_hit::streams::STATE_T;

use super::{Before, PIXEL};
use crate::ui::desk::CORNELL;
use crate::ui::stage::Stage;

pub(super) fn nothing(_: &mut Stage) -> f64 {
    0.0
}

pub(super) fn choose_cornell(stage: &mut Stage) -> f64 {
    stage.desk.lock().expect("not poisoned").choice = Some(CORNELL.into());
    0.0
}

/// A kernel's own file.
pub(super) fn choose_kernel(stage: &mut Stage) -> f64 {
    let mut desk = stage.desk.lock().expect("not poisoned");
    desk.choice = Some("my.wgsl".into());
    desk.sessions = vec![("my.wgsl".into(), INTERSECT.info().wgsl.as_bytes().to_vec())];
    0.0
}

/// That file in place of the kernel.
pub(super) fn replace_kernel(stage: &mut Stage) -> f64 {
    choose_kernel(stage);
    stage.perform(Command::ReplaceKernel);
    0.0
}

/// A session at another place.
pub(super) fn choose_session(stage: &mut Stage) -> f64 {
    let file = format!(
        r#"{{"version": 1, "here": {{"link": "raystep:1?scene={CORNELL}&size=64x64&device=gpu&pixel=3,4&pass=5"}},
            "runs": [{{"name": "tree", "link": "raystep:1?scene={CORNELL}&size=32x32&accelerator=bvh&device=cpu"}}]}}"#
    );
    let mut desk = stage.desk.lock().expect("not poisoned");
    desk.session = Some("box.raystep-session".into());
    desk.sessions = vec![("box.raystep-session".into(), file.into_bytes())];
    0.0
}

/// A session with a kept run, without results.
pub(super) fn open_session(stage: &mut Stage) -> f64 {
    choose_session(stage);
    stage.perform(Command::OpenSession);
    0.0
}

/// Keeps the run, at least twice; returns the number of kept runs.
pub(super) fn keep(stage: &mut Stage) -> f64 {
    let is_here = |kept: &&raystep_inspector::runs::Kept| kept.recipe.settings.size == [64, 64];
    while stage.harness.state().kept_runs().list().iter().filter(is_here).count() < 2 {
        stage.perform(Command::KeepRun);
    }
    stage.harness.state().kept_runs().list().len() as f64
}

/// The second step of a lesson, which has other panels than those at the start.
pub(super) fn begin_lesson(stage: &mut Stage) -> f64 {
    stage.perform(Command::Lesson(0));
    stage.perform(Command::NextStep);
    0.0
}

/// A step of a lesson that asks a question with four choices.
pub(super) fn ask(stage: &mut Stage) -> f64 {
    let text = "# T\n## S\n```raystep\nopen scene=built-in:cornell-box size=32x32 device=cpu pixel=20,22\nquestion \"How many passes?\"\n\
                choice \"0\" if passes = 0\nchoice \"1\" if passes = 1\nchoice \"more\" if passes > 1\nchoice \"-1\" if passes < 0\n```\n";
    stage.inspector().begin_lesson(Lesson::parse("ask.md", text).expect("a lesson"), 0);
    stage.settle();
    0.0
}

/// A step of a lesson that goes on by itself.
pub(super) fn begin_play(stage: &mut Stage) -> f64 {
    let text = "# T\n## S\n```raystep\nopen scene=built-in:cornell-box size=32x32 grid=7 device=cpu pixel=13,27\nrow \"starts in\"\nplay 5\n```\n";
    stage.inspector().begin_lesson(Lesson::parse("play.md", text).expect("a lesson"), 0);
    // Not until it has settled: it would have ended by then.
    stage.until("the first iteration", |stage| stage.reads("0 of 5 iterations"));
    0.0
}

/// The same, after selecting another ray.
pub(super) fn leave_lesson(stage: &mut Stage) -> f64 {
    begin_lesson(stage);
    stage.perform(Command::NudgeRight);
    0.0
}

/// Rays can be sorted once all passes are known.
pub(super) fn sort_rays(stage: &mut Stage) -> f64 {
    stage.perform(Command::End);
    stage.perform(Command::Show(PaneKind::Cost));
    0.0
}

/// The layer of the grid that is shown.
pub(super) fn layer(stage: &Stage) -> f64 {
    let name =
        stage.find(Role::Image, |name| name.starts_with("list lengths")).and_then(|n| n.accesskit_node().label());
    let index = name.as_deref().and_then(|name| name.split(" at ").nth(1)?.split(',').next());
    index.and_then(|index| index.parse().ok()).expect("a layer")
}

/// Between two layers of the grid: one is above, one is below.
pub(super) fn slice(stage: &mut Stage, first: Command) -> f64 {
    stage.perform(Command::Show(PaneKind::Structure));
    stage.perform(first);
    layer(stage)
}

pub(super) fn show_watches(stage: &mut Stage) -> f64 {
    stage.perform(Command::Show(PaneKind::Watches));
    f64::from(is_ray_watched(stage))
}

pub(super) fn show_passes(stage: &mut Stage) -> f64 {
    stage.perform(Command::Show(PaneKind::Passes));
    0.0
}

pub(super) fn watch_the_ray(stage: &mut Stage) -> f64 {
    show_watches(stage);
    if !is_ray_watched(stage) {
        stage.perform(Command::ToggleWatch);
    }
    0.0
}

pub(super) fn play(stage: &mut Stage) -> f64 {
    stage.key(Modifiers::NONE, Key::Space);
    0.0
}

/// Bookmarks after the next pass and before the last one.
pub(super) fn bookmarks_around(stage: &mut Stage) -> f64 {
    use Command as C;
    for command in [C::NextPass, C::ToggleBookmark, C::PreviousPass, C::PreviousPass, C::ToggleBookmark, C::NextPass] {
        stage.perform(command);
    }
    0.0
}

/// Removes the bookmark here and the other one.
pub(super) fn remove_bookmarks(stage: &mut Stage, to_the_other: Command) {
    for command in [Command::ToggleBookmark, to_the_other, Command::ToggleBookmark] {
        stage.perform(command);
    }
    assert!(!stage.paints("•"), "{:?}", stage.painted());
}

pub(super) fn exposure(stage: &mut Stage) -> f64 {
    stage.show_stream(streams::COLOR, "rgb");
    stage.number("exposure")
}

pub(super) fn range(stage: &mut Stage) -> f64 {
    stage.show_stream(streams::STATE, streams::STATE.info().layers[STATE_T]);
    stage.number("from")
}

pub(super) fn moved_range(stage: &mut Stage) -> f64 {
    let from = range(stage);
    stage.perform(Command::OffsetUp);
    assert_ne!(stage.number("from"), from);
    from
}

pub(super) fn zoomed(stage: &mut Stage) -> f64 {
    let picture = stage.find(Role::Image, |name| name.starts_with("state after")).expect("the stream");
    let pos = picture.rect().center();
    stage.event(egui::Event::PointerMoved(pos));
    stage.event(egui::Event::Zoom(3.0));
    stage.event(egui::Event::PointerGone);
    assert!(stage.find(Role::Button, |name| name == "fit").is_none(), "not zoomed");
    0.0
}

/// The 3D view, zoomed by hand.
pub(super) fn moved_view(stage: &mut Stage) -> f64 {
    stage.perform(Command::Show(PaneKind::Walk3d));
    let view = stage.find(Role::Image, |name| name.contains("visited")).expect("the 3D view");
    let pos = view.rect().center();
    stage.event(egui::Event::PointerMoved(pos));
    stage.event(egui::Event::Zoom(1.5));
    stage.event(egui::Event::PointerGone);
    assert!(stage.reads("view moved by hand"), "{}", stage.read_out());
    0.0
}

/// A second tab beside the passes, with keyboard focus.
pub(super) fn beside(stage: &mut Stage) -> f64 {
    stage.close_panels();
    for kind in [PaneKind::Passes, PaneKind::Log] {
        stage.perform(Command::Show(kind));
    }
    stage.perform(Command::NextPanel);
    assert_eq!(focused(stage).as_deref(), Some("Log panel"));
    0.0
}

/// The name of what has keyboard focus.
pub(super) fn focused(stage: &Stage) -> Option<String> {
    let nodes = stage.nodes();
    nodes.iter().find(|node| node.accesskit_node().is_focused()).and_then(|node| node.accesskit_node().label())
}

pub(super) fn is_ray_watched(stage: &Stage) -> bool {
    let node = stage.get(Role::CheckBox, "selected ray: its state changes");
    node.accesskit_node().toggled() == Some(egui::accesskit::Toggled::True)
}

/// All passes were exported, the message has their number, and the view is unchanged.
#[track_caller]
pub(super) fn assert_all(stage: &mut Stage, was: &Before, count: usize, what: &str) {
    assert!(stage.paints(&format!("{count} {what} written to ")), "{:?}", stage.painted());
    assert_eq!(stage.place(), was.place);
    stage.perform(Command::End);
    assert_eq!(count, stage.place());
}

#[track_caller]
pub(super) fn is_shown(stage: &Stage, kind: PaneKind) {
    let panes = stage.harness.state().panes_in_view();
    assert!(panes.contains(&kind), "{kind:?} is not among {panes:?}");
}

#[track_caller]
pub(super) fn shown(stage: &Stage, was: &Before, kind: PaneKind) {
    assert!(!was.panes.contains(&kind), "{kind:?} was already there");
    is_shown(stage, kind);
}

#[track_caller]
pub(super) fn same_kernel(stage: &mut Stage, was: &Before, is_forward: bool) {
    stage.settle();
    assert_eq!(stage.harness.state().model().last_pass().map(|pass| pass.kernel), was.kernel);
    assert_eq!((stage.place() > was.place, stage.place() < was.place), (is_forward, !is_forward));
}

#[track_caller]
pub(super) fn event(stage: &mut Stage, was: &Before, is_forward: bool) {
    stage.settle();
    let history = stage.harness.state().model().history.clone().expect("a history");
    let mut places = history.rows.iter().filter_map(|row| row.place());
    let to = if is_forward { places.find(|&p| p > was.place) } else { places.rfind(|&p| p < was.place) };
    assert_eq!(Some(stage.place()), to);
}

#[track_caller]
pub(super) fn pixel_moved(stage: &mut Stage, by: [i64; 2]) {
    stage.settle();
    let to = [0, 1].map(|i| (i64::from(PIXEL[i]) + by[i]) as u32);
    assert_eq!(stage.harness.state().pixel(), Some(to));
    let history = stage.harness.state().model().history.as_ref().map(|history| history.pixel);
    assert_eq!(history, Some(to), "its history is not shown");
}

/// The cursor is over a stream; returns whether texels are magnified already.
pub(super) fn over_a_texel(stage: &mut Stage) -> f64 {
    let middle = stage.find(Role::Image, |name| name.contains(" after ")).map(|node| node.rect().center());
    stage.event(egui::Event::PointerMoved(middle.expect("a stream")));
    stage.settle();
    f64::from(stage.painted().iter().any(|text| text.starts_with("0x")))
}
