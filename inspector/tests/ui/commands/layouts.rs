//! What commands about layouts need, and how to tell that they worked.

use raystep_inspector::command::{Command, Layout, MOST_OWN, PaneKind};

use super::Before;
use super::effects::is_shown;
use crate::ui::stage::Stage;

/// Shows a layout of the user's, with the log alone, after saving as many as there are keys for.
pub(super) fn elsewhere(s: &mut Stage) -> f64 {
    for number in 1..=MOST_OWN {
        let name = format!("Own layout {number}");
        if !s.reads(&name) {
            s.arrange(Layout::Overview);
            s.close_panels();
            s.perform(Command::Show(PaneKind::Log));
            s.perform(Command::SaveLayout);
            s.answer(&name);
        }
    }
    s.perform(Command::ArrangeOwn(0));
    0.0
}

/// Saves the layouts, and shows another one.
pub(super) fn save_layouts(s: &mut Stage) -> f64 {
    elsewhere(s);
    s.arrange(Layout::Overview);
    0.0
}

/// The panel that a layout is for.
fn subject(layout: Layout) -> PaneKind {
    match layout {
        Layout::Overview => PaneKind::Walk2d,
        Layout::Step => PaneKind::Passes,
        Layout::Ray => PaneKind::Walk3d,
        Layout::Compare => PaneKind::Compare,
        Layout::Cost => PaneKind::Cost,
        Layout::Learn => PaneKind::Lessons,
    }
}

pub(super) fn arranged(s: &mut Stage, was: &Before) {
    s.settle();
    let Command::Arrange(layout) = was.command else { panic!("{:?}", was.command) };
    assert_eq!(s.harness.state().layout(), layout.name());
    is_shown(s, subject(layout));
    assert_ne!(s.harness.state().panes_in_view(), was.panes);
}

pub(super) fn arranged_own(s: &mut Stage, was: &Before) {
    s.settle();
    let Command::ArrangeOwn(index) = was.command else { panic!("{:?}", was.command) };
    assert_eq!(s.harness.state().layout(), format!("Own layout {}", index + 1));
    assert_eq!(s.harness.state().panes_in_view(), [PaneKind::Log]);
}

pub(super) fn saved_layout(s: &mut Stage, was: &Before) {
    s.answer("Own layout 1");
    assert_eq!(s.harness.state().layout(), "Own layout 1");
    assert_eq!(s.harness.state().panes_in_view(), was.panes);
}

pub(super) fn hide_the_ray(s: &mut Stage) -> f64 {
    s.perform(Command::Show(PaneKind::Ray));
    0.0
}

pub(super) fn the_ray_is_back(s: &mut Stage, was: &Before) {
    s.settle();
    assert!(!was.panes.contains(&PaneKind::Ray));
    is_shown(s, PaneKind::Ray);
}
