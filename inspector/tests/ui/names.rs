//! Every widget and every image has a name for screen readers.

use std::collections::HashSet;

use egui::accessibility::is_input;
use egui::{Key, Modifiers, Role};
use egui_kittest::kittest::NodeT as _;
use raystep_inspector::command::{Command, Layout, Menu, PaneKind};
use raystep_inspector::settings::Settings;
use raystep_inspector::ui::Arrival;

use crate::ui::desk::CORNELL;
use crate::ui::stage::Stage;

/// The number of visible widgets, all of which must have names.
#[track_caller]
fn named(stage: &Stage, place: &str) -> usize {
    assert_eq!(stage.harness.unnamed_widgets(), Vec::<String>::new(), "{place}");
    let mut widgets = 0;
    for node in stage.nodes() {
        let node = node.accesskit_node();
        let name = node.label().unwrap_or_default();
        widgets += usize::from(is_input(node.role()));
        assert!(node.role() != Role::Image || !name.trim().is_empty(), "{place}: an image without a name");
        assert!(name != "?", "{place}: a {:?} is called \"?\"", node.role());
    }
    widgets
}

fn stage() -> Stage {
    let settings = Settings { size: [32, 32], ..Settings::default() };
    Stage::with_scene(CORNELL, settings, Arrival { pixel: Some([20, 22]), place: Some(20), ..Arrival::default() })
}

#[test]
fn panels() {
    let mut stage = stage();
    let bare = named(&stage, "the overview");
    assert!(bare > 20, "{bare}");
    for &kind in PaneKind::ALL {
        stage.arrange(Layout::Overview);
        let is_there = stage.harness.state().panes_in_view().contains(&kind);
        match kind {
            _ if is_there => {}
            PaneKind::Compare => stage.perform(Command::Compare),
            PaneKind::Divergence => stage.perform(Command::Divergence),
            PaneKind::Error => stage.perform(Command::Judge),
            PaneKind::Choices => stage.perform(Command::Measure),
            kind => stage.perform(Command::Show(kind)),
        }
        named(&stage, &format!("{kind:?}"));
    }
    stage.arrange(Layout::Step);
    named(&stage, "the step layout");
}

#[test]
fn options_of_each_kind_and_combo_boxes() {
    let mut stage = stage();
    stage.perform(Command::Show(PaneKind::Options));
    for name in ["accelerator", "schedule", "numerics", "skip empty space", "device", "camera"] {
        stage.click(Role::ComboBox, name);
        stage.frames(2);
        named(&stage, name);
        stage.key(Modifiers::NONE, Key::Escape);
        stage.frames(2);
        assert!(!egui::Popup::is_any_open(&stage.harness.ctx), "Escape does not close {name}");
    }
    stage.click(Role::CheckBox, "auto");
    stage.settle();
    named(&stage, "cells");
}

#[test]
fn dialogs_and_lessons() {
    use Command as C;
    let mut stage = stage();
    for command in [C::Palette, C::Help, C::GoToPixel, C::TypeRay, C::PasteLink, C::EditTexel, C::Export] {
        let before = stage.nodes().len();
        stage.perform(command);
        named(&stage, command.name());
        assert!(stage.nodes().len() > before, "{command:?} shows nothing");
        stage.key(Modifiers::NONE, Key::Escape);
        stage.settle();
    }
    stage.perform(C::Lesson(0));
    named(&stage, "a lesson");
}

#[test]
fn menus() {
    let mut stage = stage();
    for menu in Menu::ALL {
        let before: HashSet<_> = stage.nodes().iter().map(|node| node.accesskit_node().id()).collect();
        stage.click(Role::Button, menu.name());
        stage.frames(3);
        named(&stage, menu.name());
        let new = stage.nodes().iter().filter(|node| !before.contains(&node.accesskit_node().id())).count();
        assert!(new > 2, "{menu:?} is empty");
        stage.key(Modifiers::NONE, Key::Escape);
        stage.frames(2);
        assert!(!egui::Popup::is_any_open(&stage.harness.ctx), "Escape does not close {menu:?}");
    }
}
