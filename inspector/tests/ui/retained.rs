//! Drawing only what differs from the last frame gives the same window, bit for bit, as drawing all of it.

use egui::{Key, Modifiers};
use raystep_inspector::command::{Command, PaneKind};
use raystep_inspector::settings::{DeviceKind, Settings};
use raystep_inspector::ui::Arrival;

use crate::ui::desk::CORNELL;
use crate::ui::stage::{Plan, Stage};

/// Draws both ways; returns the share of the window that was drawn again.
#[track_caller]
fn compared(stage: &Stage, what: &str) -> f32 {
    let (all, (kept, share)) = (stage.image(), stage.image_over_the_last());
    let differing = all.pixels().zip(kept.pixels()).filter(|(a, b)| a != b).count();
    assert_eq!(differing, 0, "{what}: pixels differ, with {share} of the window drawn again");
    share
}

#[test]
fn a_window_that_is_drawn_where_it_differs_is_the_window() {
    let mut stage = Stage::new(Plan { size: [900.0, 600.0], scale: 1.25, ..Plan::default() });
    assert_eq!(compared(&stage, "no scene"), 1.0);
    let settings = Settings { size: [32, 32], device: DeviceKind::Cpu, ..Settings::default() };
    stage.open(CORNELL, settings, Arrival { pixel: Some([20, 22]), place: Some(3), ..Arrival::default() });
    compared(&stage, "a scene");
    assert_eq!(compared(&stage, "nothing"), 0.0);
    for step in 0..3 {
        stage.perform(Command::NextPass);
        let share = compared(&stage, &format!("step {step}"));
        assert!(share > 0.0 && share < 0.6, "step {step} draws {share} of the window");
    }
    stage.event(egui::Event::PointerMoved(egui::pos2(400.0, 300.0)));
    stage.settle();
    compared(&stage, "the pointer over the picture");
    for &pane in PaneKind::ALL {
        stage.perform(Command::Show(pane));
        compared(&stage, &format!("{pane:?}"));
    }
    stage.key(Modifiers::COMMAND, Key::P);
    stage.text("step");
    compared(&stage, "a dialog");
}
