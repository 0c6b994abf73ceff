//! What has to be there before commands, and what is there after several of them.

use egui::{Key, Modifiers, Role};
use egui_kittest::kittest::NodeT as _;
use raystep_inspector::ui::command::Command;
use raystep_inspector::ui::pane::PaneKind;
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
    let life = stage.harness.state().model().life.clone().expect("a life");
    let mut places = life.rows.iter().filter_map(|row| row.place());
    let to = if is_forward { places.find(|&p| p > was.place) } else { places.rfind(|&p| p < was.place) };
    assert_eq!(Some(stage.place()), to);
}

#[track_caller]
pub(super) fn pixel_moved(stage: &mut Stage, by: [i64; 2]) {
    stage.settle();
    let to = [0, 1].map(|i| (i64::from(PIXEL[i]) + by[i]) as u32);
    assert_eq!(stage.harness.state().pixel(), Some(to));
    let life = stage.harness.state().model().life.as_ref().map(|life| life.pixel);
    assert_eq!(life, Some(to), "its history is not shown");
}
