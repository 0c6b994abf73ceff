//! Layouts: one for each task, and the user's own; dialogs that say why they refuse; a scene that changed on disk.

use egui::{Key, Modifiers, Role};
use raystep_inspector::command::{Command, Layout, PaneKind};
use raystep_inspector::settings::Settings;
use raystep_inspector::ui::Arrival;
use raystep_inspector::ui::host::HostEvent;

use crate::ui::desk::CORNELL;
use crate::ui::stage::Stage;

fn stage() -> Stage {
    let settings = Settings { size: [32, 32], ..Settings::default() };
    Stage::with_scene(CORNELL, settings, Arrival { pixel: Some([16, 9]), place: Some(20), ..Arrival::default() })
}

fn panes(stage: &Stage) -> Vec<PaneKind> {
    stage.harness.state().panes_in_view()
}

#[test]
fn a_digit_shows_a_layout_as_it_was_left() {
    let mut stage = stage();
    for (key, layout) in [Key::Num0, Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5].into_iter().zip(Layout::ALL)
    {
        stage.key(Modifiers::NONE, key);
        stage.settle();
        assert_eq!(stage.harness.state().layout(), layout.name());
    }
    stage.perform(Command::Arrange(Layout::Step));
    stage.perform(Command::Show(PaneKind::Kernel));
    assert!(!panes(&stage).contains(&PaneKind::Kernel));
    let left = panes(&stage);
    stage.perform(Command::Arrange(Layout::Ray));
    stage.perform(Command::Arrange(Layout::Step));
    assert_eq!(panes(&stage), left);
    stage.perform(Command::ResetLayout);
    assert!(panes(&stage).contains(&PaneKind::Kernel));
    // In a lesson, digits answer.
    stage.perform(Command::Lesson(0));
    let of_lesson = panes(&stage);
    stage.key(Modifiers::NONE, Key::Num2);
    stage.settle();
    assert_eq!(panes(&stage), of_lesson);
    stage.perform(Command::CloseLesson);
    assert_eq!(stage.harness.state().layout(), "Step");
    assert!(panes(&stage).contains(&PaneKind::Kernel));
}

#[test]
fn own_layouts_are_named_kept_and_deleted() {
    let mut first = stage();
    first.close_panels();
    first.perform(Command::Show(PaneKind::Plan));
    for (name, refusal) in [("", "1 to 20 characters"), ("ray", "built in"), ("my plan", "")] {
        first.perform(Command::SaveLayout);
        first.answer(name);
        assert!(refusal.is_empty() || first.reads(refusal), "{name:?}: {}", first.read_out());
        if !refusal.is_empty() {
            first.key(Modifiers::NONE, Key::Escape);
            first.settle();
        }
    }
    first.inspector().keep();
    let saved = first.desk.lock().expect("not poisoned").remembered.clone();

    let mut second = stage();
    second.inspector().restore(saved.as_bytes());
    second.settle();
    assert_eq!((second.harness.state().layout(), panes(&second)), ("my plan", vec![PaneKind::Plan]));
    second.key(Modifiers::NONE, Key::Num2);
    second.settle();
    assert!(panes(&second).contains(&PaneKind::Walk3d));
    second.key(Modifiers::NONE, Key::Num6);
    second.settle();
    assert_eq!((second.harness.state().layout(), panes(&second)), ("my plan", vec![PaneKind::Plan]));
    // Another arrangement under the same name replaces it, however the old one was left.
    second.perform(Command::Arrange(Layout::Ray));
    second.perform(Command::SaveLayout);
    second.answer("my plan");
    second.perform(Command::Arrange(Layout::Cost));
    second.perform(Command::ArrangeOwn(0));
    assert!(panes(&second).contains(&PaneKind::Walk3d));
    second.perform(Command::SaveLayout);
    second.click(Role::Button, "delete the layout my plan");
    second.key(Modifiers::NONE, Key::Escape);
    second.settle();
    assert!(!second.reads("my plan"), "{}", second.read_out());
    assert_eq!(second.harness.state().layout(), "Overview");
    assert!(panes(&second).contains(&PaneKind::Walk2d));
}

#[test]
fn a_dialog_says_why_it_refuses_and_stays() {
    let mut stage = stage();
    stage.perform(Command::GoToPixel);
    stage.answer("99,1");
    assert!(stage.reads("expected a column from 0 to 31 and a row from 0 to 31"), "{}", stage.read_out());
    assert_eq!(stage.harness.state().pixel(), Some([16, 9]));
    stage.key(Modifiers::NONE, Key::Escape);
    stage.settle();
    stage.perform(Command::GoToPixel);
    assert!(!stage.reads("expected a column"), "the refusal is of another time");
    stage.answer("3,4");
    assert_eq!(stage.harness.state().pixel(), Some([3, 4]));
}

#[test]
fn a_scene_that_was_written_is_read_again_on_demand() {
    let mut stage = stage();
    let generation = stage.harness.state().model().generation;
    let changed = |stage: &mut Stage, path: &str| {
        stage.desk.lock().expect("not poisoned").events.push(HostEvent::Changed { path: path.into() });
        stage.settle();
        stage.reads("has changed on disk")
    };
    assert!(!changed(&mut stage, "another scene"));
    assert!(changed(&mut stage, CORNELL));
    stage.click(Role::Button, "Not now");
    stage.settle();
    assert!(!stage.reads("has changed on disk"));
    assert!(changed(&mut stage, CORNELL));
    stage.click(Role::Button, "Reload");
    stage.settle();
    let state = stage.harness.state();
    assert_eq!((state.model().generation, state.model().place, state.pixel()), (generation + 1, 20, Some([16, 9])));
    assert!(!stage.reads("has changed on disk"));
}
