//! Error against run time: wrong rays are counted, one can be found, and clicking the curve selects a pass.

use egui::{Role, pos2};
use egui_kittest::kittest::NodeT as _;
use raystep_inspector::command::{Command, PaneKind};
use raystep_inspector::settings::{DeviceKind, Settings};
use raystep_inspector::ui::Arrival;
use raystep_kernels::{Choices, GridSize, Numerics, ScheduleKind};

use crate::ui::desk::CORNELL;
use crate::ui::stage::{Plan, Stage};

/// Image size at which some rays are wrong with the paper's numerics.
const LARGE: u32 = 256;

fn settings(numerics: Numerics, side: u32) -> Settings {
    Settings {
        size: [side, side],
        device: DeviceKind::Cpu,
        choices: Choices {
            numerics,
            grid: GridSize::Cells([20; 3]),
            schedule: ScheduleKind::Second,
            ..Choices::stepped()
        },
        ..Settings::default()
    }
}

fn stage(numerics: Numerics, side: u32) -> Stage {
    let mut stage = Stage::new(Plan::default());
    stage.open(CORNELL, settings(numerics, side), Arrival::picture());
    stage.perform(Command::Show(PaneKind::Error));
    stage
}

fn curve(stage: &Stage) -> (egui::Rect, String) {
    let found = stage.find(Role::Slider, |name| name.starts_with("rays not yet resolved over device time"));
    let node = found.unwrap_or_else(|| panic!("no curve in\n{}", stage.read_out()));
    (node.rect(), node.accesskit_node().label().unwrap_or_default())
}

#[test]
fn the_curve_leads_to_any_place() {
    let mut stage = stage(Numerics::Robust, 64);
    let end = stage.place();
    let (rect, name) = curve(&stage);
    assert!(name.ends_with(&format!("run A: 0 of 4,096 after {end} passes")), "{name}");
    let mut places = Vec::new();
    for part in [0.0, 0.3, 0.6, 1.0] {
        stage.click_at(pos2(rect.left() + 46.0 + part * (rect.width() - 50.0), rect.center().y));
        stage.settle();
        places.push(stage.place());
        assert!(curve(&stage).1.ends_with(&format!(" after {} passes", stage.place())), "{}", curve(&stage).1);
    }
    assert!((places[0], places[3]) == (0, end) && places.is_sorted_by(|a, b| a < b), "{places:?} of {end}");
}

#[test]
fn judged_rays_are_counted_and_a_wrong_one_is_found() {
    let mut stage = stage(Numerics::Paper, LARGE);
    let end = stage.place();
    assert!(!stage.reads("judged"));
    stage.click(Role::Button, "Judge");
    stage.settle();
    let count = stage.find(Role::Link, |name| name.ends_with(" of 65,536 judged rays wrong"));
    let count = count.unwrap_or_else(|| panic!("not judged:\n{}", stage.read_out()));
    let text = count.accesskit_node().label().unwrap_or_default();
    assert!(!text.starts_with("0 "), "{text}");
    count.click_accesskit();
    stage.frame();
    stage.settle();
    let (pixel, place) = (stage.harness.state().pixel().expect("one is selected"), stage.place());
    assert!(place > 0 && place < end, "{place} of {end}");
    let by_then = "judged rays resolved wrongly";
    let (_, name) = curve(&stage);
    assert!(name.ends_with(by_then) && !name.ends_with(&format!(" 0 {by_then}")), "{name}");
    // The next wrong ray.
    stage.find(Role::Link, |name| name.ends_with("wrong")).expect("the count").click_accesskit();
    stage.frame();
    stage.settle();
    assert_ne!(stage.harness.state().pixel(), Some(pixel));

    // A run with edits no longer belongs to these options.
    stage.perform(Command::EditTexel);
    stage.answer("2");
    assert!(stage.reads("not judged: the run contains edits"), "{}", stage.read_out());
    assert!(stage.get(Role::Button, "Judge").accesskit_node().is_disabled());
}

#[test]
fn two_runs_are_judged_each_by_its_own_engine() {
    let mut stage = stage(Numerics::Robust, 64);
    stage.perform(Command::Compare);
    stage.perform(Command::Judge);
    let (_, name) = curve(&stage);
    assert!(name.contains("run A: ") && name.contains("run B: "), "{name}");
    let is_count = |node: &&egui_kittest::Node<'_>| {
        let node = node.accesskit_node();
        let text = node.label().or(node.value()).unwrap_or_default();
        node.role() == Role::Label && text == "0 of 4,096 judged rays wrong"
    };
    let counts = stage.nodes().iter().filter(is_count).count();
    assert_eq!(counts, 2, "{}", stage.read_out());
    stage.perform(Command::EndCompare);
    assert!(!curve(&stage).1.contains("run B"));
}

#[test]
fn a_small_panel_can_be_read() {
    // A panel of 300 x 200.
    let mut stage = Stage::new(Plan { size: [312.0, 292.0], ..Plan::default() });
    stage.open(CORNELL, settings(Numerics::Paper, LARGE), Arrival::picture());
    stage.close_panels();
    stage.perform(Command::Judge);
    stage.snapshot("panel-error-small");
}
