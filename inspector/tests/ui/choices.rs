//! The first screen of a report: measured on request, saved, and marked when it is of something else.

use std::time::{Duration, Instant};

use egui::{Key, Modifiers, Role};
use raystep_inspector::command::{Command, PaneKind};
use raystep_inspector::session::measure::on_its_device;
use raystep_inspector::settings::{DeviceKind, Settings};
use raystep_inspector::ui::Arrival;
use raystep_kernels::Choices;
use raystep_kernels::GridSize;

use crate::ui::desk::{CORNELL, TRIANGLE};
use crate::ui::stage::{Plan, Stage};

const SENTENCE: &str = "bvh, fused, robust is fastest";
const OTHER: &str = "measured with another view, grid or device";

fn settings(grid: GridSize) -> Settings {
    Settings {
        size: [32, 32],
        device: DeviceKind::Cpu,
        choices: Choices { grid, ..Choices::stepped() },
        ..Settings::default()
    }
}

fn stage() -> Stage {
    let mut stage = Stage::with_scene(CORNELL, settings(GridSize::Auto), Arrival::default());
    stage.perform(Command::Show(PaneKind::Choices));
    stage
}

#[test]
fn the_answer_is_shown_and_saved_and_marked_when_it_is_of_something_else() {
    let mut stage = stage();
    assert!(!stage.reads(SENTENCE) && stage.find(Role::Button, |name| name == "Save").is_none());
    stage.click(Role::Button, "Measure");
    stage.settle();
    assert!(stage.reads(SENTENCE) && stage.reads("0 of 4,096") && !stage.reads(OTHER), "{}", stage.read_out());
    stage.get(Role::Image, "What the first diagram shows.");
    stage.get(Role::Image, "What the second diagram shows.");

    stage.click(Role::Button, "Save");
    stage.frames(2);
    stage.click(Role::Button, "choices.csv");
    stage.settle();
    let saved: Vec<String> = stage.desk.lock().expect("the desk").saved.iter().map(|file| file.name.clone()).collect();
    assert_eq!(saved, ["choices.csv"]);

    stage.open(CORNELL, settings(GridSize::Cells([3; 3])), Arrival::default());
    assert!(!stage.reads(SENTENCE), "the scene was read again, it may have changed");
    stage.click(Role::Button, "Measure");
    stage.settle();
    assert!(stage.reads(SENTENCE) && !stage.reads(OTHER));
    stage.perform(Command::TypeRay);
    stage.answer("0,0,3,0,0,-1");
    assert!(stage.reads(SENTENCE) && !stage.reads(OTHER), "a single ray changes no choice");
    stage.perform(Command::Show(PaneKind::Options));
    stage.click(Role::ComboBox, "device");
    stage.frames(2);
    stage.click(Role::Button, "CPU, f64");
    stage.settle();
    stage.perform(Command::Show(PaneKind::Choices));
    assert!(stage.reads(SENTENCE) && stage.reads(OTHER), "{}", stage.read_out());
    stage.open(TRIANGLE, settings(GridSize::Auto), Arrival::default());
    assert!(!stage.reads(SENTENCE) && !stage.reads(OTHER));
}

/// As in a browser; the other tests' answer is always the same.
#[test]
fn the_sessions_own_device_is_measured_and_can_be_cancelled() {
    let mut stage = Stage::new(Plan { measure: on_its_device(), ..Plan::default() });
    stage.open(CORNELL, settings(GridSize::Auto), Arrival::default());
    stage.perform(Command::Show(PaneKind::Choices));
    let place = stage.place();
    stage.click(Role::Button, "Measure");
    stage.until("runs are timed", |stage| stage.harness.state().is_busy() && stage.reads("measuring choices"));
    stage.key(Modifiers::NONE, Key::Escape);
    stage.settle();
    assert!(!stage.reads("The paper's rules ("), "it was not cancelled, it ended by itself");
    stage.click(Role::Button, "Measure");
    stage.settle();
    assert!(stage.reads("On cornell-box with ") && stage.reads("none of 16,384 rays wrong"), "{}", stage.read_out());
    assert_eq!(stage.place(), place, "the session stays where it is");
}

#[test]
fn measuring_can_be_cancelled() {
    let mut stage = stage();
    stage.click(Role::CheckBox, "thorough");
    stage.frames(2);
    stage.click(Role::Button, "Measure");
    stage.until("a row appears as it comes", |stage| stage.reads("bvh fused robust"));
    assert!(stage.harness.state().is_busy());
    let begin = Instant::now();
    stage.key(Modifiers::NONE, Key::Escape);
    stage.settle();
    assert!(begin.elapsed() < Duration::from_secs(20), "it was not cancelled, it ended by itself");
    assert!(!stage.reads(SENTENCE), "{}", stage.read_out());
}
